"""What coefficients of a momentum balance say of the motor: by algebra."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from motorid.capture.model import CURRENT, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.estimate.partial import mechanical_remarks
from motorid.estimate.partial import mechanical_results as results
from motorid.estimate.partial.block_bootstrap_regression import Regression
from motorid.estimate.partial.mechanical_results import Judge, Quantity
from motorid.estimate.partial.mechanical_signals import COASTING, COMMAND
from motorid.estimate.partial.modulating_functions import Rows
from motorid.estimate.results.estimate import PARAMETERS, UNITS, Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.uncertainty.unstated_gains import PART

FREEDOM = 20
REACH = stats.t.ppf(0.975, FREEDOM)
J, B, T0 = 2e-5, 4e-5, 6e-3
RELATIVE = np.array([0.01, 0.03, 0.02, 0.5])
GAINS = {"J": 0.004, "B": 0.003, "T0": 0.002}


def regression(*coefficients: float) -> Regression:
    """With uncertainties in proportion; those of inertia and viscous friction are correlated."""
    values = np.array([*coefficients, *[0.0] * (4 - len(coefficients))])
    sd = np.abs(values) * RELATIVE
    covariance = np.diag(sd**2)
    covariance[0, 1] = covariance[1, 0] = -0.6 * sd[0] * sd[1]
    none = np.zeros(0)
    rows = Rows(np.zeros((0, 4)), none, none, none, none.astype(int), none.astype(int), none, none)
    kept = np.array([True, True, True, False])
    return Regression(values, covariance, kept, ~np.ones(4, bool), none, FREEDOM, 0.01, rows)


def answer(
    drive: str, best: Regression, linear: bool = False, **fix: float
) -> tuple[Mapping[str, Parameter], Mapping[str, Parameter]]:
    return results._answer(Judge(FREEDOM), best, GAINS, drive, fix, linear)


def relative(p: Parameter) -> float:
    assert p.value is not None
    assert p.total is not None
    return p.total / p.value


def test_a_quantity_has_students_interval_around_both_uncertainties() -> None:
    p = Judge(FREEDOM).parameter("x", "V", Quantity(2.0, 0.03**2, 0.04))
    assert (p.statistical, p.instrument, p.total) == pytest.approx((0.03, 0.04, 0.05))
    assert p.interval_95 == pytest.approx((2.0 - REACH * 0.05, 2.0 + REACH * 0.05))
    assert p.status is Status.ESTIMATED
    assert p.note == ""


@pytest.mark.parametrize(("u", "words"), [(0.29, ""), (0.31, "weakly known: ± 31 %")])
def test_weak_knowledge_is_said(u: float, words: str) -> None:
    p = Judge(FREEDOM).parameter("x", "V", Quantity(1.0, u**2), "note")
    assert p.note == ("note" if not words else f"note; {words} (one standard)")
    assert p.interval_95 is not None
    assert p.interval_95[0] == pytest.approx(1 - REACH * u)


@pytest.mark.parametrize("value", [0.99, -0.5, 0.0])
def test_what_may_be_nothing_is_given_as_a_bound(value: float) -> None:
    p = Judge(FREEDOM).parameter("x", "V", Quantity(value, 1.0))
    assert p.status is Status.NOT_IDENTIFIABLE
    assert f"below {max(value + REACH, 0.0):.2g} V" in p.note


def test_what_is_not_told_or_given_keeps_its_name_and_unit() -> None:
    p = Judge(FREEDOM).parameter("x", "V", Quantity(0.5, 1.0), "note")
    assert (p.name, p.unit) == ("x", "V")
    assert p.note.startswith("note; these data say only that it is below")
    known = results.fixed("K", "N·m/A", 0.05)
    assert (known.name, known.unit, known.value, known.interval_95) == (
        "K", "N·m/A", 0.05, (0.05, 0.05),
    )  # fmt: skip
    assert (known.statistical, known.instrument, known.total) == (0.0, 0.0, 0.0)
    assert known.status is Status.FIXED


@pytest.mark.parametrize(("relative_u", "weak"), [(0.29, False), (0.31, True)])
def test_weak_is_relative(relative_u: float, weak: bool) -> None:
    p = Judge(FREEDOM).parameter("x", "V", Quantity(50.0, (50.0 * relative_u) ** 2))
    assert ("weakly known" in p.note) is weak


def test_an_offset_may_have_either_sign() -> None:
    p = Judge(FREEDOM).parameter("x", "V", Quantity(-0.5, 1.0), signed=True)
    assert p.status is Status.ESTIMATED
    assert p.interval_95 == pytest.approx((-0.5 - REACH, -0.5 + REACH))


def test_a_friction_at_its_bound_is_none_with_an_upper_end() -> None:
    p = Judge(FREEDOM).parameter("B", "1", Quantity(0.0, 0.1**2, at_bound=True), "held")
    assert (p.name, p.unit, p.status, p.value) == ("B", "1", Status.AT_BOUND, 0.0)
    assert p.interval_95 == pytest.approx((0.0, REACH * 0.1))
    assert p.note == "held; the best fit would be negative; set to 0"


def test_a_measured_torque_gives_what_it_moves_and_no_winding() -> None:
    found, ratios = answer(TORQUE, regression(J, B, T0))
    assert ratios == {}
    for k, (name, value) in enumerate((("J", J), ("B", B), ("T0", T0))):
        assert found[name].value == value
        assert relative(found[name]) == pytest.approx(math.hypot(RELATIVE[k], GAINS[name]))
    for name in ("R", "L", "K"):
        assert found[name].value is None
        assert "torque was given" in found[name].note


def test_a_linear_axis_has_other_units_and_names() -> None:
    found, _ = answer(TORQUE, regression(J, B, T0), linear=True)
    assert (found["J"].unit, found["J"].note) == ("kg", "mass")
    assert (found["T0"].unit, found["B"].unit) == ("N", "N·s/m")
    _, ratios = answer(CURRENT, regression(J, B, T0), linear=True)
    assert ratios["J/K"].unit == "A·s²/m"
    _, coast = answer(COASTING, regression(1.0, B / J, T0 / J), linear=True)
    assert coast["T0/J"].unit == "m/s²"


def test_a_current_gives_ratios_to_the_torque_constant() -> None:
    K = 0.05
    found, ratios = answer(CURRENT, regression(J / K, B / K, T0 / K))
    assert {n: p.value for n, p in ratios.items()} == pytest.approx(
        {"J/K": J / K, "B/K": B / K, "T0/K": T0 / K}
    )
    assert [ratios[f"{n}/K"].unit for n in ("J", "B", "T0")] == ["A·s²/rad", "A·s/rad", "A"]
    assert all(p.value is None for p in found.values())
    assert "--fix K=VALUE" in found["J"].note
    assert "no voltage was measured" in found["R"].note


def test_a_given_torque_constant_scales_every_ratio() -> None:
    K = 0.05
    found, _ = answer(CURRENT, regression(J / K, B / K, T0 / K), K=K)
    assert (found["K"].status, found["K"].value) == (Status.FIXED, K)
    for k, (name, value) in enumerate((("J", J), ("B", B), ("T0", T0))):
        assert found[name].value == pytest.approx(value)
        assert relative(found[name]) == pytest.approx(math.hypot(RELATIVE[k], GAINS[name]))


def test_a_given_inertia_gives_the_torque_constant_and_its_uncertainty() -> None:
    K = 0.05
    found, _ = answer(CURRENT, regression(J / K, B / K, T0 / K), J=J)
    assert (found["J"].status, found["J"].value) == (Status.FIXED, J)
    assert found["K"].value == pytest.approx(K)
    assert relative(found["K"]) == pytest.approx(math.hypot(RELATIVE[0], GAINS["J"]))
    assert found["T0"].value == pytest.approx(T0)
    assert found["T0"].statistical == pytest.approx(T0 * math.hypot(RELATIVE[0], RELATIVE[2]))


def test_nothing_follows_from_a_friction_that_is_given_as_none() -> None:
    found, _ = answer(CURRENT, regression(1.0, 2.0, 3.0), B=0.0)
    assert found["K"].value is None
    assert found["J"].value is None


def test_a_coast_gives_what_slows_it_over_the_inertia() -> None:
    best = regression(1.0, B / J, T0 / J)
    found, ratios = answer(COASTING, best)
    assert {n: (p.value, p.unit) for n, p in ratios.items()} == {
        "B/J": (pytest.approx(B / J), "1/s"), "T0/J": (pytest.approx(T0 / J), "rad/s²"),
    }  # fmt: skip
    assert all(p.value is None for p in found.values())
    found, _ = answer(COASTING, best, J=J)
    assert found["B"].value == pytest.approx(B)
    assert found["T0"].value == pytest.approx(T0)
    assert relative(found["T0"]) == pytest.approx(math.hypot(RELATIVE[2], GAINS["T0"]))
    assert (found["J"].status, found["K"].value) == (Status.FIXED, None)


def volts(R: float, K: float) -> Regression:
    """v = JR/K dω/dt + (K + RB/K) ω + T0 R/K."""
    return regression(J * R / K, K + R * B / K, T0 * R / K)


def test_a_voltage_gives_time_constant_gain_and_what_friction_costs() -> None:
    R, K = 2.0, 0.05
    _, ratios = answer(VOLTAGE, volts(R, K))
    whole = K**2 + R * B
    assert ratios["JR/(K²+RB)"].value == pytest.approx(J * R / whole)
    assert ratios["K/(K²+RB)"].value == pytest.approx(K / whole)
    assert ratios["T0·R/K"].value == pytest.approx(T0 * R / K)
    a, b = RELATIVE[:2]
    assert relative(ratios["JR/(K²+RB)"]) == pytest.approx(
        math.sqrt(a**2 + b**2 + 2 * 0.6 * a * b)  # the two are correlated by -.6
    )
    assert relative(ratios["K/(K²+RB)"]) == pytest.approx(math.hypot(b, GAINS["B"]))
    assert [p.unit for p in ratios.values()] == ["s", "rad/s/V", "V"]


def test_a_command_has_no_volts() -> None:
    found, ratios = answer(COMMAND, volts(2.0, 0.05), K=0.05, R=2.0)
    assert [p.unit for p in ratios.values()] == ["s", "rad/s/1", "1"]
    assert found["J"].value is None


def test_a_winding_that_is_given_makes_torques_of_volts() -> None:
    R, K = 2.0, 0.05
    found, _ = answer(VOLTAGE, volts(R, K), K=K, R=R)
    best = volts(R, K)
    share = K / R
    for k, (name, value) in enumerate((("J", J), ("B", B), ("T0", T0))):
        u = share * abs(best.coefficients[k]) * math.hypot(RELATIVE[k], GAINS[name])
        assert found[name].value == pytest.approx(value)
        assert found[name].total == pytest.approx(u)


def test_a_speed_that_no_voltage_holds_gives_no_time_constant() -> None:
    _, ratios = answer(VOLTAGE, regression(1e-3, -0.1, 0.2))
    assert ratios["JR/(K²+RB)"].value is None
    assert ratios["K/(K²+RB)"].value is None
    assert ratios["T0·R/K"].value is not None


@pytest.mark.parametrize(
    ("drive", "channel", "factors"),
    [
        (CURRENT, CURRENT, (-1, -1, -1)),  # it reads too much, so the truth is less
        (CURRENT, SPEED, (1, 1, 0)),
        (COASTING, SPEED, (0, 0, -1)),
    ],
)
def test_a_gain_that_nobody_stated(drive: str, channel: str, factors: tuple[int, int, int]) -> None:
    moved = results._true_coefficients(regression(1.0, 2.0, 3.0), drive, channel)
    wanted = [c * (1 + f * PART) for c, f in zip((1.0, 2.0, 3.0), factors, strict=True)]
    assert moved[:3] == pytest.approx(wanted)


def test_correlation_is_of_what_was_free() -> None:
    assert results._correlation(regression(1.0, 2.0, 3.0)) == pytest.approx(
        np.array([[1, -0.6, 0], [-0.6, 1, 0], [0, 0, 1]])
    )
    fewer = replace(regression(1.0, 2.0, 3.0), free=np.array([True, False, True, False]))
    assert results._correlation(fewer).shape == (2, 2)


def test_every_parameter_has_an_answer_and_its_unit() -> None:
    for drive in (TORQUE, CURRENT, COASTING, VOLTAGE, COMMAND):
        found, _ = answer(drive, regression(1.0, 2.0, 3.0))
        assert {n: found[n].unit for n in PARAMETERS} == {n: UNITS[n] for n in PARAMETERS}


def gained(**uncertainties: float) -> Capture:
    """A capture whose channels declare relative uncertainties of their gains."""
    channels = {
        name: Channel(name, "", np.zeros(3), gain_uncertainty=u)
        for name, u in uncertainties.items()
    }
    return Capture(np.arange(3), 1e6, channels, clock_uncertainty=1e-3)


def test_gains_of_drive_motion_and_clock_come_into_each_coefficient() -> None:
    """A balance J dω + B ∫ω + T0 t = K ∫i: an angle over times squared, and over times."""
    one = gained(current=0.03, speed=0.04)
    found = results._gain_uncertainties([one, gained(current=0.02, speed=0.01)], CURRENT)
    assert found["J"] == pytest.approx(math.sqrt(0.03**2 + 0.04**2 + (2e-3) ** 2))
    assert found["B"] == pytest.approx(math.sqrt(0.03**2 + 0.04**2 + 1e-3**2))
    assert found["T0"] == 0.03
    coast = results._gain_uncertainties([one], COASTING)
    assert coast["J"] == 0.0
    assert coast["B"] == 1e-3
    assert coast["T0"] == pytest.approx(math.hypot(0.04, 2e-3))
    by_angle = results._gain_uncertainties([gained(current=0.0, position=0.05)], CURRENT)
    assert by_angle["B"] == pytest.approx(math.hypot(0.05, 1e-3))
    assert by_angle["T0"] == 0.0


def rowed() -> Regression:
    """Two captures' rows, of which the second has too few for a curve."""
    best = regression(1.0, 2.0, 3.0)
    matrix = np.random.default_rng(2).normal(size=(7, 4))
    weight, capture = np.linspace(1.0, 2.0, 7), np.array([0, 0, 0, 0, 0, 1, 1])
    drive = matrix @ best.coefficients + 0.1 * (-1.0) ** np.arange(7)
    time_s = np.arange(7.0)
    rows = Rows(matrix, drive, weight, time_s, capture, capture, np.ones(7), np.zeros(7))
    return replace(best, rows=rows, residual=drive - matrix @ best.coefficients)


def test_curves_are_the_drive_over_each_bump_measured_and_by_the_model() -> None:
    best = rowed()
    motions: Any = [SimpleNamespace(drive_name=CURRENT, drive_unit="A") for _ in range(2)]
    (curve,) = results._curves(motions, best)
    assert (curve.capture, curve.channel, curve.unit) == (0, CURRENT, "A")
    weight = best.rows.weight[:5]
    assert curve.measured == pytest.approx(best.rows.drive[:5] / weight)
    assert curve.measured - curve.fitted == pytest.approx(0.1 * (-1.0) ** np.arange(5) / weight)
    assert curve.sigma == pytest.approx(np.std(curve.measured - curve.fitted))
    assert curve.time_s.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(("expected", "chi"), [(0.05, 28.0), (0.0, 0.07)])
def test_chi_square_is_in_units_of_what_noise_would_leave(
    expected: float, chi: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mechanical_remarks, "expected_rms", lambda *_: expected)
    assert results._chi_square([], rowed()) == pytest.approx(chi)  # 7 residuals of .1


def test_an_offset_of_the_drive_is_an_answer_where_it_was_free() -> None:
    motion: Any = SimpleNamespace(drive_name=CURRENT, drive_unit="A")
    best = regression(1.0, 2.0, 3.0, -0.2)
    assert results._offset(Judge(FREEDOM), best, motion) == {}
    freed = replace(best, free=np.ones(4, bool))
    ((name, p),) = results._offset(Judge(FREEDOM), freed, motion).items()
    assert (name, p.name, p.unit, p.value) == ("current_offset", "current_offset", "A", -0.2)
    assert p.instrument == 0.0
    assert p.statistical == pytest.approx(0.2 * RELATIVE[3])
