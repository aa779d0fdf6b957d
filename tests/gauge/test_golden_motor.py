"""A golden motor and the line of several, against formulas and SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from motorid.errors import DataError, UsageError
from motorid.quality.ranges import d2_star
from motorid.quality.reference import golden, linearity, sigma_by_range

VALUES = np.array([1.0, 3.0, 2.0, 6.0])  # mean 3, standard deviation √(14/3)


def test_a_bias_by_students_t() -> None:
    found = golden(VALUES, 2.0, tolerance=20.0)
    sd = math.sqrt(14.0 / 3.0)
    expected = stats.ttest_1samp(VALUES, 2.0)
    ends = expected.confidence_interval(0.95)
    assert (found.count, found.mean, found.bias) == (4, 3.0, 1.0)
    assert (found.sigma, found.reference, found.reference_uncertainty) == (
        pytest.approx(sd), 2.0, 0.0,
    )  # fmt: skip
    assert (found.t, found.p) == pytest.approx((expected.statistic, expected.pvalue))
    assert found.interval_95 == pytest.approx((ends.low - 2.0, ends.high - 2.0))
    assert not found.biased
    assert (found.cg, found.cgk) == pytest.approx((4.0 / (6.0 * sd), (2.0 - 1.0) / (3.0 * sd)))
    assert found.tolerance == 20.0
    plain = golden(VALUES, 2.0)
    assert plain.cg is plain.cgk is plain.tolerance is None


def test_the_reference_has_an_uncertainty_of_its_own() -> None:
    """Errors √(7/6) and 2 add in squares; by Welch and Satterthwaite it has more degrees."""
    found = golden(VALUES, -6.0, reference_uncertainty=2.0)
    own = 14.0 / 3.0 / 4.0
    error = math.sqrt(own + 4.0)
    degrees = 3 * (own + 4.0) ** 2 / own**2
    half = stats.t.ppf(0.975, degrees) * error
    assert found.interval_95 == pytest.approx((9.0 - half, 9.0 + half))
    assert (found.t, found.biased) == (pytest.approx(9.0 / error), True)
    assert found.p == pytest.approx(2 * stats.t.sf(9.0 / error, degrees))
    assert golden(VALUES, 12.0).biased


@pytest.mark.parametrize(
    ("reference", "t", "p", "cgk"),
    [(5.0, 0.0, 1.0, math.inf), (4.0, math.inf, 0.0, -math.inf), (5.5, -math.inf, 0.0, math.inf)],
)
def test_readings_that_never_differ(reference: float, t: float, p: float, cgk: float) -> None:
    """A tolerance of 9 leaves 0.9 for the bias."""
    found = golden(np.full(5, 5.0), reference, tolerance=9.0)
    assert (found.sigma, found.t, found.p) == (0.0, t, p)
    assert (found.cg, found.cgk) == (math.inf, cgk)
    off = 5.0 - reference
    assert found.interval_95 == pytest.approx((off, off))


def test_golden_studies_that_are_none() -> None:
    assert golden(VALUES[:2], 2.0).count == 2
    with pytest.raises(DataError, match="not 1"):
        golden(VALUES[:1], 2.0)
    for tolerance in (0.0, -1.0, math.nan):
        with pytest.raises(UsageError, match="positive width"):
            golden(VALUES, 2.0, tolerance=tolerance)
    assert sigma_by_range(VALUES) == pytest.approx(5.0 / d2_star(4, 1))


AT = (1.0, 2.03, 5.0)
READ = (np.array([1.5, 1.25]), np.array([2.5]), np.array([4.0, 4.5, 4.75]))


def test_the_line_of_bias_is_scipys() -> None:
    found = linearity(AT, READ)
    x = np.array([1.0, 1.0, 2.03, 5.0, 5.0, 5.0])
    y = np.concatenate(READ) - x
    line = stats.linregress(x, y)
    assert (found.count, found.degrees) == (6, 4)
    assert (found.slope.value, found.slope.error) == pytest.approx((line.slope, line.stderr))
    assert found.slope.t == pytest.approx(line.slope / line.stderr)
    assert found.slope.p == pytest.approx(line.pvalue)
    assert (found.intercept.value, found.intercept.error) == pytest.approx(
        (line.intercept, line.intercept_stderr)
    )
    t = line.intercept / line.intercept_stderr
    assert found.intercept.p == pytest.approx(2 * stats.t.sf(abs(t), 4))
    assert found.r_squared == pytest.approx(line.rvalue**2)
    left = y - line.intercept - line.slope * x
    sigma = math.sqrt(float(left @ left) / 4)
    assert found.sigma == pytest.approx(sigma)
    assert [at for at, _ in found.biases] == [1.0, 2.03, 5.0]
    assert [bias for _, bias in found.biases] == pytest.approx([0.375, 0.47, 13.25 / 3 - 5.0])
    assert len(found.band) == 42  # 1, 1.1 ... 5, and 2.03 among them
    sxx = float(((x - x.mean()) ** 2).sum())
    for at, low, high in found.band:
        half = stats.t.ppf(0.975, 4) * sigma * math.sqrt(1 / 6 + (at - x.mean()) ** 2 / sxx)
        fitted = line.intercept + line.slope * at
        assert (low, high) == pytest.approx((fitted - half, fitted + half))
    assert [found.band[k][0] for k in (0, -1)] == [1.0, 5.0]


def test_an_exact_line_and_one_without_bias() -> None:
    exact = linearity(AT, [np.array([2.0 * x]) for x in AT])
    assert (exact.slope.value, exact.r_squared) == pytest.approx((1.0, 1.0))
    same = linearity(AT, [np.array([x]) for x in AT])
    assert (same.r_squared, same.slope.t, same.sigma) == (1.0, math.inf, 0.0)


def test_a_line_needs_three_references_and_readings() -> None:
    with pytest.raises(DataError, match="not 2"):
        linearity((1.0, 2.0, 2.0), READ)
    with pytest.raises(DataError, match="every motor"):
        linearity(AT, (*READ[:2], np.array([])))
