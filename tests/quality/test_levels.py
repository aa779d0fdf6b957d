"""Speed and current as measured at a stated level, against the simulated motor driven for long."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motorid
from motorid.acquire.record import capture
from motorid.capture import store
from motorid.errors import UsageError
from motorid.estimate.results.estimate import Estimate, MeasuredLevel
from motorid.motor.brushes import Brushes, figure, figure_uncertainty
from motorid.motor.parameters import FIGURES, Motor
from motorid.program import Decay, Program, Step, StepKind
from motorid.quality import levels
from motorid.quality.judge import judge
from motorid.quality.product import Product, parse
from motorid.quality.verdict import Outcome

MOTOR = Motor(2.6, 180e-6, 7.7e-3, 2.4e-7, 4.5e-7, 4.3e-4)
LEVEL = MeasuredLevel(0, 0.1, 0.14, 6.0, 0.006, 750.0, 0.4, 0.08, 0.001)
TRUE = "&heating=0&noise=0&gain_error=0&voltage_gain_error=0&offset_error=0&clock_ppm=0"


def driven_long(rig: Any, options: str, folder: Path) -> tuple[float, float, float]:
    """Speed, current and voltage of the simulated motor after a second at 6 V, without errors."""
    port = f"{rig.port}{TRUE}&{options}"
    steps = (
        Step(StepKind.COAST, 0.01),
        Step(StepKind.DRIVE_VOLTS, 1.0, 6.0, Decay.SYNCHRONOUS_SLOW),
    )
    path = capture(replace(rig, port=port), Program(steps), folder / "long.h5", serial="D000001")
    run = store.load(path)
    late = run.time_s > 0.6
    series = [run.get(name) for name in ("position", "current", "terminal_voltage")]
    x, i, v = (channel.values[late] for channel in series if channel is not None)
    return float(np.polyfit(run.time_s[late], x, 1)[0]), float(i.mean()), float(v.mean())


@pytest.mark.slow
@pytest.mark.parametrize("options", ["brush_drop=0.3&cogging=3e-4", "quadratic=3e-10"])
def test_a_level_is_what_the_motor_does_in_the_end(
    measure: Any, line_rig: Any, tmp_path: Path, options: str
) -> None:
    estimate = motorid.fit(measure(options), model="six")
    speed, current, volts = driven_long(line_rig, options, tmp_path)
    forwards, back = estimate.levels
    for level in (forwards, back):
        assert level.voltage_v is not None
        share = abs(level.voltage_v) / volts
        expected = math.copysign(speed * share, level.voltage_v)
        u = math.hypot(level.speed_u or 0.0, speed * (level.voltage_u or 0.0) / volts)
        assert level.speed_rad_s == pytest.approx(expected, abs=3 * u)
        assert u < 0.01 * speed
        assert abs(level.current_a or 0.0) == pytest.approx(current, abs=3 * (level.current_u or 0))
    derived = estimate.derived["no_load_speed"]
    assert derived.value is not None
    assert estimate.nominal_v is not None
    assert derived.value == pytest.approx(
        speed * estimate.nominal_v / volts, abs=4 * (derived.total or 0.0)
    )


@pytest.mark.slow
def test_a_brush_drop_fails_the_speed_that_it_spoils(measure: Any, product: Product) -> None:
    """1 V of 6: the true speed is below the limit, and so say the parameters with the drop."""
    verdict = judge(motorid.fit(measure("brush_drop=1"), model="six"), product)
    assert verdict.outcome is Outcome.FAIL
    assert verdict["no_load_speed"].outcome is Outcome.FAIL
    assert "settled" in verdict["measured_speed"].reading.problem


def test_a_drop_is_less_where_pwm_swings_the_current() -> None:
    smooth, swung = Brushes(1.0, 0.1), Brushes(1.0, 0.1, 0.2)
    current = np.linspace(0.08 - 0.2, 0.08 + 0.2, 20001)
    assert swung.drop(0.08) == pytest.approx(np.mean(current / np.hypot(current, 0.1)), rel=1e-4)
    assert smooth.drop(0.08) == pytest.approx(0.08 / math.hypot(0.08, 0.1), rel=1e-6)
    assert smooth.slope(0.08) == pytest.approx(0.1**2 / math.hypot(0.08, 0.1) ** 3, rel=1e-6)
    assert swung.drop(-0.08) == -swung.drop(0.08)


def test_the_no_load_speed_solves_its_own_equations() -> None:
    brushes = Brushes(0.8, 0.1, 0.1)
    speed = figure("no_load_speed", MOTOR, 6.0, brushes)
    current = (MOTOR.B * speed + MOTOR.T0) / MOTOR.K
    volts = MOTOR.R * current + MOTOR.K * speed + brushes.drop(current)
    assert volts == pytest.approx(6.0, rel=1e-9)
    stall = figure("stall_current", MOTOR, 6.0, brushes)
    assert MOTOR.R * stall + brushes.drop(stall) == pytest.approx(6.0, rel=1e-9)
    for name, plain in FIGURES.items():
        assert figure(name, MOTOR, 6.0, None) == plain.of(MOTOR, 6.0)
        assert figure(name, MOTOR, 6.0, Brushes(0.0, 0.1)) == pytest.approx(plain.of(MOTOR, 6.0))
    assert figure("no_load_speed", MOTOR, 0.1, Brushes(0.5, 0.01)) == 0.0


def test_an_uncertain_drop_makes_the_speed_uncertain() -> None:
    """dw/dU = -1/(K + R B/K) for a drop that hardly bends."""
    brushes = Brushes(0.5, 1e-6, 0.0, (0.01, 0.0, 0.0))
    u = figure_uncertainty("no_load_speed", MOTOR, 6.0, brushes)
    assert u == pytest.approx(0.1 / (MOTOR.K + MOTOR.R * MOTOR.B / MOTOR.K), rel=1e-3)
    assert figure_uncertainty("Kv", MOTOR, 6.0, brushes) == 0.0


@pytest.mark.parametrize(
    ("level", "said"),
    [
        (replace(LEVEL, voltage_v=5.0), "no steady level of 6 V"),
        (replace(LEVEL, problem="the speed has not settled there"), "has not settled"),
        (replace(LEVEL, speed_u=None), "calibrate"),
        (replace(LEVEL, voltage_u=None), "calibrate"),
    ],
)
def test_a_level_that_cannot_be_judged_says_why(level: MeasuredLevel, said: str) -> None:
    reading = levels.read(levels.Stated("speed", 6.0), [level], 6.0)
    assert reading.value is None
    assert said in reading.problem


def test_a_level_is_reduced_to_its_voltage_and_signed_by_it() -> None:
    near = replace(LEVEL, voltage_v=-5.9, speed_rad_s=-737.5)
    reading = levels.read(levels.Stated("speed", -6.0), [near], 6.0)
    assert reading.value == pytest.approx(750.0)
    assert reading.uncertainty == pytest.approx(
        math.hypot(0.4, 737.5 * 0.006 / 5.9, 0.3 * 12.5), rel=1e-6
    )
    turned = replace(LEVEL, speed_rad_s=-750.0)  # leads or encoder the wrong way round
    assert (levels.read(levels.Stated("speed", 6.0), [turned], 6.0).value or 0.0) < 0.0
    best = levels.read(levels.Stated("current", 6.0), [replace(LEVEL, current_u=0.1), LEVEL], 6.0)
    assert best.uncertainty == pytest.approx(0.001)


@pytest.mark.parametrize(
    ("name", "kind", "volts"),
    [("measured_speed", "speed", None), ("measured_current@-4.5", "current", -4.5)],
)
def test_names_of_levels(name: str, kind: str, volts: float | None) -> None:
    assert levels.stated(name) == levels.Stated(kind, volts)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["measured_speed@", "measured_speed@0", "measured_torque@6"])
def test_no_other_name_is_one(name: str, product: Product) -> None:
    assert levels.stated(name) is None
    with pytest.raises(UsageError, match="no such quantity"):
        parse(product.text + f'\n[limits."{name}"]\nlow = 1\n')


def test_what_is_derived_must_be_what_is_measured(estimate: Estimate, product: Product) -> None:
    assert judge(estimate, product).outcome is Outcome.PASS
    off = [replace(lv, speed_rad_s=(lv.speed_rad_s or 0.0) * 0.97) for lv in estimate.levels]
    verdict = judge(replace(estimate, levels=off), product)
    assert verdict.outcome is Outcome.INVALID
    assert "does not support" in verdict["derived_as_measured"].reason
    bad = parse(product.text.replace("high = 2.8\n", "high = 2.45\n"))
    assert judge(replace(estimate, levels=off), bad).outcome is Outcome.FAIL  # still a bad motor
