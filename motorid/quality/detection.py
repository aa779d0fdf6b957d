"""How large a defect must be to be found: a curve through trials of graded severity.

    P(not passed) = g + (1 - g) Φ((ln x - m)/s)

with the share g of good motors that do not pass. A grid over m, ln s and g, each equally likely
before the trials, gives the severities found in 50 and in 95 of 100 cases with their intervals:
where all small ones pass and all large ones fail, no largest likelihood exists, and the grid does.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LEVELS = 61  # severities that may be tried, evenly apart in their logarithm
FIRST = 8  # trials over the whole range before the first look
BATCH = 8  # trials between two looks, at least
TARGETS = (0.3, 0.5, 0.8, 0.95)  # shares whose severities the next trials are made at
MIDDLES, WIDTHS, SHARES = 181, 41, 7  # of the grid
FINE = 8  # cells of a step between two middles
NARROWEST, WIDEST = 0.02, 3.0  # s: a step, or a factor of 20
BEYOND = 0.5  # of the range's logarithm: how far outside it the middle may lie


@dataclass(frozen=True)
class Range:
    """The least and the largest severity that are tried; both above zero."""

    least: float
    most: float

    def severity(self, level: int) -> float:
        """Of a level from 0 to LEVELS - 1, to six digits, on every machine alike."""
        share = level / (LEVELS - 1)
        return float(f"{self.least * (self.most / self.least) ** share:.6g}")

    def level(self, severity: float) -> int:
        """The nearest level."""
        span = np.log(self.most / self.least)
        at = (LEVELS - 1) * np.log(severity / self.least) / span
        return int(np.clip(np.round(at), 0, LEVELS - 1))

    def first(self) -> list[int]:
        """Levels of the first trials."""
        return [round(k * (LEVELS - 1) / (FIRST - 1)) for k in range(FIRST)]


@dataclass(frozen=True)
class Found:
    """A severity with its 95 % interval. None: larger than all that were tried.

    One below the least that was tried says no more than that.
    """

    value: float | None
    low: float
    high: float | None


@dataclass(frozen=True)
class Trials:
    """What became of motors of graded severities: ``found`` says which did not pass.

    ``good``, ``rejected``: how many motors without a defect there were, and how many of them did
    not pass.
    """

    range: Range
    severities: tuple[float, ...]
    found: tuple[bool, ...]
    good: int
    rejected: int

    def severity(self, share: float) -> Found:
        """Of a defect that is found in so large a share of the cases."""
        at, weights = self._places(share)
        low, middle, high = (float(np.exp(x)) for x in _quantiles(at, weights, self._step))
        most = self.range.most

        def inside(value: float) -> float | None:
            return value if value <= most else None

        return Found(inside(middle), min(low, most), inside(high))

    def next(self) -> list[int]:
        """Levels of the next trials: at the targets, by what is known so far.

        Half as many as were made already, so that a long study does not look more often.
        """
        levels = []
        for share in TARGETS:
            at, weights = self._places(share)
            levels.append(self.range.level(float(np.exp(at @ weights))))
        count = max(BATCH, len(self.found) // 2)
        return [levels[k % len(levels)] for k in range(count)]

    @property
    def _step(self) -> float:
        """Between two middles of the grid."""
        span = float(np.log(self.range.most / self.range.least))
        return (1.0 + 2.0 * BEYOND) * span / (MIDDLES - 1)

    def _counted(self) -> dict[float, tuple[int, int]]:
        """How many were found, and not found, at each severity."""
        counts: dict[float, tuple[int, int]] = {}
        for severity, hit in zip(self.severities, self.found, strict=True):
            hits, misses = counts.get(severity, (0, 0))
            counts[severity] = (hits + hit, misses + (not hit))
        return counts

    def _places(self, share: float) -> tuple[Floats, Floats]:
        """The logarithm of the severity found in that share, and the weight, at each grid point."""
        from scipy.special import ndtri

        middles, widths, alarms, weights = self._posterior
        # where more good motors than that share do not pass, any severity is found
        beyond = np.clip((share - alarms) / (1.0 - alarms), 1e-12, 1.0)
        at = middles + widths * ndtri(beyond)
        return np.maximum(at, np.log(self.range.least) - BEYOND).ravel(), weights.ravel()

    @cached_property
    def _posterior(self) -> tuple[Floats, Floats, Floats, Floats]:
        from scipy.special import betaincinv, ndtr

        least, most = np.log(self.range.least), np.log(self.range.most)
        reach = BEYOND * (most - least)
        middles = np.linspace(least - reach, most + reach, MIDDLES)[:, None, None]
        widths = np.geomspace(NARROWEST, WIDEST, WIDTHS)[None, :, None]
        # equally likely shares, by what the good motors say (Jeffreys)
        shares = (np.arange(SHARES) + 0.5) / SHARES
        alarms = betaincinv(self.rejected + 0.5, self.good - self.rejected + 0.5, shares)
        alarms = alarms[None, None, :]
        log = np.zeros(np.broadcast_shapes(middles.shape, widths.shape, alarms.shape))
        for severity, (hits, misses) in self._counted().items():
            seen = alarms + (1.0 - alarms) * ndtr((np.log(severity) - middles) / widths)
            seen = np.clip(seen, 1e-9, 1.0 - 1e-9)
            log += hits * np.log(seen) + misses * np.log1p(-seen)
        weights = np.exp(log - log.max())
        ones = np.ones_like(log)
        return middles * ones, widths * ones, alarms * ones, weights / weights.sum()


def _quantiles(at: Floats, weights: Floats, step: float) -> Floats:
    """2.5 %, 50 % and 97.5 % of places ``at``, each spread evenly over the grid's ``step``."""
    cell = step / FINE
    first = float(at.min()) - step
    cells = np.floor((at - first) / cell).astype(np.int64)
    shares = np.convolve(np.bincount(cells, weights), np.full(FINE, 1.0 / FINE))
    ends = first + cell * (np.arange(len(shares) + 1) - 0.5 * (FINE - 1))
    reached = np.concatenate([[0.0], np.cumsum(shares)])
    return np.asarray(np.interp([0.025, 0.5, 0.975], reached, ends))


def most_named(names: Sequence[Sequence[str]], count: int = 2) -> list[str]:
    """The quantities that were named in most trials, the most frequent first."""
    times = Counter(name for one in names for name in set(one))
    return sorted(times, key=lambda name: (-times[name], name))[:count]
