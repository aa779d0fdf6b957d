"""The concentrated likelihood at a point: its value, its derivatives, its normal equations, a step.

Every noise level is eliminated, and so are the nuisances of each record; the formula of F is
likelihood.py's.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError
from motorid.estimate.solver import allowance
from motorid.estimate.solver.bounded_step import bounded_step
from motorid.estimate.solver.dense_products import project, square
from motorid.estimate.solver.normal_equations import Normal, Products, products
from motorid.estimate.solver.problem import Derivatives, Record, Solution, Unknown
from motorid.estimate.solver.search_coordinates import Coordinates

Floats = NDArray[np.float64]

BEYOND = (
    "no motor with finite parameters explains these captures: check the units, the scales and the "
    "time column"
)


@dataclass
class Point:
    """Parameters, their residuals and the objective there."""

    shared: Floats
    own: list[Floats]
    residuals: list[list[Floats]]
    totals: Floats  # sums of squares by kind of reading
    variances: Floats  # of each kind
    sigmas: list[Floats]
    prior: float  # chi-square of what was known before
    objective: float

    def fallen_to(self, other: Point) -> float:
        """Chi-square less than here, by the noise levels of here; what was known before counts."""
        fallen = float(((self.totals - other.totals) / self.variances).sum())
        return fallen + self.prior - other.prior


class Concentrated:
    """F of ``records`` as a function of search coordinates, and what a step from a point needs.

    ``before``, a solution for the same unknowns, lends its nuisances and its derivatives.
    """

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
        if self.start.objective == np.inf:
            raise DataError(BEYOND)
        self._summed: tuple[Derivatives, list[Products]] | None = None
        lent = before.derivatives if before else None
        self.known = self._renewed(lent) if lent is not None and self.fits(lent) else None

    @property
    def worked(self) -> int:
        """Responses of a record so far, at most, by what they were worth."""
        return max((record.simulated for record in self.records), default=0)

    @property
    def used_up(self) -> bool:
        """It may compute no more responses; one that computes none goes on."""
        return self.worked > 0 and allowance.used_up()

    @property
    def width(self) -> int:
        """Responses that derivatives and a point take."""
        return 1 + len(self.frame.start) + max((len(f.start) for f in self.own), default=0)

    def point(self, shared: Floats, own: list[Floats]) -> Point:
        """F and the residuals at these search coordinates; infinite F where they overflow."""
        with np.errstate(over="ignore", invalid="ignore"):
            return self._point(shared, own)

    def _point(self, shared: Floats, own: list[Floats]) -> Point:
        values = self.frame.outward(shared)
        residuals = []
        totals = np.zeros(len(self.counts))
        prior = self.frame.prior(shared)
        for record, frame, x, groups in zip(self.records, self.own, own, self.groups, strict=True):
            blocks = record.residuals(values, frame.outward(x))
            prior += frame.prior(x)
            for g, r in zip(groups, blocks, strict=True):
                totals[g] += square(r)
            residuals.append(blocks)
        s = np.sqrt(np.maximum(totals / np.maximum(self.counts, 1.0), self.floors**2))
        objective = prior + float((2.0 * self.counts * np.log(s) + totals / s**2).sum())
        sigmas = [s[groups] for groups in self.groups]
        self.evaluations += 1
        if not np.isfinite(objective):
            objective = np.inf
        return Point(shared, own, residuals, totals, s**2, sigmas, prior, objective)

    def derivatives(self, at: Point) -> Derivatives:
        """By finite differences, one response for each unknown of the widest record."""
        values = self.frame.outward(at.shared)
        shared, owned = [], []
        for k, record in enumerate(self.records):
            frame, own = self.own[k], self.own[k].outward(at.own[k])
            base = np.concatenate(at.residuals[k] or [np.zeros(0)])
            A = np.empty((len(self.frame.start), len(base)))
            C = np.empty((len(frame.start), len(base)))
            steps_own = [frame.difference(at.own[k], j) for j in range(len(C))]
            steps = [self.frame.difference(at.shared, j) for j in range(len(A))]
            # nuisances first: a record may remember the response that they share with ``at``
            points = [(values, frame.outward(x)) for x in _moved(at.own[k], steps_own)]
            points += [(self.frame.outward(x), own) for x in _moved(at.shared, steps)]
            record.foresee(points)
            for row, point, step in zip((*C, *A), points, (*steps_own, *steps), strict=True):
                row[:] = _slope(base, record.residuals(*point), step)
            shared.append(A)
            owned.append(C)
        if self.records:
            self.evaluations += max(len(self.frame.start) + len(f.start) for f in self.own)
        return Derivatives(at.shared, tuple(at.own), tuple(shared), tuple(owned))

    def _renewed(self, lent: Derivatives) -> Derivatives:
        """Taken anew where a nuisance moved nothing yet: a loss, before any current was known."""
        values, at, most, renewed = self.frame.outward(self.start.shared), self.start, 0, []
        for k, (record, frame) in enumerate(zip(self.records, self.own, strict=True)):
            slopes = lent.own_slopes[k]
            idle = np.flatnonzero(~slopes.any(axis=1))
            if len(idle):
                slopes = slopes.copy()
                base = np.concatenate(at.residuals[k])
            for j in idle:
                x, step = at.own[k].copy(), frame.difference(at.own[k], int(j))
                x[j] += step
                slopes[j] = _slope(base, record.residuals(values, frame.outward(x)), step)
            renewed.append(slopes)
            most = max(most, len(idle))
        self.evaluations += most
        return replace(lent, own_slopes=tuple(renewed))

    def apart(self, at: Point, known: Derivatives) -> float:
        """How far the point is from where the derivatives were taken, in search coordinates."""
        own = [f.apart(a, b) for f, a, b in zip(self.own, at.own, known.own, strict=True)]
        return max(self.frame.apart(at.shared, known.at), *own, 0.0)

    def fits(self, known: Derivatives) -> bool:
        """The derivatives are of residuals of these lengths."""
        lengths = [sum(len(r) for r in blocks) for blocks in self.start.residuals]
        return [A.shape[1] for A in known.shared] == lengths

    def normals(self, at: Point, known: Derivatives) -> list[Normal]:
        """Normal equations at a point with derivatives taken there, or near it."""
        with np.errstate(over="ignore", invalid="ignore"):
            out = self._normals(at, known)
        if not all(one.finite for one in out):
            raise DataError(BEYOND)
        return out

    def _normals(self, at: Point, known: Derivatives) -> list[Normal]:
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

    def weighed_residual(self, at: Point, k: int, power: int = 1) -> Floats:
        """The residuals of record k over a power of their sigmas, (n,)."""
        each = zip(at.residuals[k], at.sigmas[k], strict=True)
        return np.concatenate([r / s**power for r, s in each] or [np.zeros(0)])

    def weighed_slopes(self, at: Point, known: Derivatives, k: int) -> tuple[Floats, Floats]:
        """Derivatives (p, n) and (m, n) of record k at a point, over the sigmas there."""
        weights = np.repeat(1.0 / at.sigmas[k], [len(r) for r in at.residuals[k]])
        shared = known.shared[k] * self.frame.growth(known.at, at.shared) * weights
        own = known.own_slopes[k] * self.own[k].growth(known.own[k], at.own[k]) * weights
        return shared, own

    def _products(self, known: Derivatives) -> list[Products]:
        """They stay as long as the derivatives do, whatever becomes of the noise."""
        if self._summed is None or self._summed[0] is not known:
            lengths = [[len(r) for r in blocks] for blocks in self.start.residuals]
            each = zip(known.shared, known.own_slopes, lengths, strict=True)
            self._summed = known, [products(A, C, n) for A, C, n in each]
        return self._summed[1]

    def step(self, at: Point, normals: list[Normal], damping: float) -> tuple[Point, float]:
        """The damped step, and the decrease of F that the linear model promises."""
        shared, own, promise = self.move(at, normals, damping)
        return self.point(shared, own), promise

    def move(
        self, at: Point, normals: list[Normal], damping: float
    ) -> tuple[Floats, list[Floats], float]:
        """Where the damped step ends, and its promise."""
        frame = self.frame
        shared, own = bounded_step(frame, at.shared, self.own, at.own, normals, damping)
        ds, promise = shared - at.shared, 0.0
        for normal, before, after in zip(normals, at.own, own, strict=True):
            d = after - before
            promise += 2 * float(normal.gs @ ds + normal.go @ d)
            promise -= float(ds @ normal.ss @ ds + 2 * ds @ normal.so @ d + d @ normal.oo @ d)
        p, m = frame.precision, frame.mean
        promise -= float(p @ (2 * (at.shared - m) * ds + ds**2))
        return shared, own, promise


def _moved(at: Floats, steps: Sequence[float]) -> Iterator[Floats]:
    """A point with one coordinate after the other moved."""
    for j, step in enumerate(steps):
        x = at.copy()
        x[j] += step
        yield x


def _slope(base: Floats, moved: list[Floats], step: float) -> Floats:
    """Derivative of the model: residuals fall as it rises."""
    return np.asarray((base - np.concatenate(moved or [np.zeros(0)])) / step)
