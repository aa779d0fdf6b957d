"""Measured levels, their disagreement with the parameters and a dead sensor, by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from motorid.estimate.results.estimate import Estimate, MeasuredLevel, SteadyRow
from motorid.motor.parameters import Motor
from motorid.quality import levels
from motorid.quality.levels import Stated, dead_sensor, disagreement, stated
from tests.quality.made_estimate import VALUES, curve, estimate, parameter

LEVEL = MeasuredLevel(0, 0.1, 0.2, 5.0, 0.02, 400.0, 0.5, 0.2, 0.004)
MOTOR = Motor.of(VALUES)
# R i + K w = U and K i = B w + T0: w = (U K - R T0) / (K² + R B)
SPEED = (5.0 * 0.01 - 2.0 * 5e-4) / (1e-4 + 2e-6)


def test_words_of_a_level() -> None:
    assert Stated("speed", None).meaning == "speed as measured at the product's voltage"
    assert Stated("current", -4.5).meaning == "current as measured at -4.5 V"
    for name, found in (
        ("measured_current", Stated("current", None)), ("measured_speed@+6", Stated("speed", 6.0)),
        ("measured_speed@0.0", None), ("measured_speed@-0", None), ("x_measured_speed", None),
        ("measured_speed@6.", None), ("measured_speed@٦", None),
    ):  # fmt: skip
        assert stated(name) == found, name


@pytest.mark.parametrize(
    ("volts", "near"), [(4.76, True), (4.74, False), (5.24, True), (5.26, False), (None, False)]
)
def test_a_level_counts_within_five_percent(volts: float | None, near: bool) -> None:
    """Of the stated voltage of 5 V, or of the product's."""
    level = replace(LEVEL, voltage_v=volts)
    for asked in (Stated("speed", 5.0), Stated("speed", None)):
        assert (levels.read(asked, [level], 5.0).value is not None) is near
    back = replace(LEVEL, voltage_v=None if volts is None else -volts)
    assert (levels.read(Stated("speed", -5.0), [back], 9.0).value is not None) is near
    assert levels.read(Stated("speed", -5.0), [level], 9.0).value is None


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_speed_follows_its_voltage_and_a_current_does_not(sign: float) -> None:
    """From 5 V to 4.9 V: a speed loses 2 %, of which three tenths are unsure."""
    level = replace(LEVEL, voltage_v=sign * 5.0, speed_rad_s=sign * 400.0, current_a=sign * 0.2)
    speed = levels.read(Stated("speed", sign * 4.9), [level], 1.0)
    assert speed.value == pytest.approx(392.0)
    u = math.hypot(0.5, 400.0 * 0.02 / 5.0, 0.3 * 8.0)
    assert (speed.unit, speed.uncertainty) == ("rad/s", pytest.approx(u))
    current = levels.read(Stated("current", sign * 4.9), [level], 1.0)
    assert (current.unit, current.value) == ("A", pytest.approx(0.2))
    assert current.uncertainty == pytest.approx(math.hypot(0.004, 0.3 * 0.004))


@pytest.mark.parametrize("gone", ["speed_rad_s", "speed_u", "voltage_u"])
def test_what_a_level_lacks(gone: str) -> None:
    found = levels.read(Stated("speed", 5.0), [replace(LEVEL, **{gone: None})], 1.0)
    assert found.value is None
    assert found.problem.startswith("the speed or the voltage was not measured")
    for missing in ("current_a", "current_u", "speed_rad_s"):
        found = levels.read(Stated("current", 5.0), [replace(LEVEL, **{missing: None})], 1.0)
        assert found.problem.startswith("the current or the voltage was not measured")


def test_the_level_that_is_known_best() -> None:
    """Of those without a problem; the first problem is named where each has one."""
    late = replace(LEVEL, speed_rad_s=401.0, speed_u=0.1)
    spoilt = replace(LEVEL, speed_u=0.01, problem="it is too hot")
    found = levels.read(Stated("speed", 5.0), [LEVEL, spoilt, late], 1.0)
    assert found.value == pytest.approx(401.0)
    other = replace(spoilt, problem="it is too cold")
    said = levels.read(Stated("speed", 5.0), [spoilt, other], 1.0)
    assert said.problem == "it is too hot: give its step more time"
    assert said.unit == "rad/s"
    none = levels.read(Stated("current", 5.0), [], 1.0)
    assert (none.unit, none.value) == ("A", None)
    assert "no steady level of 5 V within 5%" in none.problem


def compared(*found: MeasuredLevel, share: float = 0.003) -> str:
    own = parameter("no_load_speed", 500.0, statistical=share * 500.0)
    made = estimate(derived={"no_load_speed": own}, levels=found)
    return disagreement(made, MOTOR)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("off", "said"), [(2.9, False), (-2.9, False), (3.1, True), (-3.1, True)])
def test_three_standard_uncertainties_are_a_disagreement(
    sign: float, off: float, said: bool
) -> None:
    """Of the reading's own 2 rad/s beside 0.3 % of the derived speed."""
    u = math.hypot(2.0, 0.003 * SPEED)
    level = replace(LEVEL, voltage_v=sign * 5.0, speed_rad_s=sign * (SPEED + off * u), speed_u=2.0)
    text = compared(level)
    assert bool(text) is said
    if said:
        assert text.startswith(f"at the level of {5.0 * sign:.3g} V the speed is")
        assert f"{SPEED * sign:.4g} rad/s by the parameters, 3.1 standard" in text


def test_the_worst_level_is_named() -> None:
    worse = replace(LEVEL, speed_rad_s=SPEED - 60.0)
    other = replace(LEVEL, voltage_v=5.1, speed_rad_s=SPEED)
    bad = replace(LEVEL, speed_rad_s=SPEED - 40.0)
    for order in ((bad, worse, other), (worse, bad, other)):
        assert f"{SPEED - 60.0:.4g} rad/s as measured" in compared(*order)


@pytest.mark.parametrize(
    "change", [{"problem": "hot"}, {"voltage_v": 0.0}, {"voltage_v": None}, {"speed_rad_s": None},
               {"speed_u": None}],
)  # fmt: skip
def test_a_level_that_cannot_be_compared(change: dict[str, object]) -> None:
    far = replace(LEVEL, speed_rad_s=100.0)
    assert compared(far)
    assert compared(replace(far, **change)) == ""  # type: ignore[arg-type]
    assert compared(replace(far, **change), far)  # type: ignore[arg-type]


def test_without_a_derived_speed_nothing_disagrees() -> None:
    far = (replace(LEVEL, speed_rad_s=100.0),)
    own = parameter("no_load_speed", 500.0, statistical=1.0)
    assert disagreement(estimate(derived={"no_load_speed": own}, levels=far), MOTOR)
    assert disagreement(estimate(derived={"no_load_speed": own}, levels=far), None) == ""
    for gone in (replace(own, value=None), replace(own, value=0.0), replace(own, statistical=None)):
        assert disagreement(estimate(derived={"no_load_speed": gone}, levels=far), MOTOR) == ""
    assert disagreement(estimate(levels=far), MOTOR) == ""


# ---- a dead sensor -----------------------------------------------------------------------------

STEADY = SteadyRow(0, 0.05, 0.149, 5.0, 0.0, 300.0, 0.0)


def quiet(step: float = 2e-3, count: int = 200) -> np.ndarray:
    """Of a step to and fro: noise of 1.4826/√2 of it."""
    return np.asarray(np.resize([0.0, step], count))


def test_a_current_that_never_leaves_its_noise() -> None:
    """Below 14 standard deviations of the noise in all; of 32 readings or more."""
    noise = 1.4826 / math.sqrt(2.0) * 2e-3
    for most, dead in ((13.9 * noise, True), (14.1 * noise, False)):
        values = quiet()
        values[100] = most
        found = dead_sensor(estimate(curves=(curve("current", values, values),)))
        assert found.startswith("the current never leaves its noise of 0.0021 A") is dead
    for count, dead in ((32, True), (31, False)):
        flat = quiet(count=count)
        assert bool(dead_sensor(estimate(curves=(curve("current", flat, flat),)))) is dead
    other = curve("position", quiet(), quiet())
    assert dead_sensor(estimate(curves=(other,))) == ""


def live(mean: float, extent: float = 40.0) -> np.ndarray:
    """No current but ``mean`` from 0.05 to 0.149 s, beside noise of 2 mA, and one large reading."""
    values = quiet()
    values[50:150] += mean - 1e-3
    values[0] = extent
    return values


def turning(values: np.ndarray, row: SteadyRow = STEADY, **changes: object) -> Estimate:
    return estimate(curves=(curve("current", values, values),), steady=(row,), **changes)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_motor_that_turns_without_a_current(sign: float) -> None:
    """Below five standard uncertainties of the mean of a hundred: 1.05 mA."""
    bound = 5.0 * 1.4826 / math.sqrt(2.0) * 2e-3 / 10.0
    said = f"the motor turns at 300 rad/s without a current: {levels.DEAD}"
    assert dead_sensor(turning(live(sign * 0.9 * bound))) == said
    assert dead_sensor(turning(live(sign * 1.1 * bound))) == ""
    own = {"current offset 1": parameter("current offset 1", 0.0, 1e-3)}
    assert dead_sensor(turning(live(sign * 1.1 * bound), nuisance=own)) == said
    for reach, dead in ((90.0 * bound, False), (110.0 * bound, True)):  # the level is known well
        assert bool(dead_sensor(turning(live(0.0, reach)))) is dead


@pytest.mark.parametrize(
    ("change", "dead"),
    [
        ({"capture": 1}, False), ({"speed_rad_s": None}, False), ({"speed_rad_s": 0.0}, False),
        ({"start_s": 0.1185}, False), ({"start_s": 0.1175}, True), ({"end_s": 0.0805}, False),
        ({"end_s": 0.0815}, True), ({"start_s": 0.0, "end_s": 0.199}, False),
    ],
)  # fmt: skip
def test_which_stretches_show_it(change: dict[str, object], dead: bool) -> None:
    """Of the same capture, while it turns; 31 readings are too few, and 40 A is a current."""
    row = replace(STEADY, **change)  # type: ignore[arg-type]
    assert bool(dead_sensor(turning(live(0.0, 4.0), row))) is dead


def test_the_zero_of_the_current_is_as_sure_as_its_worst_offset() -> None:
    made = {
        "current offset 1": parameter("a", 0.0, 1e-3),
        "current offset 2": parameter("b", 0.0, 3e-3),
        "voltage offset": parameter("c", 0.0, 9.0),
        "current offset 3": replace(parameter("d", 0.0, 1.0), total=None),
    }  # fmt: skip
    assert levels._offset(estimate(nuisance=made)) == 3e-3
    assert levels._offset(estimate()) == 0.0
