"""After a stop a board may send what it kept, and no more: no run goes on for ever."""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace

import numpy as np
import pytest

from motorid.acquire.drive import drive
from motorid.acquire.plan import WireProgram
from motorid.errors import LinkError
from motorid.wire.codec import Event, SampleBlock
from motorid.wire.enums import Channel, EndReason, Mode

KEPT, PER_BLOCK = 65_536, 1024  # samples that the memory of a board holds at most
CONFIG = {"sample_period_ticks": 1, "host_silence_ms": 1000, "mode": Mode.STREAM, "config_hash": 1}
STEP = {"index": 0, "kind": 0, "decay": 0, "level": 0, "ticks": 100_000_000}
HOURS = WireProgram((STEP,), (0,))


class Talker:
    """A board that is asked to stop at once, and has so many samples left to send."""

    def __init__(self, left: int, stop: SimpleNamespace) -> None:
        self.left, self.stop, self.sent = left, stop, list[str]()
        self.identity = {"clock_hz": 10_000}
        self.news: deque[Event | SampleBlock] = deque()
        self.port = SimpleNamespace(name="board", now=lambda: self.clock)
        self.clock = self.heard_at = 0.0
        self.trip, self.hasten = "", None

    def ask(self, name: str, **fields: int) -> dict[str, int]:
        self.stop.requested = name == "start"
        return {}

    def tell(self, name: str, **fields: int) -> None:
        self.sent.append(name)

    def hear(self, timeout_s: float) -> None:
        self.clock += timeout_s
        self.heard_at = self.clock
        if "stop" not in self.sent:
            return
        if self.left > 0:
            samples = np.zeros((PER_BLOCK, 1), dtype=np.int16)
            self.news.append(SampleBlock(0, 0, 0, 0, (Channel.CURRENT,), samples))
            self.left -= PER_BLOCK
        else:
            self.news.append(Event("done", {"reason": EndReason.STOPPED}))


def heard(left: int) -> tuple[str, int]:
    """Why the run ended, and how many samples came of it."""
    stop = SimpleNamespace(requested=False)
    board, taken = Talker(left, stop), list[int]()
    reason = drive(board, HOURS, CONFIG, stop, lambda one: taken.append(len(one.samples)))  # type: ignore[arg-type]
    return reason, sum(taken)


def test_what_a_board_had_kept_is_taken_after_a_stop() -> None:
    assert heard(KEPT) == ("stopped", KEPT)


def test_a_board_that_goes_on_after_a_stop_is_left() -> None:
    with pytest.raises(LinkError, match="the run does not end: reset the board"):
        heard(2 * KEPT)
