"""Risks against adaptive quadrature: a measurement as wide as the process, or a millionth of it."""

from __future__ import annotations

import json
import math
from itertools import pairwise

import pytest
from scipy.integrate import quad
from scipy.stats import norm

from motorid.cli.main import run
from motorid.quality.guard_band import Rule, risks, specific

ROOT = math.sqrt(2.0 * math.pi)
LIMITS = {
    "both": (-2.0, 1.7), "lower": (-3.1, math.inf), "tight": (-0.3, 0.4),
}  # fmt: skip


def by_quadrature(u: float, low: float, high: float, band: float) -> tuple[float, float]:
    """Both risks of a standard normal process, in pieces of a few u about what decides."""
    least, most = low + band, high - band
    ends = sorted(
        {-9.0, 9.0, 0.0, *(max(-9.0, min(9.0, e + k * u)) for e in (low, high, least, most)
                           if math.isfinite(e) for k in (-12, -6, -3, 0, 3, 6, 12))}
    )  # fmt: skip

    def tail(z: float) -> float:
        return 0.5 * math.erfc(z / math.sqrt(2.0))

    def inside(x: float) -> float:
        """By the tail that is small on this side."""
        if x > 0.5 * (max(least, -9) + min(most, 9)):
            return tail((x - most) / u) - tail((x - least) / u)
        return tail((least - x) / u) - tail((most - x) / u)

    def outside(x: float) -> float:
        return tail((x - least) / u) + tail((most - x) / u)

    consumer = producer = 0.0
    for a, b in pairwise(ends):
        conforms = low <= 0.5 * (a + b) <= high
        of = outside if conforms else inside
        share, _ = quad(
            lambda x, of=of: math.exp(-0.5 * x * x) / ROOT * of(x), a, b, epsabs=1e-20, epsrel=1e-10
        )  # fmt: skip
        consumer, producer = consumer + (not conforms) * share, producer + conforms * share
    return consumer, producer


@pytest.mark.parametrize("limits", LIMITS.values(), ids=list(LIMITS))
@pytest.mark.parametrize("ratio", [1.0, 1 / 3300, 1e-6])
@pytest.mark.parametrize("bands", [0.0, 2.0])
def test_risks_by_adaptive_quadrature(
    limits: tuple[float, float], ratio: float, bands: float
) -> None:
    low, high = limits
    sd, mean = 0.12, 1500.0
    band = min(bands * ratio, 0.45 * (high - low))
    found = risks(
        ratio * sd, mean + low * sd, mean + high * sd,
        Rule("global_risk", process_mean=mean, process_sd=sd), band * sd,
    )  # fmt: skip
    # a millionth of the sd beside a mean of 1500 is 8e-11 of it: 1e-5 of that is a double's grain
    tolerance = max(1e-8, 1e-15 * mean / (ratio * sd))
    for ours, other in zip(found, by_quadrature(ratio, low, high, band), strict=True):
        assert ours == pytest.approx(other, rel=tolerance, abs=1e-17)


def test_no_uncertainty_is_no_risk_without_a_band() -> None:
    rule = Rule("global_risk", process_mean=0.0, process_sd=1.0)
    assert risks(0.0, -1.0, 1.0, rule, 0.0) == (0.0, 0.0)
    consumer, producer = risks(0.0, -1.0, 1.0, rule, 0.1)
    assert consumer == 0.0
    assert producer == pytest.approx(2 * (norm.cdf(1.0) - norm.cdf(0.9)), rel=1e-12)


def test_what_a_value_says_of_its_item() -> None:
    """Normal prior and normal reading: the posterior has the precision of both."""
    rule = Rule(process_mean=0.0, process_sd=1.0)
    found = specific(0.9, 0.5, -1.0, 1.0, rule)
    spread = math.sqrt(1 / (1 + 1 / 0.25))
    mean = 0.9 / 1.25
    assert found.with_process == pytest.approx(
        norm.cdf((1 - mean) / spread) - norm.cdf((-1 - mean) / spread), rel=1e-12
    )
    assert found.conformance == pytest.approx(norm.cdf(0.2) - norm.cdf(-3.8), rel=1e-12)
    assert not found.accepted  # no value has a guard band of 2 u to both limits
    assert specific(0.0, 0.1, -1.0, 1.0, Rule()).with_process is None


def test_a_specific_risk_is_right_where_it_is_tiny() -> None:
    """Nine standard uncertainties inside, and as many outside: the normal tail, and not 0."""
    tail = norm.sf(9.0)
    inside = specific(0.91, 0.01, -1.0, 1.0, Rule())
    assert inside.accepted
    assert inside.risk == pytest.approx(tail, rel=1e-9, abs=0.0)
    outside = specific(1.09, 0.01, -1.0, 1.0, Rule())
    assert not outside.accepted
    assert outside.risk == outside.conformance == pytest.approx(tail, rel=1e-9, abs=0.0)
    below = specific(-1.09, 0.01, -1.0, 1.0, Rule(process_mean=0.0, process_sd=1e3))
    assert below.conformance == pytest.approx(tail, rel=1e-9, abs=0.0)
    assert below.risk_with_process == pytest.approx(
        tail, rel=1e-4, abs=0.0
    )  # nearly no prior knowledge


@pytest.mark.parametrize("limits", [(-6.0, 6.0), (2.0, 3.0), (-math.inf, 4.5), (-1e-3, 2e-3)])
@pytest.mark.parametrize("ratio", [10.0, 0.1, 1e-4, 1e-6])
def test_risks_of_far_and_of_narrow_limits(limits: tuple[float, float], ratio: float) -> None:
    """Also with limits of acceptance beyond those of the tolerance."""
    low, high = limits
    rule = Rule("global_risk", process_mean=0.0, process_sd=1.0)
    for band in (0.0, -1.5 * ratio):
        found = risks(ratio, low, high, rule, band)
        for ours, other in zip(found, by_quadrature(ratio, low, high, band), strict=True):
            assert ours == pytest.approx(other, rel=1e-8, abs=1e-17)


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    options = "risk --low 1499.8 --high 1500.2 -u 0.04 --process-mean 1500 --process-sd 0.12"
    assert run([*options.split(), "--value", "1500.1", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    rule = Rule(process_mean=1500.0, process_sd=0.12)
    expected = risks(0.04, 1499.8, 1500.2, rule)
    assert (said["consumer"], said["producer"]) == pytest.approx(expected)
    assert said["guard_band"] == pytest.approx(0.08)
    assert said["specific"]["accepted"] is True
    assert run([*options.split(), "--value", "1500.19"]) == 0
    assert "rejected" in capsys.readouterr().out


@pytest.mark.parametrize("more", ["--process-mean 1", "--low 3", ""])
def test_the_command_refuses_half_of_what_it_needs(more: str) -> None:
    assert run(f"risk --high 2 -u 0.1 {more}".split()) == 2
