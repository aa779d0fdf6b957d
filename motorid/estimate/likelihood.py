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
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.algebra import project, square
from motorid.estimate.coordinates import Coordinates
from motorid.estimate.normal_equations import Normal, Products, products
from motorid.estimate.solution import (
    Block,
    Derivatives,
    Linearised,
    Record,
    Solution,
    Unknown,
    bounded_inverse,
)

Floats = NDArray[np.float64]

__all__ = [
    "Block",
    "Linearised",
    "Record",
    "Solution",
    "Unknown",
    "bounded_inverse",
    "maximise",
]

ENOUGH = 1e-3  # predicted decrease of F (in chi-square units) at which the search ends
DAMPING, LEAST_DAMPING = 1e-3, 1e-12  # at the start, and ever
CREEPING = 10.0  # times the decrease that is enough: what undamped steps would still promise
MAX_ITERATIONS = 100
NEAR = 0.01  # distance, in search coordinates, over which derivatives are taken to stay the same
KEPT_WORD = 0.25  # of what a step promised: what it may miss before derivatives are taken anew


@dataclass
class _Point:
    """Parameters, their residuals and the objective there."""

    shared: Floats
    own: list[Floats]
    residuals: list[list[Floats]]
    totals: Floats  # sums of squares by kind of reading
    variances: Floats  # of each kind
    sigmas: list[Floats]
    objective: float

    def fallen_to(self, other: _Point) -> float:
        """Chi-square less than here, by the noise levels of here."""
        return float(((self.totals - other.totals) / self.variances).sum())


class _Search:
    def __init__(
        self, shared: Sequence[Unknown], records: Sequence[Record], before: Solution | None = None
    ) -> None:
        self.records = records
        self.frame = Coordinates(shared)
        self.own = [Coordinates(record.unknowns) for record in records]
        self.evaluations = before.evaluations if before else 0
        keys: dict[str, int] = {}
        self.groups = [
            [keys.setdefault(b.group or f"{k}/{b.name}", len(keys)) for b in record.blocks]
            for k, record in enumerate(records)
        ]
        self.counts, self.floors = np.zeros(len(keys)), np.zeros(len(keys))
        for record, groups in zip(records, self.groups, strict=True):
            for block, g in zip(record.blocks, groups, strict=True):
                self.counts[g] += block.count
                self.floors[g] = max(self.floors[g], block.floor)
        own = [f.start for f in self.own]
        if before is not None:
            own = [f.clipped(x) for f, x in zip(self.own, before.own, strict=True)]
        self.start = self.point(self.frame.start, own)
        self._summed: tuple[Derivatives, list[Products]] | None = None
        lent = before.derivatives if before else None
        self.known = lent if lent is not None and self.fits(lent) else None

    def point(self, shared: Floats, own: list[Floats]) -> _Point:
        values = self.frame.outward(shared)
        residuals = []
        totals = np.zeros(len(self.counts))
        objective = self.frame.prior(shared)
        for record, frame, x, groups in zip(self.records, self.own, own, self.groups, strict=True):
            blocks = record.residuals(values, frame.outward(x))
            objective += frame.prior(x)
            for g, r in zip(groups, blocks, strict=True):
                totals[g] += square(r)
            residuals.append(blocks)
        s = np.sqrt(np.maximum(totals / np.maximum(self.counts, 1.0), self.floors**2))
        objective += float((2.0 * self.counts * np.log(s) + totals / s**2).sum())
        sigmas = [s[groups] for groups in self.groups]
        self.evaluations += 1
        if not np.isfinite(objective):
            objective = np.inf
        return _Point(shared, own, residuals, totals, s**2, sigmas, objective)

    def derivatives(self, at: _Point) -> Derivatives:
        """By finite differences, one response for each unknown of the widest record."""
        values = self.frame.outward(at.shared)
        shared, owned = [], []
        for k, record in enumerate(self.records):
            frame, own = self.own[k], self.own[k].outward(at.own[k])
            base = np.concatenate(at.residuals[k] or [np.zeros(0)])
            A = np.empty((len(self.frame.start), len(base)))
            C = np.empty((len(frame.start), len(base)))
            # nuisances first: a record may remember the response that they share with ``at``
            for j in range(len(C)):
                x, step = at.own[k].copy(), frame.difference(at.own[k], j)
                x[j] += step
                C[j] = _slope(base, record.residuals(values, frame.outward(x)), step)
            for j in range(len(A)):
                x, step = at.shared.copy(), self.frame.difference(at.shared, j)
                x[j] += step
                A[j] = _slope(base, record.residuals(self.frame.outward(x), own), step)
            shared.append(A)
            owned.append(C)
        if self.records:
            self.evaluations += max(len(self.frame.start) + len(f.start) for f in self.own)
        return Derivatives(at.shared, tuple(at.own), tuple(shared), tuple(owned))

    def apart(self, at: _Point, known: Derivatives) -> float:
        """How far the point is from where the derivatives were taken, in search coordinates."""
        own = [f.apart(a, b) for f, a, b in zip(self.own, at.own, known.own, strict=True)]
        return max(self.frame.apart(at.shared, known.at), *own, 0.0)

    def fits(self, known: Derivatives) -> bool:
        """The derivatives are of residuals of these lengths."""
        lengths = [sum(len(r) for r in blocks) for blocks in self.start.residuals]
        return [A.shape[1] for A in known.shared] == lengths

    def normals(self, at: _Point, known: Derivatives) -> list[Normal]:
        """Normal equations at a point with derivatives taken there, or near it."""
        out = []
        for k, (frame, sums) in enumerate(zip(self.own, self._products(known), strict=True)):
            residual, prior = self.weighed_residual(at, k, 2), frame.precision
            shared = self.frame.growth(known.at, at.shared)
            own = frame.growth(known.own[k], at.own[k])
            ss, so, oo = sums.weighed(at.sigmas[k] ** -2.0)
            out.append(
                Normal(
                    ss * shared * shared.T, so * shared * own.T, oo * own * own.T + np.diag(prior),
                    project(known.shared[k], residual) * shared[:, 0],
                    project(known.own_slopes[k], residual) * own[:, 0]
                    - prior * (at.own[k] - frame.mean),
                )
            )  # fmt: skip
        return out

    def weighed_residual(self, at: _Point, k: int, power: int = 1) -> Floats:
        """The residuals of record k over a power of their sigmas, (n,)."""
        each = zip(at.residuals[k], at.sigmas[k], strict=True)
        return np.concatenate([r / s**power for r, s in each] or [np.zeros(0)])

    def _products(self, known: Derivatives) -> list[Products]:
        """They stay as long as the derivatives do, whatever becomes of the noise."""
        if self._summed is None or self._summed[0] is not known:
            lengths = [[len(r) for r in blocks] for blocks in self.start.residuals]
            each = zip(known.shared, known.own_slopes, lengths, strict=True)
            self._summed = known, [products(A, C, n) for A, C, n in each]
        return self._summed[1]

    def step(self, at: _Point, normals: list[Normal], damping: float) -> tuple[_Point, float]:
        """The damped step, and the decrease of F that the linear model promises."""
        shared, own, promise = self.move(at, normals, damping)
        return self.point(shared, own), promise

    def move(
        self, at: _Point, normals: list[Normal], damping: float
    ) -> tuple[Floats, list[Floats], float]:
        """Where the damped step ends, and its promise."""
        frame = self.frame
        H = np.diag(frame.precision.astype(np.float64))
        g = -frame.precision * (at.shared - frame.mean)
        solved = []
        for normal, own_frame, own in zip(normals, self.own, at.own, strict=True):
            oo = normal.oo + damping * np.diag(np.diag(normal.oo))
            held = own_frame.blocked(own, normal.go)
            inverse = bounded_inverse(oo, held)
            H = H + normal.ss - normal.so @ inverse @ normal.so.T
            g = g + normal.gs - normal.so @ (inverse @ normal.go)
            solved.append(inverse)
        diagonal = sum((n.ss for n in normals), np.diag(frame.precision)).diagonal()
        ds = frame.bounded_step(at.shared, H + damping * np.diag(diagonal), g)
        shared = np.clip(at.shared + ds, frame.lower, frame.upper)
        moves: list[Floats] = []
        promise = 0.0
        for normal, inverse, x, limits in zip(normals, solved, at.own, self.own, strict=True):
            moved = np.clip(
                x + inverse @ (normal.go - normal.so.T @ ds), limits.lower, limits.upper
            )
            d = moved - x
            promise += 2 * float(normal.gs @ ds + normal.go @ d)
            promise -= float(ds @ normal.ss @ ds + 2 * ds @ normal.so @ d + d @ normal.oo @ d)
            moves.append(moved)
        p, m = frame.precision, frame.mean
        promise -= float(p @ (2 * (at.shared - m) * ds + ds**2))
        return shared, moves, promise


def maximise(
    shared: Sequence[Unknown],
    records: Sequence[Record],
    max_iterations: int = MAX_ITERATIONS,
    enough: float = ENOUGH,
    before: Solution | None = None,
) -> Solution:
    """The most likely parameters of ``records``. Finds no start point of its own.

    The search ends when F would fall by less than ``enough`` (a change of chi-square).
    ``converged`` is false when the iterations ran out or no step helped while one was promised.
    ``before``, a solution for the same unknowns and nearly the same readings, lends its nuisances
    and its derivatives, and its evaluations are counted with this search's.
    """
    search = _Search(shared, records, before)
    bent = any(u.log != _straightened(u, u.start).log for u in shared)
    at, converged, creeping = _descend(
        search, search.start, max_iterations, enough, patient=not bent
    )
    values = search.frame.outward(at.shared)
    if bent and (creeping or not converged):
        straight = [_straightened(u, float(v)) for u, v in zip(shared, values, strict=True)]
        other = _Search(straight, records)
        other.known = _lent(search, other)
        first = other.point(other.frame.start, at.own)
        ahead, _, _ = _descend(other, first, max_iterations, enough, LEAST_DAMPING)
        search.evaluations += other.evaluations
        if ahead.objective < at.objective:
            values = other.frame.outward(ahead.shared)
            search.known = _lent(other, search)
            back = search.point(search.frame.inward(values), ahead.own)
            at, converged, _ = _descend(search, back, max_iterations, enough)
    return _solution(search, at, converged)


def _lent(one: _Search, other: _Search) -> Derivatives | None:
    """The derivatives that one search knows, in the shared coordinates of another."""
    if one.known is None:
        return None
    at = other.frame.inward(one.frame.outward(one.known.at))
    factors = (other.frame.slopes(at) / one.frame.slopes(one.known.at))[:, None]
    return replace(one.known, at=at, shared=tuple(A * factors for A in one.known.shared))


def _straightened(unknown: Unknown, value: float) -> Unknown:
    """Searched by its logarithm where it can be: valleys along ratios are straight there."""
    bent = unknown.lower == 0.0 and value > 0.0 and not np.isfinite(unknown.prior_sd)
    return replace(unknown, start=value, log=unknown.log or bent)


def _descend(
    search: _Search,
    at: _Point,
    max_iterations: int,
    enough: float,
    damping: float = DAMPING,
    patient: bool = True,
) -> tuple[_Point, bool, bool]:
    """The point, whether steps ended there, and whether damping alone ended them.

    One that is not patient gives up where a step fails by the derivatives of its own place: a bent
    valley, which other coordinates may make straight.

    Derivatives serve until they no longer keep their word, or the answer has left them behind.
    """
    converged = stopped = False
    near = NEAR if enough <= ENOUGH else np.inf  # a rough answer serves with rough derivatives
    known = search.known
    if known is None or search.apart(at, known) > near:
        known = search.derivatives(at)
    normals = search.normals(at, known)
    for _ in range(max_iterations):
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
            stopped = True  # the first step that gets through does not lift what let it
            if damping > 1e12:
                break
    search.known = known
    *_, undamped = search.move(at, search.normals(at, known), 0.0)
    return at, converged, undamped > CREEPING * enough


def _slope(base: Floats, moved: list[Floats], step: float) -> Floats:
    """Derivative of the model: residuals fall as it rises."""
    return np.asarray((base - np.concatenate(moved or [np.zeros(0)])) / step)


def _solution(search: _Search, at: _Point, converged: bool) -> Solution:
    known = search.known or search.derivatives(at)
    normals = search.normals(at, known)
    frame = search.frame
    information = np.diag(frame.precision.astype(np.float64))
    own_covariance, followed, explained = [], [], []
    blocks = [tuple(record.blocks) for record in search.records]  # as they are now
    for k, normal in enumerate(normals):
        held = search.own[k].blocked(at.own[k], normal.go)
        inverse = bounded_inverse(normal.oo, held)
        information = information + normal.ss - normal.so @ inverse @ normal.so.T
        own_covariance.append(inverse)
        followed.append(inverse @ normal.so.T)
        explained.append(normal.so @ inverse)
    at_bound = (at.shared <= frame.lower) | (at.shared >= frame.upper)
    covariance = bounded_inverse(information, at_bound)
    own_covariance = [
        inverse + follows @ covariance @ follows.T
        for inverse, follows in zip(own_covariance, followed, strict=True)
    ]
    return Solution(
        unknowns=frame.unknowns,
        values=frame.outward(at.shared),
        own=tuple(f.outward(x) for f, x in zip(search.own, at.own, strict=True)),
        own_covariance=tuple(own_covariance),
        information=information,
        at_bound=at_bound,
        linearise=partial(_linearised, search, at, known, explained, blocks),
        objective=at.objective,
        evaluations=search.evaluations,
        converged=converged,
        derivatives=known,
    )


def _linearised(
    search: _Search,
    at: _Point,
    known: Derivatives,
    explained: Sequence[Floats],
    blocks: Sequence[tuple[Block, ...]],
) -> tuple[Linearised, ...]:
    """Every record at a point; ``explained`` (p, m): by how much its nuisances follow."""
    out = []
    for k in range(len(blocks)):
        edges = np.cumsum([0, *(len(r) for r in at.residuals[k])])
        weights = np.repeat(1.0 / at.sigmas[k], np.diff(edges))
        shared = known.shared[k] * search.frame.growth(known.at, at.shared) * weights
        own = known.own_slopes[k] * search.own[k].growth(known.own[k], at.own[k]) * weights
        out.append(
            Linearised(
                residual=search.weighed_residual(at, k),
                shared=shared.T,
                own=own.T,
                orthogonal=(shared - np.einsum("pm,mn->pn", explained[k], own)).T,
                own_precision=search.own[k].precision,
                blocks=blocks[k],
                slices=tuple(slice(int(a), int(b)) for a, b in pairwise(edges)),
                sigmas=at.sigmas[k],
            )
        )
    return tuple(out)
