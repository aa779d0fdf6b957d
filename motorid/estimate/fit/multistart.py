"""The most likely parameters: several starts, delays as unknowns, correlated noise.

Whatever the model: records of six parameters settle as those of a wider model do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.estimate.fit.alternating_fit import (
    ROUGH,
    again,
    in_turn,
    judge_at,
    near_inductance,
    vanished,
    with_sources,
)
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.fit.promotion import contradicted, promoted
from motorid.estimate.fit.repeating import taken_again, with_repeating
from motorid.estimate.model import prewhitening
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.unexplained import shares, unsupported
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.dense_products import misfits
from motorid.estimate.solver.levenberg_marquardt import ENOUGH, MAX_ITERATIONS
from motorid.estimate.solver.problem import Derivatives, Solution
from motorid.estimate.uncertainty import added_noise

COLOUR_PASSES = 2  # of noise model and fit in turn
RISES = (0.3, 0.1)  # L/R in sample periods to begin with instead
RETAKEN = 3  # times at most that what repeats with the rotor is taken anew along the motion
GROSS = 0.02  # residuals in units of a channel's range: worth another start
MUCH = 0.05  # of a channel's mean square, left by a fit behind filters of its noise,
TIMES = 3.0  # and as many times what it leaves in white noise: the filters hide its readings
MOST_TRIED = 2000  # responses of a capture, after which no other start is tried
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
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    worth: float = np.inf,
) -> Solution:
    """The most likely parameters for white noise: other starts are tried where one misfits, but for
    one that leaves more of F than is ``worth`` it. With what of F is the voltage's noise.
    """
    return added_noise.judged(records, _settled(records, free, start, worth))


def _settled(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    worth: float,
) -> Solution:
    solution = with_sources(records, free, start)
    misfits = not solution.converged or leaves_misfit(solution, records)
    if misfits and solution.objective < worth:
        for k, factors in enumerate(OTHER_STARTS):
            if _evaluations(records) > MOST_TRIED:
                for record in records:
                    record.untried = len(OTHER_STARTS) - k
                break
            other = {n: start[n] * factors.get(n, 1.0) for n in PARAMETERS}
            trial = with_sources(records, free, other)
            if trial.objective < solution.objective - 1.0:
                solution = trial
        if _evaluations(records) <= MOST_TRIED or unsupported(records, solution) is None:
            solution = with_sources(records, free, merged(start, solution))
    if unsupported(records, solution) is not None:
        return solution  # nothing that is left to do explains so much
    if vanished(solution, records):
        solution = _begun_again(records, free, merged(start, solution), solution)
    return with_promoted(records, free, start, solution)


def _evaluations(records: Sequence[MotorRecord]) -> int:
    """Responses of a capture so far, at most."""
    return max(record.simulated for record in records)


def _begun_again(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    known: Mapping[str, float],
    lost: Solution,
) -> Solution:
    """From the likelier of some inductances, held while what drives the motor settles with them."""
    period = min(record.timeline.period_s for record in records)
    trials = [
        near_inductance(records, free, known, lost, rise * known["R"] * period) for rise in RISES
    ]
    likeliest = min(trials, key=lambda one: one.objective)
    best = merged(known, likeliest)
    judge_at(records, likeliest, best["L"])
    return with_sources(records, free, best)


def with_promoted(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    before: Solution,
) -> Solution:
    """With propagated quantities that the data tell among the unknowns, one after the other."""
    while True:
        widened, found = promoted(records, before)
        if not found:
            return before
        after = again(records, free, start, widened, ROUGH)
        if contradicted(records, after, found):
            for record in records:
                record.propagate(*found)
            return before
        before = in_turn(records, free, start, after)


def with_repeated(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    before: Solution,
) -> Solution:
    """With what repeats with the rotor's angle among the unknowns, where the readings show it.

    It hid from the sources what their readings say: their forms are decided anew.
    """
    widened = with_repeating(records, before)
    if widened is None:
        return before
    for record in records:
        record.decide(False)
    found = in_turn(records, free, start, again(records, free, start, widened, ROUGH))
    for _ in range(RETAKEN):
        moved = taken_again(records, found)
        if moved is None:
            break
        found = in_turn(records, free, start, again(records, free, start, moved, ROUGH))
    return found


def whitened(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    solution: Solution,
    enough: float = ENOUGH,
    most: int = MAX_ITERATIONS,
) -> Solution:
    """The fit again with the memory of every kind of residual in its weights, where it has one.

    Where that hides what the readings show: ``_thinned``. Derivatives that ``solution`` has are
    those of white readings.
    """
    white = solution.derivatives
    begun, plain = solution, shares(records, solution)
    for _ in range(COLOUR_PASSES):
        coloured = prewhitening.whiten(records, solution)
        weighed = prewhitening.thin(records, solution) or coloured
        lent = replace(solution, derivatives=_filtered(records, white))
        solution = again(records, free, start, lent, enough, most=most)
        if not weighed and solution.objective >= lent.objective:  # it began where it had ended
            solution = replace(
                solution, converged=lent.converged, promised=lent.promised, left=lent.left
            )
        if not coloured:
            break
    if _hides(plain, shares(records, solution)):
        return _thinned(records, free, start, begun, enough, most)
    return solution


def _hides(white: Mapping[str, float], coloured: Mapping[str, float]) -> bool:
    """Behind its filters a fit leaves much of a channel that it explains in white noise."""
    return any(share > MUCH and share > TIMES * white[name] for name, share in coloured.items())


def _thinned(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    white: Solution,
    enough: float,
    most: int,
) -> Solution:
    """A fit whose slow residuals cost their readings weight, with no filter of its noise.

    A filter passes what changes alone. Residuals of a model that lacks an effect, such as a slow
    sensor, make one that passes no level, and a fit behind it that contradicts the readings.
    """
    for record in records:
        record.whiten([None for _ in record.measured])
    prewhitening.thin(records, white)
    return again(records, free, start, replace(white, derivatives=None), enough, most=most)


def _filtered(records: Sequence[MotorRecord], white: Derivatives | None) -> Derivatives | None:
    """Derivatives of white readings as the records weigh those now."""
    if white is None:
        return None
    shared = (r.filtered_rows(table) for r, table in zip(records, white.shared, strict=True))
    own = (r.filtered_rows(table) for r, table in zip(records, white.own_slopes, strict=True))
    return replace(white, shared=tuple(shared), own_slopes=tuple(own))


def leaves_misfit(solution: Solution, records: Sequence[MotorRecord], small: float = GROSS) -> bool:
    """Residuals are neither noise nor ``small``, in shares of a channel's range: the search ended
    in the wrong valley, or the model is the wrong one.

    A little that the model lacks, such as warming between runs, is no such thing.
    """
    return any(
        misfits(left, small * float(np.ptp(m.values)))
        for record, own in zip(records, solution.own, strict=True)
        for m, left in zip(record.measured, record.departures(solution.values, own), strict=True)
    )
