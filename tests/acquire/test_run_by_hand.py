"""One run of a board that says what a test has it say: beats, ends, silences, and what is kept."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.acquire import outputs, pulse, session
from motorid.acquire.contacts import check_inputs
from motorid.acquire.doubts import doubts
from motorid.acquire.drive import drive, load
from motorid.acquire.keep import digest, missing
from motorid.acquire.leftover import is_journal, set_aside, target_of
from motorid.acquire.plan import WireProgram
from motorid.capture.model import CURRENT, POSITION, Capture, Channel, Gap, Phase
from motorid.errors import DataError, LinkError, RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.wire.codec import Event, SampleBlock
from motorid.wire.enums import Channel as WireChannel
from motorid.wire.enums import EndReason, Fault, Input, Mode, State
from tests.acquire.rigs import sim_rig

CONFIG = {"sample_period_ticks": 10, "host_silence_ms": 500, "mode": Mode.STREAM, "config_hash": 5}
WIRE = WireProgram(({"index": 0, "kind": 0, "decay": 0, "level": 0, "ticks": 10_000},), (0,))  # 1 s
DONE = Event("done", {"reason": EndReason.COMPLETED})


class Spoken:
    """A board that says ``news`` at their times, and ``status`` when it is asked."""

    def __init__(self, news: list[tuple[float, Any]], **status: int) -> None:
        self.due, self.status = list(news), {"state": State.IDLE, "fault": 0} | status
        self.identity = {"clock_hz": 10_000}
        self.news: deque[Any] = deque()
        self.port = SimpleNamespace(name="board", now=lambda: self.clock)
        self.clock = self.heard_at = 0.0
        self.trip, self.hasten = "of yore", None
        self.asked: list[tuple[str, dict[str, int]]] = []
        self.told: list[tuple[float, str, dict[str, int]]] = []
        self.alive = True

    def ask(self, name: str, **fields: int) -> dict[str, int]:
        self.asked.append((name, fields))
        self.heard_at = self.clock
        return self.status

    def tell(self, name: str, **fields: int) -> None:
        self.told.append((self.clock, name, fields))

    def check_same(self) -> None:
        self.asked.append(("same", {}))

    def hear(self, timeout_s: float) -> None:
        self.clock += timeout_s
        if self.alive:
            self.heard_at = self.clock
        while self.due and self.due[0][0] <= self.clock:
            self.news.append(self.due.pop(0)[1])


def samples(count: int, sequence: int = 0) -> SampleBlock:
    block = np.zeros((count, 1), np.int16)
    return SampleBlock(sequence, 0, 0, 0, (WireChannel.CURRENT,), block)


def run(board: Any, stop: Any = None, config: Any = CONFIG) -> tuple[str, list[Any]]:
    taken: list[Any] = []
    stop = stop or SimpleNamespace(requested=False)
    return drive(board, WIRE, config, stop, taken.append), taken


def test_a_run_is_started_by_its_hashes_and_beats_until_it_is_done() -> None:
    board = Spoken([(0.3, samples(5, 7)), (1.0, DONE)])
    reason, taken = run(board)
    assert reason == "completed"
    assert [len(one.samples) for one in taken] == [5]
    assert board.asked == [("start", {"config_hash": 5, "program_hash": WIRE.hash})]
    assert board.trip == ""
    beats = [(at, fields["sequence"]) for at, name, fields in board.told if name == "heartbeat"]
    assert np.diff([at for at, _ in beats]) == pytest.approx(0.05, abs=0.0201)  # a tenth of .5 s
    assert {number for at, number in beats if at < 0.28} == {0}
    assert {number for at, number in beats if at > 0.32} == {7}
    assert {name for _, name, _ in board.told} == {"heartbeat"}


def test_a_stop_before_the_start_moves_nothing() -> None:
    board = Spoken([])
    assert run(board, SimpleNamespace(requested=True)) == ("stopped", [])
    assert board.asked == board.told == []


@pytest.mark.parametrize(("at_s", "stops"), [(0.44, True), (0.54, False)])
def test_a_run_that_is_done_too_early_is_stopped(at_s: float, stops: bool) -> None:
    board = Spoken([(at_s, DONE)])
    assert run(board)[0] == "completed"
    assert ("stop" in [name for _, name, _ in board.told]) is stops


@pytest.mark.parametrize(
    ("value", "told"),
    [(int(WireChannel.POSITION), "position"), (int(WireChannel.CURRENT), "current")],
)
def test_a_trip_s_event_names_it_and_its_channel(value: int, told: str) -> None:
    fault = Event("fault", {"fault": Fault.WRONG_SIGN, "value": value})
    board = Spoken([(0.3, fault), (0.4, Event("done", {"reason": EndReason.FAULT}))])
    assert run(board)[0] == "fault: wrong_sign"
    assert board.trip == told


def test_a_trip_whose_event_was_lost_is_asked_for() -> None:
    ended = Event("done", {"reason": EndReason.FAULT})
    board = Spoken([(0.4, ended)], fault=Fault.OVER_SPEED)
    assert run(board)[0] == "fault: over_speed"
    assert board.asked[-1] == ("read_status", {})


def test_a_reset_in_mid_run_ends_it_with_its_cause() -> None:
    board = Spoken([(0.3, Event("hello", {"reset_cause": 99}))])
    with pytest.raises(LinkError, match=r"reset in mid-run .*: check its supply and its cable"):
        run(board)
    assert board.told[-1][1] == "stop"  # every way out asks for an open bridge


@pytest.mark.parametrize(("silence_ms", "patience_s"), [(500, 1.0), (1500, 1.5)])
def test_a_board_that_falls_silent_is_given_up(silence_ms: int, patience_s: float) -> None:
    board = Spoken([])
    board.alive = False
    with pytest.raises(LinkError, match="the board went silent in mid-run"):
        run(board, config=CONFIG | {"host_silence_ms": silence_ms, "mode": Mode.BURST})
    assert board.clock == pytest.approx(patience_s, abs=0.04)


@pytest.mark.parametrize(
    ("status", "reason"),
    [
        ({}, "completed"),
        ({"fault": Fault.OVER_CURRENT}, "fault: over_current"),
        ({"fault": Fault.HOST_SILENCE}, "fault: host_silence"),
    ],
)
@pytest.mark.parametrize(("mode", "lull_s"), [(Mode.STREAM, 1.0), (Mode.BURST, 2.0)])
def test_a_lull_is_asked_about(status: Any, reason: str, mode: Mode, lull_s: float) -> None:
    board = Spoken([], **status)
    assert run(board, config=CONFIG | {"mode": mode})[0] == reason
    assert board.clock == pytest.approx(lull_s, abs=0.05)
    assert ("same", {}) in board.asked
    silence = "no heartbeat came for 0.5 s; they were sent, and lost on the link"
    assert board.trip == (silence if "silence" in reason else "")


def test_a_run_that_should_be_over_and_is_not_is_endless() -> None:
    board = Spoken([], state=State.RUNNING)
    with pytest.raises(LinkError, match="the run does not end: reset the board"):
        run(board)
    assert board.clock == pytest.approx(2.0, abs=0.1)  # a second lull, a second after the end


@pytest.mark.parametrize(("count", "good"), [(3002, True), (3003, False)])
def test_more_samples_than_a_run_can_have_are_endless(count: int, good: bool) -> None:
    # twice 1000 planned ones and twice the steps, and 1000 to spare; the end counts as well
    board = Spoken([(0.2, samples(count - 1)), (0.6, DONE)])
    if good:
        assert run(board)[0] == "completed"
    else:
        with pytest.raises(LinkError, match="does not end"):
            run(board)


def test_a_program_is_put_on_the_board_step_by_step() -> None:
    board: Any = Spoken([], program_hash=WIRE.hash)
    load(board, WIRE)
    assert board.asked == [("clear_program", {}), ("add_step", dict(WIRE.steps[0]))]
    with pytest.raises(LinkError, match="board: the program did not arrive as sent"):
        load(Spoken([], program_hash=WIRE.hash ^ 1), WIRE)  # type: ignore[arg-type]


def test_a_contact_that_is_open_is_named() -> None:
    rig = sim_rig()
    named = [one.name.lower() for one in Input]
    for index, name in enumerate(named):
        board: Any = Spoken([], inputs=1 << Input[name.upper()], pin=4)
        board.identity = {"board": "bench"}
        check_inputs(board, replace(rig, limits=replace(rig.limits, inputs=(name,))))
        other = named[index - 1]
        with pytest.raises(RigError, match=rf"contact {other} is open \(pin 4 of bench\)"):
            check_inputs(board, replace(rig, limits=replace(rig.limits, inputs=(name, other))))


# -- a pulse
def measured(raw: list[int], driven: list[int], **zero: float) -> pulse.Pulse:
    fact = {"scale": -0.5, "raw_min": 0, "raw_max": 99}
    board: Any = SimpleNamespace(descriptors={CURRENT: fact, "terminal_voltage": fact})
    offsets = {"current_offset": 10.0, "voltage_offset": 4.0, "current_noise": 0.4} | zero
    columns = {name: np.array(raw, np.int16) for name in (CURRENT, "terminal_voltage")}
    part = np.array(driven, dtype=bool)
    return pulse._measure(board, columns, part, offsets, 0.25, 8.0, 2**32 - 7)


def test_a_pulse_s_figures_are_of_its_driven_samples() -> None:
    found = measured([0, 6, 20, 2, 99], [0, 1, 1, 1, 0])
    assert (found.duty, found.volts, found.counts) == (0.25, 2.0, -7)
    assert found.current_a == pytest.approx(np.mean([2.0, -5.0, 4.0]))
    assert found.peak_a == 5.0
    assert found.voltage_v == pytest.approx(np.mean([-1.0, -8.0, 1.0]))
    assert found.current_noise_a == pytest.approx(0.5 * 0.5 / np.sqrt(3))  # of .4 and .3 counts
    assert not found.saturated
    assert measured([0, 6], [1, 1]).saturated
    assert measured([99, 6], [1, 1]).saturated


# -- what is kept
def capture(**facts: Any) -> Capture:
    channels = {CURRENT: Channel(CURRENT, "A", np.array([1, 2, 3], np.int16))}
    return Capture(np.array([0, 1000, 2000]), 1e3, channels, **facts)


def test_what_a_capture_lacks_of_its_run() -> None:
    program = Program((Step(StepKind.BRAKE, 7.5),))
    assert missing(capture(program=program)) == ""
    early = "the run ended early (stopped)"
    assert missing(capture(end_reason="stopped")) == early
    assert missing(capture(end_reason="stopped", program=program)) == (
        f"{early}; 2.000 of 7.500 s are here"
    )
    one = replace(capture(end_reason="stopped", program=program), ticks=np.array([5]), channels={})
    assert missing(one) == early
    gaps = (Gap(1, 3, "a"), Gap(2, 4, "b"))
    assert missing(capture(gaps=gaps[:1])) == "3 samples are missing in 1 gap"
    assert missing(capture(gaps=gaps)) == "7 samples are missing in 2 gaps"


def test_a_digest_is_of_ticks_names_types_and_readings() -> None:
    first = capture()
    others = [
        replace(first, ticks=first.ticks + 1),
        *(
            replace(first, channels={name: Channel(name, "A", np.array(raw, kind))})
            for name, raw, kind in (
                ("speed", [1, 2, 3], "i2"), (CURRENT, [1, 2, 4], "i2"), (CURRENT, [1, 2, 3], "i4"),
            )
        ),
    ]  # fmt: skip
    assert len({digest(one) for one in (first, *others)}) == 5
    assert digest(first) == digest(replace(capture(), path="elsewhere", clock_hz=5.0))


def test_journals_names(tmp_path: Path) -> None:
    assert is_journal(Path("run.h5.journal.raw-12"))
    assert not is_journal(Path("run.h5.journal.odd"))
    assert not is_journal(Path(".journal"))
    assert target_of(Path("a/run.h5.journal")) == Path("a/run.h5")
    assert target_of(Path("a/run.h5.journal.old-2")) == Path("a/run.old-2.h5")
    journal = tmp_path / "run.h5.journal"
    names = []
    for why in ("old", "old", "old", "raw"):
        journal.write_text("x")
        names.append(set_aside(journal, why).name.removeprefix("run.h5.journal"))
    assert names == [".old", ".old-2", ".old-3", ".raw"]
    old = tmp_path / "run.h5.journal.old-2"
    assert set_aside(old, "old") == old
    assert set_aside(old, "torn").name == "run.h5.journal.torn"


def test_what_a_run_may_take_of_a_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = sim_rig(program=Program((Step(StepKind.BRAKE, 2.0),)))
    sampling = replace(rig.sampling, rate_hz=1000.0, channels=("current", "position"))
    rig = replace(rig, sampling=sampling)
    # 2000 samples: 8 bytes a tick and 8 a reading; 3 bytes and 2 a reading in a journal
    assert outputs.planned_bytes(rig, rig.program) == (48_000.0, 14_000.0)
    endless = replace(rig, sampling=replace(sampling, rate_hz=float("inf")))
    assert outputs.planned_bytes(endless, rig.program) == (0.0, 0.0)
    paths = [tmp_path / "1.h5", tmp_path / "2.h5"]
    for free, good in ((110_000, True), (109_999, False)):
        monkeypatch.setattr(outputs.shutil, "disk_usage", lambda _, n=free: SimpleNamespace(free=n))
        if good:
            outputs.check_outputs(paths, rig, rig.program, force=False)
        else:
            with pytest.raises(DataError, match="has 0 MB free, and these runs may take 0 MB"):
                outputs.check_outputs(paths, rig, rig.program, force=False)


# -- a level, and sensors that fail
def test_a_level_is_a_mean_with_the_scatter_of_its_blocks_and_its_drift() -> None:
    blocks = np.array([3.0, -3.0, 1.0, -1.0] * 2 + [7.0, 1.0, 5.0, 3.0] * 2)
    found = session.level_of(np.repeat(blocks, 4))
    assert found.mean == pytest.approx(2.0)
    assert found.drift == pytest.approx(4.0)
    scatter = np.std(blocks, ddof=1) / 4.0
    assert found.uncertainty == pytest.approx(np.hypot(scatter, 4.0 / np.sqrt(3)))
    steady = session.level_of(np.full(32, 7.0))
    assert (steady.mean, steady.drift) == (7.0, 0.0)
    assert steady.uncertainty == pytest.approx(1 / np.sqrt(12))  # a count hides what is below it
    with pytest.raises(RigError, match="too few samples of a level"):
        session.level_of(np.zeros(31))


def turning(counts: Any, *steps: Step, ticks: list[int] | None = None) -> list[str]:
    """Doubts about an encoder's counts at 1 kHz, under these steps of 100 samples each."""
    values = np.asarray(counts, dtype=np.int64)
    phases = tuple(Phase(n, 100 * n) for n in range(len(steps)))
    channels = {POSITION: Channel(POSITION, "rad", values)}
    program = Program(steps)
    return doubts(Capture(np.arange(len(values)), 1e3, channels, program=program, phases=phases))


UP = Step(StepKind.DRIVE_VOLTS, 0.1, 3.0, Decay.SYNCHRONOUS_SLOW)
REST = Step(StepKind.COAST, 0.1)


def test_a_count_that_stops_at_once_in_a_drive_is_doubted() -> None:
    moves = np.minimum(np.arange(100) * 2, 2 * 50)
    (said,) = turning(moves, UP)
    assert said.startswith("the encoder stands still from 0.050 s on while the bridge drives")
    assert turning(np.minimum(np.arange(100) * 2, 2 * 60), UP) == []  # for less than two windows
    assert turning(moves, REST) == []
    slowing = np.rint(100 * (1 - (1 - np.minimum(np.arange(100) / 50, 1)) ** 2)).astype(int)
    assert turning(slowing, UP) == []  # as brakes do


def test_a_drive_that_moved_the_motor_once_should_again() -> None:
    turns = np.r_[np.arange(100), np.full(100, 99)]
    assert turning(turns, UP, REST) == []
    (said,) = turning(turns, UP, UP)
    assert "from 0.100 s on" in said
    weaker = replace(UP, level=2.9)
    assert turning(turns, UP, weaker) == []
    assert turning(turns, UP, replace(UP, level=-3.1)) != []
    flicker = turns + np.r_[np.zeros(100, int), np.arange(100) % 2]
    assert turning(flicker, UP, UP) != []
    assert turning(turns + np.r_[np.zeros(100, int), np.arange(100) // 40], UP, UP) == []
