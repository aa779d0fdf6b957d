"""Components of variation, their intervals and their shares, by formulas of the literature."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2
from scipy.stats import f as fisher

from motorid.errors import DataError, UsageError
from motorid.quality.anova import anova_table, nested_sigmas, nested_table
from motorid.quality.gauge import Study, analyse, chi_interval
from motorid.quality.ranges import d2, d2_star, d3, degrees_of_freedom, degrees_of_moving_ranges

# 3 parts x 2 operators x 2 repeats: every mean is whole or a half
TABLE = np.array([[[1.0, 3.0], [4.0, 6.0]], [[7.0, 7.0], [8.0, 12.0]], [[2.0, 4.0], [4.0, 4.0]]])


def study(values: np.ndarray) -> Study:
    parts, operators, _ = values.shape
    return Study(values, tuple("PQRS"[:parts]), tuple("ABC"[:operators]))


def test_the_crossed_table_by_hand() -> None:
    """Cells 2, 5 / 7, 10 / 3, 4; parts 3.5, 8.5, 3.5; operators 4, 19/3; all 31/6."""
    rows = anova_table(TABLE)
    part = 4 * (2 * (3.5 - 31 / 6) ** 2 + (8.5 - 31 / 6) ** 2)
    operator = 6 * ((4 - 31 / 6) ** 2 + (19 / 3 - 31 / 6) ** 2)
    error = 2.0 + 2.0 + 0.0 + 8.0 + 2.0 + 0.0
    total = float(((TABLE - 31 / 6) ** 2).sum())
    both = total - part - operator - error
    names = ("part", "operator", "operator × part", "repeatability", "total")
    squares, degrees = (part, operator, both, error, total), (2, 1, 2, 6, 11)
    for name, square, freedom in zip(names, squares, degrees, strict=True):
        row = rows[name]
        assert (row.source, row.degrees) == (name, freedom)
        assert (row.squares, row.mean) == pytest.approx((square, square / freedom))
    for name, over in (("part", both / 2), ("operator", both / 2), ("operator × part", error / 6)):
        row, against = rows[name], 6 if name == "operator × part" else 2
        assert row.f == pytest.approx(row.mean / over)
        assert row.p == pytest.approx(fisher.sf(row.mean / over, row.degrees, against))
    assert rows["repeatability"].f is rows["total"].p is None


def test_one_operator_has_a_one_way_table() -> None:
    """Parts 2, 7, 3 of mean 4; within them 2 + 0 + 2."""
    rows = anova_table(TABLE[:, :1])
    assert set(rows) == {"part", "repeatability", "total"}
    assert (rows["part"].squares, rows["repeatability"].squares) == pytest.approx((28.0, 4.0))
    assert rows["part"].f == pytest.approx(14.0 / (4.0 / 3.0))
    assert rows["part"].p == pytest.approx(fisher.sf(10.5, 2, 3))
    found = analyse(study(TABLE[:, :1]))
    sigmas = {name: one.sigma for name, one in found.components.items()}
    pv = math.sqrt((14.0 - 4.0 / 3.0) / 2.0)
    ev = math.sqrt(4.0 / 3.0)
    assert sigmas == pytest.approx({"EV": ev, "GRR": ev, "PV": pv, "TV": math.hypot(ev, pv)})
    ends = [math.sqrt(4.0 / chi2.ppf(p, 3)) for p in (0.975, 0.025)]
    for name in ("EV", "GRR"):  # one mean square alone: both intervals are exact
        assert found.components[name].interval_95 == pytest.approx(ends)
    assert not found.pooled


def test_what_has_no_noise_is_not_tested() -> None:
    rows = anova_table(np.repeat(TABLE[:, :1, :1], 2, axis=2))
    assert rows["part"].squares == pytest.approx(2 * ((1 - 10 / 3) ** 2 + (11 / 3) ** 2 + 16 / 9))
    assert rows["part"].f is rows["part"].p is None


def test_the_nested_table_by_hand() -> None:
    """Operators 4 and 19/3; cells about them -2, 3, -1 and -4/3, 11/3, -7/3."""
    rows = nested_table(TABLE)
    part = 2 * (4 + 9 + 1 + (16 + 121 + 49) / 9)
    operator = 6 * 2 * (7 / 6) ** 2
    expected = {"operator": (operator, 1), "part (operator)": (part, 4), "repeatability": (14.0, 6)}
    for name, (square, freedom) in expected.items():
        assert (rows[name].squares, rows[name].degrees) == pytest.approx((square, freedom))
    total = float(((TABLE - 31 / 6) ** 2).sum())
    assert (rows["total"].squares, rows["total"].degrees) == pytest.approx((total, 11))
    assert rows["operator"].f == pytest.approx(operator / (part / 4))
    assert rows["operator"].p == pytest.approx(fisher.sf(operator / (part / 4), 1, 4))
    assert rows["part (operator)"].f == pytest.approx((part / 4) / (14 / 6))
    sigmas = nested_sigmas(rows, 3, 2)
    assert sigmas["PV"] == pytest.approx(math.sqrt((part / 4 - 14 / 6) / 2))
    assert sigmas["EV"] == pytest.approx(math.sqrt(14 / 6))
    assert sigmas["AV"] == 0.0  # the operators differ less than their parts do
    apart = TABLE + np.array([0.0, 20.0])[None, :, None]
    rows = nested_table(apart)
    between = (6 * 2 * (7 / 6 + 10) ** 2 - part / 4) / 6
    assert nested_sigmas(rows, 3, 2)["AV"] == pytest.approx(math.sqrt(between))
    found = analyse(study(apart), method="nested")
    ends = [math.sqrt(14.0 / chi2.ppf(p, 6)) for p in (0.975, 0.025)]
    assert found.components["EV"].interval_95 == pytest.approx(ends)
    assert found.components["GRR"].interval_95 is None
    assert [row.source for row in found.table][:2] == ["operator", "part (operator)"]
    alone = nested_table(TABLE[:, :1])
    assert "operator" not in alone
    assert "AV" not in nested_sigmas(alone, 3, 2)


def large_sample(terms: list[tuple[float, float, int]]) -> tuple[float, float, float]:
    """Graybill and Wang (1980): of weights, mean squares and degrees; sigma and its 95 % ends."""
    total = sum(weight * mean for weight, mean, _ in terms)
    below = above = 0.0
    for weight, mean, degrees in terms:
        g = 1.0 - degrees / chi2.ppf(0.975, degrees)
        h = degrees / chi2.ppf(0.025, degrees) - 1.0
        below += (g * weight * mean) ** 2
        above += (h * weight * mean) ** 2
    ends = total - math.sqrt(below), total + math.sqrt(above)
    return math.sqrt(total), math.sqrt(ends[0]), math.sqrt(ends[1])


def apart() -> np.ndarray:
    """The table with a third of the operators' difference that depends on the part."""
    values = TABLE + np.array([[0.0, 3.0], [0.0, -9.0], [0.0, 9.0]])[:, :, None]
    return values + np.array([0.0, 12.0])[None, :, None]


@pytest.mark.parametrize("alpha", [0.0, 1.0])
def test_sigmas_and_intervals_of_both_models(alpha: float) -> None:
    """Pooled: GRR² = MSo/(pr) + (1 - 1/(pr)) MSe. Full: MSo/(pr) + (1 - 1/p) MSi/r + (1 - 1/r) MSe
    (Burdick, Borror and Montgomery 2005, chapter 3)."""
    rows = anova_table(apart())
    part, operator, both, error = (
        rows[n] for n in ("part", "operator", "operator × part", "repeatability")
    )
    found = analyse(study(apart()), alpha=alpha)
    sigmas = {name: one.sigma for name, one in found.components.items()}
    p, o, r = 3, 2, 2
    assert found.pooled is (alpha == 0.0)
    if found.pooled:
        noise = (error.squares + both.squares) / 8
        terms = [(1 / (p * r), operator.mean, 1), (1 - 1 / (p * r), noise, 8)]
        floor, freedom, ev = noise, 8, noise
        assert "INT" not in sigmas
        table = {row.source: row for row in found.table}
        assert (table["repeatability"].degrees, table["repeatability"].mean) == (8, noise)
        assert table["part"].f == pytest.approx(part.mean / noise)
        assert table["operator"].p == pytest.approx(fisher.sf(operator.mean / noise, 1, 8))
        assert table["operator × part"] == both
        assert table["total"] == rows["total"]
    else:
        terms = [
            (1 / (p * r), operator.mean, 1), ((1 - 1 / p) / r, both.mean, 2),
            (1 - 1 / r, error.mean, 6),
        ]  # fmt: skip
        floor, freedom, ev = both.mean, 6, error.mean
        assert sigmas["INT"] ** 2 == pytest.approx((both.mean - error.mean) / r)
        assert list(found.table) == list(rows.values())
    assert sigmas["EV"] ** 2 == pytest.approx(ev)
    assert sigmas["AV"] ** 2 == pytest.approx((operator.mean - floor) / (p * r))
    assert sigmas["PV"] ** 2 == pytest.approx(max(0.0, (part.mean - floor) / (o * r)))
    sigma, low, high = large_sample(terms)
    grr = found.components["GRR"]
    assert grr.sigma == pytest.approx(sigma)
    assert grr.interval_95 == pytest.approx((low, high))
    ends = [math.sqrt(ev * freedom / chi2.ppf(q, freedom)) for q in (0.975, 0.025)]
    assert found.components["EV"].interval_95 == pytest.approx(ends)
    assert found.components["PV"].interval_95 is None


@pytest.mark.parametrize(("alpha", "pooled"), [(None, False), (0.25, False), (0.1, True)])
def test_an_interaction_is_pooled_by_its_p(alpha: float | None, pooled: bool) -> None:
    """One of p = 0.2 is below the AIAG's 0.25."""
    values = TABLE + np.array([[0.0, 2.0], [0.0, -2.0], [0.0, 0.0]])[:, :, None]
    p = anova_table(values)["operator × part"].p
    assert p is not None
    assert 0.1 < p < 0.25
    assert analyse(study(values), alpha=alpha).pooled is pooled


@pytest.mark.parametrize("bad", [-0.1, 1.1, math.nan])
def test_alpha_is_a_probability(bad: float) -> None:
    with pytest.raises(UsageError, match="alpha is a probability"):
        analyse(study(TABLE), alpha=bad)
    for name in ("tolerance", "process_sigma"):
        for number in (0.0, -1.0, math.nan):
            with pytest.raises(UsageError, match="is a positive width"):
                analyse(study(TABLE), **{name: number})  # type: ignore[arg-type]


def test_average_and_range_by_hand() -> None:
    """Ranges 2, 2, 0, 4, 2, 0 of mean 5/3; parts 3.5 to 8.5; operators 4 to 19/3."""
    found = analyse(study(TABLE), method="range", tolerance=12.0, spread=5.15)
    sigmas = {name: one.sigma for name, one in found.components.items()}
    ev = 5 / 3 / (2 / math.sqrt(math.pi))  # d2 of two is 2/√π
    between = (7 / 3) / math.sqrt(2.0)  # d2* of one range of two is √2
    av = math.sqrt(between**2 - ev**2 / 6)
    pv = 5.0 / d2_star(3, 1)
    grr = math.hypot(ev, av)
    expected = {"EV": ev, "AV": av, "GRR": grr, "PV": pv, "TV": math.hypot(grr, pv)}
    assert sigmas == pytest.approx(expected)
    assert found.ndc == pytest.approx(1.41 * pv / grr)
    assert found.categories == max(1, int(1.41 * pv / grr))
    for one in found.components.values():
        assert one.percent_tolerance == pytest.approx(100 * 5.15 * one.sigma / 12.0)
        assert one.percent_study == pytest.approx(100 * one.sigma / expected["TV"])
        assert one.percent_contribution == pytest.approx(100 * (one.sigma / expected["TV"]) ** 2)
        assert one.interval_95 is None
    assert (found.spread, found.tolerance, found.method) == (5.15, 12.0, "range")
    assert found.table == found.ranges_outside == ()
    alone = analyse(study(TABLE[:, :1]), method="range")
    assert set(alone.components) == {"EV", "GRR", "PV", "TV"}


def test_a_range_beyond_its_limit_is_named() -> None:
    """D4 of two is 3.27: one range of 12 among eleven of 1 has a mean of 23/12 and lies beyond."""
    values = np.zeros((4, 3, 2))
    values[:, :, 1] = 1.0
    values[2, 1, 1] = 12.0
    assert analyse(study(values), method="range").ranges_outside == (("R", "B"),)
    values[2, 1, 1] = 4.0  # 3.2 times the mean of 1.25
    assert analyse(study(values), method="range").ranges_outside == ()


def test_a_known_process_stands_for_the_whole() -> None:
    plain = analyse(study(TABLE), method="range")
    grr = plain.grr.sigma
    wide = analyse(study(TABLE), method="range", process_sigma=2.0 * grr)
    assert wide.components["PV"].sigma == pytest.approx(math.sqrt(3.0) * grr)
    assert wide.components["TV"].sigma == pytest.approx(2.0 * grr)
    assert wide.ndc == pytest.approx(1.41 * math.sqrt(3.0))
    assert (wide.categories, wide.grr.percent_contribution) == (2, pytest.approx(25.0))
    narrow = analyse(study(TABLE), method="range", process_sigma=0.5 * grr)
    assert (narrow.components["PV"].sigma, narrow.ndc, narrow.categories) == (0.0, 0.0, 1)


def test_a_gauge_that_never_differs() -> None:
    """Its resolution hides its spread: no number of categories; what is nothing has no share."""
    flat = np.repeat(np.arange(3.0)[:, None, None], 2, axis=2)
    found = analyse(study(flat))
    assert (found.ndc, found.categories) == (math.inf, None)
    assert found.components["PV"].percent_study == pytest.approx(100.0)
    assert found.grr.percent_tolerance is None
    nothing = analyse(study(0.0 * flat), method="range")
    assert math.isnan(nothing.grr.percent_study)
    assert math.isnan(nothing.grr.percent_contribution)


def test_a_study_states_its_repeatability() -> None:
    known = replace(study(TABLE), stated=np.full(TABLE.shape, 1.0) + 6.0 * (TABLE == 12.0))
    assert analyse(known).stated_sigma == pytest.approx(math.sqrt((11 + 49) / 12))
    assert analyse(study(TABLE)).stated_sigma is None
    assert study(TABLE[:, :, :2]).repeats == 2


@pytest.mark.parametrize(
    ("values", "names", "says"),
    [
        (TABLE[:1], ("P",), "2 parts or more"),
        (TABLE[:, :, :1], ("P", "Q", "R"), "2 parts or more"),
        (TABLE, ("P", "Q"), "disagree"),
        (np.where(TABLE == 12.0, np.nan, TABLE), ("P", "Q", "R"), "is missing"),
        (np.where(TABLE == 12.0, np.inf, TABLE), ("P", "Q", "R"), "is missing"),
    ],
)
def test_a_study_that_is_none(values: np.ndarray, names: tuple[str, ...], says: str) -> None:
    with pytest.raises(DataError, match=says):
        Study(values, names, ("A", "B"))
    assert study(TABLE[:2]).values.shape == (2, 2, 2)
    with pytest.raises(DataError, match="disagree"):
        Study(TABLE, ("P", "Q", "R"), ("A",))


@pytest.mark.parametrize("level", [0.95, 0.8])
def test_the_interval_of_a_standard_deviation(level: float) -> None:
    low, high = chi_interval(3.0, 7.5, level)
    ends = (1 - level) / 2, (1 + level) / 2
    assert 7.5 * 9.0 / low**2 == pytest.approx(chi2.ppf(ends[1], 7.5))
    assert 7.5 * 9.0 / high**2 == pytest.approx(chi2.ppf(ends[0], 7.5))
    assert chi_interval(3.0, 7.5) == pytest.approx(chi_interval(3.0, 7.5, 0.95))


def test_moments_of_ranges_in_closed_form() -> None:
    """Two: |x - y| of mean 2/√π and variance 2 - 4/π; three: a mean of 3/√π."""
    assert d2(2) == pytest.approx(2 / math.sqrt(math.pi), rel=1e-9)
    assert d3(2) == pytest.approx(math.sqrt(2 - 4 / math.pi), rel=1e-6)
    assert d2(3) == pytest.approx(3 / math.sqrt(math.pi), rel=1e-9)
    assert d2_star(2, 4) == pytest.approx(math.sqrt(4 / math.pi + (2 - 4 / math.pi) / 4), rel=1e-6)
    with pytest.raises(ValueError, match="not 1"):
        d2(1)


def test_degrees_of_freedom_of_mean_ranges() -> None:
    """By 1/(2 cv²) + 1/4; neighbours' moving ranges are correlated by 0.2247."""
    cv2 = (2 - 4 / math.pi) / (4 / math.pi)  # of one range of two
    assert degrees_of_freedom(2, 1) == pytest.approx(0.5 / cv2 + 0.25, rel=1e-6)
    assert degrees_of_freedom(2, 10) == pytest.approx(5.0 / cv2 + 0.25, rel=1e-6)
    for count in (3, 20):
        ranges = count - 1
        share = 1 + 2 * 0.2247 * (ranges - 1) / ranges
        expected = 0.5 * ranges / (cv2 * share) + 0.25
        assert degrees_of_moving_ranges(count) == pytest.approx(expected, rel=1e-6)
