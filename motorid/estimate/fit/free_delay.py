"""Whether the data tell the delay of the current's channel better than its declaration does.

Where a reading lies in the PWM period decides how much of the ripple it shows, so that an instant
amid ripple tells its delay far better than any data sheet. It then becomes an unknown of the fit,
with what is declared as its prior. A mean over whole periods shows its delay only by how a step
begins, where the voltage is least sure: that delay stays as declared, a cause in the budget.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.discontinuous_current import shows_ripple
from motorid.estimate.solver.dense_products import project, square
from motorid.estimate.solver.problem import Derivatives, Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.estimate.uncertainty.instrument_budget import later

Floats = NDArray[np.float64]

WORTH = 0.1  # of the variance of some parameter, that goes with the delay as an unknown
ROOM = 3.0  # standard uncertainties from no delay at all: no reading comes early
END = 0.999  # of the way to an unknown's bound


def freed(records: Sequence[MotorRecord], solution: Solution) -> Solution:
    """The solution with every record's delay among its unknowns, so far as declared.

    The same solution where that would not pay.
    """
    if not all(_may_tell(record) for record in records):
        return solution
    each = zip(records, solution.own, strict=True)
    later_by_one = [
        np.concatenate(record.weighed(later(record, solution.values, own, CURRENT)))
        for record, own in each
    ]
    if not _pays(later_by_one, solution):
        return solution
    slopes = []
    for record, change in zip(records, later_by_one, strict=True):
        record.free_delay()
        slopes.append(change / record.unknowns[-1].prior_sd)
    own = tuple(np.append(values, 0.0) for values in solution.own)
    return replace(solution, own=own, derivatives=_lent(solution.derivatives, slopes))


def contradicted(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """The data want a delay farther off than its declaration allows: something else is wrong."""
    found = [
        (record.unknowns[-1], float(own[-1]))
        for record, own in zip(records, solution.own, strict=True)
        if record.delay_is_free
    ]
    return any(not END * u.lower < late < END * u.upper for u, late in found)


def _may_tell(record: MotorRecord) -> bool:
    """Its current's delay is uncertain, may be off either way, and places it in the ripple."""
    channel = next((m.channel for m in record.measured if m.block.name == CURRENT), None)
    if channel is None or record.delay_is_free:
        return False
    roomy = 0.0 < ROOM * channel.delay_uncertainty_s <= channel.delay_s
    pwm_hz = record.capture.wiring.pwm_hz
    return roomy and shows_ripple(channel, record.timeline.period_s, pwm_hz)


def _pays(changes: Sequence[Floats], solution: Solution) -> bool:
    """An unknown of every record would lessen the variance of some parameter.

    ``changes`` (n,) of each record's readings by one standard uncertainty of its delay.
    """
    inverse = covariance_of(solution.information)
    pull, known = np.zeros(len(inverse)), 0.0
    for line, change in zip(solution.records, changes, strict=True):
        column = change / np.repeat(line.sigmas, [s.stop - s.start for s in line.slices])
        pull += project(line.orthogonal.T, column)
        known += _left(line, column)
    shift = inverse @ pull
    known = max(known - float(pull @ shift), 0.0) / len(changes)
    saved = shift**2 * known / (1.0 + known)
    return bool((saved > WORTH * (np.diag(inverse) + shift**2)).any())


def _left(line: Linearised, column: Floats) -> float:
    """Square of a column (n,) less what the record's own unknowns explain of it."""
    score = project(line.own.T, column)
    follows = np.linalg.lstsq(line.own_information, score, rcond=1e-14)[0]
    return square(column) - float(score @ follows)


def _lent(known: Derivatives | None, slopes: Sequence[Floats]) -> Derivatives | None:
    """The derivatives that a search knows, with those of one more unknown of each record."""
    if known is None:
        return None
    own = tuple(np.append(x, 0.0) for x in known.own)
    more = zip(known.own_slopes, slopes, strict=True)
    return replace(known, own=own, own_slopes=tuple(np.vstack([C, slope]) for C, slope in more))
