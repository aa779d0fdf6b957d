"""Which terms the residuals of a fit ask for: a score test, which costs a response or two a term.

A term's columns are the derivatives of the readings in its size, at size nothing. Cleared of what
the parameters and nuisances explain (D), they gain about gᵀ (DᵀD)⁻¹ g of chi-square, g = Dᵀ r, and
the term would move the parameters by -H⁻¹ Xᵀ D (DᵀD)⁻¹ g. Nothing is fitted here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import ADDED, TERMS, Term
from motorid.estimate.selection.score_derivatives import Probe
from motorid.estimate.solver.dense_products import gram, project
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

LEAST = 1e-6  # of a column's square that parameters must leave for it to be told apart
ALIKE, MOST_ALIKE = 0.9, 2  # of the best count's gain, from which another may be the true one
SCREENED = tuple(name for name in TERMS if name != "two-masses")  # that has no size nothing


@dataclass(frozen=True)
class Candidate:
    """A term that the residuals may ask for.

    ``gain`` of chi-square for white residuals; ``shift`` of every parameter, SI; ``start`` and
    ``own`` (a mapping a record) begin a fit with it. ``changes``: what it does to every record's
    readings, (q, n), weighed; empty where that is no straight line. ``companion``: a term that is
    fitted with it, whose changes follow its own. ``counts``: what of the gain is foreseen to count
    in the noise that a fit with it leaves, or all of it where no straight lines say so. ``alike``:
    the same term of other counts a turn, that promise hardly less.
    """

    term: Term
    gain: float
    shift: Mapping[str, float]
    start: Mapping[str, float]
    own: tuple[Mapping[str, float], ...] = ()
    changes: tuple[Floats, ...] = ()
    companion: Term | None = None
    counts: float = 0.0
    alike: tuple[Candidate, ...] = ()

    def shifted(self, values: Mapping[str, float]) -> dict[str, float]:
        """The parameters where straight lines see them beside the term; those that are positive by
        a factor of e at most.
        """
        out = dict(values)
        for name, shift in self.shift.items():
            if out[name] > 0.0 and self.changes:
                out[name] *= float(np.exp(np.clip(shift / out[name], -1.0, 1.0)))
        return out

    @property
    def terms(self) -> tuple[Term, ...]:
        """All that a fit of it adds; the term itself is the last."""
        return (self.term,) if self.companion is None else (self.companion, self.term)

    def beside(self, own: Sequence[Mapping[str, float]]) -> list[dict[str, float]]:
        """Every record's own sizes, with those that the term begins with."""
        return [{**a, **b} for a, b in zip(own, self.own or own, strict=True)]


@dataclass(frozen=True)
class Tried:
    """A term, a shape of it, and what it does to every record's readings, weighed."""

    term: Term
    shape: Mapping[str, float]
    changes: tuple[Floats, ...]

    @property
    def one_sided(self) -> bool:
        """Its size cannot be below nothing."""
        return not self.term.per_turn and ADDED[self.term.size].lower == 0.0


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
    probe = Probe(records, solution, values)
    tried = everything(probe, [TERMS[name] for name in terms if TERMS[name] not in taken])
    test = _Test(probe, solution)
    best: dict[str, list[Candidate]] = {}
    for candidate in sorted(test.all(tried), key=lambda c: -c.gain):
        best.setdefault(candidate.term.name, []).append(candidate)
    return sorted((_with_alike(*found) for found in best.values()), key=lambda c: -c.gain)


def _with_alike(first: Candidate, *others: Candidate) -> Candidate:
    """The best of a term; counts a turn that explain hardly less are fitted beside it."""
    if not first.term.per_turn:
        return first
    near = [one for one in others if one.gain > ALIKE * first.gain]
    return replace(first, alike=tuple(near[:MOST_ALIKE]))


def everything(probe: Probe, terms: Sequence[Term]) -> list[Tried]:
    """Every shape of every term that such captures can tell."""
    return [
        Tried(term, shape, tuple(probe.changes(k, term, shape) for k in range(len(probe.records))))
        for term in terms
        if probe.tells(term)
        for shape in probe.shapes(term)
    ]


@dataclass(frozen=True)
class Sums:
    """Products of columns (q, n), cleared of nuisances: with each other (q, q), with the shared
    parameters' (q, p), and with the residual (q,)."""

    squares: Floats
    shared: Floats
    pull: Floats

    def of(self, rows: slice) -> Sums:
        """Of some of the columns."""
        return Sums(self.squares[rows, rows], self.shared[rows], self.pull[rows])


class _Test:
    def __init__(self, probe: Probe, solution: Solution) -> None:
        self.probe, self.solution = probe, solution
        self.inverse = covariance_of(solution.information)
        self.slope = np.sum(  # what the search left of it
            [project(line.orthogonal.T, line.residual) for line in solution.records], axis=0
        )

    def all(self, tried: Sequence[Tried]) -> list[Candidate]:
        """Those that the parameters do not say already, and whose size is not below nothing."""
        if not tried:
            return []
        whole = [
            sums_of(np.concatenate([t.changes[k] for t in tried]), line)
            for k, line in enumerate(self.solution.records)
        ]
        found, first = [], 0
        for one in tried:
            rows = slice(first, first + len(one.changes[0]))
            first = rows.stop
            candidate = self._candidate(one, [sums.of(rows) for sums in whole])
            found += [candidate] if candidate else []
        return found

    def _candidate(self, tried: Tried, parts: Sequence[Sums]) -> Candidate | None:
        sums = _apart(parts) if tried.term.per_turn else _together(parts)
        information = sums.squares - sums.shared @ self.inverse @ sums.shared.T
        if not float(np.trace(information)) > LEAST * float(np.trace(sums.squares)):
            return None
        pulls = sums.pull - sums.shared @ self.inverse @ self.slope
        sizes = covariance_of(information) @ pulls
        if tried.one_sided and sizes[0] <= 0.0:
            return None
        shift = -self.inverse @ sums.shared.T @ sizes * self.solution.slopes
        moves = dict(zip(self.probe.names, shift.tolist(), strict=True))
        start, own = begins(self.probe, tried, sizes)
        gain = float(pulls @ sizes)
        return Candidate(tried.term, gain, moves, start, own, tried.changes)


def begins(
    probe: Probe, tried: Tried, sizes: Floats
) -> tuple[dict[str, float], tuple[dict[str, float], ...]]:
    """Where a fit with the term begins: its parameters, and every record's nuisances."""
    term, shape = tried.term, tried.shape
    unit = probe.scales.of(term.size)
    if not term.per_turn:
        return {**shape, term.size: float(unit * sizes[0])}, ()
    each = sizes.reshape(len(probe.records), -1)
    amplitude = float(np.mean(np.hypot(each[:, 0], each[:, 1])))
    start = {**shape, term.size: unit * amplitude}
    if term.name == "ripple":
        together = np.einsum("kq,kq->k", each[:, :2], each[:, 2:])
        start["k_R"] = float(np.mean(together)) / amplitude
    phases = np.arctan2(each[:, 1], each[:, 0])
    return start, tuple(term.phased(float(phase)) for phase in phases)


def _together(parts: Sequence[Sums]) -> Sums:
    """Of sizes that all records share."""
    return Sums(
        np.sum([p.squares for p in parts], axis=0),
        np.sum([p.shared for p in parts], axis=0),
        np.sum([p.pull for p in parts], axis=0),
    )


def _apart(parts: Sequence[Sums]) -> Sums:
    """Of sizes that each record has for itself."""
    q = len(parts[0].pull)
    squares = np.zeros((q * len(parts), q * len(parts)))
    for k, part in enumerate(parts):
        squares[k * q : (k + 1) * q, k * q : (k + 1) * q] = part.squares
    return Sums(
        squares,
        np.concatenate([p.shared for p in parts]),
        np.concatenate([p.pull for p in parts]),
    )


def sums_of(changes: Floats, line: Linearised) -> Sums:
    """Of columns (q, n) of one record."""
    lengths = [part.stop - part.start for part in line.slices]
    table = changes / np.repeat(line.sigmas, lengths)
    free, information = line.cleared()
    p, own = line.orthogonal.shape[1], free.T
    rows = np.concatenate([line.orthogonal.T, own, line.residual[None]])
    products, squares = gram(table, rows), gram(table, table)
    shared, explained, pull = products[:, :p], products[:, p:-1], products[:, -1]
    if len(own):
        inverse = covariance_of(information)
        squares = squares - explained @ inverse @ explained.T
        pull = pull - explained @ inverse @ project(own, line.residual)
    return Sums(squares, shared, pull)
