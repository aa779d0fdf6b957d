"""One line on stderr that follows a run: how far, how long yet, live current and speed."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Protocol

BAR = 24
REDRAW_S = 0.1


class Live(Protocol):
    """What a recorder tells of a run while it goes on."""

    @property
    def done_s(self) -> float: ...
    @property
    def total_s(self) -> float: ...
    @property
    def current_a(self) -> float | None: ...
    @property
    def speed_rad_s(self) -> float | None: ...


class ProgressLine:
    """Call it with each ``Live``; silent where stderr is no terminal."""

    def __init__(self) -> None:
        self.shown = sys.stderr.isatty()
        self.began = time.monotonic()
        self.drawn = float("-inf")
        self.width = 0

    def __enter__(self) -> ProgressLine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.width:
            sys.stderr.write("\n")

    def __call__(self, live: Live) -> None:
        now = time.monotonic()
        if live.done_s <= 0:
            self.began = now  # the next run
        finished = live.done_s >= live.total_s
        if not self.shown or (now - self.drawn < REDRAW_S and not finished):
            return
        self.drawn = now
        line = render(live, now - self.began)
        sys.stderr.write("\r" + line.ljust(self.width))
        sys.stderr.flush()
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
