"""Signals that ask the program to end: the one place that hears them.

Ctrl-C, a request to terminate, and a terminal that is gone (a closed window, a dropped ssh) mean
the same: stop the motor, keep what was measured, and end as interrupted.
"""

from __future__ import annotations

import _thread
import contextlib
import signal
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from types import FrameType
from typing import Protocol

PATIENCE_S = 10.0
GONE = getattr(signal, "SIGHUP", None)  # given twice by nobody's hand: by a shell and its terminal
ASKING = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")  # the last is of Windows
    if hasattr(signal, name)
)


class Asked(Protocol):
    """Says whether a stop was asked for, by whomever."""

    @property
    def requested(self) -> bool:
        """True from then on."""


@dataclass
class Stop:
    """Whether the user asked to stop."""

    requested: bool = False


def heed() -> None:
    """Lets every signal that asks the program to end raise KeyboardInterrupt, as Ctrl-C does.

    For the main thread of a program. A hang-up that the program was started to ignore (nohup) stays
    ignored.
    """
    for number in _heard():
        signal.signal(number, _interrupt)


def heed_no_more() -> None:
    """Once the outcome is settled: a request ends the program at once, and changes no exit code.

    A hang-up is heeded no more at all, for the second of two comes by itself.
    """
    for number in _heard():
        signal.signal(number, signal.SIG_IGN if number == GONE else signal.SIG_DFL)


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _heard() -> list[signal.Signals]:
    return [n for n in ASKING if n != GONE or signal.getsignal(n) != signal.SIG_IGN]


@contextlib.contextmanager
def interruptible() -> Iterator[Stop]:
    """A first request asks for a gentle stop; a second Ctrl-C or termination quits at once.

    So does one that nothing has followed for PATIENCE_S, wherever the program waits. A hang-up is
    never the second: a shell and its terminal both send one.
    """
    stop = Stop()
    if threading.current_thread() is not threading.main_thread():
        yield stop  # signals belong to the main thread
        return
    asked, over, late = threading.Event(), threading.Event(), threading.Event()
    by_hand: list[int] = []

    def watch() -> None:
        asked.wait()
        if not over.wait(PATIENCE_S):
            late.set()
            _thread.interrupt_main()

    def handle(number: int, frame: FrameType | None) -> None:
        if late.is_set() or (by_hand and number != GONE):
            raise KeyboardInterrupt
        if number != GONE:
            by_hand.append(number)
        stop.requested = True
        asked.set()

    watcher = threading.Thread(target=watch, name="patience", daemon=True)
    watcher.start()
    before = {number: signal.signal(number, handle) for number in _heard()}
    try:
        yield stop
    finally:
        over.set()
        asked.set()
        watcher.join()
        for number, handler in before.items():
            signal.signal(number, handler)
