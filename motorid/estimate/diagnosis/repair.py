"""The fit again with a fault that was convicted among its unknowns: what is named is allowed for.

A fault that has a size is a quantity as any other (VIM 2.52): its size is estimated with the motor,
and what is left open of it is in the intervals. The fault is named all the same, with the values of
the fit that takes the channels as stated.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from motorid.capture.model import Capture
from motorid.errors import DataError
from motorid.estimate.diagnosis import misfit, rank
from motorid.estimate.diagnosis.faults import lost_samples, missing_samples
from motorid.estimate.diagnosis.faults.zeros import current_zero
from motorid.estimate.diagnosis.refit import scatter
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.fit.multistart import settled, whitened, with_repeated
from motorid.estimate.fit.parameter_bounds import held_values, merged, searched
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.intersample_voltage import Rival
from motorid.estimate.solver.problem import Solution, Unknown

Fit = tuple[list[MotorRecord], Solution]


ZERO = "current_offset"
REST = 0.15  # of a misfit, that its fault may leave


@dataclass(frozen=True)
class Repaired:
    """The captures with a fault among their unknowns, and what is said of it."""

    records: list[MotorRecord]
    solution: Solution
    suspect: Suspect


def repaired(
    records: Sequence[MotorRecord],
    solution: Solution,
    found: Sequence[Suspect],
    convicted: rank.Convicted | None,
    fix: Mapping[str, float],
    without: Sequence[str],
) -> Repaired | None:
    """The first of ``found`` that can be estimated; None where none can, or where the fit with it
    leaves as much to explain as a fault does, and no small part of what was.

    ``fix`` and ``without`` as of a fit.
    """
    held, was = held_values(fix, without), misfit.of_fit(records, solution)
    before = merged(held, solution)
    for suspect in found:
        if suspect.allowed or suspect.strength != "named":
            continue
        try:
            if suspect.code == missing_samples.CODE:
                fitted = _with_time(records, held, before)
            elif convicted is not None and suspect is convicted.suspect:
                fitted = _with_size(records, solution, convicted, held)
            else:
                fitted = _with_zero(records, held, before) if suspect.code == ZERO else None
        except DataError:
            continue  # the fault stays named, and what it may have moved stays doubtful
        if fitted is None or not fitted[1].converged:
            continue
        named = convicted if convicted is not None and suspect is convicted.suspect else None
        rest = _rest(was, *fitted, named)
        if rest <= REST:
            after = merged(held, fitted[1])
            moves = {name: math.sqrt(rest) * abs(after[name] - before[name]) for name in after}
            said = _allowed(suspect, before)
            return Repaired(*fitted, replace(said, moves=moves) if rest else said)
    return None


def _rest(
    was: float,
    records: Sequence[MotorRecord],
    solution: Solution,
    convicted: rank.Convicted | None,
) -> float:
    """Share of what ``was`` misfit that a fault leaves: as much of what it does may be left; none
    where no other fault is called for. What chance gives the fault is its own.
    """
    left, more = misfit.residuals(records, solution), []
    if convicted is not None:
        trial = convicted.trial
        more = scatter(records, solution.values, solution.own, trial.hypothesis, trial.found.size)
    now = misfit.excess(records, left, more)
    if now < rank.LIKELY:
        return 0.0
    return now / was if now < rank.SURELY else math.inf


def _with_time(
    records: Sequence[MotorRecord], held: Mapping[str, float], start: Mapping[str, float]
) -> Fit | None:
    """With the samples put back that are seen to be missing; None: not of all of them."""
    mended = [missing_samples.put_back(record.capture, record.timeline) for record in records]
    if not any(mended):
        return None
    pairs = zip(mended, records, strict=True)
    again = [_fresh(capture or record.capture, record, held) for capture, record in pairs]
    if any(lost_samples.suspects(record.capture, record.timeline) for record in again):
        return None
    return _fitted(again, held, start)


def _with_zero(
    records: Sequence[MotorRecord], held: Mapping[str, float], start: Mapping[str, float]
) -> Fit | None:
    """With a zero of the current as far off as it reads with the bridge open."""
    again, one = _unweighed(records), Instance(CURRENT_OFFSET)
    for record in again:
        zero = current_zero.seen(record)
        if zero is not None:
            usual = one.unknown(record)
            assert usual is not None
            record.find({one: replace(usual, start=zero, prior_sd=abs(zero))})
    return _fitted(again, held, start)


def _with_size(
    records: Sequence[MotorRecord],
    solution: Solution,
    convicted: rank.Convicted,
    held: Mapping[str, float],
) -> Fit | None:
    """With a fault that a fit convicted, by its quantity, or as a declared fact of the captures.

    None of a log, but for what was done to its readings afterwards: its fit has looked for all else
    that nobody stated of its channels, in more ways.
    """
    logged = any(record.sensed.waveform is not None for record in records)
    if logged and not convicted.trial.hypothesis.afterwards:
        return None
    names = [unknown.name for unknown in solution.unknowns]
    ended = dict(zip(names, map(float, convicted.trial.found.values), strict=True))
    start = {**merged(held, solution), **ended}
    found = _with_quantity(records, convicted, held, start)
    return found or _with_remedy(records, convicted, held, start)


def _with_quantity(
    records: Sequence[MotorRecord],
    convicted: rank.Convicted,
    held: Mapping[str, float],
    start: Mapping[str, float],
) -> Fit | None:
    """The fault is an unknown of the fit, known to be there, of about the trial's size."""
    hypothesis, size = convicted.trial.hypothesis, float(convicted.trial.found.size[0])
    if hypothesis.quantity is None:
        return None
    place = 0 if hypothesis.place is None else hypothesis.place(convicted.trial.found.size)
    one, again = Instance(hypothesis.quantity, place), _unweighed(records)
    scale, lower, upper = hypothesis.scale[0], hypothesis.lower[0], hypothesis.upper[0]
    if hypothesis.whole:
        size = lower = upper = float(round(size))
    for k in convicted.records:
        unknown = Unknown(one.name, size, lower, upper, scale=scale, prior_sd=abs(size))
        again[k].find({one: unknown})
        again[k].outlying = False  # they lay far off by what is now an unknown
    return _fitted(again, held, start)


def _with_remedy(
    records: Sequence[MotorRecord],
    convicted: rank.Convicted,
    held: Mapping[str, float],
    start: Mapping[str, float],
) -> Fit | None:
    """The likeliest of the captures that declare a fault of about that size; the others are its
    rivals.
    """
    remedy, size = convicted.trial.hypothesis.remedy, float(convicted.trial.found.size[0])
    if remedy is None:
        return None
    declared = [
        remedy(record.capture, size) if k in convicted.records else None
        for k, record in enumerate(records)
    ]
    found = []
    for n in range(max(len(each) for each in declared if each)):
        again = [
            _fresh(each[n] if each else record.capture, record, held)
            for each, record in zip(declared, records, strict=True)
        ]
        found.append(_fitted(again, held, start))
    best, solution = min(found, key=lambda one: one[1].objective)
    best[0].rivals = tuple(
        Rival(other.values, other.objective - solution.objective)
        for _, other in found
        if other is not solution
    )
    return best, solution


def _fresh(capture: Capture, record: MotorRecord, held: Mapping[str, float]) -> MotorRecord:
    """Another capture in the place of one, with what was found of it."""
    free = searched(held)
    again = MotorRecord(capture, free, held, record.shape)
    pairs = zip(record.instances, record.unknowns, strict=True)
    again.find({one: unknown for one, unknown in pairs if one in record.found})
    return again


def _unweighed(records: Sequence[MotorRecord]) -> list[MotorRecord]:
    """The records with noise taken as white: its colour was the fault's."""
    again = [record.twin() for record in records]
    for record in again:
        record.whiten([None] * len(record.measured))
    return again


def _fitted(
    records: list[MotorRecord], held: Mapping[str, float], start: Mapping[str, float]
) -> Fit:
    free = searched(held)
    found = settled(records, free, start)
    if not any(record.repeating.slopes for record in records):  # of new captures
        found = with_repeated(records, free, start, found)
    return records, whitened(records, free, merged(start, found), found)


def _allowed(suspect: Suspect, before: Mapping[str, float]) -> Suspect:
    return replace(
        suspect,
        evidence=f"{suspect.evidence}; the fit allows for it",
        moves={},
        allowed=True,
        without=before,
    )
