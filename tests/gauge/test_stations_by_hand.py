"""Stations beside each other and agreement of appraisers, by figures made by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from motorid.errors import DataError, UsageError
from motorid.quality.agreement import (
    Ratings,
    Share,
    _interval,
    _weights,
    agreement,
    cohen,
    fleiss,
    ratings_of,
)
from motorid.quality.stations import Pair, Reading, compare

A, B = (1.0, 2.0, 4.0, 7.0, 9.0), (1.5, 1.0, 4.5, 5.0, 9.5)  # apart -0.5, 1, -0.5, 2, -0.5


def readings(
    station: str, values: tuple[float, ...], u: float | None = None, part: str = ""
) -> list[Reading]:
    return [Reading(station, part or str(k), x, u) for k, x in enumerate(values)]


def test_two_stations_by_hand() -> None:
    (found,) = compare([*readings("b", B), *readings("a", A)])
    apart = np.array(A) - np.array(B)
    sd = math.sqrt(float(((apart - 0.3) ** 2).sum()) / 4)
    t = stats.t.ppf(0.975, 4)
    assert (found.first, found.second, found.parts) == ("a", "b", 5)
    assert (found.difference, found.sd) == pytest.approx((0.3, sd))
    half = t * sd / math.sqrt(5)
    assert found.interval_95 == pytest.approx((0.3 - half, 0.3 + half))
    limits = 0.3 - 1.959964 * sd, 0.3 + 1.959964 * sd
    assert found.limits == pytest.approx(limits)
    of_limit = t * sd * math.sqrt(3 / 5)
    assert found.limits_95 is not None
    for ends, limit in zip(found.limits_95, limits, strict=True):
        assert ends == pytest.approx((limit - of_limit, limit + of_limit))
    assert found.p == pytest.approx(stats.ttest_rel(A, B).pvalue)
    middle = (np.array(A) + np.array(B)) / 2
    assert found.slope_p == pytest.approx(stats.linregress(middle, apart).pvalue)
    assert found.e_n is None
    (turned,) = compare([*readings("b", B), *readings("a", A)], reference="a")
    assert (turned.first, turned.second, turned.difference) == ("b", "a", pytest.approx(-0.3))


@pytest.mark.parametrize(
    ("a", "b", "slope", "p"),
    [
        (A[:4], B[:4], False, None),  # too few for a slope
        ((1.0, -1.0, 0.5, -0.5, 2.0), (-1.0, 1.0, -0.5, 0.5, -2.0), False, None),  # one middle
        (A, A, False, 1.0),  # alike to the last digit
        (A, tuple(x - 1.0 for x in A), False, 0.0),  # one difference, and always
        ((0.1, 0.2, 0.15, 0.3, 0.24), (0.12, 0.18, 0.16, 0.31, 0.2), True, None),
    ],
)
def test_when_a_slope_is_asked_for(
    a: tuple[float, ...], b: tuple[float, ...], slope: bool, p: float | None
) -> None:
    (found,) = compare([*readings("a", a), *readings("b", b)])
    assert (found.slope_p is not None) is slope
    assert p is None or found.p == p


def test_motors_are_compared_by_their_means_and_only_common_ones() -> None:
    some = [*readings("a", (1.0, 3.0), part="x"), *readings("a", (5.0,), part="y")]
    other = [*readings("b", (1.0,), part="x"), *readings("b", (2.0, 4.0, 3.0), part="y")]
    (found,) = compare([*some, *other, *readings("a", (99.0,), part="z")])
    assert (found.parts, found.difference) == (2, pytest.approx(1.5))


def test_the_stated_uncertainties_of_a_difference() -> None:
    """Root mean squares of 3 and of 4 stand side by side: 5, expanded to 10."""
    (found,) = compare([*readings("a", A, 3.0), *readings("b", B, 4.0)])
    assert found.e_n == pytest.approx(0.3 / 10.0)
    some = [*readings("a", A[:4], 1.0), Reading("a", "4", 9.0, 7.0)]  # mean square 53/5
    (found,) = compare([*some, *readings("b", B, 2.0)])
    assert found.e_n == pytest.approx(0.3 / (2.0 * math.sqrt(53 / 5 + 4)))
    for unknown in (None, 0.0):
        (found,) = compare([*readings("a", A, 3.0), *readings("b", B, unknown)])
        assert found.e_n is None


def test_one_motor_by_welch() -> None:
    one, other = (1.0, 2.0, 6.0), (4.0, 4.5)
    (found,) = compare(
        [*readings("a", one, 0.3, "G"), *readings("b", other, 0.4, "G"), *readings("b", (1.0,))]
    )
    expected = stats.ttest_ind(one, other, equal_var=False)
    ends = expected.confidence_interval(0.95)
    assert (found.parts, found.difference) == (1, pytest.approx(-1.25))
    assert found.p == pytest.approx(expected.pvalue)
    assert found.interval_95 == pytest.approx((ends.low, ends.high))
    assert found.e_n == pytest.approx(1.25)
    assert found.sd is found.limits is found.limits_95 is found.slope_p is None
    for b, p in (((3.0, 3.0), 1.0), ((4.0, 4.0), 0.0)):
        (same,) = compare([*readings("a", (3.0, 3.0), part="G"), *readings("b", b, part="G")])
        assert (same.p, same.interval_95) == (p, (3.0 - b[0], 3.0 - b[0]))
    for a, b in (((1.0,), (1.0, 2.0)), ((1.0, 2.0), (1.0,))):
        with pytest.raises(DataError, match="often enough"):
            compare([*readings("a", a, part="G"), *readings("b", b, part="G")])
    assert compare([*readings("a", (1.0, 2.0)), *readings("b", (1.0, 2.5))])[0].parts == 2


def test_holms_p_never_passes_one() -> None:
    """Three pairs, of which two are alike to the last digit: 3 times 1 is 1."""
    found = compare([*readings("a", A), *readings("b", A), *readings("c", tuple(
        x + d for x, d in zip(A, (0.5, 0.7, 0.6, 0.5, 0.7), strict=True)))])  # fmt: skip
    by_pair = {(one.first, one.second): one.p for one in found}
    raw = float(stats.ttest_1samp([0.5, 0.7, 0.6, 0.5, 0.7], 0.0).pvalue)
    assert by_pair["a", "b"] == 1.0
    assert by_pair["a", "c"] == by_pair["b", "c"] == pytest.approx(3 * raw)
    equal = compare([one for name in "abc" for one in readings(name, A)])
    assert [one.p for one in equal] == [1.0, 1.0, 1.0]
    with_c = compare([*readings("a", A), *readings("b", A), *readings("c", B)], reference="c")
    assert [(one.first, one.second) for one in with_c] == [("a", "c"), ("b", "c")]


def test_a_pair_differs_below_five_percent() -> None:
    made = ("a", "b", 2, 0.0, (0.0, 0.0), None, None, None)
    for p, differ in ((0.049, True), (0.051, False)):
        assert Pair(*made, p, None, None).differ is differ


# ---- attributes ------------------------------------------------------------------------------


@pytest.mark.parametrize(("found", "of"), [(0, 7), (3, 7), (6, 7), (7, 7), (1, 1)])
def test_the_exact_interval_of_a_share(found: int, of: int) -> None:
    ends = stats.binomtest(found, of).proportion_ci(0.95, "exact")
    assert Share(found, of).interval_95 == pytest.approx((ends.low, ends.high))
    assert Share(found, of).value == pytest.approx(found / of)
    assert math.isnan(Share(0, 0).value)


def test_kappa_by_hand() -> None:
    """Of 2 0 / 1 1: seen 3/4, by chance 2/4 · 3/4 + 2/4 · 1/4 = 1/2. One category: no number."""
    values = cohen(np.array([[[2, 0], [1, 1]], [[4, 0], [0, 0]], [[0, 3], [3, 0]]]))
    assert values[[0, 2]] == pytest.approx([0.5, -1.0])
    assert math.isnan(values[1])
    # 3 raters: agreed 1, 1/3, 1/3; shares 5/9 and 4/9, by chance 41/81
    counts = np.array([[3, 0], [1, 2], [1, 2]])
    assert fleiss(counts)[0] == pytest.approx((5 / 9 - 41 / 81) / (40 / 81))
    # the first part three times, the second once: shares 10/12 and 2/12
    weighed = fleiss(counts, np.array([[3, 1, 0]]))
    assert weighed[0] == pytest.approx(((3 + 1 / 3) / 4 - 104 / 144) / (40 / 144))


def test_parts_are_resampled_a_thousand_times_and_always_alike() -> None:
    drawn = np.random.default_rng(1960).multinomial(4, [0.25] * 4, size=1000)
    assert np.array_equal(_weights(4), drawn)


def test_intervals_of_kappa_need_nine_of_ten_resamples() -> None:
    drawn = np.linspace(0.0, 1.0, 41)
    assert _interval(0.5, drawn) == pytest.approx((0.025, 0.975))
    drawn[-4:] = math.nan
    assert _interval(0.5, drawn) == pytest.approx((0.0225, 0.8775))
    assert _interval(math.nan, drawn) is None
    drawn[-5:] = math.nan
    assert _interval(0.5, drawn) is None


def test_an_attribute_study_of_three() -> None:
    """z never agrees with itself; ratings are in the order of their names, and none is bad."""
    called = {"x": "aa bb aa", "y": "aa bb bb", "z": "ab ba ab"}
    rows = [
        (str(part), who, one)
        for who, all_of_it in called.items()
        for part, said in enumerate(all_of_it.split())
        for one in said
    ]
    parts, who, ratings = (list(column) for column in zip(*rows, strict=True))
    found = agreement(ratings_of(parts, who, ratings))
    assert [(k.first, k.second) for k in found.pairs] == [("x", "y"), ("x", "z"), ("y", "z")]
    assert [one.consistent for one in found.appraisers] == [Share(3, 3), Share(3, 3), Share(0, 3)]
    assert (found.all_agree, found.all_right) == (Share(0, 3), None)
    assert found.with_reference == ()
    assert found.appraisers[0].right is found.appraisers[0].missed is None
    assert found.pairs[0].table is not None
    assert found.pairs[0].table.tolist() == [[2, 2], [0, 2]]
    assert found.overall is not None
    assert found.overall.value == pytest.approx(fleiss(np.array([[5, 1], [1, 5], [3, 3]]))[0])
    assert (found.overall.first, found.overall.second) == ("all", "all")
    two = agreement(
        ratings_of(parts, who, ratings, [dict(zip("012", "aba", strict=True))[p] for p in parts])
    )
    assert [k.second for k in two.with_reference] == ["reference"] * 3
    assert two.appraisers[1].right == Share(2, 3)
    assert two.appraisers[1].missed is two.appraisers[1].alarmed is None
    assert two.with_reference[0].value == pytest.approx(1.0)
    assert two.all_right == Share(0, 3)


def test_one_appraiser_needs_a_reference() -> None:
    parts, said = ["1", "2", "3"], ["a", "b", "b"]
    found = agreement(ratings_of(parts, ["x"] * 3, said, ["a", "b", "a"], "b"))
    assert found.overall is None  # one rating a part agrees with nothing
    assert found.pairs == ()
    (x,) = found.appraisers
    assert (x.right, x.missed, x.alarmed) == (Share(2, 3), Share(0, 1), Share(1, 2))
    assert found.all_right == Share(2, 3)
    alone = np.zeros((2, 1, 1), np.int64), ("1", "2"), ("x",), ("a", "b")
    assert Ratings(*alone, np.array([0, 1])).bad is None
    with pytest.raises(DataError, match="2 appraisers or a reference"):
        Ratings(*alone)
    with pytest.raises(DataError, match="2 parts or more"):
        Ratings(np.zeros((1, 2, 1), np.int64), ("1",), ("x", "y"), ("a", "b"))


def test_ratings_that_make_no_study() -> None:
    parts, who = ["1", "1", "2", "2"], ["x", "y", "x", "y"]
    with pytest.raises(DataError, match="empty rating"):
        ratings_of(parts, who, ["a", "b", "", "a"])
    with pytest.raises(UsageError, match="ratings are a, b"):
        ratings_of(parts, who, ["a", "b", "b", "a"], None, "c")
    with pytest.raises(DataError, match=r"s\.csv is no crossed study: part 2 by y has 0 ratings"):
        ratings_of(parts[:3], who[:3], ["a", "b", "b"], where="s.csv")
    assert ratings_of(parts, who, ["a", "b", "b", "a"], ["c"] * 4).categories == ("a", "b", "c")
