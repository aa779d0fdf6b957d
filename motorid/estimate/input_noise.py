"""Noise taken in with the voltage: readings after a step that drive the fit as read, and slopes.

An error in the input leaves its mark on current and motion alike, where no residual shows it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.algebra import project
from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Linearised, Solution
from motorid.estimate.source import Source
from motorid.estimate.uncertainty import covariance_of

Floats = NDArray[np.float64]

UNIT_V = 1e-3  # by which a reading is tried


def shifts(solution: Solution, records: Sequence[MotorRecord]) -> list[Floats]:
    """What one standard deviation of each such error does to the parameters, (p,) each.

    In search coordinates; the errors are independent of each other.
    """
    inverse = covariance_of(solution.information)
    return [
        inverse @ pull
        for record, line, own in zip(records, solution.records, solution.own, strict=True)
        for pull in _pulls(record, line, solution.values, own)
    ]


def _pulls(record: MotorRecord, line: Linearised, values: Floats, own: Floats) -> Iterator[Floats]:
    base = record.fitted(values, own)
    for part, source in zip(record.timeline.parts, record.sources, strict=True):
        for error in _errors(source, part.stop - part.start):
            largest = float(np.abs(error).max(initial=0.0))
            if largest == 0.0:
                continue
            volts = record.volts.copy()
            volts[part.slice] += error * (UNIT_V / largest)
            moved = record.fitted_with(values, own, volts)
            left = record.weighed([new - y for y, new in zip(base, moved, strict=True)])
            scaled = np.concatenate([d / s for d, s in zip(left, line.sigmas, strict=True)])
            yield project(line.orthogonal.T, scaled) * largest / UNIT_V


def _errors(source: Source | None, count: int) -> Iterator[Floats]:
    """Independent errors (V) of a part's voltage that the fit has no unknown for, (count,) each."""
    if source is None:
        return
    for head in source.errors:
        error = np.zeros(count)
        error[: len(head)] = head
        yield error
    yield np.broadcast_to(source.tilt, count)
