"""Noise of a log's voltage, whose readings drive the model: an error in the variables.

The model turns such noise into a current that the motor never had. Each draw of it moves the
answer by chance; and since an answer that passes less of it fits better, all draws together move it
one way: an inductance is taken for larger, and a lag for longer. Both are tried: noise as large as
that of the readings is added to them once more, and the answer's step is what it does (simulation
and extrapolation: Cook and Stefanski, 1994, its first step).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.dense_products import gram, project
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.added_noise import noisier
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

MOST_MORE = 3.0  # times a step under more noise, that the noise itself may have made it
MOST_GROWN = 2.0  # the same of a search's: it ends where a straight line does not
FAR = 5.0  # standard deviations, of a step that no straight line foretells
REFIT, NEAR = 20, 0.01  # steps of a search for it, which ends at so little of chi-square
OPEN = 30.0  # standard deviation of a logarithm, from which a value may be any


@dataclass(frozen=True)
class Step:
    """Of the answer, by one draw: ``shared`` (p,) in search coordinates, ``own`` (m,). ``change``
    (n,): of the model's readings, weighed, if the answer stayed.
    """

    shared: Floats
    own: Floats
    change: Floats


def steps(k: int, record: MotorRecord, solution: Solution) -> Iterator[Step]:
    """By every draw, each a standard deviation over the root of their number; none: no log, or its
    voltage has no noise.
    """
    others = list(noisier(record))
    if not others:
        return
    found = solution.records[k]
    usual = _in_units_of(found, _at(k, record.twin(), solution))
    lines = [_in_units_of(found, _at(k, other, solution)) for other in others]
    told = _told(solution)
    left, grown = _without_what_noise_tells(solution.information, usual, lines, told)
    inverse = _among(solution, told, left, 0.0)
    more = _among(solution, told, grown, 1.0)
    follows = covariance_of(usual.own_information)
    share = 1.0 / np.sqrt(len(others))
    for line, other in zip(lines, others, strict=True):
        pull = project(line.orthogonal.T, line.residual)
        shared = inverse @ (pull - project(usual.orthogonal.T, usual.residual))
        own = project(line.own.T, line.residual) - project(usual.own.T, usual.residual)
        own = follows @ (own - usual.own.T @ project(usual.shared, shared))
        if len(solution.records) == 1 and shared @ solution.information @ shared > FAR**2:
            moved, own_moved = _refitted(other, solution)
            if moved.any():  # else the search found no way on
                shared, own = more @ moved, own_moved
        yield Step(share * shared, share * own, share * (usual.residual - line.residual))


def foreseen(k: int, record: MotorRecord, solution: Solution) -> Iterator[Step]:
    """The same by straight lines, the derivatives as they are: near enough for a choice."""
    values, own = solution.values, solution.own[k]
    line, told = solution.records[k], _told(solution)
    inverse = _among(solution, told, covariance_of(solution.information[np.ix_(told, told)]), 0.0)
    follows = covariance_of(line.own_information)
    others, usual = list(noisier(record)), record.departures(values, own)
    for other in others:
        moved = zip(other.departures(values, own), usual, strict=True)
        left = record.weighed([now - was for now, was in moved])
        change = np.concatenate([d / s for d, s in zip(left, line.sigmas, strict=True)])
        change /= np.sqrt(len(others))
        shared = inverse @ project(line.orthogonal.T, change)
        yield Step(shared, follows @ project(line.own.T, change - line.shared @ shared), -change)


def _refitted(other: MotorRecord, solution: Solution) -> tuple[Floats, Floats]:
    """The step of the answer (p,) of a lone record, and of its nuisances (m,), by a search."""
    pairs = list(zip(solution.unknowns, solution.values.tolist(), strict=True))
    found = maximise([replace(u, start=v) for u, v in pairs], [other], REFIT, NEAR)
    moved = [
        math.log(now / v) if u.log else now - v
        for (u, v), now in zip(pairs, found.values.tolist(), strict=True)
    ]
    return np.array(moved), found.own[0] - solution.own[0]


def _told(solution: Solution) -> NDArray[np.intp]:
    """Unknowns that the readings tell: of others derivatives are rounding alone, and no noise moves
    what nothing holds.
    """
    sizes = np.sqrt(np.diag(covariance_of(solution.information)))
    factors = np.array([unknown.log for unknown in solution.unknowns])
    return np.flatnonzero(~factors | (sizes < OPEN))


def _among(solution: Solution, told: NDArray[np.intp], matrix: Floats, held: float) -> Floats:
    """A ``matrix`` of the unknowns that are told, among all; ``held``: the diagonal's others."""
    out = held * np.eye(len(solution.unknowns))
    out[np.ix_(told, told)] = matrix
    return out


def _without_what_noise_tells(
    information: Floats, usual: Linearised, lines: Sequence[Linearised], k: NDArray[np.intp]
) -> tuple[Floats, Floats]:
    """The inverse, of the unknowns ``k``, of the information that is left without that of the noise
    itself; and by how much a step under more noise is less than under none (q, q).

    Noise moves the model's readings as a voltage does, so that their derivatives seem to tell the
    parameters. More noise tells as much again. Where that is nearly all, steps are bounded.
    """
    moved = [(line.orthogonal - usual.orthogonal)[:, k] for line in lines]
    told = np.mean([gram(one.T, one.T) for one in moved], axis=0)
    root = _root(covariance_of(information[np.ix_(k, k)]))
    shares, ways = np.linalg.eigh(root.T @ told @ root)
    left = np.maximum(1.0 - shares, (1.0 + shares) / MOST_MORE)
    basis = root @ ways
    more = basis * np.minimum((1.0 + shares) / left, MOST_GROWN) @ np.linalg.pinv(basis)
    return np.asarray(basis / left @ basis.T), np.asarray(more)


def _in_units_of(found: Linearised, line: Linearised) -> Linearised:
    """A record's residuals and derivatives in the standard deviations of another.

    By its own, which the draw itself makes larger, it would seem to pull less than it does.
    """
    lengths = [part.stop - part.start for part in line.slices]
    rows = np.repeat(line.sigmas / found.sigmas, lengths)
    of = rows[:, None]
    return replace(
        line,
        residual=line.residual * rows,
        shared=line.shared * of,
        own=line.own * of,
        orthogonal=line.orthogonal * of,
    )


def _root(covariance: Floats) -> Floats:
    """(p, p), by whose product with its transpose a covariance is."""
    sizes, ways = np.linalg.eigh(covariance)
    return np.asarray(ways * np.sqrt(np.maximum(sizes, 0.0)))


def _at(k: int, record: MotorRecord, solution: Solution) -> Linearised:
    """A record that stands for the one of that number, at the solution from here on."""
    shared = [
        replace(unknown, start=float(value))
        for unknown, value in zip(solution.unknowns, solution.values, strict=True)
    ]
    record.unknowns = tuple(
        replace(unknown, start=float(size))
        for unknown, size in zip(record.unknowns, solution.own[k], strict=True)
    )
    return maximise(shared, [record], max_iterations=0).records[0]
