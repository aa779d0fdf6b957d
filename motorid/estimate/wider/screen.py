"""Which terms the residuals of a fit ask for: a score test, which costs a response or two a term.

A term's columns are the derivatives of the readings in its size, at size nothing. Cleared of what
the parameters and nuisances explain (D), they gain about gᵀ (DᵀD)⁻¹ g of chi-square, g = Dᵀ r, and
the term would move the parameters by -H⁻¹ Xᵀ D (DᵀD)⁻¹ g. Nothing is fitted here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.algebra import gram, project
from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Linearised, Solution
from motorid.estimate.uncertainty import covariance_of
from motorid.estimate.wider.fit import scales_of
from motorid.estimate.wider.record import WideRecord
from motorid.estimate.wider.rotation import periods_a_turn, turned
from motorid.estimate.wider.terms import ADDED, TERMS, Term

Floats = NDArray[np.float64]

TRIED = 1e-4  # of a term's scale, by which a derivative is taken
LEAST = 1e-6  # of a column's square that parameters must leave for it to be told apart
QUARTER = np.pi / 2
BACKWARDS = 0.05  # of the largest speed, that is motion the other way
SCREENED = tuple(name for name in TERMS if name != "two-masses")  # that has no size nothing


@dataclass(frozen=True)
class Candidate:
    """A term that the residuals may ask for.

    ``gain`` of chi-square for white residuals; ``shift`` of every parameter, in search
    coordinates; ``start`` and ``own`` (a mapping a record) begin a fit with it.
    """

    term: Term
    gain: float
    shift: Mapping[str, float]
    start: Mapping[str, float]
    own: tuple[Mapping[str, float], ...] = field(default_factory=tuple)


def screen(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    taken: Sequence[Term] = (),
    terms: Sequence[str] = SCREENED,
) -> list[Candidate]:
    """The terms but those ``taken``, the most promising first; those against reason left out.

    ``values``: of all parameters at the solution, those held among them.
    """
    probe = _Probe(records, solution, values, taken)
    wanted = [TERMS[name] for name in terms if TERMS[name] not in taken and probe.tells(name)]
    found = []
    for term in wanted:
        tried = [c for shape in probe.shapes(term) if (c := probe.test(term, shape))]
        if tried:
            found.append(max(tried, key=lambda c: c.gain))
    return sorted(found, key=lambda c: -c.gain)


class _Probe:
    """The records under a model of every term, each of size nothing but those taken."""

    def __init__(
        self,
        records: Sequence[MotorRecord],
        solution: Solution,
        values: Mapping[str, float],
        taken: Sequence[Term],
    ) -> None:
        self.solution = solution
        self.names = tuple(u.name for u in solution.unknowns)
        self.inverse = covariance_of(solution.information)
        self.slope = np.sum(  # what the search left of it
            [project(line.orthogonal.T, line.residual) for line in solution.records], axis=0
        )
        self.scales = scales_of(records, values)
        self.free = (*self.names, *(n for n in ADDED if n not in self.names))
        absent = {name: added.absent for name, added in ADDED.items()}
        self.values = {**absent, **values}
        fixed = {n: v for n, v in values.items() if n not in self.free}
        self.records = []
        for k, record in enumerate(records):
            wide = WideRecord(
                record, self.free, fixed, tuple(TERMS.values()), self.scales, {}, k == 0
            )
            wide.follow(record)
            self.records.append(wide)
        self.own = [
            {**dict.fromkeys((u.name for u in wide.unknowns), 0.0),
             **dict(zip((u.name for u in record.unknowns), own.tolist(), strict=True))}
            for wide, record, own in zip(self.records, records, solution.own, strict=True)
        ]  # fmt: skip
        self.base = [self._fitted(k, {}, {}) for k in range(len(records))]

    # ---- columns --------------------------------------------------------------------------

    def _vectors(
        self, k: int, shared: Mapping[str, float], own: Mapping[str, float]
    ) -> tuple[Floats, Floats]:
        values, nuisances = {**self.values, **shared}, {**self.own[k], **own}
        names = (u.name for u in self.records[k].unknowns)
        return np.array([values[n] for n in self.free]), np.array([nuisances[n] for n in names])

    def _fitted(
        self, k: int, shared: Mapping[str, float], own: Mapping[str, float]
    ) -> list[Floats]:
        return self.records[k].fitted(*self._vectors(k, shared, own))

    def column(
        self, k: int, name: str, shape: Mapping[str, float], own: Mapping[str, float]
    ) -> Floats:
        """Weighted derivative of record k's readings in a size, counted in its scale."""
        scale = self.scales.of(name)
        size = scale / TRIED if ADDED[name].log else self.values[name] + TRIED * scale
        moved = self._fitted(k, {**shape, name: size}, own)
        parts = [(a - b) / TRIED for a, b in zip(moved, self.base[k], strict=True)]
        sigmas = self.solution.records[k].sigmas
        weighed = self.records[k].weighed(parts)
        return np.concatenate([y / s for y, s in zip(weighed, sigmas, strict=True)])

    def _columns(self, term: Term, shape: Mapping[str, float]) -> list[Floats]:
        """(q, n) of every record. A phase of its own makes two columns of a size, in one record."""
        sizes = [name for name in term.free if name == term.size or name == "k_R"]
        if not term.per_turn:
            return [np.array([self.column(k, term.size, shape, {})]) for k in range(len(self.own))]
        out = []
        for k in range(len(self.own)):
            mine = [
                self.column(k, name, shape, {term.phase: phase})
                for name in sizes
                for phase in (0.0, QUARTER)
            ]
            table = np.zeros((len(mine) * len(self.own), len(mine[0])))
            table[k * len(mine) : (k + 1) * len(mine)] = mine
            out.append(table)
        return out

    def tells(self, name: str) -> bool:
        """Whether such captures can tell the term at all."""
        if name == "ke-kt":  # torque, inertia and friction scale together unless one is held
            return not {"J", "B", "T0"} <= set(self.names)
        if name == "direction":
            return bool(min(self._turns) < 0 < max(self._turns))
        return True

    def shapes(self, term: Term) -> Iterator[dict[str, float]]:
        """What to try for the parameters that mean nothing while the size is 0."""
        if term.per_turn:
            for count in self._counts:
                yield {term.per_turn: float(count)}
            return
        names = list(term.shapes)
        for parts in product(*(term.shapes[name] for name in names)):
            yield {n: p * self.scales.of(n) for n, p in zip(names, parts, strict=True)}

    @cached_property
    def _angles(self) -> list[Floats]:
        """The rotor's angle in every record, (count,), rad."""
        return [r.angle(*self._vectors(k, {}, {})) for k, r in enumerate(self.records)]

    @property
    def _turns(self) -> list[float]:
        """The fastest steps either way, of each record."""
        steps = [np.diff(angle) for angle in self._angles]
        most = max(float(np.abs(step).max()) for step in steps)
        ends = [float(end) for step in steps for end in (step.min(), step.max())]
        return [end if abs(end) > BACKWARDS * most else 0.0 for end in ends]

    @cached_property
    def _counts(self) -> list[int]:
        """How often a turn the residuals repeat."""
        channels = []
        for k, (record, angle) in enumerate(zip(self.records, self._angles, strict=True)):
            left = [m.values - y for m, y in zip(record.measured, self.base[k], strict=True)]
            channels.append(turned(record, left, angle))
        return periods_a_turn(channels)

    # ---- the test ---------------------------------------------------------------------------

    def test(self, term: Term, shape: Mapping[str, float]) -> Candidate | None:
        """None where the parameters say the same, or the size would be below nothing."""
        sums = [
            _sums(table, line)
            for table, line in zip(self._columns(term, shape), self.solution.records, strict=True)
        ]
        squares, shared, pulls = (np.sum(parts, axis=0) for parts in zip(*sums, strict=True))
        information = squares - shared @ self.inverse @ shared.T
        if not float(np.trace(information)) > LEAST * float(np.trace(squares)):
            return None
        pulls = pulls - shared @ self.inverse @ self.slope
        sizes = covariance_of(information) @ pulls
        if not term.per_turn and sizes[0] <= 0.0 and ADDED[term.size].lower == 0.0:
            return None
        shift = -self.inverse @ shared.T @ sizes
        moves = dict(zip(self.names, shift.tolist(), strict=True))
        start, own = self._start(term, shape, sizes)
        return Candidate(term, float(pulls @ sizes), moves, start, own)

    def _start(
        self, term: Term, shape: Mapping[str, float], sizes: Floats
    ) -> tuple[dict[str, float], tuple[dict[str, float], ...]]:
        """Where a fit with the term begins."""
        unit, added = self.scales.of(term.size), ADDED[term.size]
        if not term.per_turn:
            size = unit / sizes[0] if added.log else unit * sizes[0]
            return {**shape, term.size: float(size)}, ()
        each = sizes.reshape(len(self.own), -1)
        amplitude = float(np.mean(np.hypot(each[:, 0], each[:, 1])))
        start = {**shape, term.size: unit * amplitude}
        if term.name == "ripple":
            together = np.einsum("kq,kq->k", each[:, :2], each[:, 2:])
            start["k_R"] = float(np.mean(together)) / amplitude
        phases = np.arctan2(each[:, 1], each[:, 0])
        return start, tuple({term.phase: float(phase)} for phase in phases)


def _sums(table: Floats, line: Linearised) -> tuple[Floats, Floats, Floats]:
    """Products of columns (q, n), cleared of the record's nuisances: with each other (q, q), with
    the shared parameters' (q, p), and with the residual (q,)."""
    squares, own = gram(table, table), line.own.T
    shared, pull = gram(table, line.orthogonal.T), project(table, line.residual)
    if len(own):
        explained = gram(table, own)
        inverse = covariance_of(gram(own, own) + np.diag(line.own_precision))
        squares = squares - explained @ inverse @ explained.T
        pull = pull - explained @ inverse @ project(own, line.residual)
    return squares, shared, pull
