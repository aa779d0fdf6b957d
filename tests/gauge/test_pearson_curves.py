"""Pearson's curves near the borders of their types, many at once, mirrored and beyond."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from motorid.quality.pearson_curve import PearsonCurve, _kinds, curve_of
from motorid.quality.shapiro_wilk import _p, shapiro_wilk


def curve(*moments: tuple[float, float, float, float]) -> PearsonCurve:
    """Of (mean, standard deviation, skewness, kurtosis) each."""
    return PearsonCurve(*(np.array(column) for column in zip(*moments, strict=True)))


MEMBERS = {
    "normal": stats.norm(), "gamma": stats.gamma(4.0), "beta": stats.beta(2.0, 5.0),
    "four": stats.t(9), "beta prime": stats.betaprime(5, 9),
}  # fmt: skip
# gamma of shape 4: skewness 1, kurtosis 3/2; type V divides IV from VI
KINDS = {
    "normal": (0.0, 0.0), "gamma": (1.0, 1.5), "beta": (1.0, 1.4), "beta prime": (1.0, 1.6),
    "four": (1.0, 4.0),
}  # fmt: skip


@pytest.mark.parametrize("name", KINDS)
def test_the_type_by_skewness_and_kurtosis(name: str) -> None:
    skew, kurtosis = (np.array([x]) for x in KINDS[name])
    assert [kind for kind, here in _kinds(skew, kurtosis).items() if here[0]] == [name]
    nearly = _kinds(skew, kurtosis + 1e-7)
    assert sum(int(here[0]) for here in nearly.values()) == 1


def moments_of(member: stats.rv_continuous) -> tuple[float, float, float, float]:
    mean, variance, skew, kurtosis = (float(x) for x in member.stats("mvsk"))
    return mean, math.sqrt(variance), skew, kurtosis


@pytest.mark.parametrize("p", [0.00135, 0.2, 0.5, 0.99865])
def test_many_curves_at_once_are_each_its_own(p: float) -> None:
    """Of every type, and each mirrored: quantiles of -x are those of x, with the other share."""
    own = [moments_of(member) for member in MEMBERS.values()]
    mirrored = [(-mean, sd, -skew, kurtosis) for mean, sd, skew, kurtosis in own]
    found = curve(*own, *mirrored).quantile(p)
    expected = [float(member.ppf(p)) for member in MEMBERS.values()]
    expected += [-float(member.ppf(1.0 - p)) for member in MEMBERS.values()]
    sds = np.array([sd for _, sd, _, _ in own] * 2)
    assert np.abs((found - expected) / sds).max() < 2e-4


@pytest.mark.parametrize("name", MEMBERS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_shares_below(name: str, sign: float) -> None:
    member = MEMBERS[name]
    mean, sd, skew, kurtosis = moments_of(member)
    one = curve((10.0 + sign * 3.0 * mean, 3.0 * sd, sign * skew, kurtosis))
    for p in (0.01, 0.4, 0.97):
        below = p if sign > 0 else 1.0 - p
        assert one.cdf(10.0 + sign * 3.0 * float(member.ppf(p))) == pytest.approx(below, abs=2e-5)
    for far, share in ((-1e3, 0.0), (1e3, 1.0)):
        assert one.cdf(far) == pytest.approx(share, abs=1e-6)


def test_a_kurtosis_that_cannot_be_is_raised() -> None:
    """Two points alone have skewness² - 2; below it nothing is, and the curve is nearly those."""
    impossible, least = curve((0.0, 1.0, 0.5, -5.0)), curve((0.0, 1.0, 0.5, -1.75 + 1e-6))
    for p in (0.1, 0.9):
        assert impossible.quantile(p) == pytest.approx(least.quantile(p))
    assert impossible.cdf(0.0) == pytest.approx(least.cdf(0.0))
    low, high = (float(impossible.quantile(p)[0]) for p in (0.05, 0.95))
    assert (low + high, low * high) == pytest.approx((0.5, -1.0), abs=0.01)


@pytest.mark.parametrize("count", [2, 3, 4, 7])
def test_moments_of_few_readings(count: int) -> None:
    """Where a sample's skewness (of 3) or kurtosis (of 4) is not defined, that of the readings."""
    values = np.array([1.0, 4.0, 2.0, 9.0, 3.0, 3.5, 7.0])[:count]
    found = curve_of(values)
    assert (found.mean[0], found.sd[0]) == pytest.approx((values.mean(), values.std(ddof=1)))
    assert found.skewness[0] == pytest.approx(stats.skew(values, bias=count <= 2), abs=1e-12)
    assert found.kurtosis[0] == pytest.approx(stats.kurtosis(values, bias=count <= 3))


def test_a_perfect_w_and_three_readings() -> None:
    """Three even readings have W = 1 and p = 1; the least W of three is 3/4, with p = 0."""
    assert shapiro_wilk(np.array([1.0, 2.0, 3.0])) == pytest.approx(1.0)
    assert shapiro_wilk(np.array([1.0, 1.0, 2.0])) == pytest.approx(0.0, abs=1e-6)
    assert shapiro_wilk(np.array([1.0, 1.5, 4.0])) == pytest.approx(
        stats.shapiro([1.0, 1.5, 4.0]).pvalue, rel=1e-6
    )
    for count in (5, 11, 12, 40):
        assert _p(1.0, count) == pytest.approx(1.0)
        assert _p(0.01, count) < 1e-3
    assert _p(1e-3, 4) == 1e-99  # beyond what the formula of few readings reaches
