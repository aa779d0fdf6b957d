"""Whether a better model is worth looking for: most captures of a good motor need none.

Brushes and a warming winding are unknowns of every capture already (loss.py). The terms that
describe them begin from a fit without those unknowns, which costs as much as the first one. It is
made only where they take something that stands out, or where the residuals ask for another term.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motorid.estimate.effects.brush_and_heating import BENT, BRIDGE, DROP, WARMING
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.selection.score_test import Candidate
from motorid.estimate.solver.dense_products import gram
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

ALLOWED = (TERMS["brush-drop"], TERMS["heating"])  # terms of which each capture has an unknown
LOST = (DROP, BENT, BRIDGE, WARMING)
STANDS_OUT = 15.0  # of chi-square: half of what a term must promise to be fitted
GIVES = 0.5  # of the least that a drop may be, below none
SURELY = 4.0  # of the mean's standard deviations
HINT = 0.5  # of what matters, that it must move some parameter by


def largest_move(candidate: Candidate, reach: Mapping[str, float]) -> float:
    """The largest move of a parameter that it promises, in units of what matters."""
    shift = candidate.shift
    return max((abs(shift.get(n, 0.0)) / limit for n, limit in reach.items()), default=0.0)


def matters(candidate: Candidate, reach: Mapping[str, float]) -> bool:
    """It promises to move what matters."""
    return largest_move(candidate, reach) > HINT


def carry_loss(records: Sequence[MotorRecord]) -> bool:
    """Some capture has unknowns of what brushes and winding take."""
    return any(_places(record) for record in records)


def loss_stands_out(
    records: Sequence[MotorRecord], solution: Solution, reach: Mapping[str, float]
) -> bool:
    """What brushes and winding take is no noise, and without it some parameter would be elsewhere.

    ``reach``: by how much a parameter may move (SI) before it matters.
    """
    if sum(_taken(record, solution, k) for k, record in enumerate(records)) < STANDS_OUT:
        return False
    moves = _moves(records, solution)
    return any(
        not abs(moves.get(name, 0.0)) <= HINT * limit
        for name, limit in reach.items()
        if name != "L"  # a few steps tell it, and they tell of losses next to nothing
    )


def drop_gives(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """Brushes seem to give voltage, on the mean over the captures: surely, and a good part of the
    little that a drop below none may be.
    """
    shares, noise = [], []
    each = zip(records, solution.own, solution.own_covariance, strict=True)
    for record, own, covariance in each:
        for j in _places(record, (DROP,)):
            least = record.unknowns[j].lower
            if least < 0.0:
                shares.append(float(own[j]) / least)
                noise.append(float(covariance[j, j]) / least**2)
    if not shares:
        return False
    scatter = float(np.var(shares, ddof=1)) if len(shares) > 1 else 0.0
    deviation = np.sqrt((np.mean(noise) + scatter) / len(shares))
    return bool(np.mean(shares) > max(GIVES, SURELY * deviation))


def _places(record: MotorRecord, names: Sequence[str] = LOST) -> list[int]:
    return [j for j, u in enumerate(record.unknowns) if u.name in names]


def _taken(record: MotorRecord, solution: Solution, k: int) -> float:
    """The square of the capture's loss in its standard deviations."""
    places = _places(record)
    values = solution.own[k][places]
    information = covariance_of(solution.own_covariance[k][np.ix_(places, places)])
    return float(values @ information @ values) if places else 0.0


def _moves(records: Sequence[MotorRecord], solution: Solution) -> dict[str, float]:
    """By how much (SI) each parameter would be elsewhere if nothing were lost, by straight lines.

    Those of the likelihood: what is lost goes, and all other unknowns follow.
    """
    information = np.zeros_like(solution.information)
    pull = np.zeros(len(information))
    for record, line, own in zip(records, solution.records, solution.own, strict=True):
        places = _places(record)
        others = [j for j in range(len(own)) if j not in places]
        shared, rest, lost = line.shared.T, line.own.T[others], line.own.T[places]
        inverse = covariance_of(gram(rest, rest) + np.diag(line.own_precision[others]))
        cleared = shared - np.einsum("pm,mn->pn", gram(shared, rest) @ inverse, rest)
        information += gram(cleared, shared)
        pull += gram(cleared, lost) @ own[places]
    shifts = covariance_of(information) @ pull * solution.slopes
    return dict(zip((u.name for u in solution.unknowns), shifts.tolist(), strict=True))
