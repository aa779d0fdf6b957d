"""The search, the voltage sources and the noise in turn, until none changes the others.

Whatever the model: records of six parameters settle as those of a wider model do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.estimate import colour, delays
from motorid.estimate.algebra import misfits
from motorid.estimate.likelihood import ENOUGH, maximise
from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Derivatives, Solution, Unknown
from motorid.estimate.source import Source
from motorid.estimate.types import PARAMETERS
from motorid.estimate.unknowns import merged, unknowns_of

SOURCE_PASSES = 3  # at most, of fit and source lines in turn
LOSS_PASSES = 7  # the same while what brushes take follows a current that still moves
ROUGH = 1.0  # change of chi-square that is near enough while sources and noise are unsettled
COLOUR_PASSES = 2  # of noise model and fit in turn
VANISHED = 0.02  # L/R in sample periods: less than readings tell from none
RISES, NEARBY = (0.3, 0.1), 3.0  # L/R in sample periods to begin with instead; factor
GROSS = 0.02  # residuals in units of a channel's range: worth another start
OTHER_STARTS: tuple[dict[str, float], ...] = (
    {"L": 0.2},
    {"L": 5.0},
    {"J": 0.4, "L": 2.0},
    {"J": 2.5, "R": 1.5},
)


def solve(
    records: Sequence[MotorRecord], free: Sequence[str], start: Mapping[str, float]
) -> Solution:
    """The most likely parameters: as ``settled``, then correlated noise allowed."""
    solution = settled(records, free, start)
    return whitened(records, free, merged(start, solution), solution)


def settled(
    records: Sequence[MotorRecord], free: Sequence[str], start: Mapping[str, float]
) -> Solution:
    """The most likely parameters for white noise: other starts are tried where one misfits."""
    solution = with_sources(records, free, start)
    if not solution.converged or leaves_misfit(solution, records):
        for factors in OTHER_STARTS:
            other = {n: start[n] * factors.get(n, 1.0) for n in PARAMETERS}
            trial = with_sources(records, free, other)
            if trial.objective < solution.objective - 1.0:
                solution = trial
        solution = with_sources(records, free, merged(start, solution))
    if _vanished(solution, records):
        known = merged(start, solution)
        period = min(record.timeline.period_s for record in records)
        trials = [solution]
        for rise in RISES:
            near_h = rise * known["R"] * period
            _judge_at(records, solution, near_h)
            trials.append(with_sources(records, free, {**known, "L": near_h}, near_h))
        likeliest = min(trials, key=lambda one: one.objective)
        best = merged(start, likeliest)
        _judge_at(records, likeliest, best["L"])  # what drives them is the last one's
        held = with_sources(records, free, best, best["L"])
        solution = with_sources(records, free, merged(start, held))
        if solution.objective > held.objective + ROUGH:  # it lost it again
            kept = merged(start, held)
            _judge_at(records, held, kept["L"])
            solution = with_sources(records, free, kept, kept["L"])
    return with_delays(records, free, start, solution)


def with_delays(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    before: Solution,
) -> Solution:
    """With a delay that the data tell among the unknowns, unless they contradict what is said."""
    widened = delays.freed(records, before)
    if widened is before:
        return before
    found = again(records, free, start, widened, ROUGH)
    if delays.contradicted(records, found):
        for record in records:
            record.hold_delay()
        return before
    return found


def _judge_at(records: Sequence[MotorRecord], solution: Solution, inductance_h: float) -> None:
    """What drives the motor, and what is lost, if that were its inductance.

    Ripple and pulses follow it, and what brushes take of them: judged by none, it stays none.
    """
    values = np.array([
        inductance_h if unknown.name == "L" else value
        for unknown, value in zip(solution.unknowns, solution.values, strict=True)
    ])  # fmt: skip
    for record, own in zip(records, solution.own, strict=True):
        record.retake_sources(values, own)


def _vanished(solution: Solution, records: Sequence[MotorRecord]) -> bool:
    """The inductance has gone to where it is none; what the ripple does went with it."""
    values = merged({}, solution)
    period = min(record.timeline.period_s for record in records)
    return 0.0 < values.get("L", 0.0) < VANISHED * values.get("R", 0.0) * period


def _held(unknowns: list[Unknown], inductance_h: float) -> list[Unknown]:
    """The same, for a search that must not leave an inductance far behind; 0: it may."""
    if not inductance_h:
        return unknowns
    low, high = inductance_h / NEARBY, inductance_h * NEARBY
    return [replace(u, lower=low, upper=high) if u.name == "L" else u for u in unknowns]


def with_sources(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    near_h: float = 0.0,
) -> Solution:
    """The fit and what drives the motor in turn, until that stays; ``near_h`` as in ``_held``."""
    first = _held(unknowns_of(records, free, start), near_h)
    solution = maximise(first, records, enough=ROUGH)
    settled = True
    for n in range(1, LOSS_PASSES):
        if settled and n >= SOURCE_PASSES:
            break
        before = [record.sources for record in records]
        for record, own in zip(records, solution.own, strict=True):
            record.retake_sources(solution.values, own)
        after = [record.sources for record in records]
        settled = all(record.settled for record in records)
        if settled and all(_same(a, b) for old, new in zip(before, after, strict=True)
               for a, b in zip(old, new, strict=True)):  # fmt: skip
            break
        solution = again(records, free, start, solution, ROUGH, near_h)
    return solution


def again(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    before: Solution,
    enough: float = ENOUGH,
    near_h: float = 0.0,
) -> Solution:
    """The search goes on from a solution, with what has changed in the records."""
    known = _held(unknowns_of(records, free, merged(start, before)), near_h)
    return maximise(known, records, enough=enough, before=before)


def whitened(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    solution: Solution,
    enough: float = ENOUGH,
) -> Solution:
    """The fit again with the memory of every kind of residual in its weights, where it has one.

    Derivatives that ``solution`` has are those of white readings.
    """
    white = solution.derivatives
    for _ in range(COLOUR_PASSES):
        coloured = colour.whiten(records, solution)
        colour.thin(records, solution)
        lent = replace(solution, derivatives=_filtered(records, white))
        solution = again(records, free, start, lent, enough)
        if not coloured:
            break
    return solution


def _filtered(records: Sequence[MotorRecord], white: Derivatives | None) -> Derivatives | None:
    """Derivatives of white readings as the records weigh those now."""
    if white is None:
        return None
    shared = (r.filtered_rows(table) for r, table in zip(records, white.shared, strict=True))
    own = (r.filtered_rows(table) for r, table in zip(records, white.own_slopes, strict=True))
    return replace(white, shared=tuple(shared), own_slopes=tuple(own))


def _same(a: Source | None, b: Source | None) -> bool:
    return a is b if a is None or b is None else a.near(b)


def leaves_misfit(solution: Solution, records: Sequence[MotorRecord]) -> bool:
    """Residuals are neither noise nor small: the search ended in the wrong valley, or the model is
    the wrong one.

    A little that the model lacks, such as warming between runs, is no such thing.
    """
    return any(
        misfits(left, GROSS * float(np.ptp(m.values)))
        for record, own in zip(records, solution.own, strict=True)
        for m, left in zip(record.measured, record.departures(solution.values, own), strict=True)
    )
