"""What cogging that no log was found to show leaves open of the parameters.

Nobody states how often a turn cogging repeats, nor where the rotor begins: every order has two
sizes a record, of the cosine and of the sine, each with the friction at the highest voltage's speed
as its standard deviation before any data. D are the readings' changes by one of them, cleared of
what parameters and nuisances explain, r the residuals, and M = 1 + D'D. An order's weight is its
marginal likelihood, exp(r'D M^-1 D'r/2)/sqrt(det M) (MacKay, Information Theory, Inference, and
Learning Algorithms, 2003, ch. 28). Given an order, the sizes are M^-1 D'r with the covariance M^-1.
The parameters follow by straight lines: their second moment about the fit without cogging, over all
orders, is the line of the budget.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects import scales
from motorid.estimate.effects.rotor.cogging import friction
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.autoregression import inflation
from motorid.estimate.solver.dense_products import gram, project
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.cogging_columns import ORDERS, cogging_columns
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]
Vectors = Sequence[tuple[Floats, Floats]]  # shared and own unknowns of each record

BEST = 4  # orders that a search begins with
TERM = "cogging"  # of a wider model
LEAST = 1e-6  # of the largest eigenvalue of a second moment: less moves nothing


@dataclass(frozen=True)
class _Lines:
    """A record's columns of all orders (orders, 2, ...): products with one another (…, 2), with the
    shared parameters (…, p), with the residual (…)."""

    squares: Floats
    shared: Floats
    pull: Floats


def strongest(records: Sequence[MotorRecord], vectors: Vectors, solution: Solution) -> list[int]:
    """Orders of cogging that explain most of the residuals of logs, the best first; none of other
    captures. ``solution``: in white noise.
    """
    if not _are_logs(records):
        return []
    parts = _lines(records, vectors, solution, filtered=False)
    inverse = covariance_of(solution.information)
    gains = [_order(k, parts, inverse, 0.0)[1] for k in range(len(ORDERS))]
    return [ORDERS[k] for k in np.argsort(gains)[::-1][:BEST]]


def shifts(records: Sequence[MotorRecord], solution: Solution) -> list[Floats]:
    """Shifts (p,) of the parameters in search coordinates, whose squares make up the second moment;
    none of other captures than logs, nor where the model has cogging.
    """
    if not _are_logs(records) or any(TERM in record.modelled for record in records):
        return []
    vectors = [(solution.values, own) for own in solution.own]
    sizes = [friction(record) for record in records]
    parts = _lines(records, vectors, solution, filtered=True, sizes=sizes)
    inverse, colour = covariance_of(solution.information), inflation(solution)
    found = [_order(k, parts, inverse, 1.0, colour) for k in range(len(ORDERS))]
    evidence = np.array([0.5 * gain - 0.5 * logdet for _, gain, logdet in found])
    weights = np.exp(evidence - evidence.max())
    moment = sum(w * m for w, (m, *_) in zip(weights / weights.sum(), found, strict=True))
    variances, ways = np.linalg.eigh(np.asarray(moment))
    return [
        np.sqrt(v) * way
        for v, way in zip(variances, ways.T, strict=True)
        if v > LEAST * variances[-1]
    ]


def _are_logs(records: Sequence[MotorRecord]) -> bool:
    """Of which nobody states what drove the motor between their rows; with a motion."""
    return all(r.sensed.waveform is not None and scales.moving(r) is not None for r in records)


def _lines(
    records: Sequence[MotorRecord],
    vectors: Vectors,
    solution: Solution,
    filtered: bool,
    sizes: Sequence[float] | None = None,
) -> list[_Lines]:
    each = zip(records, vectors, sizes or [1.0] * len(records), solution.records, strict=True)
    return [
        _products(size * cogging_columns(record, shared, own, filtered=filtered), line)
        for record, (shared, own), size, line in each
    ]


def _products(columns: Floats, line: Linearised) -> _Lines:
    lengths = [part.stop - part.start for part in line.slices]
    table = columns / np.repeat(line.sigmas, lengths)
    flat = table.reshape(-1, table.shape[-1])
    free, information = line.cleared()
    follows = covariance_of(information) @ gram(free.T, flat) if free.shape[1] else None
    cleared = flat if follows is None else flat - (free @ follows).T
    shared = gram(flat, line.orthogonal.T).reshape(*table.shape[:2], -1)
    pull = project(cleared, line.residual).reshape(table.shape[:2])
    squares = np.einsum("oqn,orn->oqr", table, cleared.reshape(table.shape))
    return _Lines(squares, shared, pull)


def _order(
    k: int, parts: Sequence[_Lines], inverse: Floats, prior: float, colour: float = 1.0
) -> tuple[Floats, float, float]:
    """Second moment (p, p) of the parameters by an order's sizes, what those gain of chi-square,
    and the logarithm of the determinant of M. ``prior``: precision of each size.
    """
    q = 2 * len(parts)
    squares = np.zeros((q, q))
    for r, part in enumerate(parts):
        squares[2 * r : 2 * r + 2, 2 * r : 2 * r + 2] = part.squares[k]
    shared = np.concatenate([part.shared[k] for part in parts])
    pull = np.concatenate([part.pull[k] for part in parts]) / colour
    information = (squares - shared @ inverse @ shared.T) / colour + prior * np.eye(q)
    covariance = covariance_of(information)
    sizes = covariance @ pull
    moves = -inverse @ shared.T
    moment = moves @ (covariance + np.outer(sizes, sizes)) @ moves.T
    return moment, float(pull @ sizes), float(np.linalg.slogdet(information)[1])
