"""What the client of a board makes of its replies, by replies made by hand."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.acquire import keep
from motorid.acquire.board import Board
from motorid.acquire.safety import check_program
from motorid.capture import store
from motorid.capture.model import CURRENT, Capture, Channel
from motorid.errors import DataError, LinkError, RigError
from motorid.program import Program, Step, StepKind
from motorid.wire.enums import State
from tests.acquire.rigs import sim_rig


class Answered(Board):
    """A board whose replies are given; a list is answered in turn, its last one for ever."""

    def __init__(self, **replies: Any) -> None:
        self.clock = 0.0
        port: Any = SimpleNamespace(name="board", now=lambda: self.clock)
        super().__init__(port)
        self.replies, self.asked = replies, list[str]()

    def ask(self, name: str, /, timeout_s: float = 0.3, **fields: Any) -> dict[str, Any]:
        self.asked.append(name)
        found = self.replies.get(name, {})
        if isinstance(found, list):
            return found.pop(0) if len(found) > 1 else found[0]  # type: ignore[no-any-return]
        return found  # type: ignore[no-any-return]

    def wait(self, duration_s: float) -> None:
        self.clock += duration_s


@pytest.mark.parametrize(
    ("sent", "counts"),
    [(0, 0), (7, 7), (2**31 - 1, 2**31 - 1), (2**31, -(2**31)), (2**32 - 1, -1)],
)
def test_a_position_has_a_sign(sent: int, counts: int) -> None:
    assert Answered(read_status={"position": sent}).position() == counts


def test_the_supply_in_volts_where_the_board_reads_it() -> None:
    board = Answered(read_status={"supply_voltage_raw": 60})
    assert board.supply_v() is None
    board.descriptors["supply_voltage"] = {"scale": 0.25, "offset": 20.0}
    assert board.supply_v() == 10.0


def test_offsets_that_are_no_readings_are_the_firmware_s_fault() -> None:
    assert Answered(zero={"current_offset": 5.0}).zero(16) == {"current_offset": 5.0}
    with pytest.raises(LinkError, match="the board says current_offset = nan at rest"):
        Answered(zero={"current_offset": float("nan")}).zero(16)


@pytest.mark.parametrize(("state", "clears"), [(State.FAULTED, True), (State.IDLE, False)])
def test_a_latched_fault_is_cleared(state: State, clears: bool) -> None:
    board = Answered(read_status={"state": state})
    board.unlatch()
    assert board.asked == ["stop", "read_status", *["clear_fault"] * clears]


@pytest.mark.parametrize(
    ("counts", "looks"),
    [([5, 5], 2), ([5, 6], 2), ([5, 7, 8], 3), ([0, 2**32 - 1], 2), ([9, 7, 7], 3)],
)
def test_rest_is_a_count_that_stands_but_for_one(counts: list[int], looks: int) -> None:
    board = Answered(read_status=[{"position": count} for count in counts])
    board.wait_for_rest()
    assert len(board.asked) == looks
    assert board.clock == pytest.approx(0.15 * (looks - 1))


def test_a_motor_that_goes_on_turning_is_said() -> None:
    board = Answered(read_status=[{"position": 2 * n} for n in range(99)])
    with pytest.raises(RigError, match="still moves 3 s after the bridge opened"):
        board.wait_for_rest(3.0)
    assert board.clock == pytest.approx(3.0, abs=0.16)


@pytest.mark.parametrize(("opens", "kind"), [(True, StepKind.COAST), (False, StepKind.BRAKE)])
def test_a_rest_opens_the_bridge_where_it_can(opens: bool, kind: StepKind) -> None:
    board = Answered()
    board.opens = opens
    assert board.rest_step(0.5) == Step(kind, 0.5)


def test_requests_are_numbered_from_one_to_65535() -> None:
    board = Answered()
    board._request = 65534
    assert [board._next_request() for _ in range(3)] == [65535, 1, 2]


def test_why_nobody_answers() -> None:
    board = Answered()
    assert "nothing answers: is the board powered" in board._why_nobody()
    board._received = 9
    assert "something sends there (9 bytes), but not" in board._why_nobody()
    board.good_frames = 1
    assert "a motorid board speaks there but does not answer" in board._why_nobody()


def test_a_program_without_a_drive_passes_no_limit_of_speed() -> None:
    check_program(sim_rig(), Program((Step(StepKind.COAST, 0.1), Step(StepKind.BRAKE, 0.1))))


def test_a_capture_that_reads_back_otherwise_is_set_aside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(*raw: int) -> Capture:
        channels = {CURRENT: Channel(CURRENT, "A", np.array(raw, np.int16))}
        return Capture(np.arange(len(raw)), 1e3, channels)

    path = tmp_path / "run.h5"
    path.write_bytes(b"what is there")
    monkeypatch.setattr(store, "load", lambda _: run(1, 2, 4))
    keep._read_back(run(1, 2, 4), path)
    for other in (run(1, 2, 3), run(1, 2)):
        path.write_bytes(b"what is there")
        with pytest.raises(DataError, match=r"reads back otherwise .* is run\.h5\.bad now"):
            keep._read_back(other, path)
        assert not path.exists()
        assert (tmp_path / "run.h5.bad").read_bytes() == b"what is there"
