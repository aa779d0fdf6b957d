"""Decision rules of JCGM 106:2012: how far inside its limits a value must lie to be accepted.

A value y with standard uncertainty u is taken to be normal. Limits may be infinite on one side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorid.errors import UsageError

Floats = NDArray[np.float64]
RuleName = Literal["simple", "uncertainty", "specific_risk", "global_risk"]
RULES: tuple[RuleName, ...] = ("simple", "uncertainty", "specific_risk", "global_risk")
NODES = 24  # of the quadrature in each panel
PANELS = (-9.0, -6.0, -4.0, -2.5, -1.2, 0.0, 1.2, 2.5, 4.0, 6.0, 9.0)  # of a sd or a u
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
    below, above = (low - value) / u, (high - value) / u
    if below > 0.0:  # of two tails on one side, the small ones
        return _phi(-below) - _phi(-above)
    return max(0.0, _phi(above) - _phi(below))


def nonconformance(value: float, u: float, low: float, high: float) -> float:
    """What is left of 1 by ``conformance``, right also where that is 1 to the last digit."""
    if u <= 0:
        return float(not low <= value <= high)
    return _phi((low - value) / u) + _phi((value - high) / u)


def accepts(value: float, u: float, low: float, high: float, rule: Rule) -> bool:
    """Whether the rule accepts ``value``; only ever within the limits."""
    if not low <= value <= high:
        return False
    if rule.name == "specific_risk":
        return nonconformance(value, u, low, high) <= rule.consumer_risk
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
    rejected = _integral(low, high, u, (low + w, high - w), mean, sd, inside=False)
    return _consumer(u, low, high, mean, sd, w), rejected


@dataclass(frozen=True)
class Specific:
    """Of one item with a measured value: the probability that it conforms, by the measurement
    alone and with the process as prior knowledge, and whether the rule accepts it.

    ``risk`` is the specific consumer's risk of what is accepted, that it does not conform, or the
    specific producer's risk of what is rejected, that it does (JCGM 106, 9.3).
    """

    accepted: bool
    conformance: float
    with_process: float | None
    risk: float
    risk_with_process: float | None


def specific(value: float, u: float, low: float, high: float, rule: Rule) -> Specific:
    """What a measured value says of its item; ``with_process`` None: no process was given."""
    accepted = accepts(value, u, low, high, rule)
    risk = nonconformance if accepted else conformance
    known = known_risk = None
    if rule.process_mean is not None and rule.process_sd is not None:
        sd, mean = rule.process_sd, rule.process_mean
        weight = sd**2 / (sd**2 + u**2)
        posterior = mean + weight * (value - mean), u * math.sqrt(weight), low, high
        known, known_risk = conformance(*posterior), risk(*posterior)
    return Specific(
        accepted,
        conformance(value, u, low, high),
        known,
        risk(value, u, low, high),
        known_risk,
    )


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
    accepted = (low + band, high - band)
    below = _integral(-math.inf, low, u, accepted, mean, sd, inside=True)
    return below + _integral(high, math.inf, u, accepted, mean, sd, inside=True)


def _integral(
    start: float,
    stop: float,
    u: float,
    accepted: tuple[float, float],
    mean: float,
    sd: float,
    *,
    inside: bool,
) -> float:
    """Share of items of a true value from ``start`` to ``stop`` measured ``inside`` the limits of
    acceptance, or outside of them.

    The process changes over its sd, the measurement over its u about the limits of acceptance:
    panels end where either does, so that a ratio of a millionth of both is no harder than one.
    """
    start, stop = max(start, mean - REACH * sd), min(stop, mean + REACH * sd)
    if not stop > start:
        return 0.0
    places = [mean + k * sd for k in PANELS]
    places += [end + k * u for end in accepted if math.isfinite(end) for k in PANELS]
    edges = np.array(sorted({start, stop, *(p for p in places if start < p < stop)}))
    nodes, weights = _legendre()
    half = 0.5 * np.diff(edges)[:, None]
    x = 0.5 * (edges[1:] + edges[:-1])[:, None] + half * nodes
    density = np.exp(-0.5 * ((x - mean) / sd) ** 2) / (sd * math.sqrt(2.0 * math.pi))
    return float((half * weights * density * _measured(x, u, accepted, inside)).sum())


def _measured(x: Floats, u: float, accepted: tuple[float, float], inside: bool) -> Floats:
    """Probability that items of true values ``x`` are measured inside, or outside, the limits of
    acceptance; each by the smaller tails, so that no difference of nearly equal figures is left.
    """
    least, most = accepted
    if least >= most:
        return np.full_like(x, 0.0 if inside else 1.0)
    if u <= 0.0:
        within = (x >= least) & (x <= most)
        return np.where(within == inside, 1.0, 0.0)
    from scipy.special import ndtr

    below, above = (least - x) / u, (most - x) / u
    if not inside:
        return np.asarray(ndtr(below) + ndtr(-above))
    right = ndtr(above) - ndtr(below)
    left = ndtr(-below) - ndtr(-above)
    return np.asarray(np.maximum(np.where(below > 0.0, left, right), 0.0))


@lru_cache(maxsize=1)
def _legendre() -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    return nodes, weights
