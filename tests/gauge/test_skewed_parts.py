"""The parts of the performance of skewed processes: resamples, intervals, bounds and refusals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from motorid.errors import DataError, UsageError
from motorid.quality import skewed
from motorid.quality.capability import capability, indices, sigma_within
from motorid.quality.pearson_curve import PearsonCurve, curve_of
from motorid.quality.ranges import d2, degrees_of_freedom, degrees_of_moving_ranges
from motorid.quality.skewed import best_power, by_box_cox, by_percentiles, normality

FEW = np.array([1.2, 0.7, 2.9, 1.6, 0.9, 4.2, 1.1, 2.2, 0.8, 1.4])


@pytest.fixture
def draws(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """The resamples of FEW as the bootstrap draws them, reading by reading; 30 instead of 1000."""
    monkeypatch.setattr(skewed, "DRAWS", 30)
    often = np.random.default_rng(1964).multinomial(10, np.full(10, 0.1), size=30)
    return [np.repeat(np.sort(FEW), times) for times in often]


def test_a_thousand_resamples_of_as_many_readings() -> None:
    found = skewed._resampled(np.ones((2, 1)), np.array([0.25, 0.75]), 8)
    assert found.tolist() == [[8.0]] * 1000


def test_the_curves_of_resamples_have_their_moments(draws: list[np.ndarray]) -> None:
    found = skewed._resampled_curve(FEW)
    assert found.mean == pytest.approx([one.mean() for one in draws])
    assert found.sd == pytest.approx([one.std(ddof=1) for one in draws])
    assert found.skewness == pytest.approx([stats.skew(one, bias=False) for one in draws])
    assert found.kurtosis == pytest.approx([stats.kurtosis(one, bias=False) for one in draws])


def test_a_resample_in_blocks_is_the_same(
    draws: list[np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = skewed._resampled_curve(FEW)
    monkeypatch.setattr(skewed, "LARGEST", 70)  # blocks of 7 of the 30
    parts = skewed._resampled_curve(FEW)
    assert len(parts.mean) == len(draws)
    assert parts.mean.tolist() == pytest.approx(whole.mean.tolist())


@pytest.mark.slow
@pytest.mark.parametrize("search", [True, False])
def test_the_powers_of_resamples_are_their_best(draws: list[np.ndarray], search: bool) -> None:
    """Of the largest likelihood by SciPy; a known power is everyone's."""
    scaled = FEW / stats.gmean(FEW)
    mean, sd, power = skewed._resampled_powers(scaled, 0.3, search)
    for k, one in enumerate(draws[:10]):
        here = one / stats.gmean(FEW)
        best = float(stats.boxcox_normmax(here, method="mle"))
        if not search:
            assert power[k] == 0.3
        elif abs(best) < 4.9:
            assert power[k] == pytest.approx(best, abs=0.06)  # the grid's step is 0.05
        shown = stats.boxcox(here, power[k])
        assert (mean[k], sd[k]) == pytest.approx((shown.mean(), shown.std(ddof=1)))
    assert np.abs(power).max() <= skewed.STEEPEST


def test_many_readings_are_means_of_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    bins, shares = skewed._bins(np.array([3.0, 1.0, 2.0]))
    assert (bins.tolist(), shares.tolist()) == ([1.0, 2.0, 3.0], pytest.approx([1 / 3] * 3))
    monkeypatch.setattr(skewed, "MOST_BINS", 3)
    bins, shares = skewed._bins(np.array([9.0, 1.0, 2.0, 8.0, 4.0, 3.0, 20.0]))
    assert bins.tolist() == pytest.approx([2.0, 7.0, 20.0])
    assert shares.tolist() == pytest.approx([3 / 7, 3 / 7, 1 / 7])


def test_intervals_of_a_bootstrap() -> None:
    """Of 0 to 100 the 80 % between 10 and 90; of logarithms about the value, less their bias."""
    assert skewed._percentiles(7.0, np.arange(101.0), 0.8) == pytest.approx((10.0, 90.0))
    drawn = np.exp(np.array([-0.1, 0.1, 0.3]))  # mean 0.1, standard deviation 0.1633
    half = stats.norm.ppf(0.9) * math.sqrt(0.08 / 3)
    low, high = skewed._less_bias(math.e, drawn, 0.8)
    assert (math.log(low), math.log(high)) == pytest.approx((1.9 - half, 1.9 + half))
    low, high = skewed._less_bias(math.exp(-0.5), drawn, 0.8)
    assert (math.log(low), math.log(high)) == pytest.approx((-1.1 - half, -1.1 + half))
    for value, some in ((0.0, drawn), (-1.0, drawn), (1.0, drawn - drawn[0]), (1.0, drawn - 2.0)):
        assert skewed._less_bias(value, some, 0.8) == skewed._percentiles(value, some, 0.8)


def test_nine_of_ten_resamples_must_have_an_index() -> None:
    value, drawn = np.array([1.0]), np.arange(1.0, 21.0)
    drawn[:2] = math.nan
    of_two = skewed._with_intervals((value, 2 * value), (drawn, drawn), 0.9, skewed._percentiles)
    assert of_two[0] is not None
    assert (of_two[0][0], of_two[1][0]) == (1.0, 2.0)
    assert of_two[1][1:] == pytest.approx(np.quantile(np.arange(3.0, 21.0), [0.05, 0.95]))
    one_sided = skewed._with_intervals((None, value), (None, drawn), 0.9, skewed._percentiles)
    assert one_sided[0] is None
    drawn[2] = math.inf
    for found, some in ((value, drawn), (value * math.nan, np.arange(1.0, 21.0))):
        with pytest.raises(DataError, match="too much alike"):
            skewed._with_intervals((None, found), (None, some), 0.9, skewed._percentiles)


@pytest.mark.parametrize(
    ("shown", "power", "reading"),
    [
        (1.5, 0.0, math.exp(1.5)), (1.5, 2.0, 2.0), (-0.75, -0.5, 1 / 1.375**2),
        (-0.5, 2.0, 0.0), (-2.0, 2.0, 0.0), (2.0, -0.5, math.inf), (3.0, -1.0, math.inf),
    ],
)  # fmt: skip
def test_the_way_back_from_a_power(shown: float, power: float, reading: float) -> None:
    assert skewed._back(shown, power) == pytest.approx(reading)


def test_the_index_is_of_the_nearer_limit() -> None:
    low, middle, high = (np.array([x]) for x in (1.0, 2.0, 5.0))
    pp, ppk = skewed._by_quantiles(low, middle, high, 0.5, 11.0)
    assert pp is not None
    assert (pp[0], ppk[0]) == pytest.approx((10.5 / 4.0, 1.5))
    assert skewed._by_quantiles(low, middle, high, None, 11.0)[1][0] == pytest.approx(3.0)
    for ends in ((None, 11.0), (0.5, None)):
        assert skewed._by_quantiles(low, middle, high, *ends)[0] is None
    mean, sd, power = (np.array([x]) for x in (1.0, 0.5, 2.0))
    pp, ppk = skewed._by_moments(mean, sd, power, 1.0, 3.0)  # squares: 0 and 4
    assert pp is not None
    assert (pp[0], ppk[0]) == pytest.approx((4.0 / 3.0, 2.0 / 3.0))
    pp, ppk = skewed._by_moments(mean, sd, power, None, 3.0)
    assert (pp, ppk[0]) == (None, pytest.approx(2.0))
    assert skewed._by_moments(mean, sd, power, 1.0, None)[0] is None


@pytest.mark.parametrize("member", [stats.norm(3.0, 2.0), stats.gamma(4.0), stats.beta(2, 5)])
def test_scores_are_the_deviates_of_the_share_below(member: stats.rv_continuous) -> None:
    moments = member.stats("mvsk")
    curve = PearsonCurve(
        *(np.array([float(x)]) for x in (*moments[:1], member.std(), *moments[2:]))
    )
    shares = np.array([0.0005, 0.03, 0.3, 0.5, 0.8, 0.995])
    found = skewed._scores(curve, np.asarray(member.ppf(shares)))
    assert found == pytest.approx(stats.norm.ppf(shares), abs=5e-3)


def test_many_readings_are_thinned_for_the_test_of_normality() -> None:
    values = np.random.default_rng(3).normal(size=10_003)
    assert normality(values) == pytest.approx(stats.shapiro(values[::3]).pvalue, rel=1e-2)
    assert normality(values[:5000]) == pytest.approx(stats.shapiro(values[:5000]).pvalue, rel=1e-2)


def powered(power: float, count: int = 400) -> np.ndarray:
    """Readings that are normal after that power, by even quantiles."""
    shown = stats.norm.ppf((np.arange(count) + 0.5) / count, 10.0, 1.0)
    return np.asarray(shown ** (1.0 / power))


@pytest.mark.parametrize(("power", "found"), [(2.0, 2.0), (-2.0, -2.0), (8.0, None), (-9.0, None)])
def test_powers_that_are_too_steep(power: float, found: float | None) -> None:
    best = best_power(powered(power))
    assert best == (found if found is None else pytest.approx(found, abs=0.15))


def test_a_power_without_an_overflow() -> None:
    assert skewed._most(np.array([0.5, 2.0])) == 5.0
    assert skewed._most(np.array([1.0, math.exp(-150.0)])) == pytest.approx(4.0)
    assert skewed._most(np.array([1.0, math.exp(300.0)])) == pytest.approx(2.0)


def test_box_cox_of_a_known_power() -> None:
    """Of squares: limits, mean and percentiles by the normal distribution of these."""
    values, ends = powered(2.0, 60), (2.0, 3.8)
    found = by_box_cox(values, *ends, 0.9, 2.0)
    assert found is not None
    squares = values**2
    mean, sd = squares.mean(), squares.std(ddof=1)
    assert (found.power, found.shape) == (2.0, "box-cox")
    assert found.pp is not None
    assert found.pp[0] == pytest.approx((3.8**2 - 4.0) / (6 * sd))
    assert found.ppk[0] == pytest.approx(min(3.8**2 - mean, mean - 4.0) / (3 * sd))
    assert found.percentiles == pytest.approx([math.sqrt(mean + k * sd) for k in (-3, 0, 3)])
    beyond = stats.norm.cdf(4.0, mean, sd), stats.norm.sf(3.8**2, mean, sd)
    assert found.outside == pytest.approx(sum(beyond))
    assert found.p == pytest.approx(stats.shapiro(squares).pvalue, rel=1e-2)
    for ends_of_one, share in (((2.0, None), beyond[0]), ((None, 3.8), beyond[1])):
        one = by_box_cox(values, *ends_of_one, 0.9, 2.0)
        assert one is not None
        assert one.pp is None
        assert one.outside == pytest.approx(share)


@pytest.mark.parametrize(
    ("values", "ends"),
    [
        (FEW, (0.0, 9.0)), (FEW, (None, 0.0)), (FEW, (-1.0, None)), (FEW - 0.7, (0.1, None)),
        (FEW, (1e-60, None)), (FEW, (None, 1e60)), (powered(8.0), (None, 9.0)),
    ],
)  # fmt: skip
def test_box_cox_is_not_defined(values: np.ndarray, ends: tuple[float | None, ...]) -> None:
    assert by_box_cox(values, ends[0], ends[1], 0.95) is None
    assert by_box_cox(FEW, 1e-3, 9.0, 0.95) is not None


def test_the_share_outside_of_percentiles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(skewed, "DRAWS", 30)
    values = np.random.default_rng(4).gamma(3.0, 2.0, 60)
    curve = curve_of(values)
    for ends, share in (
        ((1.0, None), curve.cdf(1.0)), ((None, 12.0), 1.0 - curve.cdf(12.0)),
        ((1.0, 12.0), curve.cdf(1.0) + 1.0 - curve.cdf(12.0)),
    ):  # fmt: skip
        assert by_percentiles(values, *ends, 0.95).outside == pytest.approx(share)


def lognormal(count: int) -> np.ndarray:
    return np.asarray(np.exp(stats.norm.ppf((np.arange(count) + 0.5) / count)))


@pytest.mark.parametrize(
    ("values", "shape", "said"),
    [
        (lognormal(29), "normal", "too few"),
        (lognormal(30), "box-cox", "after the power transform"),
        (-lognormal(49), "normal", "too few"),
        (-lognormal(50), "percentile", "no power makes them so"),
        (np.log(lognormal(30)), "normal", "do not contradict"),
    ],
)
def test_the_shape_by_count(values: np.ndarray, shape: str, said: str) -> None:
    found = capability(values, -500.0 if values.min() < 0 else None, 500.0)
    assert found.shape == shape
    assert said in found.why


@pytest.mark.parametrize(("shape", "least"), [("box-cox", 30), ("percentile", 50)])
def test_a_shape_that_is_asked_for_needs_readings(shape: str, least: int) -> None:
    found = capability(lognormal(least), None, 500.0, shape=shape)  # type: ignore[arg-type]
    assert found.shape == shape
    assert found.why.endswith("as asked")
    assert found.count == least
    with pytest.raises(DataError, match=f"needs {least} readings or more, not {least - 1}"):
        capability(lognormal(least - 1), None, 500.0, shape=shape)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"power": 5.1}, UsageError, "goes with box-cox"),
        ({"power": -5.1}, UsageError, "goes with box-cox"),
        ({"power": math.nan}, UsageError, "goes with box-cox"),
        ({"power": 1.0, "shape": "auto"}, UsageError, "goes with box-cox"),
        ({"upper": None}, UsageError, "give a lower one"),
        ({"lower": 500.0}, UsageError, "does not lie below"),
        ({"values": FEW[:2]}, DataError, "more than 2 readings"),
        ({"values": FEW[:7], "subgroup": 4}, DataError, "more than 7 readings"),
        ({"values": np.full(9, 2.0)}, DataError, "all readings are equal"),
        ({"values": np.repeat([1.0, 2.0], 4), "subgroup": 4}, DataError, "all readings are equal"),
        ({"values": np.array([1.7e308, -1.7e308, 1e308])}, DataError, "too large"),
    ],
)
def test_a_capability_that_cannot_be(
    change: dict[str, object], error: type[Exception], said: str
) -> None:
    asked = {"values": lognormal(30), "lower": None, "upper": 500.0, "shape": "box-cox"} | change
    with pytest.raises(error, match=said):
        capability(**asked)  # type: ignore[arg-type]


def test_what_is_just_possible() -> None:
    for power in (5.0, -5.0):
        assert capability(lognormal(30), None, 500.0, shape="box-cox", power=power).power == power
    assert capability(FEW[:3], 0.0, 5.0).count == 3
    assert capability(FEW[:8], 0.0, 5.0, subgroup=4, shape="normal").count == 8


def test_capability_of_a_normal_process_by_hand() -> None:
    values = FEW[:6]  # moving ranges 0.5, 2.2, 1.3, 0.7, 3.3
    found = capability(values, 1.0, 4.0, shape="normal", level=0.9)
    mean, sd, within = values.mean(), values.std(ddof=1), 1.6 / d2(2)
    assert (found.mean, found.sigma_overall, found.sigma_within) == pytest.approx(
        (mean, sd, within)
    )
    assert (found.cp, found.cpk) == indices(
        found.mean, found.sigma_within, 1.0, 4.0, 6, degrees_of_moving_ranges(6), 0.9
    )
    assert found.pp.interval is not None
    ends = [math.sqrt(stats.chi2.ppf(q, 5) / 5) * 3.0 / (6 * sd) for q in (0.05, 0.95)]
    assert found.pp.interval == pytest.approx(ends)
    ppk = (mean - 1.0) / (3 * sd)
    half = stats.norm.ppf(0.95) * math.sqrt(1 / 54 + ppk**2 / 10)
    assert found.ppk.value == pytest.approx(ppk)
    assert found.ppk.interval == pytest.approx((ppk - half, ppk + half))
    beyond = stats.norm.cdf(1.0, mean, sd) + stats.norm.sf(4.0, mean, sd)
    assert found.ppm_expected == pytest.approx(1e6 * beyond)
    assert found.ppm_seen == pytest.approx(1e6 * 3 / 6)  # 0.7, 0.9 and 4.2
    assert (found.shape, found.why, found.power) == ("normal", "normal, as asked", None)
    assert found.fit_p == found.normal_p == pytest.approx(stats.shapiro(values).pvalue, rel=0.02)
    low, high = (capability(values, *ends) for ends in ((1.0, None), (None, 4.0)))
    assert low.cp.value is low.pp.interval is None
    assert low.ppm_seen == pytest.approx(1e6 / 3)
    assert high.ppm_seen == pytest.approx(1e6 / 6)
    assert low.ppm_expected + high.ppm_expected == pytest.approx(found.ppm_expected)
    touched = capability(values, 0.7, 4.2, shape="normal")
    assert touched.ppm_seen == 0.0  # a reading on its limit is within


def test_the_spread_within_subgroups() -> None:
    """Threes 1.2 0.7 2.9, 1.6 0.9 4.2 and 1.1 2.2 0.8; the tenth reading is left out."""
    sigma, degrees = sigma_within(FEW, 3)
    assert sigma == pytest.approx((2.2 + 3.3 + 1.4) / 3 / d2(3))
    assert degrees == degrees_of_freedom(3, 3)


def test_a_known_power_reaches_the_answer() -> None:
    found = capability(lognormal(40), 0.01, 500.0, shape="box-cox", power=0.0)
    logs = np.log(lognormal(40))
    assert found.pp.value == pytest.approx(math.log(5e4) / (6 * logs.std(ddof=1)))
    assert found.why == "Box-Cox of λ = 0.00, as asked"
    assert found.percentiles == pytest.approx(
        [math.exp(logs.mean() + k * logs.std(ddof=1)) for k in (-3, 0, 3)]
    )
    assert found.cp.value is found.cpk.interval is None
    assert found.pp.interval is not None
    assert found.pp.interval[0] < found.pp.value < found.pp.interval[1]
    assert replace(found, fit_p=1.0).fit_p != found.fit_p
