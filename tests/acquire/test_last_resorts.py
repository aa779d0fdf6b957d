"""What keeps a run from going on for ever, and a rotor from turning: bounds, clamps, signals."""

from __future__ import annotations

import signal
import time
from dataclasses import FrozenInstanceError, replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire import held_rotor, interrupt
from motorid.acquire import journal_writer as writing
from motorid.acquire.clock import Clock, Pair
from motorid.acquire.controls import BUSY, Controls, Press
from motorid.acquire.held_rotor import check_held
from motorid.acquire.journal import Journal, Kind, Record
from motorid.acquire.journal_check import JournalState
from motorid.acquire.journal_writer import JournalWriter
from motorid.acquire.keep import Kept
from motorid.acquire.link_test import LinkTest
from motorid.acquire.live import Live
from motorid.acquire.plan import WireProgram
from motorid.acquire.ports import PortInfo
from motorid.acquire.pulse import Pulse
from motorid.acquire.scpi.bench_file import BenchFile, Place, Source
from motorid.acquire.scpi.dialect import Dialect
from motorid.acquire.scpi.notes import Told
from motorid.acquire.scpi.recorder import Recording, Trace
from motorid.acquire.scpi.scan import Scans
from motorid.acquire.session import Level
from motorid.acquire.strips import Strip
from motorid.acquire.tap import RunFacts, Scale
from motorid.acquire.timeline import Arrays
from motorid.errors import DataError, LinkError, RigError
from motorid.rig import Nameplate
from motorid.wire.codec import Event
from motorid.wire.enums import State
from tests.acquire.rigs import sim_rig
from tests.acquire.test_board_client import Answered
from tests.acquire.test_run_by_hand import Spoken, run

RIG = replace(sim_rig(), nameplate=Nameplate(resistance_ohm=2.0))


# -- a board that talks on
def phases(seconds: int) -> list[tuple[float, Event]]:
    """One piece of news a second: there is always some, and never an end."""
    return [(float(at), Event("phase", {"index": 0, "tick": 0})) for at in range(1, seconds)]


@pytest.mark.parametrize(("stop_s", "end_s"), [(None, 122.0), (5.0, 122.0), (0.5, 120.5)])
def test_two_minutes_after_its_end_a_run_that_talks_on_is_given_up(
    stop_s: float | None, end_s: float
) -> None:
    """A run of one second, over at the latest after two, or when a stop was asked for."""

    class Asked:
        @property
        def requested(self) -> bool:
            return stop_s is not None and board.clock >= stop_s

    board = Spoken(phases(400))
    with pytest.raises(LinkError, match="the run does not end: reset the board"):
        run(board, Asked())
    assert board.clock == pytest.approx(end_s, abs=0.05)
    stops = [at for at, name, _ in board.told if name == "stop"]
    assert stops[0] == pytest.approx(end_s if stop_s is None else stop_s, abs=0.05)


# -- a rotor that must not turn
class Clamped:
    """A board whose encoder stood at 100 and is at ``now`` then."""

    def __init__(self, now: int = 100) -> None:
        self.positions = iter((100, now))

    def position(self) -> int:
        return next(self.positions)


STANDS = Pulse(0.1, 0.7, 0, 0.35, 0.01, 0.4, False, None)
MOST = held_rotor.allowed_counts(RIG)


def held(patch: pytest.MonkeyPatch, shown: Pulse | Exception | None, now: int = 100) -> Any:
    board, stop = Clamped(now), object()

    def pulse(*words: Any) -> Pulse | None:
        assert words == (board, RIG, "config", "zero", stop, 0.1, 7.0)
        if isinstance(shown, Exception):
            raise shown
        return shown

    patch.setattr(held_rotor, "weak_pulse", pulse)
    return check_held(board, RIG, "config", "zero", 7.0, stop)  # type: ignore[arg-type]


def test_a_pulse_that_moves_nothing_bounds_the_resistance(monkeypatch: pytest.MonkeyPatch) -> None:
    found = held(monkeypatch, replace(STANDS, counts=MOST))
    assert found["resistance_bound_ohm"] == pytest.approx(1.75)  # without a back-EMF it is that
    assert (found["duty"], found["counts"]) == (0.1, MOST)
    assert held(monkeypatch, replace(STANDS, current_a=None, peak_a=0.0))["current_a"] is None
    assert held(monkeypatch, replace(STANDS, peak_a=0.0))["resistance_bound_ohm"] is None
    assert held(monkeypatch, None) == {}


@pytest.mark.parametrize(
    ("facts", "says"),
    [
        ({"counts": MOST + 1}, f"moves by {MOST + 1} counts at 10% duty; clamp it"),
        ({"counts": -MOST - 1}, f"moves by -{MOST + 1} counts at 10% duty; clamp it"),
        ({"current_a": 0.04}, r"draws 0\.04 A at 10% duty \(0\.70 V\): check its leads"),
        ({"current_a": -0.35}, r"reads -0\.35 A under positive voltage: the sensor is reversed"),
        ({"saturated": True}, "the motor is shorted"),
    ],
)
def test_a_rotor_that_is_not_held_or_a_dead_motor_is_said(
    facts: dict[str, Any], says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(RigError, match=says):
        held(monkeypatch, replace(STANDS, **facts))


@pytest.mark.parametrize(
    ("now", "says"), [(100 + MOST, "it tripped"), (101 + MOST, f"moves by {MOST + 1} counts")]
)
def test_a_board_that_trips_in_the_pulse_saw_the_rotor_move_or_not(
    now: int, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(RigError, match=says):
        held(monkeypatch, RigError("it tripped"), now)


def test_a_board_is_made_ready_by_a_stop_and_a_rest() -> None:
    board = Answered(read_status={"state": State.FAULTED, "position": 5})
    board.make_ready()
    assert board.asked == ["stop", "read_status", "clear_fault", "read_status", "read_status"]
    assert board.clock > 0.0


def test_a_press_is_begun_once() -> None:
    desk = Controls()
    press = Press(RIG.program, 60.0)
    assert (desk.take(), desk.waiting) == (None, False)
    assert desk.offer(press) == ""
    assert desk.waiting
    assert desk.take() is press
    assert (desk.take(), desk.waiting) == (None, False)
    assert desk.offer(press) == BUSY  # until it is over
    desk.stop("a hand")
    assert (press.requested, press.why) == (True, "a hand")
    desk.over()
    assert desk.offer(press) == ""


# -- requests to end
def test_a_request_that_nobody_follows_interrupts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupt, "PATIENCE_S", 0.01)
    until = time.monotonic() + 60.0

    def waits() -> None:
        with interrupt.interruptible() as stop:
            signal.raise_signal(signal.SIGTERM)
            while stop.requested and time.monotonic() < until:
                time.sleep(0.001)

    with pytest.raises(KeyboardInterrupt):
        waits()


def test_a_second_request_by_hand_interrupts_at_once() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with interrupt.interruptible() as stop:
        signal.raise_signal(signal.SIGTERM)
        assert stop.requested
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGTERM) == before


@pytest.mark.skipif(interrupt.GONE is None, reason="Windows has no hang-ups")
def test_a_hang_up_is_never_the_second() -> None:
    assert interrupt.GONE is not None
    with interrupt.interruptible() as stop:
        signal.raise_signal(interrupt.GONE)
        assert stop.requested
        signal.raise_signal(interrupt.GONE)
        signal.raise_signal(signal.SIGTERM)  # the first by hand
        signal.raise_signal(interrupt.GONE)


# -- a disk that refuses while the run waits for it
def test_who_waits_for_a_slow_disk_is_told_why_it_refused(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def sleep(seconds: float) -> None:
        writer._error = OSError(28, "No space left on device")

    writer = JournalWriter(tmp_path / "run.journal", {})
    writer.close()
    monkeypatch.setattr(writing, "BACKLOG", 1)
    monkeypatch.setattr(writing, "time", SimpleNamespace(sleep=sleep))
    writer.append(Kind.SENT, 0.0, b"waits")
    with pytest.raises(DataError, match=r"cannot be written any more \(No space left on"):
        writer.append(Kind.SENT, 0.0, b"more")


# -- facts that are handed from one thread or step to another
@pytest.mark.parametrize(
    "kind",
    [
        LinkTest, Pulse, BenchFile, Place, Source, Dialect, Told, Recording, Trace, Scans, Level,
        Strip, RunFacts, Scale, PortInfo, Pair, Clock, Live, Kept, JournalState, WireProgram,
        Arrays, Record, Journal,
    ],
)  # fmt: skip
def test_facts_that_are_handed_on_do_not_change(kind: type) -> None:
    one = object.__new__(kind)
    with pytest.raises(FrozenInstanceError):
        one.name = "another"
