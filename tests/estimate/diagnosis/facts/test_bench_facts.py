"""Facts of a bench that contradict its readings, or one another, are named; others are not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import SUPPLY_BEFORE, Capture, Stated
from motorid.errors import DataError
from motorid.estimate.diagnosis.facts import commanded, pooled, supply
from motorid.estimate.diagnosis.facts.pwm import aliasing
from motorid.estimate.results.estimate import Diagnostic, Estimate, Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, Program, Step, StepKind
from tests.exact_capture import FAULHABER, Plan, clean_capture
from tests.report import example

MOTOR = {
    n: Parameter(n, "", v, 0.0, 0.0, 0.01 * v, None, Status.ESTIMATED) for n, v in FAULHABER.items()
}


@cache
def exact() -> Capture:
    """A run at 6 and 3 V."""
    return clean_capture(FAULHABER, Plan(count=800))


def run(board: str = "A1", serial: str = "", **wiring: Any) -> Capture:
    """A run at 6 and 3 V over a PWM of 20 kHz."""
    capture = exact()
    known = {"identity": {"board": "b"}, "board_serial": board, "serial": serial}
    bench = replace(capture.wiring, **{"pwm_hz": 20_000.0, **wiring})
    return replace(capture, wiring=bench, provenance=known)


def read(capture: Capture, supply_v: float) -> Capture:
    """The same, whose board read its supply before it."""
    return replace(capture, provenance={**capture.provenance, SUPPLY_BEFORE: supply_v})


def by_duty(capture: Capture, supply_v: float) -> Capture:
    """The same, commanded in duties of a supply."""
    assert capture.program is not None
    steps = tuple(
        Step(StepKind.DRIVE_DUTY, s.duration_s, s.level / supply_v, Decay.SYNCHRONOUS_SLOW)
        if s.level
        else s
        for s in capture.program.steps
    )
    return replace(capture, program=Program(steps))


# ---------------------------------------------------------------- supply


def test_a_supply_that_the_board_read_otherwise_is_named_and_not_used() -> None:
    capture = read(run(supply_voltage_v=9.0), 7.0)
    (said,) = supply.findings(capture, MOTOR)
    assert "= 9" in said.message
    assert "7 V" in said.message
    assert not said.moves
    assert capture.supply_v == 7.0


def test_a_nominal_supply_near_the_reading_stays() -> None:
    capture = read(run(supply_voltage_v=7.0), 7.2)
    assert list(supply.findings(capture, MOTOR)) == []
    assert capture.supply_v == 7.0


def test_a_motor_above_its_supply_is_named() -> None:
    (said,) = supply.findings(run(supply_voltage_v=5.0), MOTOR)
    assert "reaches 6 V" in said.message
    assert said.moves["L"] > 0.0


def test_a_duty_gives_the_supply_away() -> None:
    driven = by_duty(run(supply_voltage_v=12.0), 8.0)
    (said,) = supply.findings(driven, MOTOR)
    assert "8 V" in said.message
    assert list(supply.findings(by_duty(run(supply_voltage_v=8.0), 8.0), MOTOR)) == []


# ---------------------------------------------------------------- captures that are pooled


def estimate_of(captures: Sequence[Capture]) -> Estimate:
    """R is 2 ohm, and 1 ohm more where a run is of M18."""
    more = any(c.provenance["serial"] == "M18" for c in captures)
    R = replace(MOTOR["R"], value=3.0 if more else 2.0)
    return replace(example.estimate(), parameters={**MOTOR, "R": R})


def together(captures: Sequence[Capture]) -> list[Diagnostic]:
    """What is said of captures that are fitted together."""
    return list(pooled.findings(captures, estimate_of(captures), estimate_of))


def test_two_serial_numbers_are_named() -> None:
    (said,) = together([run(serial="M17"), run(serial="M17"), run(serial="M18")])
    assert said.severity == "error"
    assert "runs 1, 2 of M17; run 3 of M18" in said.message
    assert said.moves["R"] == pytest.approx(1.0)
    assert said.moves["K"] == 0.0


def test_a_motor_that_tells_nothing_by_itself_leaves_the_size_open() -> None:
    def nothing(captures: Sequence[Capture]) -> Estimate:
        raise DataError("too little")

    runs = [run(serial="M17"), run(serial="M18")]
    (said,) = pooled.findings(runs, estimate_of(runs), nothing)
    assert said.moves["R"] == math.inf


@pytest.mark.parametrize("other", ["", " M17 ", "M17"])
def test_one_serial_number_or_none_is_not(other: str) -> None:
    assert together([run(serial="M17"), run(serial=other)]) == []


def test_one_encoder_has_one_figure() -> None:
    (said,) = together([run(counts_per_turn=2048.0), run(counts_per_turn=512.0)])
    assert "2048" in said.message
    assert "512" in said.message
    two_boards = [run("A1", counts_per_turn=2048.0), run("A2", counts_per_turn=512.0)]
    assert together(two_boards) == []


def test_a_gain_beyond_its_uncertainty_is_named() -> None:
    one, other = run(), run()
    current = other.channels["current"]
    wrong = {**other.channels, "current": replace(current, scale=1.03 * current.scale)}
    (said,) = together([one, replace(other, channels=wrong)])
    assert "scale of the current" in said.message
    sure = {n: replace(c, gain_uncertainty=0.01) for n, c in one.channels.items()}
    assert list(together([replace(one, channels=sure), replace(other, channels=wrong)])) == []


def test_two_nameplates_are_named() -> None:
    plates = [Stated({"resistance_ohm": 2.6}), Stated({"resistance_ohm": 8.4})]
    (said,) = together([replace(run(), stated=s) for s in plates])
    assert said.code == "nameplates_differ"


# ---------------------------------------------------------------- windows over part of a period


def seen_through(aperture_s: float, **changes: Any) -> Capture:
    """A run whose voltage is a mean over so long."""
    capture = run(supply_voltage_v=7.0)
    volts = replace(capture.channels["terminal_voltage"], aperture_s=aperture_s, **changes)
    return replace(capture, channels={**capture.channels, "terminal_voltage": volts})


@pytest.mark.parametrize("periods", [1.0, 2.0, 5.0])
def test_whole_periods_are_not_remarked_on(periods: float) -> None:
    assert list(aliasing.findings(seen_through(periods / 20e3), MOTOR)) == []


@pytest.mark.parametrize(("periods", "wrong"), [(1.6, 0.6), (0.4, 2.0), (0.0, 3.0)])
def test_part_of_a_period_in_step_with_the_samples_is_named(periods: float, wrong: float) -> None:
    kind = "mean" if periods else "instant"
    capture = seen_through(periods / 20e3, kind=kind)
    (said,) = aliasing.findings(capture, MOTOR)
    assert "stays the same" in said.message
    found = aliasing.aliased(capture)
    assert found is not None
    assert found.error_v > wrong
    assert found.error_v == pytest.approx(worst(found.level_v / 7.0, periods), rel=0.02)


def worst(duty: float, periods: float) -> float:
    """V by which a window may be wrong, by trying all places of it."""
    fine = np.arange(200_000) / 100_000.0  # two periods, then as many as are needed
    on = np.tile(np.where(fine % 1.0 < duty, 7.0, 0.0), 2)
    width = max(round(periods * 100_000), 1)
    sums = np.concatenate([[0.0], np.cumsum(on)])
    means = (sums[width:] - sums[:-width]) / width
    return float(np.abs(means - 7.0 * duty).max())


def test_a_filter_before_the_converter_takes_it_away() -> None:
    kept = seen_through(0.0, kind="instant", filter_s=5e-3, delay_s=5e-3)
    assert list(aliasing.findings(kept, MOTOR)) == []


def test_a_fast_beat_is_noise_and_a_slow_one_is_not() -> None:
    fast = replace(seen_through(8e-5), wiring=replace(run().wiring, pwm_hz=21_234.0))
    slow = replace(seen_through(8e-5), wiring=replace(run().wiring, pwm_hz=20_002.0))
    rail = {"supply_voltage_v": 7.0}
    fast, slow = (replace(c, wiring=replace(c.wiring, **rail)) for c in (fast, slow))
    assert list(aliasing.findings(fast, MOTOR)) == []
    (said,) = aliasing.findings(slow, MOTOR)
    assert "comes and goes at 2 Hz" in said.message


# ---------------------------------------------------------------- volts as commanded


def reading(times: float, **changes: Any) -> Capture:
    """A run whose voltage reads so much times what it is."""
    capture = run(supply_voltage_v=9.0)
    volts = capture.channels["terminal_voltage"]
    volts = replace(volts, raw=times * np.asarray(volts.raw), aperture_s=1e-4, **changes)
    return replace(capture, channels={**capture.channels, volts.name: volts})


def test_a_voltage_above_its_command_is_named() -> None:
    (said,) = commanded.findings(reading(1.1), MOTOR)
    assert "reads 6.6 V where the program commands 6 V" in said.message
    assert said.moves["K"] == pytest.approx(0.1 * FAULHABER["K"])


@pytest.mark.parametrize("times", [1.0, 1.03, 0.9])
def test_a_voltage_at_its_command_or_below_is_not(times: float) -> None:
    assert list(commanded.findings(reading(times), MOTOR)) == []


def test_a_gain_that_is_not_sure_is_not_accused() -> None:
    assert list(commanded.findings(reading(1.1, gain_uncertainty=0.02), MOTOR)) == []


@pytest.mark.parametrize("level_v", [0.4, 0.9, 6.0])
def test_a_small_level_is_wrong_by_more_of_itself(level_v: float) -> None:
    """Volts, of a supply of 7 V."""
    part = Part(0, 100, StepKind.DRIVE_VOLTS, level_v, Decay.SYNCHRONOUS_SLOW)
    duty = Part(0, 100, StepKind.DRIVE_DUTY, -level_v / 7.0, Decay.SYNCHRONOUS_SLOW)
    channel = seen_through(0.4 / 20e3).channels["terminal_voltage"]
    found = aliasing._of_part(part, 7.0, channel, 20e3)
    assert found is not None
    assert found.level_v == pytest.approx(level_v)
    assert found.error_v == pytest.approx(worst(level_v / 7.0, 0.4), rel=0.02)
    other = aliasing._of_part(duty, 7.0, channel, 20e3)
    assert other is not None
    assert (other.level_v, other.error_v) == pytest.approx((found.level_v, found.error_v))
