"""One line on stderr that follows a run: how far, how long yet, live current and speed."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from types import TracebackType
from typing import TYPE_CHECKING

from motorid.cli.streams import paint

if TYPE_CHECKING:
    from motorid.acquire.live import Live

BAR = 24


class ProgressLine:
    """Call it with each ``Live``; silent where stderr is no terminal."""

    def __init__(self) -> None:
        self.shown = sys.stderr.isatty()
        self.began = time.monotonic()
        self.width = 0
        self.last: Live | None = None

    def __enter__(self) -> ProgressLine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.last is None:
            return
        if error is None:
            self._draw(replace(self.last, done_s=self.last.total_s))
        paint(sys.stderr, "\n")

    def __call__(self, live: Live) -> None:
        if not self.shown:
            return
        if live.done_s <= 0:
            self.began = time.monotonic()  # the next run
        self.last = live
        self._draw(live)

    def _draw(self, live: Live) -> None:
        line = render(live, time.monotonic() - self.began)
        paint(sys.stderr, "\r" + line.ljust(self.width))
        self.width = len(line)


def render(live: Live, elapsed_s: float) -> str:
    """The line for a run that has taken ``elapsed_s`` so far.

    The time left is by the pace so far: a simulated rig may run faster than its own clock.
    """
    share = min(max(live.done_s / live.total_s, 0.0), 1.0) if live.total_s > 0 else 0.0
    filled = round(share * BAR)
    left = f"{elapsed_s * (1 - share) / share:4.0f} s left" if share > 0 else "        "
    parts = [f"[{'#' * filled}{'.' * (BAR - filled)}] {share:4.0%}", left]
    if live.current_a is not None:
        parts.append(f"{live.current_a:+8.3f} A")
    if live.speed_rad_s is not None:
        parts.append(f"{live.speed_rad_s:+8.1f} rad/s")
    return "  ".join(parts)
