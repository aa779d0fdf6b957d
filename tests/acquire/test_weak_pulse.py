"""A weak pulse on a board that plays back samples, and how the first drive goes by its pulses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.acquire import check, pulse
from motorid.acquire.pulse import Pulse
from motorid.acquire.signs import Sign, SignError
from motorid.errors import RigError
from motorid.program import Step, StepKind
from motorid.rig import Nameplate
from motorid.wire.codec import SampleBlock, channel_mask
from motorid.wire.enums import Channel, ChannelKind
from tests.acquire.rigs import sim_rig

FAST = Nameplate(resistance_ohm=1.0, inertia_kg_m2=1e-6, torque_constant_nm_a=1e-2)  # 10 ms
SLOW = replace(FAST, inertia_kg_m2=1e-3)
RIG = replace(sim_rig(), nameplate=FAST)
CHANNELS = (Channel.CURRENT, Channel.TERMINAL_VOLTAGE, Channel.POSITION)
CONFIG = {"sample_period_ticks": 1000, "channels": channel_mask(CHANNELS)}
ZERO = {"current_offset": 0.0, "current_noise": 0.4, "voltage_offset": 0.0}
FACT = {"scale": 1.0, "raw_min": -999, "raw_max": 999}
GO: Any = SimpleNamespace(requested=False)
DRIVEN = slice(11, 71)  # of 90 samples, 1 ms apart: 10 ms of rest, 60 ms of drive, 20 ms of rest


class Played:
    """A board whose position goes from 5 to 105 in a drive that has these samples."""

    opens, trip = True, ""
    shown: tuple[Channel, ...] = CHANNELS

    def __init__(self, columns: Any, kept: Any, reason: str = "completed") -> None:
        self.identity = {
            "clock_hz": 1_000_000, "decay_modes": 0xFF, "board": "bench", "max_steps": 9,
        }  # fmt: skip
        self.descriptors = {"current": FACT, "terminal_voltage": FACT}
        self.columns, self.kept, self.reason = columns, kept, reason
        self.positions, self.wire = iter((5, 105)), None

    def position(self) -> int:
        return next(self.positions)

    def rest_step(self, seconds: float) -> Step:
        return Step(StepKind.COAST, seconds)

    def drive(self, board: Any, wire: Any, config: Any, stop: Any, consume: Any) -> str:
        assert (board, stop) == (self, GO)
        self.wire = wire
        assert next(self.positions) == 105  # it was asked where it stood before
        self.positions = iter((105,))
        for n in self.kept:
            by_name = dict(zip(CHANNELS, self.columns, strict=True))
            sample = np.array([[by_name[name][n] for name in self.shown]], np.int16)
            consume(SampleBlock(0, 1000 * n, 0, int(self.columns[2][n]), self.shown, sample))
        return self.reason


def pulsed(
    monkeypatch: pytest.MonkeyPatch, board: Played, rig: Any = RIG, **more: bool
) -> Pulse | None:
    loaded: list[Any] = []
    monkeypatch.setattr(pulse, "load", lambda to, wire: loaded.append((to, wire)))
    monkeypatch.setattr(pulse, "drive", board.drive)
    config = CONFIG | {"channels": channel_mask(board.shown)}
    found = pulse.weak_pulse(board, rig, config, ZERO, GO, 0.2, 7.0, **more)  # type: ignore[arg-type]
    assert loaded == [(board, board.wire)]
    return found


def columns() -> list[Any]:
    """Current, volts and counts by sample; edges of the stretches stand out."""
    n = np.arange(90)
    return [100 + n, 300 - n, n**2 // 10]


def test_a_pulse_is_what_came_while_it_drove(monkeypatch: pytest.MonkeyPatch) -> None:
    board = Played(columns(), range(90))
    found = pulsed(monkeypatch, board)
    current, volts, counts = columns()
    assert found is not None
    assert (found.duty, found.volts, found.counts) == (0.2, pytest.approx(1.4), 100)
    assert found.current_a == pytest.approx(np.mean(current[DRIVEN]))
    assert found.peak_a == 170
    assert found.voltage_v == pytest.approx(np.mean(volts[DRIVEN]))
    assert found.coast_v == pytest.approx(np.mean(volts[81:]))  # of the last half of the rest
    assert found.counts_per_s == pytest.approx((counts[70] - counts[56]) / 0.014)  # last quarter
    assert board.wire is not None
    assert [(step["kind"], step["level"], step["ticks"]) for step in board.wire.steps] == [
        (StepKind.COAST, 0, 10_000), (StepKind.DRIVE_DUTY, 200_000, 60_000),
        (StepKind.COAST, 0, 20_000),
    ]  # fmt: skip


def test_a_braked_pulse_is_what_came_while_it_braked(monkeypatch: pytest.MonkeyPatch) -> None:
    board = Played(columns(), range(90))
    found = pulsed(monkeypatch, board, braking=True)
    assert found is not None
    assert found.current_a == pytest.approx(np.mean(columns()[0][71:]))
    assert (found.coast_v, found.counts_per_s) == (None, None)  # 19 samples show no speed
    assert board.wire is not None
    assert board.wire.steps[2]["kind"] == StepKind.BRAKE


def test_terminals_that_stay_shorted_show_no_voltage(monkeypatch: pytest.MonkeyPatch) -> None:
    board = Played(columns(), range(90))
    board.opens = False
    found = pulsed(monkeypatch, board)
    assert found is not None
    assert found.coast_v is None
    board = Played(columns(), range(81))  # none came so late
    found = pulsed(monkeypatch, board)
    assert found is not None
    assert found.coast_v is None


def test_without_sensors_a_pulse_shows_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    board = Played(columns(), range(90))
    board.descriptors, board.shown = {}, (Channel.POSITION,)
    found = pulsed(monkeypatch, board)
    assert found is not None
    assert (found.current_a, found.voltage_v, found.coast_v, found.saturated) == (
        None, None, None, False
    )  # fmt: skip
    assert (found.current_noise_a, found.peak_a, found.counts) == (0.0, 0.0, 100)
    assert found.counts_per_s is not None
    assert not found.draws


@pytest.mark.parametrize(("kept", "known"), [(32, True), (31, False)])
def test_so_many_samples_show_a_speed(
    kept: int, known: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = pulsed(monkeypatch, Played(columns(), [0, *range(11, 11 + kept)]))
    assert found is not None
    assert (found.counts_per_s is not None) is known


@pytest.mark.parametrize(
    ("plate", "ms"),
    [(FAST, 60), (SLOW, 300), (Nameplate(), 187.5), (replace(FAST, inertia_kg_m2=4e-6), 120)],
)  # three mechanical time constants, of eight that are at least 60 ms and at most 2 s
def test_a_pulse_lasts_by_the_motor(
    plate: Nameplate, ms: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    board = Played([np.zeros(1)] * 3, [])
    with pytest.raises(RigError, match="the board sent no samples of the first pulse"):
        pulsed(monkeypatch, board, replace(RIG, nameplate=plate))
    assert board.wire is not None
    assert board.wire.steps[1]["ticks"] == pytest.approx(1000 * ms, abs=500)


def test_a_pulse_whose_samples_were_lost_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(RigError, match="every sample of the first pulse was lost"):
        pulsed(monkeypatch, Played(columns(), range(11)))
    found = pulsed(monkeypatch, Played(columns(), range(12)))
    assert found is not None
    assert found.current_a == 111.0


@pytest.mark.parametrize(
    ("reason", "sign"), [("fault: over_current", Sign.SHORTED), ("fault: over_speed", None)]
)
def test_a_pulse_that_trips_is_said(
    reason: str, sign: Sign | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(
        RigError, match=r"^in the first weak pulse \(20% duty\) the board trip"
    ) as e:
        pulsed(monkeypatch, Played(columns(), range(90), reason))
    assert (e.value.sign if isinstance(e.value, SignError) else None) == sign


def test_a_pulse_that_was_stopped_shows_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(GO, "requested", True)
    assert pulsed(monkeypatch, Played(columns(), range(90))) is None


# -- the first drive
PER_TURN = round(RIG.wiring.counts_per_turn)
TURNS = Pulse(0.1, 0.7, 4, 0.3, 0.01, 0.35, False, None)
STILL = replace(TURNS, counts=3)
BRAKES = replace(TURNS, current_a=-0.3)
IDLES = replace(TURNS, current_a=-0.04)
MEANS = {"current": {"aperture_ns": 50_000, "kind": ChannelKind.MEAN}}
PARTS = {"current": {"aperture_ns": 50_000, "kind": ChannelKind.INSTANT}}
CALM = replace(RIG, nameplate=Nameplate(), voltage_sense="terminals")


class First:
    """A first drive whose pulses are given; notes each pulse and each rest."""

    def __init__(self, facts: Any, *pulses: Pulse | None) -> None:
        self.descriptors, self.identity = facts, {"pwm_hz": 20_000}
        self.coming: Iterator[Pulse | None] = iter(pulses)
        self.did: list[Any] = []

    def wait_for_rest(self) -> None:
        self.did.append("rest")

    def pulse(
        self, board: Any, rig: Any, config: Any, zero: Any, stop: Any, duty: float,
        supply_v: float, braking: bool = False,
    ) -> Pulse | None:  # fmt: skip
        assert (board, rig, config, zero, stop) == (self, CALM, CONFIG, ZERO, GO)
        assert supply_v == 7.0
        self.did.append(("brake" if braking else "drive", duty))
        return next(self.coming)


def first(monkeypatch: pytest.MonkeyPatch, board: First, judged: str = "") -> Any:
    def judge(rig: Any, shown: Pulse) -> None:
        assert (rig, abs(shown.counts) >= 4) == (CALM, True)
        if judged:
            raise RigError(judged)

    monkeypatch.setattr(check, "judge_scale", judge)
    monkeypatch.setattr(check, "weak_pulse", board.pulse)
    return check.check_signs(board, CALM, CONFIG, ZERO, 7.0, GO)  # type: ignore[arg-type]


def drives(*duties: float) -> list[Any]:
    return [what for duty in duties for what in (("drive", duty), "rest")]


def test_the_first_pulse_that_moves_the_motor_is_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    board = First(MEANS, STILL, TURNS)
    found = first(monkeypatch, board)
    assert board.did == drives(0.1, 0.2)
    assert found["counts"] == 4
    assert found["resistance_bound_ohm"] == pytest.approx(0.7 / 0.35 / 1.5)
    with pytest.raises(RigError, match="the sensor is reversed"):
        first(monkeypatch, First(MEANS, BRAKES))
    with pytest.raises(RigError, match="the motor is shorted"):
        first(monkeypatch, First(MEANS, replace(STILL, saturated=True)))
    with pytest.raises(RigError, match="too fast"):
        first(monkeypatch, First(MEANS, TURNS), judged="too fast")
    with pytest.raises(RigError, match="counts backwards"):
        first(monkeypatch, First(MEANS, replace(TURNS, counts=-PER_TURN)))


def test_readings_of_a_part_are_judged_by_a_brake(monkeypatch: pytest.MonkeyPatch) -> None:
    board = First(PARTS, IDLES, BRAKES)
    assert first(monkeypatch, board)["current_a"] == -0.04  # of the drive
    assert board.did == [("drive", 0.1), "rest", ("brake", 0.1), "rest"]
    board = First(PARTS, TURNS, IDLES, TURNS, replace(BRAKES, counts=3), TURNS, BRAKES)
    assert first(monkeypatch, board)["current_a"] == 0.3
    assert [what for what in board.did if what != "rest"] == [
        (kind, duty) for duty in check.DUTIES for kind in ("drive", "brake")
    ]
    assert board.did.count("rest") == 6


def test_a_brake_without_a_current_is_a_dead_sensor(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(RigError, match=r"at 10% duty, but the current sensor reads -0\.04 A while"):
        first(monkeypatch, First(PARTS, *[TURNS, IDLES] * 3))
    with pytest.raises(RigError, match="the encoder stands still"):
        first(monkeypatch, First(PARTS, *[TURNS, replace(BRAKES, counts=3)] * 3))
    with pytest.raises(RigError, match=r"reads -0\.04 A while"):
        first(monkeypatch, First(PARTS, TURNS, IDLES, STILL, STILL))


def test_a_motor_that_never_turns_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    board = First(MEANS, STILL, STILL, STILL)
    with pytest.raises(RigError, match="the encoder stands still"):
        first(monkeypatch, board)
    assert board.did == drives(*check.DUTIES)
    with pytest.raises(RigError, match="the rotor swings by -4 counts"):
        first(monkeypatch, First(MEANS, *[replace(TURNS, counts=-4)] * 3))


def test_a_first_drive_that_was_stopped_has_no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    assert first(monkeypatch, First(MEANS, None)) == {}
    assert first(monkeypatch, First(PARTS, TURNS, None)) == {}
