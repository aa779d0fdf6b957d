"""Straight pieces: the fewest straight lines that follow a set of signals to within their noise.

Bottom up: neighbours are joined, cheapest first, while the joint line costs no more chi-square
than the noise explains. Keogh et al., "An online algorithm for segmenting time series", 2001,
describe the family; joining every locally cheapest pair at once makes it fast in numpy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GOLDEN = 0.6180339887498949


@dataclass(frozen=True)
class Pieces:
    """Lines over blocks ``first`` to ``stop`` (exclusive), each (p,).

    ``middle``, ``level`` and ``slope`` are of shape (p,), (p, c) and (p, c) for c signals;
    ``slope_error`` (p, c) is the standard error of the slope for the noise given.
    """

    first: Ints
    stop: Ints
    middle: Floats
    level: Floats
    slope: Floats
    slope_error: Floats

    def at(self, piece: Ints, time_s: Floats, signal: int = 0) -> Floats:
        """The lines' values at times that lie in the given pieces; shapes (k,)."""
        away = time_s - self.middle[piece]
        return np.asarray(self.level[piece, signal] + self.slope[piece, signal] * away)


@dataclass(frozen=True)
class _Sums:
    """Counts, means and centred second moments of each piece: enough to fit and to join lines."""

    count: Floats
    time: Floats
    value: Floats
    time_time: Floats
    time_value: Floats
    value_value: Floats

    def pick(self, index: NDArray[np.bool_] | slice) -> _Sums:
        return _Sums(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    def join(self, other: _Sums) -> _Sums:
        count = self.count + other.count
        share = other.count / count
        weight = self.count * share
        time_step, value_step = other.time - self.time, other.value - self.value
        return _Sums(
            count,
            self.time + share * time_step,
            self.value + share[:, None] * value_step,
            self.time_time + other.time_time + weight * time_step**2,
            self.time_value + other.time_value + (weight * time_step)[:, None] * value_step,
            self.value_value + other.value_value + weight[:, None] * value_step**2,
        )

    def slope(self) -> Floats:
        spread = np.where(self.time_time > 0, self.time_time, 1.0)
        return np.asarray(self.time_value / spread[:, None])

    def misfit(self) -> Floats:
        """Chi-square of each piece's line, over all signals."""
        return np.asarray(np.sum(self.value_value - self.slope() * self.time_value, axis=1))


def straight_pieces(
    time_s: Floats, signals: Floats, sigma: Floats, joined: NDArray[np.bool_], penalty: float
) -> Pieces:
    """Pieces of ``signals`` (k, c) with noise ``sigma`` (c,), never across ``joined[j]`` False.

    ``penalty`` is the chi-square that one more piece must save.
    """
    k = len(time_s)
    sums = _Sums(
        np.ones(k),
        np.asarray(time_s, dtype=np.float64),
        signals / sigma,
        np.zeros(k),
        np.zeros_like(signals),
        np.zeros_like(signals),
    )
    first, open_after, misfit = np.arange(k), joined, np.zeros(k)
    while len(first) > 1:
        both = sums.pick(slice(None, -1)).join(sums.pick(slice(1, None)))
        misfit_both = both.misfit()
        cost = np.where(open_after, misfit_both - misfit[:-1] - misfit[1:], np.inf)
        chosen = _cheapest(cost, 1e-6 * penalty) & (cost <= penalty)
        if not chosen.any():
            break
        keep = ~np.concatenate(([False], chosen))
        sums, misfit = _replace(sums, both, chosen, keep), _put(misfit, misfit_both, chosen)[keep]
        first, open_after = first[keep], open_after[~chosen]
    slope_error = sigma / np.sqrt(np.where(sums.time_time > 0, sums.time_time, np.inf))[:, None]
    slope_error = np.where(sums.time_time[:, None] > 0, slope_error, np.inf)
    stop = np.append(first[1:], k)
    return Pieces(first, stop, sums.time, sums.value * sigma, sums.slope() * sigma, slope_error)


def _cheapest(cost: Floats, tie: float) -> NDArray[np.bool_]:
    """Pairs cheaper than the pairs before and after, so that no two share a piece.

    Equal costs (a shaft at rest, exactly) are told apart by up to ``tie``, spread evenly.
    """
    spread = np.arange(len(cost)) * GOLDEN % 1.0
    padded = np.concatenate(([np.inf], cost + tie * spread, [np.inf]))
    return np.asarray((padded[1:-1] <= padded[:-2]) & (padded[1:-1] < padded[2:]))


def _put(values: Floats, joint: Floats, chosen: NDArray[np.bool_]) -> Floats:
    """``values`` with those of the left piece of each chosen pair replaced by the pair's."""
    out = values.copy()
    out[:-1][chosen] = joint[chosen]
    return out


def _replace(sums: _Sums, both: _Sums, chosen: NDArray[np.bool_], keep: NDArray[np.bool_]) -> _Sums:
    names = sums.__dataclass_fields__
    return _Sums(*(_put(getattr(sums, n), getattr(both, n), chosen)[keep] for n in names))
