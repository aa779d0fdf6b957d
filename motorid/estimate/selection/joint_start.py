"""Where a fit with several terms begins: all their sizes at once, by straight lines.

Each term by itself would explain what another one does as well: what one promises beside another is
told by the same sums, which are the screen's.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import Term
from motorid.estimate.selection.score_derivatives import Probe
from motorid.estimate.selection.score_test import Candidate, Tried, begins, everything, sums_of
from motorid.estimate.solver.dense_products import project
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]
Start = tuple[dict[str, float], tuple[dict[str, float], ...]]

PASSES = 2  # over the terms, each taking the shape that suits the others best
FAINT = 0.01  # of its scale: a size that the others leave nothing for


def starts(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    terms: Sequence[Term],
) -> dict[Term, Start]:
    """The parameters of every term that shows, and every record's nuisances of it.

    ``solution``: the derivatives in white noise, at ``values`` of all parameters.
    """
    probe = Probe(records, solution, values)
    tried = everything(probe, [term for term in terms if term.name != "two-masses"])
    if not tried:
        return {}
    lines = _Lines(tried, solution)
    chosen = {one.term: k for k, one in reversed(list(enumerate(tried)))}
    for _ in range(PASSES):
        for term in chosen:
            same = [k for k, one in enumerate(tried) if one.term is term]
            chosen[term] = max(same, key=lambda k: lines.gain({**chosen, term: k}.values()))
    sizes = lines.sizes(chosen.values())
    return {term: begins(probe, tried[k], sizes[k]) for term, k in chosen.items()}


def beside(one: Candidate, other: Candidate, solution: Solution) -> float:
    """What ``one`` promises beside another, of chi-square; both have changes."""
    lines = _Lines([Tried(c.term, {}, c.changes) for c in (one, other)], solution)
    return lines.gain([0, 1]) - lines.gain([1])


def pair(candidates: Sequence[Candidate], solution: Solution) -> Candidate | None:
    """The two that promise most together, as one, the more promising of them the companion; None
    of fewer than two. Each has the shape that it has alone, and none has phases.

    What one effect does to the readings may undo what another does: alone, neither promises much,
    and a forward selection passes both by (A. Miller, Subset Selection in Regression, 2nd ed.,
    2002, on forward selection).
    """
    known = [c for c in candidates if c.changes and not c.term.per_turn]
    if len(known) < 2:
        return None
    lines = _Lines([Tried(c.term, {}, c.changes) for c in known], solution)
    two = max(combinations(range(len(known)), 2), key=lines.gain)
    last, first = sorted(two, key=lambda k: known[k].gain)
    sizes, gain = lines.solved([last, first])
    start: dict[str, float] = {}
    for k, together in zip((last, first), sizes, strict=True):
        alone, size = lines.solved([k])[0][0], known[k].term.size
        start |= {**known[k].start, size: known[k].start[size] * float(together / alone)}
    names = [u.name for u in solution.unknowns]
    shift = dict(zip(names, (lines.follows([last, first]) * solution.slopes).tolist(), strict=True))
    changes = tuple(
        np.concatenate(both) for both in zip(known[last].changes, known[first].changes, strict=True)
    )
    return Candidate(known[last].term, gain, shift, start, (), changes, known[first].term)


class _Lines:
    """Everything that was tried, as straight lines beside the parameters and nuisances."""

    def __init__(self, tried: Sequence[Tried], solution: Solution) -> None:
        self.tried = tried
        lengths = [len(one.changes[0]) for one in tried]
        ends = np.cumsum(lengths)
        self.rows = [np.arange(end - n, end) for end, n in zip(ends, lengths, strict=True)]
        self.parts = [
            sums_of(np.concatenate([one.changes[k] for one in tried]), line)
            for k, line in enumerate(solution.records)
        ]
        self.inverse = covariance_of(solution.information)
        self.slope = np.sum(
            [project(line.orthogonal.T, line.residual) for line in solution.records], axis=0
        )

    def gain(self, chosen: Iterable[int]) -> float:
        """Of chi-square."""
        return self.solved(list(chosen))[1]

    def sizes(self, chosen: Iterable[int]) -> dict[int, Floats]:
        """Of each that was chosen, in scales; its own of every record, one after the other."""
        chosen = list(chosen)
        sizes, _ = self.solved(chosen)
        places = self._places(chosen)
        found = {}
        for k, here in places.items():
            each = sizes[np.unique(here)]
            found[k] = np.maximum(each, FAINT) if self.tried[k].one_sided else each
        return found

    def follows(self, chosen: Sequence[int]) -> Floats:
        """The move (p,) of the parameters in search coordinates beside these, without phases."""
        sizes, _ = self.solved(chosen)
        rows = np.concatenate([self.rows[k] for k in chosen])
        shared = np.sum([part.shared[rows] for part in self.parts], axis=0)
        return np.asarray(-self.inverse @ shared.T @ sizes)

    def _places(self, chosen: Sequence[int]) -> dict[int, NDArray[np.int_]]:
        """(records, q): where each one's sizes are; those of a phase differ between records."""
        places, first = {}, 0
        for k in chosen:
            q = len(self.rows[k])
            each = np.arange(first, first + q)
            own = q * np.arange(len(self.parts))[:, None] if self.tried[k].term.per_turn else 0
            places[k] = each + own + np.zeros((len(self.parts), 1), dtype=int)
            first = int(places[k].max()) + 1
        return places

    def solved(self, chosen: Sequence[int]) -> tuple[Floats, float]:
        """The sizes (n,) in scales, and what they gain of chi-square together."""
        places = self._places(chosen)
        total = 1 + max(int(here.max()) for here in places.values())
        squares, pull = np.zeros((total, total)), np.zeros(total)
        shared = np.zeros((total, len(self.inverse)))
        rows = np.concatenate([self.rows[k] for k in chosen])
        for r, part in enumerate(self.parts):
            here = np.concatenate([places[k][r] for k in chosen])
            squares[np.ix_(here, here)] += part.squares[np.ix_(rows, rows)]
            shared[here] += part.shared[rows]
            pull[here] += part.pull[rows]
        information = squares - shared @ self.inverse @ shared.T
        pull = pull - shared @ self.inverse @ self.slope
        one_sided = np.zeros(total, dtype=bool)
        for k, here in places.items():
            one_sided[here.ravel()] = self.tried[k].one_sided
        sizes = _at_least_nothing(information, pull, one_sided)
        return sizes, float(2 * pull @ sizes - sizes @ information @ sizes)


def _at_least_nothing(information: Floats, pull: Floats, one_sided: NDArray[np.bool_]) -> Floats:
    """The most likely sizes; those that would be below nothing, and must not, are none."""
    sizes, kept = np.zeros(len(pull)), np.ones(len(pull), dtype=bool)
    while kept.any():
        sizes[:] = 0.0
        sizes[kept] = covariance_of(information[np.ix_(kept, kept)]) @ pull[kept]
        below = kept & one_sided & (sizes < 0.0)
        if not below.any():
            break
        kept &= ~below
    return np.maximum(sizes, np.where(one_sided, 0.0, -np.inf))
