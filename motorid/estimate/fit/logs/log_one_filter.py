"""One channel of a log behind a low-pass that nobody stated, and all others as stamped.

A search that begins with filters of first order makes up for what they lack by lags and low-passes
of the other channels and by the winding, and ends there. One filter of second order is the simpler
cause. A low-pass of any order is, to first order, its delay. So each channel that comes later than
the others is tried alone: behind a filter that delays it as much, critically damped and less, with
nothing of the others but what is usual.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.errors import DataError
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import SECOND_ORDER, UNSTATED
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated import default
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from motorid.estimate.fit.logs.log_unknowns import Fit, Search, of_sizes, widened, with_rivals_of
from motorid.estimate.fit.multistart import MOST_TRIED, settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import BROKEN, JOINED, Shape
from motorid.estimate.solver.problem import Unknown

FIRST = {CURRENT: CURRENT_SMOOTHING, SPEED: SPEED_SMOOTHING, VOLTAGE: VOLTAGE_SMOOTHING}
BENDS = (0.5, 0.7)  # second of first time constant: two equal stages, and Butterworth's
LEAST = 0.6  # samples later than the others: less is no filter that matters
SOUGHT = 2.0  # samples, to begin with where a fit says nothing of it
READ: tuple[Shape, ...] = (JOINED, "curved", "held", BROKEN)  # of a voltage, the smooth ones first
SHAPES = {CURRENT: READ, SPEED: READ, VOLTAGE: ("curved", JOINED)}

Floats = NDArray[np.float64]
Found = list[dict[Instance, Unknown]]  # for each record


class _Search(Search):
    def __call__(self, shape: Shape, found: Found, start: Mapping[str, float]) -> Fit:
        """With these found and the others as is usual."""
        records = self.records(shape)
        for record, known in zip(records, found, strict=True):
            record.estimate(*(Instance(quantity) for quantity in UNSTATED))
            record.find(known)
        first = settled(records, self.free, start, self.worth)
        return records, widened(records, self.free, start, first, self.worth)


def taken(
    before: Fit,
    as_read: Sequence[Capture],
    free: Sequence[str],
    known: Mapping[str, float],
    fixed: Mapping[str, float],
    sought: bool = False,
) -> Fit:
    """The likeliest such fit of the captures ``as_read``; ``before`` where no channel is late
    enough, or none is likelier.

    ``sought``: ``before`` leaves a misfit, so that what it says of lags may be wrong. Then every
    channel is tried, by some samples at least.
    """
    search = _Search(as_read, free, fixed, before[1].objective)
    near = merged(known, before[1])
    least = SOUGHT if sought else 0.0
    fits = [fit for channel in FIRST for fit in _finite(_of(channel, before, search, near, least))]
    best = min([before, *fits], key=lambda fit: fit[1].fair)
    return best if best is before else with_rivals_of(before, best)


def _finite(fits: Iterator[Fit]) -> Iterator[Fit]:
    """Until one begins where no motor with finite readings is."""
    try:
        yield from fits
    except DataError:
        return


def _of(
    channel: str, before: Fit, search: _Search, near: Mapping[str, float], least: float
) -> Iterator[Fit]:
    """Fits with that channel behind a filter, of ``least`` samples or more."""
    first, second = Instance(FIRST[channel]), Instance(SECOND_ORDER[FIRST[channel]])
    if any(first.unknown(record) is None for record in before[0]):
        return  # somebody states it
    late = [
        max(later(record, own.tolist()).get(channel, 0.0), least * default.period_s(record))
        for record, own in zip(*_each(before), strict=True)
    ]
    enough = [LEAST * default.period_s(record) for record in before[0]]
    if any(size <= short for size, short in zip(late, enough, strict=True)):
        return
    smooth, *others = SHAPES[channel]

    def filtered(bend: float) -> Found:
        pairs = zip(before[0], late, strict=True)
        return [of_sizes(record, {first: size, second: bend * size}) for record, size in pairs]

    tried = [search(smooth, filtered(bend), near) for bend in BENDS]
    yield from tried
    best = min(tried, key=lambda fit: fit[1].fair)
    goes_on = [_found(record, own) for record, own in zip(*_each(best), strict=True)]
    for shape in others:
        if sum(r.simulated for records, _ in tried for r in records) > MOST_TRIED:
            return
        tried.append(search(shape, goes_on, merged(near, best[1])))
        yield tried[-1]


def _found(record: MotorRecord, own: Floats) -> dict[Instance, Unknown]:
    """What a fit has found, to begin with."""
    each = zip(record.instances, record.unknowns, own.tolist(), strict=True)
    return {one: replace(unknown, start=x) for one, unknown, x in each if one in record.found}


def _each(fit: Fit) -> tuple[Sequence[MotorRecord], Sequence[Floats]]:
    return fit[0], fit[1].own


def later(record: MotorRecord, own: Sequence[float]) -> dict[str, float]:
    """s, by channel whose filter nobody states: how much later than the usual one of its log it
    comes, by its lag and by the delay of its low-pass.
    """
    known = {one.quantity: x for one, x in zip(record.instances, own, strict=True)}
    lags = {CURRENT: known.get(CURRENT_LAG, 0.0), VOLTAGE: -known.get(VOLTAGE_LATE, 0.0)}
    total = {
        channel: lags.get(channel, 0.0) + known[first]
        for channel, first in FIRST.items()
        if first in known
    }
    usual = sorted(total.values())[(len(total) - 1) // 2] if total else 0.0
    return {channel: size - usual for channel, size in total.items()}
