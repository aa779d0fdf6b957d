"""Charts, run rules, drift and the sentences of a trend, by figures made by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import t as student

from motorid.errors import DataError, UsageError
from motorid.quality.charts import Drift, drift, i_mr, xbar_r
from motorid.quality.ranges import d2, d3
from motorid.quality.rules import LIMITS, NELSON, SETS, WESTERN_ELECTRIC, Rule, alarms
from motorid.quality.small_shifts import cusum, ewma
from motorid.quality.trend import Trend, trend

GROUPS = np.array([[1.0, 3.0, 2.0], [4.0, 8.0, 6.0], [2.0, 5.0, 5.0], [20.0, 22.0, 24.0]])
MOVES = np.array([1.0, 3.0, 2.0, 6.0, 6.0, 30.0])


def test_charts_of_subgroups() -> None:
    """Means 2, 6, 4, 22; ranges 2, 4, 3, 4: the first three set the limits about 4 and 3."""
    means, ranges = xbar_r(GROUPS, baseline=3)
    sigma = 3.0 / d2(3)
    of_mean = sigma / math.sqrt(3.0)
    assert means.points.tolist() == [2.0, 6.0, 4.0, 22.0]
    assert (means.name, means.centre, means.baseline, means.first) == ("X-bar", 4.0, 3, 0)
    assert (means.lower, means.upper) == pytest.approx((4 - 3 * of_mean, 4 + 3 * of_mean))
    assert means.sigma == pytest.approx(of_mean)
    assert [(a.index, a.rule) for a in means.alarms] == [(3, "1")]
    assert (ranges.name, ranges.centre, ranges.baseline, ranges.first) == ("R", 3.0, 3, 0)
    assert ranges.points.tolist() == [2.0, 4.0, 3.0, 4.0]
    assert ranges.sigma == pytest.approx(d3(3) * sigma)
    assert (ranges.lower, ranges.upper) == pytest.approx((0.0, 3.0 + 3 * d3(3) * sigma))
    assert ranges.alarms == ()
    assert xbar_r(GROUPS)[0].centre == 8.5
    assert xbar_r(GROUPS)[1].baseline == 4
    wide = np.vstack([GROUPS, [[0.0, 9.0, 18.0]]])
    assert [a.index for a in xbar_r(wide, baseline=3)[1].alarms] == [4]


def test_ranges_of_many_have_a_lower_limit() -> None:
    """Of eight: 1 - 3 d3/d2 is 0.136 of the mean range of 7 (Montgomery, appendix VI)."""
    groups = np.array([[0.0, 6.0, *[3.0] * 6], [0.0, 8.0, *[4.0] * 6], [0.0, 0.5, *[0.2] * 6]])
    _, ranges = xbar_r(groups, baseline=2)
    assert (ranges.lower, ranges.upper) == pytest.approx((0.136 * 7.0, 1.864 * 7.0), abs=8e-3)
    assert [a.index for a in ranges.alarms] == [2]


def test_charts_of_individuals() -> None:
    """Moving ranges 2, 1, 4, 0, 24: of the first four readings, 7/3 in the mean."""
    single, moving = i_mr(MOVES, baseline=4)
    sigma = (7.0 / 3.0) / d2(2)
    assert (single.name, single.centre, single.baseline, single.first) == ("individuals", 3.0, 4, 0)
    assert (single.lower, single.upper) == pytest.approx((3.0 - 3 * sigma, 3.0 + 3 * sigma))
    assert [(a.index, a.rule) for a in single.alarms] == [(5, "1")]
    assert moving.points.tolist() == [2.0, 1.0, 4.0, 0.0, 24.0]
    assert (moving.name, moving.baseline, moving.first) == ("moving range", 3, 1)
    assert moving.centre == pytest.approx(7.0 / 3.0)
    assert moving.sigma == pytest.approx(d3(2) * sigma)
    assert moving.upper == pytest.approx(7.0 / 3.0 + 3 * d3(2) * sigma)
    assert [a.index for a in moving.alarms] == [4]
    assert i_mr(MOVES)[0].centre == 8.0
    assert i_mr(MOVES[:3])[1].centre == 1.5
    assert i_mr(MOVES, baseline=2)[0].centre == 2.0


@pytest.mark.parametrize(
    ("shape", "baseline", "error"),
    [
        ((3, 1), None, DataError), ((3, 26), None, DataError), ((1, 4), None, DataError),
        ((3, 4), 1, UsageError), ((3, 4), 4, UsageError),
    ],
)  # fmt: skip
def test_subgroups_that_make_no_chart(
    shape: tuple[int, int], baseline: int | None, error: type[Exception]
) -> None:
    rng = np.random.default_rng(1)
    with pytest.raises(error):
        xbar_r(rng.normal(size=shape), baseline=baseline)
    for good in ((2, 2), (2, 25)):
        assert xbar_r(rng.normal(size=good), baseline=2)[0].baseline == 2


def test_individuals_that_make_no_chart() -> None:
    with pytest.raises(DataError, match="three readings"):
        i_mr(MOVES[:2])
    for baseline in (1, 7):
        with pytest.raises(UsageError, match="a baseline is 2 points to all 6"):
            i_mr(MOVES, baseline=baseline)
    with pytest.raises(DataError, match="all equal"):
        i_mr(np.array([2.0, 2.0, 5.0]), baseline=2)
    with pytest.raises(DataError, match="all equal"):
        xbar_r(np.ones((3, 2)) * np.arange(3.0)[:, None])


def test_a_pattern_names_its_first_point() -> None:
    """Alarms come by their points, then by their rules; a bound itself is not beyond it."""
    found = alarms(np.array([0.0, 2.5, -0.5, 3.5]), WESTERN_ELECTRIC)
    assert [(a.index, a.first, a.rule) for a in found] == [(3, 3, "1"), (3, 1, "2")]
    assert alarms(np.array([0.0, -2.5, 0.5, -3.5]), WESTERN_ELECTRIC)[1].rule == "2"
    for points in ([3.0], [-3.0], [2.0, 2.0, 2.0], [1.0] * 5, [0.0] * 8):
        assert alarms(np.array(points), WESTERN_ELECTRIC) == (), points
    assert alarms(np.array([-3.1]), LIMITS)[0].index == 0
    assert alarms(np.array([2.5, 2.5, 0.0]), WESTERN_ELECTRIC) == ()  # the last does not complete
    assert alarms(np.array([]), NELSON) == ()


@pytest.mark.parametrize(
    ("rule", "points"),
    [
        ("3", [1.5, 1.2, 0.8, 0.5, 0.2, -0.2]),
        ("4", [-0.3, 0.3] * 7),
        ("2", [-0.2, -0.5] * 4 + [-0.1]),
        ("7", [0.9, -0.9, 0.5] * 5),
        ("8", [-1.5, 1.1, 1.2, -1.3] * 2),
    ],
)
def test_nelsons_patterns_the_other_way(rule: str, points: list[float]) -> None:
    by_name: dict[str, Rule] = {one.name: one for one in NELSON}
    found = alarms(np.array(points), (by_name[rule],))
    assert [(a.index, a.first) for a in found] == [(len(points) - 1, 0)]
    assert alarms(np.array(points[1:]), (by_name[rule],)) == ()
    touched = np.array(points)
    touched[3] = {"3": 0.8, "4": -0.3, "2": 0.0, "7": 1.0, "8": 1.0}[rule]  # a tie, or on the bound
    assert alarms(touched, (by_name[rule],)) == ()
    assert SETS["nelson"] is NELSON


def test_a_tie_is_neither_rising_nor_falling() -> None:
    steady = next(rule for rule in NELSON if rule.name == "3")
    points = np.array([-0.5, -0.2, 0.1, 0.1, 0.3, 0.6])
    assert alarms(points, (steady,)) == alarms(-points, (steady,)) == ()
    points[3] = 0.2
    assert len(alarms(points, (steady,))) == len(alarms(-points, (steady,))) == 1


DAYS = np.array([0.0, 1.0, 2.0, 3.0, 6.0])
GOLD = np.array([1.0, 3.0, 2.0, 5.0, 4.0])


def test_a_drift_by_hand() -> None:
    """About day 2.4 and 3: Sxx 21.2, Sxy 10.0, Syy 10; the slope's t has three degrees."""
    found = drift(DAYS, GOLD)
    sxx = float(((DAYS - 2.4) ** 2).sum())
    slope = float(((DAYS - 2.4) * (GOLD - 3.0)).sum()) / sxx
    left = GOLD - 3.0 - slope * (DAYS - 2.4)
    error = math.sqrt(float(left @ left) / 3 / sxx)
    half = student.ppf(0.975, 3) * error
    assert (found.count, found.days, found.per_day) == (5, 6.0, pytest.approx(slope))
    assert found.interval_95 == pytest.approx((slope - half, slope + half))
    assert found.p == pytest.approx(2 * student.sf(slope / error, 3))
    assert found.total == pytest.approx(6.0 * slope)
    assert not found.significant


def test_what_shows_no_drift() -> None:
    for days, values in ((DAYS[:2], GOLD[:2]), (DAYS[:0], GOLD[:0]), (np.ones(5), GOLD)):
        with pytest.raises(DataError, match="at different times"):
            drift(days, values)
    assert drift(DAYS[:3], GOLD[:3]).count == 3
    for p, significant in ((0.0026, True), (0.0028, False)):
        assert Drift(3, 1.0, 0.0, (0.0, 0.0), p, 0.0).significant is significant


def test_a_weighted_mean_by_hand() -> None:
    """Weight 1/4 about 8: 9, 8.25 and 8.1875; limits of 3 sigma times √(1/7) in the long run."""
    chart = ewma(np.array([12.0, 6.0, 8.0]), 8.0, 2.0, weight=0.25, width=3.0, baseline=2)
    assert chart.points == pytest.approx([9.0, 8.25, 8.1875])
    half = 3.0 * 2.0 * math.sqrt(0.25 / 1.75)
    assert (chart.lower, chart.upper) == pytest.approx((8 - half, 8 + half))
    assert (chart.name, chart.centre, chart.baseline, chart.first) == ("EWMA", 8.0, 2, 0)
    assert chart.sigma == pytest.approx(2.0 * math.sqrt(0.25 / 1.75))
    assert chart.alarms == ()
    down = ewma(np.array([8.0, 0.0, 8.0]), 8.0, 1.0, weight=1.0, width=3.0)
    assert [(a.index, a.first, a.rule) for a in down.alarms] == [(1, 1, "EWMA")]
    usual = ewma(np.array([8.0, 9.0]), 8.0, 1.0)
    assert (usual.points[1], usual.baseline) == (pytest.approx(8.2), 0)
    assert usual.upper == pytest.approx(8.0 + 2.962 / 3.0)  # √(0.2/1.8) is a third


def test_sums_of_small_shifts_by_hand() -> None:
    """About 10 by sigma 2 and K = 1: 12 and 9; sums above 10, 4 slack away, are beyond H."""
    values = np.array([13.0, 10.0, 14.0, 20.0, 2.0, 3.0, 8.0])
    above, below = cusum(values, 10.0, 2.0, slack=0.5, decision=4.0, baseline=3)
    assert above.points == pytest.approx([2.0, 1.0, 4.0, 13.0, 4.0, 0.0, 0.0])
    assert below.points == pytest.approx([0.0, 0.0, 0.0, 0.0, -7.0, -13.0, -14.0])
    assert (above.lower, above.upper, above.centre) == (0.0, 8.0, 0.0)
    assert (below.lower, below.upper, below.centre) == (-8.0, 0.0, 0.0)
    assert (above.sigma, below.sigma, above.baseline, below.baseline) == (2.0, 2.0, 3, 3)
    assert [(a.index, a.first) for a in above.alarms] == [(3, 0)]
    assert [(a.index, a.first) for a in below.alarms] == [(5, 4), (6, 4)]
    usual = cusum(values, 10.0, 2.0)
    assert (usual[0].upper, usual[0].points[0], usual[1].baseline) == (10.0, 2.0, 0)
    assert cusum(values, 10.0, 2.0, slack=0.0)[0].points[0] == 3.0


@pytest.mark.parametrize(
    "call",
    [
        lambda: ewma(MOVES, 0.0, 1.0, weight=1.1), lambda: ewma(MOVES, 0.0, 1.0, width=0.0),
        lambda: ewma(MOVES, 0.0, 1.0, weight=-0.1), lambda: cusum(MOVES, 0.0, 1.0, slack=-0.1),
        lambda: cusum(MOVES, 0.0, 1.0, decision=-1.0),
    ],
)  # fmt: skip
def test_charts_of_small_shifts_that_make_no_sense(call: object) -> None:
    with pytest.raises(UsageError):
        call()  # type: ignore[operator]


def noisy(count: int = 40) -> np.ndarray:
    """In control by every rule of Western Electric: 0.5 to and fro, twice each."""
    return 10.0 + np.resize([0.5, 0.4, -0.5, -0.4], count)


def test_a_trend_holds_what_it_was_made_of() -> None:
    values, days = noisy(), np.arange(40.0)
    plain = trend(values, days)
    assert [c.name for c in plain.charts] == ["individuals", "moving range"]
    assert (plain.quantity, plain.unit, plain.subgroup) == ("value", "", 1)
    assert (plain.rules, plain.capability, plain.drift) == ("western-electric", None, None)
    assert plain.in_control
    assert plain.values is values
    assert plain.days is days
    more = trend(values, days, small_shifts=True, lower=8.0, quantity="R", unit="ohm")
    names = ["individuals", "moving range", "EWMA", "CUSUM above", "CUSUM below"]
    assert [c.name for c in more.charts] == names
    assert {c.baseline for c in more.charts} == {40, 39}
    assert more.charts[2].centre == more.charts[0].centre
    assert more.charts[3].sigma == more.charts[0].sigma
    assert more.capability is not None
    assert (more.capability.lower, more.capability.upper) == (8.0, None)
    assert trend(values, days, upper=12.0).capability is not None
    grouped = trend(values[:39], days[:39], subgroup=4, baseline=5, upper=12.0)
    assert (len(grouped.charts[0].points), grouped.charts[0].baseline) == (9, 5)
    assert grouped.charts[0].name == "X-bar"
    assert grouped.capability is not None
    assert grouped.capability.count == 39


def test_alarms_are_said_by_chart_and_rule() -> None:
    """Points are counted from 1; a moving range belongs to its second reading; eight are shown."""
    values = noisy()
    values[20:30] += np.resize([9.0, 9.5], 10)
    found = trend(values, np.arange(40.0), baseline=20, rules="limits")
    where = "21, 22, 23, 24, 25, 26, 27, 28, …"
    assert found.alarms[0] == (
        f"individuals chart, rule 1: a point beyond three sigma, at point {where}"
    )
    assert found.alarms[1] == (
        "moving range chart, rule 1: a point beyond three sigma, at point 21, 31"
    )
    assert not found.in_control
    values[29] = noisy()[29]
    nine = trend(values, np.arange(40.0), baseline=20, rules="limits")
    assert nine.alarms[0].endswith(f"at point {where}")
    values[28] = noisy()[28]
    eight = trend(values, np.arange(40.0), baseline=20, rules="limits")
    assert eight.alarms[0].endswith("at point 21, 22, 23, 24, 25, 26, 27, 28")


def alarmed(found: Trend) -> list[str]:
    return [said for said in found.alarms if "chart" not in said]


def test_a_golden_motor_that_drifts_is_said() -> None:
    values, days = noisy() + 0.125 * np.arange(40.0), np.arange(40.0)
    found = trend(values, days, golden=True, unit="ohm")
    assert found.drift is not None
    low, high = found.drift.interval_95
    assert alarmed(found) == [
        f"the golden motor drifts by {found.drift.per_day:.3g} ohm a day "
        f"(95 %: {low:.3g} to {high:.3g}): calibrate the station"
    ]
    assert alarmed(trend(values, days, unit="ohm")) == []
    assert alarmed(trend(noisy(), days, golden=True)) == []


def test_an_index_below_what_was_asked_for_is_said() -> None:
    """Of limits at the mean ± 1: Ppk is 1 over three standard deviations."""
    ppk = 1.0 / (3.0 * float(noisy().std(ddof=1)))
    asked = {"lower": 9.0, "upper": 11.0, "shape": "normal"}
    for least, said in (
        (1.01 * ppk, [f"Ppk is {ppk:.2f}, below the {1.01 * ppk:g} that was asked for"]),
        (0.99 * ppk, []),
        (None, []),
    ):
        found = trend(noisy(), np.arange(40.0), least_ppk=least, **asked)  # type: ignore[arg-type]
        assert list(found.alarms) == said
    assert trend(noisy(), np.arange(40.0), least_ppk=9.0).alarms == ()
