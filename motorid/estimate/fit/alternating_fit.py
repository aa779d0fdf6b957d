"""The search and what drives the motor in turn, until neither changes the other.

Every pass judges the source by the model's own current, and the search goes on with that. What is a
choice between two things (how many readings a source follows, a supply's lag) is decided while the
answer still moves much, and kept from then on: two choices that bring each other about would else
take turns for ever. The passes end where what is left to come is a small part of what noise leaves
open. Where the last of them does not get there, what is left is a cause of the budget.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.fit.parameter_bounds import merged, unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.source_mixing import Mixer
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.allowance import used_up
from motorid.estimate.solver.levenberg_marquardt import ENOUGH, MAX_ITERATIONS, maximise
from motorid.estimate.solver.problem import Solution, Unknown
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

MOST_PASSES = 24  # of fit and source in turn
BARE_PASSES = 3  # the same without unknowns of what brushes take: of a model that has them itself
LOST_PASSES = 7  # the same where L has vanished: no pass finds it again
MOST_SIMULATED = 3000  # responses of a capture, after which no other pass begins
ROUGH_PASSES = 2  # from a start
LATEST = 12  # passes after which all is decided
COMPARED_PASSES = 6  # of a fit that is only compared with others: one far off may swing for ever
DECIDED = 0.02  # of a standard deviation by noise: with less to come nothing is decided anew
SETTLED = 0.02  # of it: the same of what is worth no other pass
SAID = 0.1  # of it: less would widen an interval by half a per cent at most
CALM = 2  # passes on end that are worth no other: what swings passes through its middle
QUICKEST, SLOWEST = 0.3, 0.95  # that a pass changes of what the one before did
HOVERING = 6  # passes that stay near where they lead away by less than ASTRAY of their way
ASTRAY = 0.5
ROUGH = 1.0  # change of chi-square that is near enough while sources and noise are unsettled
JUDGED = 0.1  # the same of a model that is to be judged: its size must not hang on where it ended
JUDGED_STEPS = 25  # of a search whose model is to be judged: one that creeps is no better than that
CLOSE = 1e-4  # the same once they nearly are: what passes leave undone, the next take for a change
SAME = 1e-9  # of a voltage: less is rounding
VANISHED = 0.02  # L/R in sample periods: less than readings tell from none


@dataclass(frozen=True)
class Change:
    """Of one pass: ``shift`` (p,) in search coordinates, ``deviations`` (p,) by noise of these."""

    shift: Floats
    deviations: Floats

    @property
    def size(self) -> float:
        """Of the parameter that moved most, in standard deviations by noise."""
        return float((np.abs(self.shift) / self.deviations).max(initial=0.0))

    @classmethod
    def of(cls, before: Solution, after: Solution) -> Change:
        """From one solution to the next."""
        stays = after.at_bound & before.at_bound
        shift = np.where(stays, 0.0, _coordinates(after) - _coordinates(before))
        return cls(shift, np.sqrt(np.diag(covariance_of(after.information))))

    def left(self, before: Change | None) -> float:
        """In standard deviations, what all further passes will change: each that much less."""
        ratio = self.size / before.size if before is not None and before.size else 1.0
        ratio = min(max(ratio, QUICKEST), SLOWEST)
        return self.size * ratio / (1.0 - ratio)

    def ahead(self, before: Sequence[Change]) -> Change:
        """What is left to come. Passes that hover end somewhere among where they have been."""
        left = self.left(before[-1] if before else None)
        onward = replace(self, shift=self.shift * (left / self.size if self.size else 0.0))
        passes = [*before, self]
        if not hovers(passes):
            return onward
        size = attrgetter("size")
        return min(onward, max(self._reached(passes), key=size), key=size)

    def _reached(self, passes: Sequence[Change]) -> list[Change]:
        """From where each of the last passes began to here."""
        shifts = np.cumsum([one.shift for one in reversed(passes[-HOVERING:])], axis=0)
        return [replace(self, shift=shift) for shift in shifts]


def hovers(passes: Sequence[Change]) -> bool:
    """So many passes have stayed near where they began."""
    last = passes[-HOVERING:]
    away = replace(last[-1], shift=np.sum([one.shift for one in last], axis=0))
    return len(last) == HOVERING and away.size <= ASTRAY * sum(one.size for one in last)


def with_sources(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    held_h: float = 0.0,
) -> Solution:
    """The fit and what drives the motor in turn, until that stays; ``held_h``: an inductance that
    is not searched, 0: it is.
    """
    return in_turn(records, free, start, _begun(records, free, start, held_h), held_h)


def going_on(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    rough: Solution,
    most: int = MAX_ITERATIONS,
) -> Solution:
    """``with_sources`` from a rough solution, whose derivatives are near enough to begin with."""
    for record in records:
        record.decide(False)
    return in_turn(records, free, start, again(records, free, start, rough, ROUGH, most=most))


def _begun(
    records: Sequence[MotorRecord], free: Sequence[str], start: Mapping[str, float], held_h: float
) -> Solution:
    """The fit with the sources as they are, of which nothing is decided yet."""
    first = _held(unknowns_of(records, free, start), held_h)
    for record in records:
        record.decide(False)
    return maximise(first, records, enough=ROUGH)


def in_turn(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    solution: Solution,
    held_h: float = 0.0,
    thorough: bool = False,
) -> Solution:
    """``with_sources`` from a solution on, with what was decided before it.

    A model with more terms gets few passes, and those roughly, unless it asks for ``thorough``.
    """
    decided = all(record.driving.decided for record in records)
    mixers = [Mixer() for _ in records]
    changes: list[Change] = []
    calm = 0
    bare = any(record.loss is None for record in records)
    most = max(record.simulated for record in records) + MOST_SIMULATED
    more = any(len(record.names) > len(PARAMETERS) for record in records)
    wide = more and not thorough
    for n in range(1, BARE_PASSES if bare or wide else MOST_PASSES):  # to be judged, no more
        lost = vanished(solution, records)
        if (lost and n >= LOST_PASSES) or max(record.simulated for record in records) > most:
            break
        if used_up():
            break
        driven = [record.volts for record in records]
        for record, own, mixer in zip(records, solution.own, mixers, strict=True):
            record.retake_sources(solution.values, own, mixer if decided else None)
        if bare and all(map(_same, driven, records)):
            break
        unsettled_yet = n <= ROUGH_PASSES and not decided
        enough = ROUGH if bare or lost or unsettled_yet else CLOSE
        enough, steps = (JUDGED, JUDGED_STEPS) if wide else (enough, MAX_ITERATIONS)
        found = again(records, free, start, solution, enough, held_h, steps)
        change = Change.of(solution, found)
        solution, left = found, change.left(changes[-1] if changes else None)
        changes.append(change)
        calm = calm + 1 if decided and left < SETTLED else 0
        if calm == CALM or (more and _in_vain(changes)):
            break
        decided = decided or (not bare and (left < DECIDED or n >= LATEST))
        for record in records:
            record.decide(decided)
    ahead = changes[-1].ahead(changes[:-1]) if changes and not bare else None
    for record in records:
        record.unsettled = ahead.shift if ahead is not None and ahead.size > SAID else None
    return solution


def _in_vain(passes: Sequence[Change]) -> bool:
    """They hover, and become no smaller: where events make a likelihood rough, none will."""
    return hovers(passes) and passes[-1].size >= passes[-HOVERING].size


def _same(volts: Floats, record: MotorRecord) -> bool:
    """The source is what it was, but for rounding."""
    largest = float(np.abs(volts).max(initial=0.0))
    return float(np.abs(record.volts - volts).max(initial=0.0)) <= SAME * largest


def _coordinates(solution: Solution) -> Floats:
    each = zip(solution.unknowns, solution.values, strict=True)
    return np.array([np.log(v) if u.log else v for u, v in each])


def vanished(solution: Solution, records: Sequence[MotorRecord]) -> bool:
    """The inductance has gone to where it is none; what the ripple does went with it."""
    resistance, inductance = (float(v) for v in records[0].motor(solution.values)[:2])
    period = min(record.timeline.period_s for record in records)
    return 0.0 < inductance < VANISHED * resistance * period


def again(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    before: Solution,
    enough: float = ENOUGH,
    held_h: float = 0.0,
    most: int = MAX_ITERATIONS,
) -> Solution:
    """The search goes on from a solution, with what has changed in the records."""
    known = _held(unknowns_of(records, free, merged(start, before)), held_h)
    return maximise(known, records, most, enough, before)


def judge_at(records: Sequence[MotorRecord], solution: Solution, inductance_h: float) -> None:
    """What drives the motor, and what is lost, if that were its inductance.

    Ripple and pulses follow it, and what brushes take of them: judged by none, it stays none.
    """
    values = np.array([
        inductance_h if unknown.name == "L" else value
        for unknown, value in zip(solution.unknowns, solution.values, strict=True)
    ])  # fmt: skip
    for record, own in zip(records, solution.own, strict=True):
        record.retake_sources(values, own)


def with_inductance(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    known: Mapping[str, float],
    near: Solution,
    inductance_h: float,
) -> Solution:
    """``with_sources`` from ``known`` values with an inductance that is held, and what drives the
    motor judged by it from the start; ``near`` is a solution to judge that with.
    """
    judge_at(records, near, inductance_h)
    return with_sources(records, free, {**known, "L": inductance_h}, inductance_h)


def near_inductance(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    known: Mapping[str, float],
    near: Solution,
    inductance_h: float,
) -> Solution:
    """``with_inductance`` as far as it takes to be compared with others: until chi-square stays."""
    judge_at(records, near, inductance_h)
    start = {**known, "L": inductance_h}
    solution = _begun(records, free, start, inductance_h)
    for _ in range(COMPARED_PASSES):
        judge_at(records, solution, inductance_h)
        before = solution
        solution = again(records, free, start, before, ROUGH, inductance_h)
        if abs(solution.objective - before.objective) < ROUGH:
            break
    return solution


def _held(unknowns: list[Unknown], held_h: float) -> list[Unknown]:
    if not held_h:
        return unknowns
    return [
        replace(u, start=held_h, lower=held_h, upper=held_h) if u.name == "L" else u
        for u in unknowns
    ]
