"""A model that a term was added to, looked at again: does each of its older terms still earn its
place, or does another one explain better what it explains? And is each of use at the end?

A term that is taken first may stand in for one that shows beside it alone. Each older term is left
out in turn, and the terms that were not taken are tried in its place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.model.extended_terms import TERMS, Term
from motorid.estimate.selection.evidence import (
    SURE,
    Price,
    in_order,
    priced,
    shapes_of,
    size_of,
    weigh,
)
from motorid.estimate.selection.extended_fit import Begun, Fitted, begin, sizes_by_name
from motorid.estimate.selection.score_test import SCREENED, Candidate, screen
from motorid.estimate.selection.unsettled_models import Unsettled
from motorid.estimate.solver.allowance import Allowance

CLEAR = 3.0  # times SURE: a size that nobody asks about again
RIVAL = 0.5  # of what a term promises, from which another is tried in its place
SAME = 0.5  # of what a rival promises in a term's place, that it may promise beside it
DECIDED = 0.5  # of what a term explains, by which another that explains more has refuted it
TRIED = 2  # in the place of one
SHARE = 0.5  # of what is left: the search goes on with the rest
STILL = 1.0  # of what matters: what a companion may move that is not part of the answer
OPENED = 0.5  # of it: what may be open besides, in standard deviations, of a parameter without it
AGAIN = 12  # times the responses of a set of derivatives: for a fit without it
LEAST = 3  # times the responses of a set of derivatives: with less no term is looked at


class Revision:
    """Looks again as far as its share of an ``allowance`` goes.

    ``but``: terms that are not looked for. ``possible``: terms that gave way to others which
    explain hardly more, and the values beside them. ``left_out``: terms of the last model that were
    not looked at again.
    """

    def __init__(self, but: Sequence[Term], allowance: Allowance) -> None:
        self.but, self.allowance = but, allowance
        self.possible: list[Unsettled] = []
        self.left_out: tuple[Term, ...] = ()

    def of(self, fitted: Fitted) -> Fitted:
        """The same model, without terms that it does not need, or with better ones in their
        place; its last term stays.
        """
        self.left_out, self.allowance.ended = (), False
        with self.allowance.keeping(SHARE * max(self.allowance.left, 0.0)):
            fitted = self._pruned(fitted)
            for k, term in enumerate(fitted.terms[:-1]):
                better = self._exchanged(fitted, term) if self._may_begin(fitted) else None
                if self.allowance.ended:
                    self.left_out = fitted.terms[k:-1]
                    return fitted
                if better is not None:
                    return better
        return fitted

    def lean(
        self, fitted: Fitted, companions: Sequence[Term], reach: Mapping[str, float]
    ) -> Fitted:
        """The same model without those of ``companions`` that change nothing which matters: no
        parameter by its ``reach`` (SI), and none is much less sure without them. They had their
        use: the search looked beside them for what they hid.
        """
        for term in companions:
            if term not in fitted.terms[:-1] or _moved_by(fitted, term, reach) > STILL:
                continue
            if not self.allowance.has(AGAIN * fitted.width):
                break
            self.allowance.ended = False
            less = without(fitted, [term])
            if not self.allowance.ended and _as_good(less, fitted, reach):
                fitted = less
        return fitted

    def _may_begin(self, fitted: Fitted) -> bool:
        """Another fit has room; else what was begun has ended here."""
        if not self.allowance.has(LEAST * fitted.width):
            self.allowance.ended = True
        return not self.allowance.ended

    def _pruned(self, fitted: Fitted) -> Fitted:
        """Without those that the data do not support beside the others."""
        for term in fitted.terms[:-1]:
            k = fitted.free.index(term.size)
            if size_of(fitted.solution, k, shapes_of(fitted.free, term)) > CLEAR * SURE:
                continue
            if not self._may_begin(fitted):
                break
            rest = _but(fitted.terms, term)
            found = weigh(fitted, rest, fitted.solution, term)
            if not (found.supports or self.allowance.ended):
                less = without(fitted, [term])
                fitted = fitted if self.allowance.ended else less
        return fitted

    def _in_white_noise(self, fitted: Fitted) -> Fitted | None:
        """The same model as roughly fitted as its rivals: colour weighs other readings."""
        return _begun(fitted, fitted.terms).followed()

    def _exchanged(self, fitted: Fitted, term: Term) -> Fitted | None:
        """Another term in the place of ``term``, if it leaves clearly less in white noise, or about
        as much with fewer unknowns.
        """
        rest = _but(fitted.terms, term)
        null = _begun(fitted, rest).followed()
        if null is None or self.allowance.ended:
            return None
        names = [n for n in SCREENED if TERMS[n] not in (*self.but, *rest)]
        tried = screen(null.records, plain(null.records, null.solution), null.values, rest, names)
        promised = next((c.gain for c in tried if c.term is term), 0.0)
        rivals = [c for c in tried if c.term not in fitted.terms and c.gain > RIVAL * promised]
        usual = self._in_white_noise(fitted) if rivals else None
        if usual is None or self.allowance.ended:
            return None
        others = self._in_its_place(null, rest, _explaining_the_same(rivals, usual))
        prices = [priced(usual, term), *(priced(rough, other) for other, _, rough in others)]
        taken = 0 if self.allowance.ended else _taken(prices)
        if not taken:
            return None
        if prices[0].paid - prices[taken].paid < DECIDED * promised:
            self.possible.append(Unsettled(term, fitted.values))
        _, begun, rough = others[taken - 1]
        return begun.nearly(rough)

    def _in_its_place(
        self, null: Fitted, rest: Sequence[Term], rivals: Sequence[Candidate]
    ) -> list[tuple[Term, Begun, Fitted]]:
        """The best few of the rivals, roughly fitted."""
        found = []
        for candidate in rivals[:TRIED]:
            begun = _begun(null, (*rest, candidate.term), candidate)
            rough = begun.followed()
            if rough is not None:
                found.append((candidate.term, begun, rough))
        return found


def without(fitted: Fitted, terms: Sequence[Term]) -> Fitted:
    """The same model without some of its terms, near enough to be judged."""
    begun = _begun(fitted, tuple(t for t in fitted.terms if t not in terms))
    return begun.nearly(begun.roughly())


def _moved_by(fitted: Fitted, term: Term, reach: Mapping[str, float]) -> float:
    """The largest move of a parameter, in units of what matters, if the term's size were nothing:
    by straight lines.
    """
    solution, k = fitted.solution, fitted.free.index(term.size)
    covariance = solution.covariance
    if not covariance[k, k] > 0.0:  # at a bound: it is nothing
        return 0.0
    follows = covariance[:, k] / covariance[k, k] * solution.slopes / solution.slopes[k]
    moves = dict(zip(fitted.free, np.abs(follows * solution.values[k]).tolist(), strict=True))
    return max((moves[n] / limit for n, limit in reach.items() if n in moves), default=0.0)


def _as_good(less: Fitted, more: Fitted, reach: Mapping[str, float]) -> bool:
    """Its terms stand, its parameters are where they were, and it is as sure of them."""
    sizes = [
        size_of(less.solution, less.free.index(term.size), shapes_of(less.free, term))
        for term in less.terms
    ]
    moved = [abs(less.values[n] - more.values[n]) / limit for n, limit in reach.items()]
    sure = [
        less.deviation(n) <= np.hypot(more.deviation(n), OPENED * limit)
        for n, limit in reach.items()
        if n in less.free
    ]
    still = max(moved, default=0.0) <= STILL and all(sure)
    return min(sizes) > SURE and still


def _taken(prices: Sequence[Price]) -> int:
    """The best place; the first of them stays where another is about as good with no fewer
    unknowns.
    """
    now, best = prices[0], in_order(prices)[0]
    alike = now.paid < prices[best].paid + now.open
    return 0 if alike and prices[best].unknowns >= now.unknowns else best


def _explaining_the_same(rivals: Sequence[Candidate], usual: Fitted) -> list[Candidate]:
    """Those that promise much less beside the term than in its place; another effect does not."""
    names = [c.term.name for c in rivals]
    white = plain(usual.records, usual.solution)
    beside = screen(usual.records, white, usual.values, usual.terms, names)
    gains = {c.term: c.gain for c in beside}
    return [c for c in rivals if gains.get(c.term, 0.0) < SAME * c.gain]


def _but(terms: Sequence[Term], term: Term) -> tuple[Term, ...]:
    return tuple(t for t in terms if t is not term)


def _begun(fitted: Fitted, terms: Sequence[Term], candidate: Candidate | None = None) -> Begun:
    """A fit of some terms from where a fit of others is."""
    gone = {n for t in fitted.terms if t not in terms for n in (*t.free, t.per_turn)}
    start = {n: v for n, v in fitted.values.items() if n not in gone}
    more = {n for t in terms for n in t.free}
    fixed = {n: v for n, v in start.items() if n not in fitted.free and n not in more}
    own = sizes_by_name(fitted.records, fitted.solution)
    if candidate is not None:
        start |= candidate.start
        own = candidate.beside(own)
    return begin(fitted.records, fitted.solution, terms, fixed=fixed, start=start, own=own)
