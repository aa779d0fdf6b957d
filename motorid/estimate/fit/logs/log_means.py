"""A log's current that is the mean over several samples, where nobody said so.

A running mean rounds a step like a low-pass does, and less so at its ends. Where a low-pass was
found, means over about as many samples as would round a step alike take its place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import SECOND_ORDER, UNSTATED
from motorid.estimate.effects.unstated import default
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.fit.alternating_fit import vanished
from motorid.estimate.fit.logs.log_unknowns import Fit, found_sizes, widened, with_rivals_of
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import Rival

Floats = NDArray[np.float64]
SMOOTHING, LAG = Instance(CURRENT_SMOOTHING), Instance(CURRENT_LAG)
SMOOTH = frozenset(Instance(one) for one in SECOND_ORDER)
LEAST = 0.6  # samples: a mean over two is rounder
ALIKE = math.sqrt(12.0)  # width of a mean that spreads a step as a low-pass of time constant 1 does
MOST = 7  # numbers of samples that are tried


def taken(
    before: Fit, free: Sequence[str], known: Mapping[str, float], fixed: Mapping[str, float]
) -> Fit:
    """The likeliest fit with means in the place of the current's low-pass; ``before`` if none is
    likelier, or no such low-pass was found.
    """
    period_s = max(default.period_s(record) for record in before[0])
    each = zip(before[0], before[1].own, strict=True)
    longest_s = max((_smoothed(record, own) for record, own in each), default=0.0)
    if longest_s <= LEAST * period_s:
        return before
    first = max(2, round(ALIKE * longest_s / period_s))
    tried = {first: _over(before, first * period_s, free, known, fixed)}
    while len(tried) < MOST:
        best = min(tried, key=lambda count: tried[count][1].fair)
        beside = [count for count in (best - 1, best + 1) if count > 1 and count not in tried]
        if not beside:
            break
        tried[beside[0]] = _over(before, beside[0] * period_s, free, known, fixed)
    means = min(tried.values(), key=lambda fit: fit[1].fair)
    if means[1].fair >= before[1].fair or vanished(means[1], means[0]):
        return before
    return with_rivals_of(before, means)


def _smoothed(record: MotorRecord, own: Floats) -> float:
    """s, of the low-pass of a record's current beside those of its other channels: smoothing of the
    one is the same as less of the others. 0: somebody states it.
    """
    known = {one: float(x) for one, x in zip(record.instances, own, strict=True) if one in SMOOTH}
    if SMOOTHING not in known:
        return 0.0
    return known[SMOOTHING] - min(0.0, *known.values())


def _over(
    before: Fit,
    width_s: float,
    free: Sequence[str],
    known: Mapping[str, float],
    fixed: Mapping[str, float],
) -> Fit:
    """The same with means over that time where a low-pass was found, as late as it was."""
    records = []
    for last, own in zip(before[0], before[1].own, strict=True):
        smoothed_s = _smoothed(last, own)
        capture = as_means(last.capture, width_s) if smoothed_s > 0.0 else last.capture
        record = MotorRecord(capture, free, fixed, last.shape)
        sizes = {one: x for one, x in found_sizes(last, own, record).items() if one != SMOOTHING}
        lag = LAG.unknown(last) if LAG in last.instances else None
        if smoothed_s > 0.0 and lag is not None:
            late_s = float(own[last.instances.index(LAG)]) + smoothed_s - width_s / 2
            sizes[LAG] = replace(lag, start=late_s, prior_sd=max(abs(late_s), lag.prior_sd))
        record.estimate(*(Instance(quantity) for quantity in UNSTATED))
        record.find(sizes)
        records.append(record)
    near = merged(known, before[1])
    worth = before[1].objective
    first = settled(records, free, near, worth)
    return records, widened(records, free, near, first, worth)


def as_means(capture: Capture, width_s: float) -> Capture:
    channel = replace(capture.channels[CURRENT], kind="mean", aperture_s=width_s)
    return replace(capture, channels={**capture.channels, CURRENT: channel})


def likelier(one: Fit, other: Fit, price: float) -> Fit:
    """The likelier of two fits of the same readings, the other a rival of it.

    ``price`` of F, of each quantity that was found.
    """

    def cost(fit: Fit) -> float:
        return fit[1].fair + price * sum(len(record.found) for record in fit[0])

    if one is other:
        return one
    best, rest = sorted((one, other), key=cost)
    behind = max(rest[1].fair - best[1].fair, 0.0)
    for record in best[0]:
        record.rivals = (*record.rivals, Rival(rest[1].values, behind))
    return best
