"""Output-error maximum likelihood for any model: the engine below every fit.

A ``Record`` (one capture, as a model sees it) turns shared parameters and its own nuisances into
residuals, one block per channel. The engine finds the parameters that make them most likely when
each block is Gaussian with an unknown standard deviation, never below the block's floor
(quantisation, declared noise). Levenberg-Marquardt on the concentrated likelihood

    F = sum over blocks of  n log s² + |r|² / s²,   s² = max(|r|² / n, floor²),

plus Gaussian priors. Nuisances are eliminated per record (Schur complement), so that the work
grows with the number of captures and not with its square. See docs/method.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.concentrated_likelihood import Concentrated, Point
from motorid.estimate.solver.problem import (
    Block,
    Derivatives,
    Linearised,
    Record,
    Solution,
    Unknown,
    bounded_inverse,
)
from motorid.estimate.solver.schur_complement import by_rows, by_sums

Floats = NDArray[np.float64]

ENOUGH = 1e-3  # predicted decrease of F (in chi-square units) at which the search ends
DAMPING, LEAST_DAMPING = 1e-3, 1e-12  # at the start, and ever
MOST_DAMPING = 1e12  # beyond which no step helps
CREEPING = 10.0  # times the decrease that is enough: what undamped steps would still promise
MAX_ITERATIONS = 100
STALLED = 6  # derivatives in a row, of which each brings less than SLOW on average: a bent valley
SLOW = 0.01  # of chi-square; or ten times the decrease that is enough, or that itself if more
NEAR = 0.01  # distance, in search coordinates, over which derivatives are taken to stay the same
EXACT = 1e-5  # the same of a search whose end must not depend on the way to it
DEAR = 3  # times the responses that all iterations take: more only where each is worth many
RUGGED = 4  # places whose own derivatives did not keep their word: no end is finer than ENOUGH
KEPT_WORD = 0.25  # of what a step promised: what it may miss before derivatives are taken anew


def maximise(
    shared: Sequence[Unknown],
    records: Sequence[Record],
    max_iterations: int = MAX_ITERATIONS,
    enough: float = ENOUGH,
    before: Solution | None = None,
) -> Solution:
    """The most likely parameters of ``records``. Finds no start point of its own.

    The search ends when F would fall by less than ``enough`` (a change of chi-square).
    ``converged`` is false when the iterations ran out or no step helped while much was promised, or
    responses took much longer than those of all iterations do: an absurd motor's are worth many.
    So it is where an allowance is used up: the search ends at the best so far.
    ``before``, a solution for the same unknowns and nearly the same readings, lends its nuisances
    and its derivatives, and its evaluations are counted with this search's.
    """
    search = Concentrated(shared, records, before)
    bent = any(u.log != _straightened(u, u.start).log for u in shared)
    at, converged, creeping = _descend(
        search, search.start, max_iterations, enough, patient=not bent
    )
    values = search.frame.outward(at.shared)
    if bent and (creeping or not converged) and not search.used_up:
        straight = [_straightened(u, float(v)) for u, v in zip(shared, values, strict=True)]
        other = Concentrated(straight, records)
        other.known = _lent(search, other)
        first = other.point(other.frame.start, at.own)
        ahead, ended, _ = _descend(other, first, max_iterations, enough, LEAST_DAMPING)
        search.evaluations += other.evaluations
        if ahead.objective < at.objective:
            values = other.frame.outward(ahead.shared)
            search.known = _lent(other, search)
            back = search.point(search.frame.inward(values), ahead.own)
            at, converged, _ = _descend(search, back, max_iterations, enough)
        elif ended:
            converged = True  # other coordinates lead no further
    return _solution(search, at, converged)


def _lent(one: Concentrated, other: Concentrated) -> Derivatives | None:
    """The derivatives that one search knows, in the shared coordinates of another.

    None where they were taken at a bound of 0, which has no logarithm.
    """
    if one.known is None:
        return None
    values = one.frame.outward(one.known.at)
    if (values[other.frame.log] <= 0.0).any():
        return None
    at = other.frame.inward(values)
    factors = (other.frame.slopes(at) / one.frame.slopes(one.known.at))[:, None]
    return replace(one.known, at=at, shared=tuple(A * factors for A in one.known.shared))


def _straightened(unknown: Unknown, value: float) -> Unknown:
    """Searched by its logarithm where it can be: valleys along ratios are straight there."""
    bent = unknown.lower == 0.0 and value > 0.0 and not np.isfinite(unknown.prior_sd)
    return replace(unknown, start=value, log=unknown.log or bent)


def _descend(
    search: Concentrated,
    at: Point,
    max_iterations: int,
    enough: float,
    damping: float = DAMPING,
    patient: bool = True,
) -> tuple[Point, bool, bool]:
    """The point, whether steps ended there, and whether damping alone ended them.

    One that is not patient gives up where a step fails by the derivatives of its own place: a bent
    valley, which other coordinates may make straight.

    Derivatives serve until they no longer keep their word, or the answer has left them behind.
    """
    converged = stopped = False
    # a rough answer serves with rough derivatives, the end of a flat valley with its own
    near = np.inf if enough > ENOUGH else NEAR if enough > EXACT else 0.0
    known = search.known
    if known is None or search.apart(at, known) > near:
        known = search.derivatives(at)
    normals = search.normals(at, known)
    most = search.worked + DEAR * max_iterations * search.width
    least = STALLED * min(10.0 * enough, max(enough, SLOW))
    ends = [at.objective]  # where derivatives were taken
    failed = 0
    for _ in range(max_iterations):
        if known.at is at.shared and at.objective < ends[-1]:
            ends.append(at.objective)
        stalls = len(ends) > STALLED and ends[-1 - STALLED] - ends[-1] < least
        if stalls or search.worked > most or search.used_up:
            break
        trial, promise = search.step(at, normals, damping)
        gain = at.objective - trial.objective
        fresh, fallen = known.at is at.shared, at.fallen_to(trial)
        if gain >= 0:
            at = trial
            damping = damping if stopped else max(damping / 10.0, LEAST_DAMPING)
            stopped = False
            if promise < enough and gain < enough:
                if fresh or search.apart(at, known) <= near:
                    converged = True
                    break
                known = search.derivatives(at)
            elif abs(fallen - promise) > KEPT_WORD * promise:
                known = search.derivatives(at)
            normals = search.normals(at, known)
        elif 0 <= promise < enough and damping < 1.0 and (fresh or search.apart(at, known) <= near):
            converged = True  # at the minimum as far as rounding can tell
            break
        elif not fresh:
            known = search.derivatives(at)
            normals = search.normals(at, known)
        else:
            if not patient:
                break
            damping *= 8.0
            failed += not stopped
            enough = max(enough, ENOUGH) if failed >= RUGGED else enough
            stopped = True  # the first step that gets through does not lift what let it
            if damping > MOST_DAMPING:
                break
    search.known = known
    *_, undamped = search.move(at, search.normals(at, known), 0.0)
    creeping = undamped > CREEPING * enough
    return at, converged or (damping > MOST_DAMPING and not creeping), creeping


def _solution(search: Concentrated, at: Point, converged: bool) -> Solution:
    known = search.known or search.derivatives(at)
    normals = search.normals(at, known)
    frame = search.frame
    information = np.diag(frame.precision.astype(np.float64))
    eliminated, stuck = [], []
    blocks = [tuple(record.blocks) for record in search.records]  # as they are now
    for k, normal in enumerate(normals):
        held = search.own[k].blocked(at.own[k], normal.go)
        found = by_sums(normal, held)
        if found.doubtful(normal):
            found = by_rows(*search.weighed_slopes(at, known, k), search.own[k].precision, held)
        information = information + found.left
        eliminated.append(found)
        stuck.append(tuple(np.flatnonzero(held).tolist()))
    at_bound = (at.shared <= frame.lower) | (at.shared >= frame.upper)
    covariance = bounded_inverse(information, at_bound)
    ahead, _, promised = search.move(at, normals, 0.0) if not converged else (None, [], 0.0)
    own_covariance = [e.inverse + e.follows @ covariance @ e.follows.T for e in eliminated]
    return Solution(
        unknowns=frame.unknowns,
        values=frame.outward(at.shared),
        own=tuple(f.outward(x) for f, x in zip(search.own, at.own, strict=True)),
        own_covariance=tuple(own_covariance),
        information=information,
        at_bound=at_bound,
        linearise=partial(
            _linearised, search, at, known, [e.follows for e in eliminated], stuck, blocks
        ),
        objective=at.objective,
        evaluations=search.evaluations,
        converged=converged,
        derivatives=known,
        promised=promised,
        left=None if ahead is None else ahead - at.shared,
    )


def _linearised(
    search: Concentrated,
    at: Point,
    known: Derivatives,
    follows: Sequence[Floats],
    held: Sequence[tuple[int, ...]],
    blocks: Sequence[tuple[Block, ...]],
) -> tuple[Linearised, ...]:
    """Every record at a point; ``follows`` (m, p): by how much its nuisances do, but those held."""
    out = []
    for k in range(len(blocks)):
        edges = np.cumsum([0, *(len(r) for r in at.residuals[k])])
        shared, own = search.weighed_slopes(at, known, k)
        out.append(
            Linearised(
                residual=search.weighed_residual(at, k),
                shared=shared.T,
                own=own.T,
                orthogonal=(shared - np.einsum("mp,mn->pn", follows[k], own)).T,
                own_precision=search.own[k].precision,
                blocks=blocks[k],
                slices=tuple(slice(int(a), int(b)) for a, b in pairwise(edges)),
                sigmas=at.sigmas[k],
                held=held[k],
            )
        )
    return tuple(out)
