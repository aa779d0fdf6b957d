"""Noise taken in with the voltage: readings after a step that drive the fit as read, and slopes.

An error in the input leaves its mark on current and motion alike, where no residual shows it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.source.thevenin_source import Source
from motorid.estimate.solver.dense_products import project
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty import log_voltage_noise
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

UNIT_V = 1e-3  # by which a reading is tried


@dataclass(frozen=True)
class Hidden:
    """What one standard deviation of one such error, independent of the others, does.

    ``shared`` (p,) to the parameters in search coordinates, ``own`` (m,) to the nuisances of the
    record of that number; ``change`` (n,) of its readings, weighed, if neither followed.
    """

    record: int
    shared: Floats
    own: Floats
    change: Floats


def hidden(
    solution: Solution, records: Sequence[MotorRecord], roughly: bool = False
) -> tuple[Hidden, ...]:
    """Every such error; ``roughly``: noise of a log by straight lines alone."""
    inverse = covariance_of(solution.information)
    steps = log_voltage_noise.foreseen if roughly else log_voltage_noise.steps
    found: list[Hidden] = []
    for k, record in enumerate(records):
        found += _of_record(k, record, solution, inverse)
        found += [Hidden(k, s.shared, s.own, s.change) for s in steps(k, record, solution)]
    return tuple(found)


def shifts(errors: Sequence[Hidden]) -> list[Floats]:
    """(p,) of the parameters by each."""
    return [one.shared for one in errors]


def own_variance(errors: Sequence[Hidden], k: int, count: int) -> Floats:
    """(count,) that they add to the nuisances of record k."""
    return sum((one.own**2 for one in errors if one.record == k), np.zeros(count))


def with_errors(solution: Solution, errors: Sequence[Hidden]) -> Solution:
    """The solution whose nuisances are as uncertain as such errors leave them."""
    covariance = [one.copy() for one in solution.own_covariance]
    for one in errors:
        covariance[one.record] += np.outer(one.own, one.own)
    return replace(solution, own_covariance=tuple(covariance))


def _of_record(
    k: int, record: MotorRecord, solution: Solution, inverse: Floats
) -> Iterator[Hidden]:
    line, own = solution.records[k], _followed_by_own(solution.records[k])
    for change in _changes(record, line, solution.values, solution.own[k]):
        shared = inverse @ project(line.orthogonal.T, change)
        yield Hidden(k, shared, own @ (change - line.shared @ shared), change)


def _followed_by_own(line: Linearised) -> Floats:
    """(m, n): what a record's nuisances make of a change of its readings (n,), weighed."""
    return covariance_of(line.own_information) @ line.own.T


def _changes(
    record: MotorRecord, line: Linearised, values: Floats, own: Floats
) -> Iterator[Floats]:
    """(n,) of the model's readings by each error, weighed."""
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
            yield scaled * largest / UNIT_V


def _errors(source: Source | None, count: int) -> Iterator[Floats]:
    """Independent errors (V) of a part's voltage that the fit has no unknown for, (count,) each."""
    if source is None:
        return
    for head in source.errors:
        error = np.zeros(count)
        error[: len(head)] = head
        yield error
    yield np.broadcast_to(source.tilt, count)
