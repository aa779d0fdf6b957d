"""Lags and low-passes of a log that nobody stated, as unknowns of one fit and of the next."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import UNSTATED, WITHOUT_WORD
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated import default
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import Rival, Shape
from motorid.estimate.solver.problem import Solution, Unknown

Floats = NDArray[np.float64]
Fit = tuple[list[MotorRecord], Solution]

BEYOND = 2.0  # standard deviations of what is usual, that make a quantity found
WORTH_IT = 0.5  # of them: less is a line of the budget
ROUNDS = 4  # in which more are found


@dataclass(frozen=True)
class Search:
    """Fits of the captures ``as_read``. ``worth``: F of the fit that they are held against."""

    as_read: Sequence[Capture]
    free: Sequence[str]
    fixed: Mapping[str, float]
    worth: float = math.inf

    def records(self, shape: Shape) -> list[MotorRecord]:
        """Of a voltage of that shape, with no more unknowns than every fit has."""
        return [MotorRecord(c, self.free, self.fixed, shape) for c in self.as_read]


def like(before: Fit, records: list[MotorRecord], whole: bool = False) -> list[MotorRecord]:
    """Records that begin with what others found; ``whole``: in whole samples."""
    for record, other, own in zip(records, before[0], before[1].own, strict=True):
        record.estimate(*(Instance(quantity) for quantity in UNSTATED))
        record.find(found_sizes(other, own, record, whole))
    return records


def with_rivals_of(before: Fit, other: Fit) -> Fit:
    """Another fit of the same readings, with the rivals that the one before it had."""
    gain = before[1].fair - other[1].fair
    for record, last in zip(other[0], before[0], strict=True):
        record.rivals = tuple(replace(r, behind=r.behind + gain) for r in last.rivals)
    return other


def as_rival(other: Fit, best: Fit, k: int) -> Rival:
    """Another fit of the same readings, as the record of that number has it for a rival."""
    records, solution = other
    behind = solution.fair - best[1].fair
    return Rival(solution.values, behind, _late_s(records[k], solution.own[k]))


def _late_s(record: MotorRecord, own: Floats) -> float:
    """By how much the voltage is taken later than its stamps; NaN: that is no unknown."""
    return -voltage_delay_s(record, own, math.nan)


def voltage_delay_s(record: MotorRecord, own: Floats, unknown: float = 0.0) -> float:
    """Of the voltage behind its stamps; ``unknown`` where no unknown says it."""
    sizes: dict[Instance, float] = dict(zip(record.instances, own.tolist(), strict=True))
    return sizes.get(Instance(VOLTAGE_LATE), unknown)


def readings(records: Sequence[MotorRecord]) -> int:
    """How many there are."""
    return sum(len(m.values) for r in records for m in r.measured)


def found_sizes(
    other: MotorRecord, own: Floats, record: MotorRecord, whole: bool = False
) -> dict[Instance, Unknown]:
    """What another record of the same readings found, to begin a search with; none: nothing."""
    if not other.found:
        return {}
    known = zip(other.instances, other.unknowns, own.tolist(), strict=True)
    return {
        one: replace(
            unknown,
            start=default.whole(record, size) if whole and one.quantity in WITHOUT_WORD else size,
        )
        for one, unknown, size in known
        if one.quantity in WITHOUT_WORD or one in other.found
    }


def of_sizes(record: MotorRecord, sizes: Mapping[Instance, float]) -> dict[Instance, Unknown]:
    """Quantities that are there, of such sizes (s)."""
    usual = {one: one.unknown(record) for one in sizes}
    return {
        one: replace(unknown, start=sizes[one], prior_sd=sizes[one])
        for one, unknown in usual.items()
        if unknown is not None
    }


def widened(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    solution: Solution,
    worth: float = np.inf,
) -> Solution:
    """With what was found given its size as its prior's deviation; ``worth``: as ``settled``. One
    that leaves much of F before may be a rival then.
    """
    for _ in range(ROUNDS):
        if not _find(records, solution):
            break
        solution = settled(records, free, merged(start, solution), worth)
    return solution


def _find(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """Whether some quantity is farther off than is usual."""
    more = False
    for record, own in zip(records, solution.own, strict=True):
        known = zip(record.instances, record.unknowns, own.tolist(), strict=True)
        found = {
            one: replace(unknown, start=size, prior_sd=abs(size))
            for one, unknown, size in known
            if one.quantity in WITHOUT_WORD and abs(size) > BEYOND * unknown.prior_sd
        }
        record.find(found)
        more = more or bool(found)
    return more


def moved(record: MotorRecord, own: Floats) -> bool:
    """Some of them is of a size that is worth an unknown."""
    known = zip(record.instances, record.unknowns, own.tolist(), strict=True)
    return any(
        one in record.found or abs(size) > WORTH_IT * unknown.prior_sd
        for one, unknown, size in known
        if one.quantity in UNSTATED
    )
