"""Steady points: degrees of freedom, gains, and rows that are not whole, by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

from motorid.capture.model import CURRENT, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.estimate.partial import steady_state_table as module

UNITS = {CURRENT: "A", SPEED: "rad/s", TORQUE: "N·m", VOLTAGE: "V"}
AMPERES = np.linspace(1.0, 8.0, 10)
OFF = 0.01 * np.array([1.0, -1.0, -1.0, 1.0, 0.0, 0.0, 1.0, -1.0, -1.0, 1.0])  # no line is in it


def table(gain: dict[str, float] | None = None, **columns: Any) -> Capture:
    channels = {
        n: Channel(n, UNITS[n], np.asarray(y, float), gain_uncertainty=(gain or {}).get(n, 0.0))
        for n, y in columns.items()
    }
    return Capture(np.arange(10) * 10**9, 1e9, channels, provenance={"static": True})


def test_an_interval_is_students_of_all_points_but_two() -> None:
    found = module.fit([table(current=AMPERES, torque=0.05 * AMPERES - 0.01 + OFF)])
    K = found.parameters["K"]
    spread = float(np.sum((AMPERES - AMPERES.mean()) ** 2))
    sd = np.sqrt(float(OFF @ OFF) / 8.0 / spread)
    assert K.value == pytest.approx(0.05)
    assert K.statistical == pytest.approx(sd)
    reach = stats.t.ppf(0.975, 8) * sd
    assert K.interval_95 == pytest.approx((0.05 - reach, 0.05 + reach))
    assert (found.degrees_of_freedom, found.evaluations, found.chi_square) == (8, 1, 0.0)
    assert found.correlation.shape == (0, 0)
    assert "a coast-down, would determine it" in found.parameters["J"].note


def test_a_gain_moves_what_it_scales() -> None:
    """A torque that reads 2 % too much makes K and T0 that much too large."""
    one = table({TORQUE: 0.02}, current=AMPERES, torque=0.05 * AMPERES - 0.01 + OFF)
    found = module.fit([one]).parameters
    assert found["K"].instrument == pytest.approx(0.02 * 0.05)
    assert found["T0"].instrument == pytest.approx(0.02 * 0.01)
    (shifted,) = module._shifted([one], {TORQUE: one.channels[TORQUE].values, SPEED: np.zeros(0)})
    assert shifted[TORQUE] == pytest.approx(1.02 * one.channels[TORQUE].values)


def test_volts_name_the_back_emf_constant_beside_the_torque_constant() -> None:
    speed = (12.0 - 0.5 * AMPERES) / 0.05
    one = table(current=AMPERES, speed=speed, torque=0.05 * AMPERES - 0.01 + OFF,
                terminal_voltage=np.full(10, 12.0))  # fmt: skip
    told = module.fit([one]).combinations["Ke"]
    assert (told.name, told.unit) == ("Ke", "V·s/rad")
    assert told.value == pytest.approx(0.05)


def test_a_line_is_judged_by_its_whole_rows() -> None:
    torque = 0.05 * AMPERES - 0.01
    torque[4] = np.nan
    (said,) = module._too_straight({CURRENT: AMPERES, TORQUE: torque})
    assert (said.code, said.severity) == ("computed_table", "warning")
    bent = 0.05 * AMPERES - 0.01 + 1e-3 * (AMPERES - 4.5) ** 2
    assert module._too_straight({CURRENT: AMPERES, TORQUE: bent}) == ()
    missing = np.where(np.arange(10) == 2, np.nan, AMPERES)
    assert len(module._too_straight({CURRENT: missing, TORQUE: torque})) == 1


def test_what_nobody_declared_is_said_once() -> None:
    (said,) = module._undeclared([])
    assert (said.code, said.severity) == ("no_instrument_uncertainty", "info")
    assert module._undeclared([{}]) == ()


def test_three_points_for_two_figures_leave_one_degree_of_freedom() -> None:
    """Off by 1, -2 and 1 about a level line: 6 over one degree, and three readings."""
    values, covariance = module.line(
        np.array([4.0, 1.0, 4.0]), np.array([-1.0, 0.0, 1.0]), np.ones(3)
    )
    assert values == pytest.approx([0.0, 3.0])
    assert np.diag(covariance) == pytest.approx([6.0 / 2.0, 6.0 / 3.0])
