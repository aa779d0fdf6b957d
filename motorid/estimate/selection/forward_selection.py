"""The better model, term by term: what the residuals ask for and the data support."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorid.errors import DataError
from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import TERMS, Term
from motorid.estimate.selection.evidence import Evidence, in_order, priced, weigh
from motorid.estimate.selection.extended_fit import (
    Begun,
    Fitted,
    begin,
    sizes_by_name,
    width_of,
)
from motorid.estimate.selection.joint_start import beside, pair
from motorid.estimate.selection.predicted_gain import foresee
from motorid.estimate.selection.revision import SAME, Revision
from motorid.estimate.selection.score_test import SCREENED, Candidate, screen
from motorid.estimate.selection.shaft_resonance import springs
from motorid.estimate.selection.trigger import largest_move, matters
from motorid.estimate.selection.unsettled_models import Unsettled
from motorid.estimate.solver.allowance import Allowance, current
from motorid.estimate.solver.problem import Solution

WORTH = 5.0  # of chi-square in white noise: a term that promises less is not looked at
HIDING = 30.0  # the same, from which one that no fit is foreseen to support may hide others
GROSS = 1000.0  # of chi-square: fitted whatever it moves
REFITTED = 3
ROUNDS = 5
KEPT = 16  # times the responses of a set of derivatives: for the end of the fit that is offered
ENDS = 2.0  # times what judging it took: the same, where its likelihood is rough
LEAST = 4  # the same: with less no other fit begins
UNFORESEEN = Evidence(np.inf, 1.0, 0.0)
RIVAL = 0.5  # of a promise, from which another is tried beside it
ALIKE = 0.2  # the same of what it moves
MASKED = 2.0  # times the best promise, from which two terms are fitted at once
LITTLE = 0.05  # of a term's size, from which a search begins that failed from the whole of it


@dataclass(frozen=True)
class Trial:
    """A term that was fitted: beside which others, its evidence, and whether it was taken.

    ``moves``: the largest move of a parameter that it makes, in units of what matters. ``stands``:
    it may only stand for another, which is likelier though its size is open.
    """

    term: Term
    beside: tuple[Term, ...]
    evidence: Evidence
    moves: float
    taken: bool = False
    stands: bool = False

    @property
    def earns(self) -> bool:
        """The data support it, and it matters."""
        return self.evidence.supports and self.moves > 1.0 and not self.stands

    @property
    def goes_on(self) -> bool:
        """Others are tried beside it: it may hide them, even if it moves nothing."""
        return self.evidence.supports or self.evidence.unsure


@dataclass(frozen=True)
class Selection:
    """Supported fits, each with a term more than the one before, and what was tried."""

    stages: tuple[Fitted, ...]
    trials: tuple[Trial, ...]
    left_out: tuple[Term, ...] = ()  # which might matter, and which the search had no room for
    unsettled: tuple[Unsettled, ...] = ()  # which the data half support, beside the last stage
    harmless: Fitted | None = None  # wider than the last stage: supported, and it moves nothing
    not_revised: tuple[Term, ...] = ()  # older ones that were not looked at again, for want of room


def select(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    reach: Mapping[str, float],
    but: Sequence[Term] = (),
    taken: Sequence[Term] = (),
) -> Selection:
    """Terms taken one by one, each the best of its round. ``values``: as ``screen``'s.

    ``reach``: by how much a parameter may move (SI) before it matters. ``but``: terms that are not
    looked for; ``taken``: those that the solution has. A term that the data support but that moves
    nothing does not end the search: the others are tried beside it, because what it leaves in the
    residuals may hide them. It is part of the answer only if one of them is taken and needs it. All
    of it draws on the allowance, of which the end of the last fit is kept.
    """
    stages: list[Fitted] = []
    trials: list[Trial] = []
    unsettled: list[Unsettled] = []
    harmless, companions = None, list[Term]()
    allowance = current()
    before = allowance.kept
    now, search = _Model(records, solution, values, tuple(taken)), _Search(reach, but, allowance)
    revision = Revision((*but, *taken), allowance)
    for _ in range(ROUNDS):
        allowance.kept = before + now.end
        found = search.round(now)
        trials += [trial for _, trial in found]
        unsettled += [Unsettled(t.term, f.values) for f, t in found if t.evidence.possible]
        after = _next(found)
        if after is None:
            break
        fitted, trial = after
        if len(fitted.terms) > 1:
            fitted = revision.of(fitted)
        if trial.earns:
            stages.append(fitted)
            unsettled.clear()
            harmless = None
        else:
            companions.append(trial.term)
            harmless = fitted if trial.evidence.supports else harmless
        now = _Model(fitted.records, fitted.solution, fitted.values, fitted.terms, fitted.took)
    allowance.kept = before
    if stages and companions:
        with allowance.keeping(KEPT * stages[-1].width):
            stages[-1] = revision.lean(stages[-1], companions, reach)
    kept = stages[-1].terms if stages else ()
    told = tuple(replace(t, taken=t.term in kept and t.goes_on) for t in trials)
    possible = [one for one in revision.possible if one.term not in kept]
    untried = [one for one in search.untried if one.term not in kept]
    half = (*unsettled, *possible, *untried)
    return Selection(tuple(stages), told, tuple(search.left_out), half, harmless, revision.left_out)


@dataclass(frozen=True)
class _Model:
    """What the next term is added to. ``values`` of all parameters, those held among them."""

    records: Sequence[MotorRecord]
    solution: Solution
    values: Mapping[str, float]
    taken: tuple[Term, ...] = ()
    took: int = 0  # responses, to be judged

    @property
    def end(self) -> float:
        """Responses that are kept for the end of its fit."""
        return max(KEPT * self.width, ENDS * self.took)

    @property
    def width(self) -> int:
        """Responses that derivatives by its unknowns take."""
        return width_of(self.records, self.solution.unknowns)


def _next(found: Sequence[tuple[Fitted, Trial]]) -> tuple[Fitted, Trial] | None:
    """The fit that the search goes on beside: whose term earns its place; else one that the data
    support, and that hides others.
    """
    for fitted, trial in found:
        if trial.earns:
            return fitted, trial
    harmless = [(fitted, trial) for fitted, trial in found if trial.goes_on]
    return max(harmless, key=lambda one: one[1].evidence.gain, default=None)


class _Search:
    """The rounds of one search, as far as an allowance goes, and what that left no room for."""

    def __init__(
        self, reach: Mapping[str, float], but: Sequence[Term], allowance: Allowance
    ) -> None:
        self.reach, self.but, self.allowance = reach, but, allowance
        self.left_out: list[Term] = []  # of the last round
        self.untried: list[Unsettled] = []  # with what is half supported

    def round(self, now: _Model) -> list[tuple[Fitted, Trial]]:
        """The candidates that were fitted; the last earns its place, if one does.

        Beside one that hides them, or for which the first may only stand, the rest are tried in the
        next round.
        """
        found: list[tuple[Fitted, Trial]] = []
        waiting, half, white = _asked(now, self.reach, self.but)
        self.left_out, self.untried = [], _unsettled(now, half)
        while waiting:
            if not self.allowance.has(LEAST * now.width):
                self._leave(now, waiting)
                break
            first = waiting[0]
            behind = [c.term for c in waiting if _stands_for(first, c, white)]
            rivals, waiting = _rivals(waiting, self.reach, behind)
            self.allowance.ended = False
            for fitted, one in self._compared(now, rivals, white.objective - WORTH):
                likelier = (t.evidence for _, t in found if t.term in behind)
                stands = any(e.possible and e.beats(one.evidence) for e in likelier)
                trial = replace(one, stands=stands and one.term is first.term)
                found.append((fitted, trial))
                if trial.earns or (trial.goes_on and trial.term in behind):
                    return found
            if self.allowance.ended:
                tried = [t.term for _, t in found]
                self._leave(now, [c for c in [*rivals, *waiting] if c.term not in tried])
                break
            if any(_hides(trial, waiting) for _, trial in found):
                return found
        return found

    def _leave(self, now: _Model, waiting: Sequence[Candidate]) -> None:
        """No room is left for these: what straight lines see of those that matter stays open."""
        left = [c for c in waiting if matters(c, self.reach)]
        self.left_out = [c.term for c in left]
        self.untried += _unsettled(now, left)

    def _compared(
        self, now: _Model, rivals: Sequence[Candidate], most: float
    ) -> Iterator[tuple[Fitted, Trial]]:
        """Each roughly fitted; then wholly fitted and judged, the best of them first.

        Those that leave more than ``most`` of F keep none of their promise. None, from where the
        allowance ends.
        """
        found = [(c, *self._rough(now, c, most)) for c in rivals]
        tried = [(c, b, rough) for c, b, rough in found if rough is not None]
        prices = [priced(rough, *candidate.terms) for candidate, _, rough in tried]
        behind = _outdone([candidate for candidate, *_ in tried], self.reach)
        for k in sorted(in_order(prices), key=behind.__getitem__):
            candidate, start, rough = tried[k]
            if rough.solution.objective > most or self.allowance.ended:
                break
            try:
                fitted = start.nearly(rough)
            except DataError:  # no motor with finite readings is where it ended
                continue
            older = (*now.taken, *candidate.terms[:-1])
            evidence = weigh(fitted, older, now.solution, candidate.term)
            if self.allowance.ended:
                break
            then = fitted.values
            moves = (abs(then[n] - now.values[n]) / r for n, r in self.reach.items())
            yield fitted, Trial(candidate.term, older, evidence, max(moves, default=0.0))

    def _rough(self, now: _Model, candidate: Candidate, most: float) -> tuple[Begun, Fitted | None]:
        """A rough fit from where straight lines see it, of the count a turn that fits best; where
        that leaves more than ``most``, from little of the term beside what is known, which a search
        can only improve.
        """
        fits = [_followed(now, one) for one in (candidate, *candidate.alike)]
        begun, rough = min(fits, key=lambda fit: _left(fit[1]))
        if _left(rough) <= most:
            return begun, rough
        return _followed(now, _little(candidate))


def _hides(trial: Trial, waiting: Sequence[Candidate]) -> bool:
    """Those that wait are looked for beside it: its size is open by what else is lacking, or it is
    there and explains more than all that they promise.
    """
    e = trial.evidence
    return e.unsure or (e.supports and bool(waiting) and e.gain > sum(c.gain for c in waiting))


def _asked(
    now: _Model, reach: Mapping[str, float], but: Sequence[Term]
) -> tuple[list[Candidate], list[Candidate], Solution]:
    """What the residuals ask for and a fit is foreseen to support, first what moves most; what
    matters and is half supported; and the solution in white noise.

    What moves nothing is asked for too where something that matters may only stand for it.
    """
    white = plain(now.records, now.solution)
    bare = (now.records, white, now.values)
    names = [name for name in SCREENED if TERMS[name] not in but]
    tried = screen(*bare, now.taken, names)
    tried += [] if TERMS["two-masses"] in but else springs(*bare, now.taken)
    promising = [c for c in tried if c.gain > WORTH]
    matter = [_foretold(now, white, c) for c in promising if matters(c, reach)]
    likely = [c for c, found in matter if _is_likely(found)]
    half = [c for c, found in matter if found.possible and not _is_likely(found)]
    hidden = any(c.gain > HIDING and not _is_likely(found) for c, found in matter)
    harmless = [
        _foretold(now, white, c)
        for c in promising
        if not matters(c, reach)
        and (hidden or c.gain > GROSS or any(_stands_for(m, c, white) for m in likely))
    ]
    likely += [c for c, found in harmless if _is_likely(found)]
    asked = sorted(likely, key=lambda c: -largest_move(c, reach))
    return [*_masked(now, white, tried, reach), *asked], half, white


def _masked(
    now: _Model, white: Solution, tried: Sequence[Candidate], reach: Mapping[str, float]
) -> list[Candidate]:
    """Two terms that explain more than twice what any one of them all does: each hides the other,
    and one by one another would come first. None, or one.
    """
    both = pair(tried, white)
    if both is None or not both.gain > MASKED * max(c.gain for c in tried):
        return []
    if not matters(both, reach):
        return []
    both, found = _foretold(now, white, both)
    return [both] if _is_likely(found) else []


def _is_likely(found: Evidence) -> bool:
    """A fit is foreseen to support it. Where much is lacking, its size is unsure by what else is:
    the fit is asked.
    """
    return found.supports or found.unsure


def _foreseen(now: _Model, white: Solution, candidate: Candidate) -> Evidence:
    """What a fit would find, as far as straight lines show that; all, of one that has none."""
    return foresee(now.records, white, candidate) if candidate.changes else UNFORESEEN


def _foretold(now: _Model, white: Solution, candidate: Candidate) -> tuple[Candidate, Evidence]:
    """The same, with a candidate that knows it."""
    found = _foreseen(now, white, candidate)
    counts = found.counted if candidate.changes else candidate.gain
    return replace(candidate, counts=counts), found


def _outdone(rivals: Sequence[Candidate], reach: Mapping[str, float]) -> list[bool]:
    """Of which another counts more than twice as much, and moves more: white noise, by which their
    prices are, takes what wanders slowly for much.
    """
    told = [(c.counts, largest_move(c, reach)) for c in rivals]
    return [
        any(RIVAL * much > counts and far > moves for much, far in told) for counts, moves in told
    ]


def _stands_for(one: Candidate, other: Candidate, white: Solution) -> bool:
    """The other explains more, and most of what ``one`` promises."""
    if not (other.gain > one.gain and one.changes and other.changes):
        return False
    return beside(one, other, white) < SAME * one.gain


def _rivals(
    waiting: Sequence[Candidate], reach: Mapping[str, float], behind: Sequence[Term] = ()
) -> tuple[list[Candidate], list[Candidate]]:
    """Those that explain much the same as the first and move as much, or that explain more and
    matter, or that are ``behind`` it: the likelihood compares them. And the rest, which wait until
    none of these earns its place.
    """
    first = waiting[0]
    counts, moves = RIVAL * first.counts, ALIKE * largest_move(first, reach)
    near = [
        c
        for c in waiting
        if (c.counts >= counts and largest_move(c, reach) >= moves)
        or (c.counts >= first.counts and matters(c, reach))
        or c.term in behind
    ]
    near = sorted(near, key=lambda c: -c.counts)[:REFITTED]
    return near, [c for c in waiting if c not in near]


def _unsettled(now: _Model, candidates: Sequence[Candidate]) -> list[Unsettled]:
    """What was not fitted, where straight lines see it."""
    return [Unsettled(c.term, c.shifted(now.values)) for c in candidates]


def _little(candidate: Candidate) -> Candidate:
    """Little of it, beside parameters that are where they were."""
    size = candidate.term.size
    start = {**candidate.start, size: LITTLE * candidate.start[size]}
    return replace(candidate, start=start, shift={})


def _followed(now: _Model, candidate: Candidate) -> tuple[Begun, Fitted | None]:
    begun = _begun(now, candidate)
    return begun, begun.followed()


def _left(rough: Fitted | None) -> float:
    """F of a rough fit; infinite of none."""
    return np.inf if rough is None else rough.solution.objective


def _begun(now: _Model, candidate: Candidate) -> Begun:
    names = {u.name for u in now.solution.unknowns}
    fixed = {n: v for n, v in now.values.items() if n not in names}
    own = candidate.beside(sizes_by_name(now.records, now.solution))
    return begin(
        now.records, now.solution, (*now.taken, *candidate.terms),
        fixed={n: v for n, v in fixed.items() if all(n not in t.free for t in candidate.terms)},
        start={**candidate.shifted(now.values), **candidate.start}, own=own,
    )  # fmt: skip
