"""Whether the data support a wider fit: information criterion, size, and captures left out.

Both fits are held against the noise as the wider one leaves it: the narrower is fitted again with
the wider's whitening filters and voltage sources, so that what it lacks is not called noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.fit.alternating_fit import again
from motorid.estimate.fit.parameter_bounds import merged, unknowns_of
from motorid.estimate.model.extended_capture_model import WideRecord
from motorid.estimate.model.extended_terms import ADDED, Term
from motorid.estimate.selection.extended_fit import Fitted
from motorid.estimate.selection.left_out_captures import foretold
from motorid.estimate.solver.autoregression import inflation
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import errors_in_variables
from motorid.estimate.uncertainty.covariance import statistical

Floats = NDArray[np.float64]

MARGIN = 10.0  # beyond Schwarz's penalty: odds of exp(-5)
SURE = 4.0  # of a size, in standard deviations
BEYOND = 5.0  # times the gain that is needed, from which a shape may be open
HALF = 2.0  # times it, from which a size may be: a search among many terms finds this much in noise
COARSE = 100.0  # change of F that is near enough for a narrower fit which is out of the question
SETTLED = 20.0  # of that, from which it is
LEAST = 1e-8  # of a variance, that rounding leaves


@dataclass(frozen=True)
class Evidence:
    """What speaks for a term. ``gain`` of F under the wider noise, over ``inflation`` by the colour
    that is left; ``needed`` by Schwarz's criterion; ``left_out``: gain on captures that the fit did
    not see, None for a single capture; ``size``: in standard deviations, colour allowed for."""

    gain: float
    inflation: float
    needed: float
    size: float = np.inf
    left_out: float | None = None

    @property
    def counted(self) -> float:
        """The gain, as far as the colour that is left lets it count."""
        return self.gain / self.inflation

    @property
    def suffices(self) -> bool:
        """The likelihood rises by more than the unknowns cost."""
        return self.counted > self.needed

    @property
    def exceeds(self) -> bool:
        """It rises by several times as much."""
        return self.counted > BEYOND * self.needed

    @property
    def possible(self) -> bool:
        """The likelihood clearly speaks for it, or captures that the fit did not see agree with it.
        Its size is not nothing, though it may be open.
        """
        agreed = self.left_out is not None and self.left_out > 0.0
        enough = self.suffices if agreed else self.counted > HALF * self.needed
        return enough and self.size > SURE / 2.0

    @property
    def unsure(self) -> bool:
        """It explains much, but what is lacking beside it leaves its size open, or captures
        disagree.
        """
        return self.exceeds and self.possible and not self.supports

    def beats(self, other: Evidence) -> bool:
        """It is clearly likelier than another in its place."""
        return self.counted - self.needed > other.counted - other.needed + MARGIN

    @property
    def supports(self) -> bool:
        """All of it speaks for the term."""
        better = self.left_out is None or self.left_out > 0.0
        return self.suffices and self.size > SURE and better


def weigh(wider: Fitted, narrower: Sequence[Term], before: Solution, added: Term) -> Evidence:
    """The evidence for ``added`` over the terms ``narrower``, whose own fit was ``before``."""
    null = _nested(wider, narrower, before)
    own = sum(len(a) - len(b) for a, b in zip(wider.solution.own, null.solution.own, strict=True))
    more = len(wider.free) - len(null.free) + own + bool(added.per_turn)  # a count is an unknown
    found = evidence(wider.solution, null.solution, more)
    k = wider.free.index(added.size)
    size, held = size_of(wider.solution, k), list[int]()
    if size <= SURE and found.exceeds:
        held = shapes_of(wider.free, added)  # its shape alone is open
        size = size_of(wider.solution, k, held)
    found = replace(found, size=size)
    if found.suffices and found.size > 0.0:
        found = _less_by_input_noise(found, wider, k, held)
    if len(wider.records) > 1 and found.suffices:
        return replace(found, left_out=foretold(found.gain, wider.solution, null.solution))
    return found


def _less_by_input_noise(
    found: Evidence, wider: Fitted, k: int, held: Sequence[int] = ()
) -> Evidence:
    """The evidence of a size that noise of the voltage moves too, which no residual shows: at the
    shapes ``held`` at which the size counts, as along an open shape it moves both.
    """
    taken_in = errors_in_variables.hidden(wider.solution, wider.records, roughly=True)
    known = statistical(wider.solution).covariance
    moved = sum((np.outer(s, s) for s in errors_in_variables.shifts(taken_in)), 0.0 * known)
    without, whole = (deviation_at(c, k, held) ** 2 for c in (known, known + moved))
    one, value = wider.solution.unknowns[k], float(wider.solution.values[k])
    deviation = (1.0 if one.log else abs(value)) / found.size
    more = 1.0 + (whole - without) / max(deviation**2, 1e-300)
    return replace(found, inflation=found.inflation * more, size=found.size / np.sqrt(more))


@dataclass(frozen=True)
class Price:
    """F of a rough fit with what the unknowns of its last term cost in the colour that is left.

    ``open``: by how much less another price must be to be a better one.
    """

    paid: float
    unknowns: int
    open: float


def priced(rough: Fitted, *added: Term) -> Price:
    """Of a fit to which ``added`` were the last to come."""
    colour = inflation(rough.solution)
    unknowns = sum(len(t.free) + (len(rough.records) if t.phase else 0) for t in added)
    paid = rough.solution.objective + colour * unknowns * _each(rough.solution)
    return Price(paid, unknowns, colour * MARGIN)


def in_order(prices: Sequence[Price]) -> list[int]:
    """Places, the best first; of those that differ by too little the one with fewest unknowns."""
    best = min(prices, key=lambda price: price.paid, default=None)
    if best is None:
        return []
    alike = [price.paid < best.paid + best.open for price in prices]
    return sorted(
        range(len(prices)),
        key=lambda k: (not alike[k], prices[k].unknowns if alike[k] else 0, prices[k].paid),
    )


def _each(solution: Solution) -> float:
    """What an unknown costs, by Schwarz: the logarithm of how many readings count."""
    count = sum(b.count for line in solution.records for b in line.blocks)
    return float(np.log(count / inflation(solution)))


def evidence(wider: Solution, narrower: Solution, more: int) -> Evidence:
    """What speaks for ``more`` unknowns, the noise of both solutions being the wider one's.

    Without a size of its own, or captures left out.
    """
    needed = more * _each(wider) + MARGIN
    return Evidence(narrower.objective - wider.objective, inflation(wider), needed)


def _nested(wider: Fitted, terms: Sequence[Term], before: Solution) -> Fitted:
    """The narrower fit with the wider's noise and sources."""
    extra = {n for t in wider.terms if t not in terms for n in (*t.free, t.per_turn)}
    free = tuple(n for n in wider.free if n not in extra)
    absent = {name: ADDED[name].absent for name in extra if name}
    start = {**merged(wider.start, before), **absent}
    fixed = {n: v for n, v in start.items() if n not in free}
    records = []
    for k, record in enumerate(wider.records):
        null = WideRecord(record, free, fixed, terms, record.scales, record.priors, k == 0)
        null.follow(record)
        named = zip((u.name for u in record.unknowns), wider.solution.own[k], strict=True)
        null.starting({name: float(v) for name, v in named})
        records.append(null)
    unknowns = unknowns_of(records, free, start)
    solution = maximise(unknowns, records, enough=COARSE)
    if solution.objective - wider.solution.objective < SETTLED * COARSE:
        start = merged(start, solution)
        solution = again(records, free, start, solution)
    return Fitted(tuple(terms), tuple(records), solution, free, start)


def shapes_of(free: Sequence[str], term: Term) -> list[int]:
    """Places of a term's parameters that mean nothing without its size."""
    return [free.index(name) for name in term.free if name in term.shapes]


def size_of(solution: Solution, k: int, shapes: Sequence[int] = ()) -> float:
    """The k-th unknown in standard deviations, by its distance from 0 or as a factor.

    At the ``shapes`` that were found: where one is open, the size is open with it, but not nothing.
    Neither is one that is as large as it may be.
    """
    one, value = solution.unknowns[k], float(solution.values[k])
    if solution.at_bound[k] and 0.0 <= value <= max(one.lower, 0.0):
        return 0.0
    deviation = deviation_at(statistical(solution).covariance, k, shapes)
    size = 1.0 if one.log else abs(value)
    return size / max(deviation, 1e-300)


def deviation_at(covariance: Floats, k: int, held: Sequence[int]) -> float:
    """Standard deviation of the k-th of some uncertain numbers if others were known; infinite where
    nothing bounds them.
    """
    among = [k, *held]
    covariance = covariance[np.ix_(among, among)]
    if not np.isfinite(covariance).all():
        return np.inf
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    table = covariance / np.outer(scale, scale)
    left = 1.0
    if len(held):
        left -= float(table[0, 1:] @ np.linalg.pinv(table[1:, 1:]) @ table[0, 1:])
    return float(scale[0] * np.sqrt(max(left, LEAST)))
