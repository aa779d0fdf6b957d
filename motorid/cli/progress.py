"""One line on stderr that follows a run: how far, how long yet, live current and speed."""

from __future__ import annotations

import sys
import threading
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


class Working:
    """A line on stderr while work of unknown length goes on: what, how much of it, how long.

    It begins after a second, and only where stderr is a terminal. A thread draws it; the work
    neither waits for it nor hears of it, so that no clock decides a result.
    """

    AFTER_S, EACH_S = 1.0, 0.25

    def __init__(self, what: str) -> None:
        self.what = what
        self.ended = threading.Event()
        self.thread: threading.Thread | None = None
        self.width = 0

    def __enter__(self) -> Working:
        if sys.stderr.isatty():
            self.began = time.monotonic()
            self.thread = threading.Thread(target=self._follow, daemon=True)
            self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.ended.set()
        if self.thread is not None:
            self.thread.join()
        if self.width:
            paint(sys.stderr, "\r" + " " * self.width + "\r")

    def _follow(self) -> None:
        patience = self.AFTER_S
        while not self.ended.wait(patience):
            patience = self.EACH_S
            line = still(self.what, responses(), time.monotonic() - self.began)
            paint(sys.stderr, "\r" + line.ljust(self.width))
            self.width = len(line)


def still(what: str, done: int, elapsed_s: float) -> str:
    """The line after ``elapsed_s`` and ``done`` evaluations of the model; a mark wanders."""
    room = BAR - 3
    at = round(elapsed_s / Working.EACH_S) % (2 * room)
    at = min(at, 2 * room - at)
    bar = f"[{'.' * at}###{'.' * (room - at)}]"
    parts = [bar, what, f"{done:,} evaluations" if done else "", f"{elapsed_s:.0f} s"]
    return "  ".join(filter(None, parts))


def responses() -> int:
    """Evaluations of the motor's response so far; 0 where none was needed yet."""
    tally = sys.modules.get("motorid.motor.tally")
    return int(tally.Tally.responses) if tally else 0
