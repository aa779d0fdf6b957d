"""Whether the data tell a propagated quantity better than its declaration does.

Such a one becomes an unknown of the fit, with what is declared as its prior, where that lessens the
variance of some parameter by a tenth. It stays propagated where the fit would take it farther off
than its declaration allows: something else is wrong then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.solver.dense_products import project, square
from motorid.estimate.solver.problem import Derivatives, Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

WORTH = 0.1  # of the variance of some parameter, that goes with the quantity as an unknown
ROUNDED = 1e-9  # of a column's square: less of it, once cleared, is a difference's rounding
END = 0.999  # of the way to an unknown's bound


def promoted(records: Sequence[MotorRecord], solution: Solution) -> tuple[Solution, list[Instance]]:
    """The solution with the first quantity that pays as an unknown of every record, at nothing.

    And which that is; the same solution where none would pay.
    """
    found: list[Instance] = []
    for one in _candidates(records):
        columns = [
            np.concatenate(record.weighed(tangent(record, solution.values, own, one)))
            for record, own in zip(records, solution.own, strict=True)
        ]
        if _pays(columns, [_deviation(record, one) for record in records], solution):
            found.append(one)
            known = _lent(solution.derivatives, columns)
            own = tuple(np.append(values, 0.0) for values in solution.own)
            solution = replace(solution, own=own, derivatives=known)
            for record in records:
                record.estimate(one)
            break  # what another would tell depends on this one
    return solution, found


def contradicted(
    records: Sequence[MotorRecord], solution: Solution, found: Sequence[Instance]
) -> bool:
    """The data want a quantity farther off than its declaration allows."""
    return any(
        not END * unknown.lower < float(size) < END * unknown.upper
        for record, own in zip(records, solution.own, strict=True)
        for one, unknown, size in zip(record.instances, record.unknowns, own, strict=True)
        if one in found
    )


def _candidates(records: Sequence[MotorRecord]) -> list[Instance]:
    """Propagated in every record, and told by the readings of each, as far as one can foresee."""
    first, *others = ([one for one, _ in record.propagated] for record in records)
    return [
        one
        for one in first
        if all(one in other for other in others)
        and all(one.quantity.told(record) for record in records)
    ]


def _deviation(record: MotorRecord, one: Instance) -> float:
    return next(unknown.prior_sd for known, unknown in record.propagated if known == one)


def _pays(columns: Sequence[Floats], deviations: Sequence[float], solution: Solution) -> bool:
    """An unknown of every record would lessen the variance of some parameter.

    ``columns`` (n,) of each record's readings by a unit, ``deviations`` of its declaration.
    """
    inverse = covariance_of(solution.information)
    pull, known, length = np.zeros(len(inverse)), 0.0, 0.0
    each = zip(solution.records, columns, deviations, strict=True)
    for line, slope, deviation in each:
        column = deviation * slope / np.repeat(line.sigmas, [s.stop - s.start for s in line.slices])
        pull += project(line.orthogonal.T, column)
        known += _left(line, column)
        length += square(column)
    shift = inverse @ pull
    left = known - float(pull @ shift)
    if left <= ROUNDED * length:
        return False
    known = left / len(columns)
    saved = shift**2 * known / (1.0 + known)
    return bool((saved > WORTH * (np.diag(inverse) + shift**2)).any())


def _left(line: Linearised, column: Floats) -> float:
    """Square of a column (n,) less what the record's own unknowns explain of it."""
    score = project(line.own.T, column)
    follows = np.linalg.lstsq(line.own_information, score, rcond=1e-14)[0]
    return square(column) - float(score @ follows)


def _lent(known: Derivatives | None, columns: Sequence[Floats]) -> Derivatives | None:
    """The derivatives that a search knows, with those of one more unknown of each record."""
    if known is None:
        return None
    own = tuple(np.append(x, 0.0) for x in known.own)
    more = zip(known.own_slopes, columns, strict=True)
    return replace(known, own=own, own_slopes=tuple(np.vstack([C, column]) for C, column in more))
