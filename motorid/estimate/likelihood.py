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
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.algebra import gram, project, square
from motorid.estimate.solution import (
    Block,
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

STEP = 1e-6  # of a finite difference, relative to the parameter's scale
ENOUGH = 1e-3  # predicted decrease of F (in chi-square units) at which the search ends
DAMPING, LEAST_DAMPING = 1e-3, 1e-12  # at the start, and ever
CREEPING = 10.0  # times the decrease that is enough: what undamped steps would still promise
MAX_ITERATIONS = 100
LOG_REACH = 14.0  # a logarithmic parameter stays within e^±14 of its start


class _Coordinates:
    """Unknowns as a vector that the search moves in."""

    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        self.unknowns = tuple(unknowns)
        self.log = np.array([u.log for u in unknowns], dtype=bool)
        start = np.array([u.start for u in unknowns], dtype=np.float64)
        lower = np.array([u.lower for u in unknowns], dtype=np.float64)
        upper = np.array([u.upper for u in unknowns], dtype=np.float64)
        self.start = self.inward(start)
        with np.errstate(divide="ignore", invalid="ignore"):
            low, high = np.log(np.maximum(lower, 0.0)), np.log(upper)
        reach = np.where(self.log, LOG_REACH, np.inf)
        self.lower = np.where(self.log, np.maximum(low, self.start - reach), lower)
        self.upper = np.where(self.log, np.minimum(high, self.start + reach), upper)
        self.start = np.clip(self.start, self.lower, self.upper)
        self.step = np.array([STEP if u.log else STEP * u.scale for u in unknowns])
        self.mean = np.array([u.prior_mean for u in unknowns], dtype=np.float64)
        self.precision = np.array([u.prior_sd for u in unknowns], dtype=np.float64) ** -2.0

    def inward(self, values: Floats) -> Floats:
        x = values.astype(np.float64, copy=True)
        x[self.log] = np.log(x[self.log])
        return x

    def outward(self, x: Floats) -> Floats:
        values = x.copy()
        values[self.log] = np.exp(x[self.log])
        return values

    def prior(self, x: Floats) -> float:
        return float(self.precision @ (x - self.mean) ** 2)

    def bounded_step(self, x: Floats, H: Floats, g: Floats) -> Floats:
        """Minimiser of d H d / 2 - g d within the bounds: what would leave them stops there."""
        held, step = self.blocked(x, g), np.zeros(len(x))
        for _ in range(len(x)):
            pull = g - H @ np.where(held, step, 0.0)
            step = np.where(held, step, bounded_inverse(H, held) @ pull)
            over = ~held & ((x + step < self.lower) | (x + step > self.upper))
            if not over.any():
                break
            step = np.where(over, np.clip(x + step, self.lower, self.upper) - x, step)
            held |= over
        return step

    def blocked(self, x: Floats, descent: Floats) -> NDArray[np.bool_]:
        """At a bound, and pulled further out."""
        return ((x <= self.lower) & (descent < 0)) | ((x >= self.upper) & (descent > 0))


@dataclass
class _Point:
    """Parameters, their residuals and the objective there."""

    shared: Floats
    own: list[Floats]
    residuals: list[list[Floats]]
    sigmas: list[Floats]
    objective: float


@dataclass
class _Normal:
    """Normal equations of one record, its nuisances apart."""

    shared: Floats
    own: Floats
    ss: Floats
    so: Floats
    oo: Floats
    gs: Floats
    go: Floats
    residual: Floats


class _Search:
    def __init__(self, shared: Sequence[Unknown], records: Sequence[Record]) -> None:
        self.records = records
        self.frame = _Coordinates(shared)
        self.own = [_Coordinates(record.unknowns) for record in records]
        self.evaluations = 0
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
        return _Point(shared, own, residuals, sigmas, objective)

    def column(self, k: int, base: _Point, weights: Floats, moved: list[Floats]) -> Floats:
        """Weighted change of the model of record k."""
        parts = [(a - b) * w for a, b, w in zip(base.residuals[k], moved, weights, strict=True)]
        return np.concatenate(parts) if parts else np.zeros(0)

    def linearise(self, at: _Point) -> list[_Normal]:
        values = self.frame.outward(at.shared)
        normals = []
        for k, record in enumerate(self.records):
            frame, own = self.own[k], self.own[k].outward(at.own[k])
            inverse = 1.0 / at.sigmas[k]
            residual = np.concatenate(
                [r * w for r, w in zip(at.residuals[k], inverse, strict=True)] or [np.zeros(0)]
            )
            n = len(residual)
            A = np.empty((len(self.frame.start), n))
            C = np.empty((len(frame.start), n))
            # nuisances first: a record may remember the response that they share with ``at``
            for j in range(len(C)):
                x, step = at.own[k].copy(), self._step(frame, at.own[k], j)
                x[j] += step
                C[j] = self.column(
                    k, at, inverse / step, record.residuals(values, frame.outward(x))
                )
            for j in range(len(A)):
                x, step = at.shared.copy(), self._step(self.frame, at.shared, j)
                x[j] += step
                moved = record.residuals(self.frame.outward(x), own)
                A[j] = self.column(k, at, inverse / step, moved)
            prior = frame.precision
            normals.append(
                _Normal(
                    A, C, gram(A, A), gram(A, C), gram(C, C) + np.diag(prior), project(A, residual),
                    project(C, residual) - prior * (at.own[k] - frame.mean), residual,
                )
            )  # fmt: skip
        if self.records:
            most = max(len(self.frame.start) + len(f.start) for f in self.own)
            self.evaluations += most
        return normals

    @staticmethod
    def _step(frame: _Coordinates, x: Floats, j: int) -> float:
        """Forward, or backward where forward leaves the bounds."""
        step = float(frame.step[j])
        return -step if x[j] + step > frame.upper[j] else step

    def step(self, at: _Point, normals: list[_Normal], damping: float) -> tuple[_Point, float]:
        """The damped step, and the decrease of F that the linear model promises."""
        shared, own, promise = self.move(at, normals, damping)
        return self.point(shared, own), promise

    def move(
        self, at: _Point, normals: list[_Normal], damping: float
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
) -> Solution:
    """The most likely parameters of ``records``. Finds no start point of its own.

    The search ends when F would fall by less than ``enough`` (a change of chi-square).
    ``converged`` is false when the iterations ran out or no step helped while one was promised.
    """
    search = _Search(shared, records)
    start = search.point(search.frame.start, [frame.start for frame in search.own])
    at, converged, creeping = _descend(search, start, max_iterations, enough)
    values = search.frame.outward(at.shared)
    straight = [_straightened(u, float(v)) for u, v in zip(shared, values, strict=True)]
    if (creeping or not converged) and straight != list(shared):
        other = _Search(straight, records)
        first = other.point(other.frame.start, at.own)
        ahead, _, _ = _descend(other, first, max_iterations, enough, LEAST_DAMPING)
        search.evaluations += other.evaluations
        if ahead.objective < at.objective:
            values = other.frame.outward(ahead.shared)
            back = search.point(search.frame.inward(values), ahead.own)
            at, converged, _ = _descend(search, back, max_iterations, enough)
    return _solution(search, at, converged)


def _straightened(unknown: Unknown, value: float) -> Unknown:
    """Searched by its logarithm where it can be: valleys along ratios are straight there."""
    if unknown.log or unknown.lower != 0.0 or not value > 0.0 or np.isfinite(unknown.prior_sd):
        return unknown
    return replace(unknown, start=value, log=True)


def _descend(
    search: _Search, at: _Point, max_iterations: int, enough: float, damping: float = DAMPING
) -> tuple[_Point, bool, bool]:
    """The point, whether steps ended there, and whether damping alone ended them."""
    converged = False
    normals = search.linearise(at)
    for _ in range(max_iterations):
        trial, promise = search.step(at, normals, damping)
        if trial.objective <= at.objective and np.isfinite(trial.objective):
            gain = at.objective - trial.objective
            at = trial
            damping = max(damping / 10.0, LEAST_DAMPING)
            if promise < enough and gain < enough:
                converged = True
                break
            normals = search.linearise(at)
        else:
            if 0 <= promise < enough and damping < 1.0:
                converged = True  # at the minimum as far as rounding can tell
                break
            damping *= 8.0
            if damping > 1e12:
                break
    *_, undamped = search.move(at, normals, 0.0)
    return at, converged, undamped > CREEPING * enough


def _solution(search: _Search, at: _Point, converged: bool) -> Solution:
    normals = search.linearise(at)
    frame = search.frame
    information = np.diag(frame.precision.astype(np.float64))
    linearised, own_covariance, followed = [], [], []
    gradient = -frame.precision * (at.shared - frame.mean)
    for k, (normal, record) in enumerate(zip(normals, search.records, strict=True)):
        held = search.own[k].blocked(at.own[k], normal.go)
        inverse = bounded_inverse(normal.oo, held)
        information = information + normal.ss - normal.so @ inverse @ normal.so.T
        gradient = gradient + normal.gs - normal.so @ (inverse @ normal.go)
        own_covariance.append(inverse)
        followed.append(inverse @ normal.so.T)
        explained = normal.so @ inverse
        edges = np.cumsum([0, *(len(r) for r in at.residuals[k])])
        linearised.append(
            Linearised(
                residual=normal.residual,
                shared=normal.shared.T,
                own=normal.own.T,
                orthogonal=(normal.shared - np.einsum("pm,mn->pn", explained, normal.own)).T,
                own_precision=search.own[k].precision,
                blocks=tuple(record.blocks),
                slices=tuple(slice(int(a), int(b)) for a, b in pairwise(edges)),
                sigmas=at.sigmas[k],
            )
        )
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
        records=tuple(linearised),
        objective=at.objective,
        evaluations=search.evaluations,
        converged=converged,
    )
