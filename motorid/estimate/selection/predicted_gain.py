"""What a fit with a term would find, by straight lines: the judge's questions before it is fitted.

The screen weighs readings equally. A fit does not: what wanders slowly is worth little, and much
of what a term promises goes with it. Here the readings follow the derivatives that the screen has,
and the noise is what the term would leave.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model import prewhitening
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import ADDED
from motorid.estimate.selection.evidence import Evidence, evidence, size_of
from motorid.estimate.selection.score_test import Candidate
from motorid.estimate.solver.allowance import taking_none
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Derivatives, Solution, Unknown

Floats = NDArray[np.float64]

ENOUGH = 0.01  # of chi-square: one that is almost a parameter gains it in small steps


class Straight(MotorRecord):
    """A record whose readings are straight lines in all that is unknown.

    Unknowns are moves: of the parameters and nuisances in search coordinates, of sizes in scales.
    """

    def __init__(
        self, record: MotorRecord, left: Floats, shared: Floats, own: Floats, starts: Floats
    ) -> None:
        vars(self).update(vars(record.twin()))
        self._left, self._shared, self._slopes = left, shared, own
        self._edges = np.cumsum([len(m.values) for m in self.measured])[:-1]
        self.unknowns = tuple(
            replace(u, start=0.0, prior_mean=u.prior_mean - float(x), lower=-np.inf, upper=np.inf)
            for u, x in zip(record.unknowns, starts, strict=True)
        )
        self.whiten([None] * len(self.measured))

    def departures(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less model, each times the root of what the reading is worth by itself."""
        lines = np.einsum("p,pn->n", shared, self._shared[: len(shared)])
        left = self._left - lines - np.einsum("m,mn->n", own, self._slopes)
        return list(np.split(left, self._edges))

    def foresee(self, points: Sequence[tuple[Floats, Floats]]) -> None:
        """No motor is simulated: there is nothing to compute at once."""

    def weighed(self, parts: Sequence[Floats], filtered: bool = True) -> list[Floats]:
        """By filters and thinning; the roots are in ``parts`` already."""
        return self.filtered(parts) if filtered else list(parts)

    def weighed_lines(self) -> tuple[Floats, Floats]:
        """The derivatives (p, n) and (m, n) of the readings, as the likelihood counts them."""
        return self.filtered_rows(self._shared), self.filtered_rows(self._slopes)


def foresee(records: Sequence[MotorRecord], plain: Solution, candidate: Candidate) -> Evidence:
    """The evidence for a term, as far as straight lines from ``plain`` show it.

    ``plain``: the derivatives in white noise that the candidate's changes go with.
    """
    straight = [_straight(record, plain, candidate, k) for k, record in enumerate(records)]
    six, sizes = _moves(plain), _sizes(candidate)
    wider = _maximum([*six, *sizes], straight, plain)
    coloured, wandering = prewhitening.whiten(straight, wider), prewhitening.thin(straight, wider)
    if coloured or wandering:
        wider = _maximum([*six, *sizes], straight, plain)
    narrower = _maximum(six, straight, plain)
    more = sum(len(term.free) for term in candidate.terms) + (
        len(records) if candidate.term.phase else 0
    )
    found = evidence(wider, narrower, more)
    if candidate.term.per_turn or not found.suffices:
        return found
    return replace(found, size=size_of(wider, len(six)))


def _straight(record: MotorRecord, plain: Solution, candidate: Candidate, k: int) -> Straight:
    line, known = plain.records[k], plain.derivatives
    assert known is not None
    lengths = [part.stop - part.start for part in line.slices]
    changes = [candidate.changes[k]]
    if candidate.term.per_turn:  # of other records' own sizes none
        changes = [c if j == k else np.zeros((len(c), len(line.residual)))
                   for j, c in enumerate(candidate.changes)]  # fmt: skip
    left = line.residual * np.repeat(line.sigmas, lengths)
    table = np.concatenate([known.shared[k], *changes])
    return Straight(record, left, table, known.own_slopes[k], plain.own[k])


def _maximum(
    unknowns: Sequence[Unknown], straight: Sequence[Straight], plain: Solution
) -> Solution:
    """The most likely moves; the lines lend their derivatives. Also where an allowance has ended:
    what a search leaves out is known by them.
    """
    p, own = len(unknowns), tuple(np.zeros(len(r.unknowns)) for r in straight)
    tables = [r.weighed_lines() for r in straight]
    known = Derivatives(
        np.zeros(p), own, tuple(shared[:p] for shared, _ in tables), tuple(o for _, o in tables)
    )
    before = replace(plain, own=own, derivatives=known)
    with taking_none():
        return maximise(unknowns, straight, enough=ENOUGH, before=before)


def _moves(plain: Solution) -> list[Unknown]:
    """The shared parameters, in search coordinates from where they are."""
    out = []
    for u, value in zip(plain.unknowns, plain.values, strict=True):
        at = float(np.log(value)) if u.log else float(value)
        out.append(
            Unknown(
                u.name, 0.0, -np.inf if u.log else u.lower - at, scale=u.scale,
                prior_mean=u.prior_mean - at, prior_sd=u.prior_sd,
            )
        )  # fmt: skip
    return out


def _sizes(candidate: Candidate) -> list[Unknown]:
    """The term's sizes in their scales; those that cannot be below nothing."""
    if candidate.term.per_turn:
        return [Unknown("size", 0.0) for changes in candidate.changes for _ in changes]
    sizes = [term.size for term in reversed(candidate.terms)]
    return [Unknown(n, 0.0, 0.0 if ADDED[n].lower == 0.0 else -np.inf) for n in sizes]
