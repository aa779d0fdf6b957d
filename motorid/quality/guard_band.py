"""Decision rules of JCGM 106:2012: how far inside its limits a value must lie to be accepted.

A value y with standard uncertainty u is taken to be normal. Limits may be infinite on one side.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorid.errors import UsageError

Floats = NDArray[np.float64]
RuleName = Literal["simple", "uncertainty", "specific_risk", "global_risk"]
RULES: tuple[RuleName, ...] = ("simple", "uncertainty", "specific_risk", "global_risk")
NODES = 200  # of the quadrature over the process, on each side of the limits
REACH = 9.0  # standard deviations beyond which nothing is left
HALVINGS = 60


@dataclass(frozen=True)
class Rule:
    """How to decide.

    ``simple`` accepts up to the limits. ``uncertainty`` keeps a guard band r·U with U = k·u.
    ``specific_risk`` accepts where the probability that this item does not conform is at most
    ``consumer_risk``. ``global_risk`` takes the least guard band by which, of all items of a normal
    process (``process_mean``, ``process_sd``), at most a share ``consumer_risk`` is accepted and
    does not conform.
    """

    name: RuleName = "uncertainty"
    r: float = 1.0
    coverage_factor: float = 2.0
    consumer_risk: float = 0.025
    process_mean: float | None = None
    process_sd: float | None = None


def conformance(value: float, u: float, low: float, high: float) -> float:
    """Probability that the true value lies within the limits (JCGM 106, 7.2)."""
    if u <= 0:
        return float(low <= value <= high)
    return max(0.0, _phi((high - value) / u) - _phi((low - value) / u))


def accepts(value: float, u: float, low: float, high: float, rule: Rule) -> bool:
    """Whether the rule accepts ``value``; only ever within the limits."""
    if not low <= value <= high:
        return False
    if rule.name == "specific_risk":
        return 1.0 - conformance(value, u, low, high) <= rule.consumer_risk
    band = guard_band(u, low, high, rule)
    return low + band <= value <= high - band


def guard_band(u: float, low: float, high: float, rule: Rule) -> float:
    """Width w: accepted is from ``low`` + w to ``high`` - w.

    For ``specific_risk`` the band that one limit alone needs; limits close together need more, and
    ``accepts`` sees to it. Raises UsageError where a global risk has no process.
    """
    match rule.name:
        case "simple":
            return 0.0
        case "uncertainty":
            return rule.r * rule.coverage_factor * u
        case "specific_risk":
            return max(0.0, -quantile(rule.consumer_risk)) * u
    return _global_band(u, low, high, *_process(rule), rule.consumer_risk)


def risks(
    u: float, low: float, high: float, rule: Rule, band: float | None = None
) -> tuple[float, float]:
    """Global (consumer's, producer's) risk of a guard band (JCGM 106, 9.5); that of the rule."""
    mean, sd = _process(rule)
    w = guard_band(u, low, high, rule) if band is None else band
    inner = (max(low, mean - REACH * sd), min(high, mean + REACH * sd))
    rejected = _integral(*inner, mean, sd, lambda x: 1.0 - _accepted(x, u, low, high, w))
    return _consumer(u, low, high, mean, sd, w), rejected


def quantile(probability: float) -> float:
    """Of the standard normal distribution."""
    from statistics import NormalDist

    return NormalDist().inv_cdf(probability)


def _phi(x: float) -> float:
    return 0.5 * math.erfc(-x / math.sqrt(2.0))


def _process(rule: Rule) -> tuple[float, float]:
    if rule.process_mean is None or rule.process_sd is None:
        raise UsageError(
            "a decision by global risk needs process_mean and process_sd of that quantity"
        )
    return rule.process_mean, rule.process_sd


@lru_cache(maxsize=256)
def _global_band(u: float, low: float, high: float, mean: float, sd: float, target: float) -> float:
    """The least band that keeps the target, by halving; 0 where none is needed."""
    if _consumer(u, low, high, mean, sd, 0.0) <= target:
        return 0.0
    least, most = 0.0, 10.0 * u
    if math.isfinite(low) and math.isfinite(high):
        most = min(most, 0.5 * (high - low))
    for _ in range(HALVINGS):
        middle = 0.5 * (least + most)
        if _consumer(u, low, high, mean, sd, middle) > target:
            least = middle
        else:
            most = middle
    return most


def _consumer(u: float, low: float, high: float, mean: float, sd: float, band: float) -> float:
    """Share of all items that does not conform and is accepted."""
    ends = (mean - REACH * sd, mean + REACH * sd)

    def accepted(x: Floats) -> Floats:
        return _accepted(x, u, low, high, band)

    below = _integral(max(ends[0], low - REACH * u), min(low, ends[1]), mean, sd, accepted)
    above = _integral(max(high, ends[0]), min(ends[1], high + REACH * u), mean, sd, accepted)
    return below + above


def _accepted(x: Floats, u: float, low: float, high: float, band: float) -> Floats:
    """Probability that an item of true value ``x`` is measured within the acceptance limits."""
    least, most = low + band, high - band
    if u <= 0:
        return ((x >= least) & (x <= most)).astype(np.float64)
    from scipy.special import ndtr

    return np.maximum(ndtr((most - x) / u) - ndtr((least - x) / u), 0.0)


def _integral(
    start: float, stop: float, mean: float, sd: float, weight: Callable[[Floats], Floats]
) -> float:
    """Of the process's density times ``weight``; 0 for an empty range."""
    if not stop > start:
        return 0.0
    nodes, weights = _legendre()
    x = 0.5 * (stop + start) + 0.5 * (stop - start) * nodes
    density = np.exp(-0.5 * ((x - mean) / sd) ** 2) / (sd * math.sqrt(2 * math.pi))
    return float(0.5 * (stop - start) * (weights * density * weight(x)).sum())


@lru_cache(maxsize=1)
def _legendre() -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    return nodes, weights
