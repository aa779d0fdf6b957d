"""The curve of detection on its own grid: levels, likelihoods and quantiles by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtr

from motorid.quality.detection import (
    BEYOND,
    FIRST,
    LEVELS,
    MIDDLES,
    TARGETS,
    Range,
    Trials,
    _quantiles,
    most_named,
)

RANGE = Range(0.01, 1.0)


def test_levels_are_even_in_their_logarithm() -> None:
    assert RANGE.severity(30) == pytest.approx(0.1)
    assert RANGE.severity(1) == float(f"{0.01 * 100 ** (1 / 60):.6g}")
    for level in (0, 17, 30, LEVELS - 1):
        assert RANGE.level(RANGE.severity(level)) == level
    assert RANGE.level(0.1 * 100 ** (0.4 / 60)) == 30
    assert RANGE.level(0.1 * 100 ** (0.6 / 60)) == 31
    assert RANGE.first() == [0, 9, 17, 26, 34, 43, 51, 60]
    assert len(RANGE.first()) == FIRST


def trials(severities: tuple[float, ...] = (), found: tuple[bool, ...] = (), *, good: int = 10,
           rejected: int = 2) -> Trials:  # fmt: skip
    return Trials(RANGE, severities, found, good, rejected)


def test_findings_are_counted_by_severity() -> None:
    some = trials((0.1, 0.2, 0.1, 0.1), (True, False, False, True))
    assert some._counted() == {0.1: (2, 1), 0.2: (0, 1)}
    with pytest.raises(ValueError, match="shorter"):
        trials((0.1, 0.2), (True,))._counted()


def test_before_the_trials_every_curve_is_as_likely() -> None:
    """Middles from a half of the range's logarithm below to as far above; shares by Jeffreys."""
    middles, widths, alarms, weights = trials()._posterior
    assert middles.shape == widths.shape == alarms.shape == weights.shape == (181, 41, 7)
    span = math.log(100.0)
    assert (middles.min(), middles.max()) == pytest.approx(
        (math.log(0.01) - 0.5 * span, 0.5 * span)
    )
    assert (widths.min(), widths.max()) == pytest.approx((0.02, 3.0))
    shares = (np.arange(7) + 0.5) / 7
    assert alarms[0, 0] == pytest.approx(stats.beta.ppf(shares, 2.5, 8.5))
    assert np.abs(weights * weights.size - 1.0).max() < 1e-9
    assert trials()._step == pytest.approx(2.0 * span / (MIDDLES - 1))
    assert middles[1, 0, 0] - middles[0, 0, 0] == pytest.approx(trials()._step)


def test_a_likelihood_by_the_formula() -> None:
    """Two of three found at 0.1 and none of one at 0.5."""
    some = trials((0.1, 0.1, 0.1, 0.5), (True, False, True, False))
    middles, widths, alarms, weights = some._posterior
    first = alarms + (1 - alarms) * ndtr((math.log(0.1) - middles) / widths)
    second = alarms + (1 - alarms) * ndtr((math.log(0.5) - middles) / widths)
    expected = first**2 * (1 - first) * (1 - second)
    assert weights.sum() == pytest.approx(1.0)
    assert np.abs(weights - expected / expected.sum()).max() < 1e-5 * weights.max()


@pytest.mark.parametrize("hit", [True, False])
def test_no_single_trial_rules_out_a_curve(hit: bool) -> None:
    """Where good motors all pass, the least likely finding still has a chance of a billionth."""
    weights = trials((0.1,), (hit,), good=10**12, rejected=0)._posterior[3]
    assert weights.min() / weights.max() == pytest.approx(1e-9, rel=1e-3)


@pytest.mark.parametrize("share", [0.2, 0.9])
def test_where_a_share_is_found_on_each_curve(share: float) -> None:
    """g + (1 - g) Φ((ln x - m)/s) is the share there, but where it lies far below the range."""
    some = trials()
    middles, widths, alarms, weights = (one.ravel()[::97] for one in some._posterior)
    at, heavy = (one[::97] for one in some._places(share))
    assert np.array_equal(heavy, weights)
    least = math.log(0.01) - BEYOND
    inner = (at > least + 1e-9) & (alarms < share)
    assert at.min() >= least
    assert inner.sum() > 100
    reached = alarms + (1 - alarms) * ndtr((at - middles) / widths)
    assert np.abs(reached[inner] - share).max() < 1e-9
    below = alarms + (1 - alarms) * ndtr((least - middles) / widths)
    assert below[(at <= least + 1e-9)].min() >= share - 1e-9
    any_at_all = at[(alarms > share) & (widths > 1.0)]
    assert np.all(any_at_all < math.log(0.01) + 0.5 * math.log(100.0))


def test_quantiles_of_places_that_are_spread_over_a_step() -> None:
    """One place is even over its step; of two, each has its own weight."""
    one = _quantiles(np.array([3.0]), np.array([1.0]), 0.8)
    assert one == pytest.approx([3.0 - 0.38, 3.0, 3.0 + 0.38], abs=0.06)
    at, weights = np.array([0.0, 10.0]), np.array([0.25, 0.75])
    low, middle, high = _quantiles(at, weights, 0.8)
    assert low == pytest.approx(-0.4 + 0.8 * 0.1, abs=0.06)
    assert middle == pytest.approx(9.6 + 0.8 / 3, abs=0.06)
    assert high == pytest.approx(9.6 + 0.8 * (0.725 / 0.75), abs=0.06)


def test_quantiles_of_many_places_are_those_of_their_weights() -> None:
    at = np.linspace(-2.0, 5.0, 701)
    weights = stats.norm.pdf(at, 1.0, 0.7)
    found = _quantiles(at, weights / weights.sum(), 0.01)
    assert found == pytest.approx(stats.norm.ppf([0.025, 0.5, 0.975], 1.0, 0.7), abs=6e-3)


def test_a_severity_beyond_the_range_is_none() -> None:
    all_found = tuple([True] * 12)
    first = trials(tuple(RANGE.severity(k) for k in range(0, 60, 5)), all_found, rejected=0)
    assert first.severity(0.95).value is not None
    none = trials(first.severities, tuple([False] * 12), rejected=0)
    found = none.severity(0.95)
    assert (found.value, found.high) == (None, None)
    assert found.low <= 1.0


def test_next_trials_are_at_the_targets() -> None:
    """In turn, at the mean of the logarithm; eight, or half of what was made."""
    severities = tuple(RANGE.severity(k) for k in (10, 20, 30, 40, 50)) * 4
    found = tuple(x > 0.09 for x in severities)
    some = trials(severities, found, rejected=0)
    expected = []
    for target in TARGETS:
        at, weights = some._places(target)
        expected.append(RANGE.level(math.exp(float((at * weights).sum()))))
    assert expected == sorted(expected)
    assert some.next() == (expected * 3)[:10]
    assert len(trials(severities[:5], found[:5]).next()) == 8
    assert len(trials(severities[:17], found[:17]).next()) == 8


def test_names_by_how_often_then_by_the_alphabet() -> None:
    names = [["b", "b", "b"], ["a"], ["c", "a"], ["c"], []]
    assert most_named(names) == ["a", "c"]
    assert most_named(names, 3) == ["a", "c", "b"]
    assert most_named([]) == []
