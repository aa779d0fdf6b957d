"""What a log still shows of a filter, once a low-pass or a lag was found and allowed for.

A filter of whatever order shows a channel as a sum of what was true at the last few samples:

    reading = (1 - sum h_k) y(t) + sum h_k y(t - k T),    k = 1 ... TAPS

The fit has one low-pass of second order and a lag. How much chi-square would fall with the h_k of
the current and of the speed among the unknowns, by derivatives, says whether that was enough; a
voltage's filter moves both. If not, the parameters would move with them: that, and what the h_k
leave open, is by how much they may be wrong.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.effects.reading.smoothing import smoothed_by
from motorid.estimate.effects.registry import WITHOUT_WORD
from motorid.estimate.effects.unstated import default
from motorid.estimate.fit.logs.unstated_channels import Told, heard
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.estimate.uncertainty.intervals import NORMAL_95

Floats = NDArray[np.float64]

TAPS = 12  # of a channel
REACH = 2.5  # delays of the filter that was found, over which they are spread
USUAL = 0.1  # standard deviation of h_k
SURE = 6.0  # standard deviations of a gain by chance, beyond which it is none
FILTERED = (CURRENT, SPEED, POSITION)


def moves(records: Sequence[MotorRecord], solution: Solution) -> dict[str, float]:
    """SI, by parameter: how far a filter of another kind may have moved it; empty: none shows."""
    if not any(default.period_s(record) and record.found for record in records):
        return {}
    inverse, found = covariance_of(solution.information), np.zeros(len(solution.unknowns))
    for record, line, own in zip(records, solution.records, solution.own, strict=True):
        if not default.period_s(record) or not record.found:
            continue
        rows = np.array([
            USUAL * np.concatenate(parts) / np.repeat(line.sigmas, _lengths(line.slices))
            for parts in _changes(record, solution.values, own)
        ])  # fmt: skip
        if not len(rows):
            continue
        told = heard(rows, line, inverse)
        if told.gain > told.unknowns + SURE * (2.0 * told.unknowns) ** 0.5:
            found = np.maximum(found, _moved(told, inverse))
    each = zip(solution.unknowns, found * solution.slopes, strict=True)
    return {unknown.name: float(move) for unknown, move in each if move > 0.0}


def _lengths(slices: Sequence[slice]) -> list[int]:
    return [s.stop - s.start for s in slices]


def _moved(told: Told, inverse: Floats) -> Floats:
    """In search coordinates: the step, and by how much the half of an interval would grow."""
    before = np.diag(inverse)
    after = before + sum(shift**2 for shift in told.shifts)
    return np.abs(told.step) + NORMAL_95 * (np.sqrt(after) - np.sqrt(before))


def _changes(record: MotorRecord, values: Floats, own: Floats) -> Iterator[list[Floats]]:
    """Of the readings as the likelihood counts them, by one h_k of a channel."""
    shown = record.fitted(values, own)
    apart = _apart(record, own)
    for channel, m in enumerate(record.measured):
        if m.block.name not in FILTERED or _averaged(record, m.block.name):
            continue
        for k in range(1, TAPS + 1):
            parts = [np.zeros(len(y)) for y in shown]
            parts[channel] = _before(shown[channel], k * apart) - shown[channel]
            yield record.weighed(parts)


def _averaged(record: MotorRecord, block: str) -> bool:
    """Its readings were smoothed digitally and no more, and their noise with them: at what such a
    kernel keeps out there is none, and chance is no measure.
    """
    alone = not any(one.quantity in WITHOUT_WORD for one in record.found)
    return alone and smoothed_by(record.instances, record.unknowns, block) is not None


def _before(series: Floats, samples: int) -> Floats:
    """What a series (n,) was so many samples before; it stood before it began."""
    return np.concatenate([np.full(min(samples, len(series)), series[0]), series[:-samples]])


def _apart(record: MotorRecord, own: Floats) -> int:
    """Samples from one h_k to the next."""
    sizes = zip(record.instances, own.tolist(), strict=True)
    longest_s = sum(abs(size) for one, size in sizes if one.quantity in WITHOUT_WORD)
    return max(1, int(np.rint(REACH * longest_s / default.period_s(record) / TAPS)))
