"""Decision rules against independent computations: normal tables, bivariate normal, chance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from motorid.errors import UsageError
from motorid.quality.guard_band import Rule, accepts, conformance, guard_band, risks

LINE = {"process_mean": 1500.0, "process_sd": 0.12}  # tolerance 1500 ± 0.2, u = 0.04


def test_conformance_by_the_normal_table() -> None:
    # -5.47 with u = 0.05 against at most -5.40: the table's value at 1.40
    assert conformance(-5.47, 0.05, -math.inf, -5.40) == pytest.approx(0.9192, abs=5e-5)
    # both limits 1.96 away
    assert conformance(0.0, 1.0, -1.959964, 1.959964) == pytest.approx(0.95, abs=1e-6)
    assert conformance(3.0, 0.0, 0.0, 3.0) == 1.0
    assert conformance(3.1, 0.0, 0.0, 3.0) == 0.0


def bivariate(accept: tuple[float, float], good: tuple[float, float]) -> tuple[float, float]:
    """(consumer's, producer's) risk by the distribution of true and measured value together."""
    u0, um = 0.12, 0.04
    both = multivariate_normal([0, 0], [[u0**2, u0**2], [u0**2, u0**2 + um**2]])
    accepted = both.cdf([9, accept[1]], lower_limit=[-9, accept[0]])
    right = both.cdf([good[1], accept[1]], lower_limit=[good[0], accept[0]])
    conforms = both.cdf([good[1], 9], lower_limit=[good[0], -9])
    return float(accepted - right), float(conforms - right)


@pytest.mark.parametrize("band", [0.0, 0.05, 0.08])
def test_global_risks_by_the_bivariate_normal(band: float) -> None:
    found = risks(0.04, 1499.8, 1500.2, Rule("global_risk", **LINE), band)
    edge = 0.2 - band
    assert found == pytest.approx(bivariate((-edge, edge), (-0.2, 0.2)), abs=2e-5)


def test_global_risk_takes_the_least_band_that_keeps_it() -> None:
    rule = Rule("global_risk", consumer_risk=0.005, **LINE)
    band = guard_band(0.04, 1499.8, 1500.2, rule)
    assert 0 < band < 0.08
    assert risks(0.04, 1499.8, 1500.2, rule)[0] == pytest.approx(0.005, rel=1e-3)
    generous = Rule("global_risk", consumer_risk=0.05, **LINE)
    assert guard_band(0.04, 1499.8, 1500.2, generous) == 0.0


def test_global_risk_by_chance() -> None:
    rng = np.random.default_rng(1)
    rule = Rule("global_risk", consumer_risk=0.005, **LINE)
    true = rng.normal(1500, 0.12, 400_000)
    read = true + rng.normal(0, 0.04, len(true))
    w = guard_band(0.04, 1499.8, 1500.2, rule)
    escaped = ((np.abs(true - 1500) > 0.2) & (np.abs(read - 1500) <= 0.2 - w)).mean()
    assert escaped == pytest.approx(0.005, abs=4 * math.sqrt(0.005 / len(true)))


def test_a_global_risk_needs_a_process() -> None:
    with pytest.raises(UsageError, match="process_mean"):
        guard_band(0.1, 0, 1, Rule("global_risk"))


def test_specific_risk_is_the_probability_of_nonconformance() -> None:
    rule = Rule("specific_risk", consumer_risk=0.05)
    one_sided = 1.6448536 * 0.1
    assert accepts(1 - one_sided - 1e-6, 0.1, -math.inf, 1.0, rule)
    assert not accepts(1 - one_sided + 1e-6, 0.1, -math.inf, 1.0, rule)
    # limits only 2 u apart: no value is sure enough, though each limit alone would let 0.5 pass
    assert not accepts(0.5, 0.5, 0.0, 1.0, rule)


rules = st.sampled_from(
    [Rule("simple"), Rule(), Rule("specific_risk"), Rule("global_risk", **LINE)]
)


@pytest.mark.slow
@given(rules, st.floats(1499, 1501), st.floats(0, 0.2), st.floats(0, 0.2))
def test_acceptance_is_within_limits_and_shrinks_with_uncertainty(
    rule: Rule, value: float, u: float, more: float
) -> None:
    low, high = 1499.8, 1500.2
    if accepts(value, u, low, high, rule):
        assert low <= value <= high
    elif (
        rule.name != "global_risk"
    ):  # a share of all items may fall as the spread of readings grows
        assert not accepts(value, u + more, low, high, rule)
