"""Low-passes of a log that turn out to be of second order, where nobody stated any.

A bend of the readings is a filter's, a delay's or the winding's. A filter of an order too low
leaves the rest of it to the winding: L was then off by up to three times its value.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.registry import SECOND_ORDER
from motorid.estimate.fit.logs.log_unknowns import Fit, like, readings, widened, with_rivals_of
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

BENT = (0.3, 0.7)  # of the time constant found, to begin a second order with
NOTHING = 1e-3  # of the time constant that was expected
SHORTER = 0.5  # of the inductance found, the same


def taken(
    before: Fit, free: Sequence[str], known: Mapping[str, float], fixed: Mapping[str, float]
) -> Fit:
    """With low-passes of second order in the place of those that were found, where that pays.

    The same bend of the readings is a filter's, a delay's or the winding's. An order too low leaves
    the rest of it to the winding.
    """
    best = before
    for first, second in SECOND_ORDER.items():
        sizes = [
            _size(record, own, first) for record, own in zip(best[0], best[1].own, strict=True)
        ]
        if not any(sizes):
            continue
        for bend in BENT:
            near = merged(known, best[1])
            if "L" in free and bend > BENT[0]:
                near["L"] *= SHORTER
            records = like(best, [MotorRecord(r.capture, free, fixed, r.shape) for r in best[0]])
            for record, size in zip(records, sizes, strict=True):
                unknown = Instance(second).unknown(record)
                if size and unknown is not None:
                    there = replace(unknown, start=bend * size, prior_sd=size)
                    record.find({Instance(second): there})
            best = _better(
                best, (records, widened(records, free, near, settled(records, free, near)))
            )
    return best


def without_vanished(
    before: Fit, free: Sequence[str], known: Mapping[str, float], fixed: Mapping[str, float]
) -> Fit:
    """Without those that ended at nothing, where the search on their account went elsewhere: as
    unknowns they would leave a lag open that all else tells.
    """
    gone = [
        set(_vanished(record, own)) for record, own in zip(before[0], before[1].own, strict=True)
    ]
    if not any(gone):
        return before
    records = like(before, [MotorRecord(r.capture, free, fixed, r.shape) for r in before[0]])
    for record, nothing in zip(records, gone, strict=True):
        record.propagate(*nothing)
        record.found -= nothing
    solution = settled(records, free, merged(known, before[1]))
    behind = solution.fair - before[1].fair
    if behind > np.log(readings(records)):
        return before
    return with_rivals_of(before, (records, solution))


def _vanished(record: MotorRecord, own: Floats) -> Iterator[Instance]:
    """Second orders of no size."""
    for one, unknown, size in zip(record.instances, record.unknowns, own.tolist(), strict=True):
        if one.quantity in SECOND_ORDER.values() and size <= NOTHING * unknown.prior_sd:
            yield one


def _better(before: Fit, other: Fit) -> Fit:
    """The other fit where it is worth an unknown more (Schwarz)."""
    gain = before[1].fair - other[1].fair
    return with_rivals_of(before, other) if gain > np.log(readings(before[0])) else before


def _size(record: MotorRecord, own: Floats, quantity: InfluenceQuantity) -> float:
    """s, of a low-pass that was found in a record; 0: none was."""
    for one, size in zip(record.instances, own.tolist(), strict=True):
        if one.quantity is quantity and one in record.found:
            return max(float(size), 0.0)
    return 0.0
