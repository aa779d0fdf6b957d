"""A board that heard no heartbeat: whose fault that was is said as far as this side can tell."""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace

import pytest

from motorid.acquire.drive import drive, tripped
from motorid.acquire.plan import WireProgram
from motorid.wire.codec import Event, SampleBlock
from motorid.wire.enums import EndReason, Fault, Mode

CONFIG = {"sample_period_ticks": 1, "host_silence_ms": 500, "mode": Mode.STREAM, "config_hash": 1}
STEP = {"index": 0, "kind": 0, "decay": 0, "level": 0, "ticks": 100_000_000}
DONE = Event("done", {"reason": EndReason.FAULT})


class Unheard:
    """A board that trips for want of heartbeats, and says so, or only that it is done."""

    def __init__(self, start_s: float, busy_s: float, tells: bool) -> None:
        self.start_s, self.busy_s, self.tells, self.lasts_s = start_s, busy_s, tells, 0.6
        self.identity = {"clock_hz": 10_000}
        self.news: deque[Event | SampleBlock] = deque()
        self.port = SimpleNamespace(name="board", now=lambda: self.clock)
        self.clock = self.heard_at = 0.0
        self.trip, self.hasten = "", None

    def ask(self, name: str, **fields: int) -> dict[str, int]:
        if name == "start":
            self.clock += self.start_s
        return {"fault": Fault.HOST_SILENCE}

    def tell(self, name: str, **fields: int) -> None:
        self.clock, self.busy_s = self.clock + self.busy_s, 0.0

    def hear(self, timeout_s: float) -> None:
        self.clock += timeout_s
        self.heard_at = self.clock
        if self.clock > self.lasts_s + self.start_s:
            fault = Event("fault", {"fault": Fault.HOST_SILENCE, "value": 500})
            self.news.extend([fault, DONE] if self.tells else [DONE])


@pytest.mark.parametrize("tells", [True, False])
@pytest.mark.parametrize(
    ("start_s", "busy_s", "says"),
    [
        (0.62, 0.0, "its reply to start was lost on the link, or 0.62 s late"),
        (0.01, 0.4, "this computer sent none for 0.42 s"),
        (0.01, 0.0, "they were sent, and lost on the link"),
    ],
)
def test_a_silence_is_put_down_to_where_it_arose(
    start_s: float, busy_s: float, says: str, tells: bool
) -> None:
    board = Unheard(start_s, busy_s, tells)
    stop = SimpleNamespace(requested=False)
    program = WireProgram((STEP,), (0,))
    reason = drive(board, program, CONFIG, stop, lambda one: None)  # type: ignore[arg-type]
    assert reason == "fault: host_silence"
    text = tripped(reason, board.trip)
    assert f"(host_silence: no heartbeat came for 0.5 s; {says}) and opened the bridge" in text
    assert "too busy" not in text
