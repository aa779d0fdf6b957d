"""Where a logged voltage jumps from a reading to the next, and how much its readings scatter."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motorid.capture.reading_step import reading_step
from motorid.estimate.signals.neighbour_noise import of_differences

Floats = NDArray[np.float64]

QUARTER_BELOW = 0.3186  # standard deviations within which a quarter of normal readings lie
CALM = 16  # stretches of a log, of which the calmer ones tell its noise
CHANCE = 3.5  # standard deviations of a stretch's noise, by which it may exceed the calm ones'
ORDERS = (2, 4, 6)  # of differences that tell the noise
SWINGS = 0.5  # of what a lower order tells: that is no noise
ENOUGH = 64  # readings of each
SAME = 1e-9  # of the range: readings that differ by less agree but for rounding
COARSE = 0.02  # of the range: larger steps are levels of a command, and no converter's
FLICKERS = 8  # readings, by which steps that noise hardly ever crosses are a converter's
CLEAR, SHARE = 8.0, 0.05  # a jump in standard deviations of a reading, and of the range
LONG, SHORTEST = 16, 4  # readings of a level, on average and at least


def jumps(volts: Floats) -> NDArray[np.intp]:
    """Readings (n,) before which the voltage jumped."""
    return _farther(volts, least_jump(volts))


def changes(volts: Floats) -> NDArray[np.intp]:
    """Readings (n,) that lie farther from the one before than noise does."""
    return _farther(volts, CLEAR * scatter(volts))


def _farther(volts: Floats, least: float) -> NDArray[np.intp]:
    """Readings (n,) that differ by more than so many V from the one before."""
    return np.asarray(np.flatnonzero(np.abs(np.diff(volts)) > least) + 1, dtype=np.intp)


def level_jumps(volts: Floats) -> NDArray[np.intp] | None:
    """Readings (n,) before which it jumped, however little, of a voltage that does so from level to
    level; None: it changes for several readings on end.
    """
    steps = changes(volts)
    alone = np.diff(steps, prepend=0, append=len(volts)) >= SHORTEST
    return steps if alone.all() and len(steps) * LONG <= len(volts) else None


def least_jump(volts: Floats) -> float:
    """V that readings (n,) differ by where the voltage jumped.

    Where it jumps every few readings no stretch is calm; many neighbours are of one level still.
    """
    noise = scatter(volts)
    if len(volts) >= ENOUGH:  # which may be too few for the noise of calm stretches
        alike = float(np.percentile(np.abs(np.diff(volts)), 25)) / QUARTER_BELOW
        alike = max(alike, count_of(volts)) / math.sqrt(2.0)
        noise = min(noise or alike, alike or noise)  # rows that stand twice tell nothing
    return max(CLEAR * noise, SHARE * float(np.ptp(volts)))


def scatter(volts: Floats) -> float:
    """Standard deviation of a reading by its neighbours, in the calmer stretches of the log.

    Differences of a higher order leave less of a voltage that swings within few readings. What a
    converter's steps hide is there, whatever neighbours show.
    """
    if len(volts) < CALM * 8:
        return 0.0
    step = count_of(volts)
    calm = _calm(np.diff(volts, ORDERS[0]), ORDERS[0], step)
    for order in ORDERS[1:]:
        less = _calm(np.diff(volts, order), order, step)
        calm = less if less < SWINGS * calm else calm
    return max(calm, step / math.sqrt(12.0)) if calm or _flickers(volts, step) else 0.0


def _flickers(volts: Floats, step: float) -> bool:
    """Readings (n,) leave a level by one ``step`` and come back at once, however seldom: it is a
    converter's, and no command's. How far its levels lie from the voltage none of them tells.
    """
    before, now, after = volts[:-2], volts[1:-1], volts[2:]
    off, same = np.abs(now - before), np.abs(after - before) < step / 2.0
    return bool(np.sum(same & (off > step / 2.0) & (off < 1.5 * step)) >= FLICKERS)


def _calm(differences: Floats, order: int, step: float) -> float:
    """Of all stretches that are as calm as the calmer quarter, but for chance: a quarter alone is
    that of which chance makes little.
    """
    stretches = min(max(len(differences) // ENOUGH, CALM // 4), CALM)
    size = len(differences) // stretches
    blocks = differences[: size * stretches].reshape(stretches, size)
    each = of_differences(blocks, order, step)
    # squares of neighbouring differences are correlated, the more the higher their order
    alike = math.comb(4 * order, 2 * order) / math.comb(2 * order, order) ** 2
    calm = float(np.percentile(each, 25))
    usual = calm * (1.0 + CHANCE * math.sqrt(alike / (2.0 * size)))
    return max(calm, float(np.sqrt(np.mean(each[each <= usual] ** 2))))


def rounding(deviation: float, step: float) -> float:
    """Standard deviation of what a converter's steps leave in the mean of many readings.

    Noise of a ``deviation`` far below a ``step`` moves none of them; of half a step it smooths the
    steps away (Widrow and Kollár, 2008: their first harmonic).
    """
    if not step > 0.0:
        return 0.0
    shown = math.exp(-2.0 * (math.pi * deviation / step) ** 2)
    return float(step * min(shown / (math.pi * math.sqrt(2.0)), 12.0**-0.5))


def count_of(volts: Floats) -> float:
    """V of a converter's step: what readings that often agree differ by at least, or of which all
    are multiples, as of a slow ramp; 0: they change by whole levels, or by any size.
    """
    range_v, distinct = float(np.ptp(volts)), np.unique(volts)
    apart = np.diff(distinct)
    apart = apart[apart > SAME * range_v]
    if not len(apart):
        return 0.0
    often = len(distinct) <= len(volts) / 2
    step = float(np.percentile(apart, 10)) if often else reading_step(volts)
    return step if step < COARSE * range_v else 0.0
