"""Charts and capability against published examples and published run lengths."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motorid.errors import DataError, UsageError
from motorid.quality.capability import capability, indices
from motorid.quality.charts import drift, i_mr, xbar_r
from motorid.quality.rules import NELSON, WESTERN_ELECTRIC, alarms
from tests.gauge.published import FLOW_RATES, PISTON_RINGS


def test_piston_rings_charts() -> None:
    """R package qcc 2.7 prints these for the first 25 subgroups."""
    mean, ranges = xbar_r(PISTON_RINGS[:25])
    assert mean.centre == pytest.approx(74.00118, abs=5e-6)
    # qcc divides by d2 = 2.326, cut to three decimals: 3 parts in 100,000
    assert mean.sigma * math.sqrt(5) == pytest.approx(0.009785039, rel=4e-5)
    assert (mean.lower, mean.upper) == pytest.approx((73.98805, 74.0143), abs=5e-6)
    assert ranges.centre == pytest.approx(0.02276, abs=5e-7)
    assert (ranges.lower, ranges.upper) == pytest.approx((0.0, 0.04812533), rel=4e-5)
    assert mean.alarms == ranges.alarms == ()


def test_piston_rings_go_out_of_control() -> None:
    """Montgomery's further 15 subgroups: 37, 38 and 39 lie beyond the limits of the first 25."""
    mean, _ = xbar_r(PISTON_RINGS, baseline=25, rules="limits")
    assert [alarm.index + 1 for alarm in mean.alarms] == [37, 38, 39]
    assert mean.centre == pytest.approx(74.00118, abs=5e-6)


def test_flow_rates() -> None:
    """NIST/SEMATECH e-Handbook 6.3.2.2."""
    chart, moving = i_mr(FLOW_RATES)
    assert round(chart.centre, 2) == 50.81
    assert round(moving.centre, 4) == 1.8778
    # the handbook divides by 1.128; d2 is 1.12838: 3 x 1.8778 x 0.0003 of a difference
    assert (chart.lower, chart.upper) == pytest.approx((45.8159, 55.8041), abs=2e-3)
    assert chart.alarms == moving.alarms == ()


def test_capability_of_the_handbook() -> None:
    """NIST/SEMATECH e-Handbook 6.1.6: limits 8 and 20, mean 16, sigma 2."""
    cp, cpk = indices(16.0, 2.0, 8.0, 20.0, 100, 99)
    assert cp.value == pytest.approx(1.0)
    assert cpk.value == pytest.approx(0.6667, abs=5e-5)


def test_capability_of_piston_rings() -> None:
    """R package qcc 2.7, limits 73.95 and 74.05; it takes n - 1 degrees of freedom for both."""
    rings = PISTON_RINGS[:25].ravel()
    within = 0.009785039  # as qcc prints it
    cp, cpk = indices(float(rings.mean()), within, 73.95, 74.05, 125, 124)
    assert round(cp.value or 0, 3) == 1.703
    assert round(cpk.value or 0, 3) == 1.663
    assert cp.interval == pytest.approx((1.491, 1.915), abs=1e-3)
    assert cpk.interval == pytest.approx((1.448, 1.878), abs=1e-3)
    one_sided, lower = indices(float(rings.mean()), within, 73.95, None, 125, 124)
    assert one_sided.value is None
    assert round(lower.value or 0, 3) == 1.743


def test_capability_of_readings() -> None:
    rings = PISTON_RINGS[:25].ravel()
    result = capability(rings, 73.99, 74.01, subgroup=5)
    assert result.cp.value == pytest.approx(0.3407, abs=1e-4)  # qcc, with its d2 of three decimals
    assert result.cpk.value == pytest.approx(0.3006, abs=1e-4)
    # qcc prints 12 % and 16 % seen outside
    assert result.ppm_seen == pytest.approx(280_000, abs=10_000)
    assert result.pp.value == pytest.approx(0.02 / 6 / rings.std(ddof=1))
    low, high = result.cp.interval or (0, 0)
    assert high - low > 0.383 - 0.2983  # ranges tell less than n - 1 degrees of freedom
    with pytest.raises(UsageError, match="does not lie below"):
        capability(rings, 1.0, 0.0)
    with pytest.raises(DataError, match="equal"):
        capability(np.ones(9), 0.0, 2.0)


@pytest.mark.slow
def test_intervals_of_capability_cover_the_truth() -> None:
    """Cp of 1.2 in 800 samples of 60: the interval by moving ranges holds it 95 times in 100."""
    rng = np.random.default_rng(3)
    held = {"cp": 0, "ppk": 0}
    for _ in range(800):
        result = capability(rng.normal(0.1, 1.0, 60), -3.6, 3.6, shape="normal")
        for name, truth in (("cp", 1.2), ("ppk", 3.5 / 3)):
            low, high = getattr(result, name).interval
            held[name] += low <= truth <= high
    assert held == pytest.approx({"cp": 760, "ppk": 760}, abs=26)


def test_each_nelson_rule_and_no_other() -> None:
    """Nelson (1984): the shortest pattern of each rule raises it, one point fewer does not."""
    patterns = {
        "1": [0.1, -0.2, 3.1],
        "2": [0.5, 0.4, 0.6, 0.2, 0.7, 0.3, 0.5, 0.4, 0.6],
        "3": [-0.5, -0.3, -0.1, 0.1, 0.3, 0.5],
        "4": [0.3, -0.3] * 7,
        "5": [2.1, -0.2, 2.2],
        "6": [1.1, 1.2, -0.1, 1.3, 1.2],
        "7": [0.5, -0.5, -0.2, 0.4, 0.6, -0.3, 0.2, -0.1, -0.4, 0.5, 0.2, -0.6, -0.1, 0.3, -0.2],
        "8": [1.2, -1.3, 1.5, 1.4, -1.2, -1.6, 1.1, -1.4],
    }
    for name, points in patterns.items():
        found = alarms(np.array(points), NELSON)
        assert {a.rule for a in found} == {name}, name
        assert found[-1].index == len(points) - 1
        assert alarms(np.array(points[1:] if name != "1" else points[:-1]), NELSON) == ()


def test_western_electric_zones() -> None:
    points = np.array([2.5, 0.0, 2.5])
    assert [a.rule for a in alarms(points, WESTERN_ELECTRIC)] == ["2"]
    assert alarms(np.array([2.5, 0.0, -2.5]), WESTERN_ELECTRIC) == ()  # not on one side
    assert [a.rule for a in alarms(np.full(8, 0.5), WESTERN_ELECTRIC)] == ["4"]
    assert [a.rule for a in alarms(np.array([1.5, 1.5, 0, 1.5, 1.5]), WESTERN_ELECTRIC)] == ["3"]


@pytest.mark.slow
def test_run_length_of_the_western_electric_rules() -> None:
    """Champ and Woodall (1987): a process in control alarms every 91.75 points on the average."""
    rng = np.random.default_rng(11)
    lengths = []
    for _ in range(4000):
        found = alarms(rng.normal(size=1200), WESTERN_ELECTRIC)
        lengths.append(found[0].index + 1 if found else 1200)
    error = float(np.std(lengths)) / math.sqrt(len(lengths))
    assert float(np.mean(lengths)) == pytest.approx(91.75, abs=4 * error)


def test_drift_is_found_and_not_invented() -> None:
    rng = np.random.default_rng(5)
    days = np.arange(60.0)
    steady = drift(days, 2.6 + rng.normal(0, 0.01, 60))
    moving = drift(days, 2.6 + 0.002 * days + rng.normal(0, 0.01, 60))
    assert not steady.significant
    assert moving.significant
    low, high = moving.interval_95
    assert low <= 0.002 <= high
    with pytest.raises(DataError, match="three readings"):
        drift(days[:2], np.ones(2))


def test_charts_refuse_what_says_nothing() -> None:
    with pytest.raises(DataError, match="equal"):
        i_mr(np.ones(10))
    with pytest.raises(UsageError, match="baseline"):
        i_mr(FLOW_RATES, baseline=40)
