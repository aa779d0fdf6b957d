"""What is asked of straight lines before a term is fitted: unknowns, noise and price."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.model.extended_terms import ADDED, TERMS, Term
from motorid.estimate.selection import predicted_gain
from motorid.estimate.selection.evidence import Evidence
from motorid.estimate.selection.extended_fit import begin
from motorid.estimate.selection.score_test import Candidate
from motorid.estimate.solver.allowance import opened
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Unknown
from tests.estimate.effects.benches import FAULHABER
from tests.estimate.uncertainty.test_budget import fitted

LOG = Unknown("R", 1.0, log=True, prior_mean=0.5, prior_sd=0.2)
LINEAR = Unknown("B", 1.0, lower=0.0, scale=3.0, prior_mean=4.0, prior_sd=0.1)


def candidate(term: Term, rows: tuple[int, ...] = (1, 1)) -> Candidate:
    return Candidate(term, 1.0, {}, {}, changes=tuple(np.ones((n, 5)) for n in rows))


def test_parameters_move_from_where_they_are_to_their_bounds() -> None:
    plain: Any = SimpleNamespace(unknowns=(LOG, LINEAR), values=np.array([np.e, 2.0]))
    one, other = predicted_gain._moves(plain)
    assert (one.name, one.start, one.lower, one.log) == ("R", 0.0, -np.inf, False)
    assert (one.prior_mean, one.prior_sd) == (pytest.approx(0.5 - 1.0), 0.2)
    assert (other.name, other.start, other.lower, other.scale) == ("B", 0.0, -2.0, 3.0)
    assert (other.prior_mean, other.prior_sd) == (2.0, 0.1)


@pytest.mark.parametrize("name", TERMS)
def test_a_size_is_not_below_nothing_where_the_term_is_not(name: str) -> None:
    term = TERMS[name]
    sizes = predicted_gain._sizes(candidate(term, (2, 2)))
    assert all(one.start == 0.0 for one in sizes)
    if term.per_turn:  # every record has its own, each with a phase
        assert len(sizes) == 4
        assert all(one.lower == -np.inf for one in sizes)
    else:
        (size,) = sizes
        assert size.lower == (0.0 if ADDED[term.size].lower == 0.0 else -np.inf)


def test_a_companions_size_comes_behind_the_terms_own() -> None:
    both = replace(candidate(TERMS["direction"], (2, 2)), companion=TERMS["load-friction"])
    own, other = predicted_gain._sizes(both)
    assert (own.name, own.lower) == ("d_T0", -np.inf)
    assert (other.name, other.lower) == ("c_load", 0.0)


class Foreseen:
    """Instead of searches: notes with which unknowns, and in which noise."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, coloured: bool, wanders: bool, gain: float
    ) -> None:
        self.searched: list[tuple[int, bool]] = []
        self.white, self.more, self.sized = True, 0, list[int]()
        self.coloured, self.wanders = coloured, wanders
        monkeypatch.setattr(predicted_gain, "_straight", lambda *_: "straight")
        monkeypatch.setattr(predicted_gain, "_moves", lambda _: [LOG, LINEAR])
        monkeypatch.setattr(predicted_gain, "_maximum", self.maximum)
        monkeypatch.setattr(predicted_gain.prewhitening, "whiten", self.whiten)
        monkeypatch.setattr(predicted_gain.prewhitening, "thin", lambda *_: wanders)
        monkeypatch.setattr(predicted_gain, "evidence", self.evidence)
        monkeypatch.setattr(predicted_gain, "size_of", lambda _, k: self.sized.append(k) or 7.0)
        self.gain = gain

    def whiten(self, *_: Any) -> bool:
        self.white = not (self.coloured or self.wanders)
        return self.coloured

    def maximum(self, unknowns: Any, _straight: Any, _plain: Any) -> tuple[int, bool]:
        self.searched.append((len(unknowns), self.white))
        return self.searched[-1]

    def evidence(self, wider: Any, narrower: Any, more: int) -> Evidence:
        self.more, self.judged = more, (wider, narrower)
        return Evidence(self.gain, 1.0, 10.0)

    def of(self, term: Term) -> Evidence:
        records: Any = [None, None]
        return predicted_gain.foresee(records, None, candidate(term))  # type: ignore[arg-type]


@pytest.mark.parametrize(("coloured", "wanders"), [(True, False), (False, True), (False, False)])
def test_both_fits_are_judged_in_the_noise_that_the_term_would_leave(
    coloured: bool, wanders: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = Foreseen(monkeypatch, coloured, wanders, gain=30.0)
    found = seen.of(TERMS["direction"])
    white = not (coloured or wanders)
    assert seen.judged == ((3, white), (2, white))
    assert len(seen.searched) == (2 if white else 3)
    assert found.size == 7.0
    assert seen.sized == [2]  # the first after the parameters


@pytest.mark.parametrize("name", ["direction", "brush-drop", "heating", "cogging", "ripple"])
def test_a_term_pays_for_what_it_adds_and_for_a_phase_in_each_capture(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    term = TERMS[name]
    seen = Foreseen(monkeypatch, False, False, gain=9.0)
    found = seen.of(term)
    assert seen.more == len(term.free) + (2 if term.phase else 0)
    assert found.size == np.inf  # it does not pay: no size is asked for
    assert seen.sized == []
    Foreseen(monkeypatch, False, False, gain=30.0)
    assert (seen.of(term).size == np.inf) is bool(term.per_turn)


def test_a_search_over_straight_lines_simulates_no_motor() -> None:
    """Whether derivatives are lent to it or taken anew, and with however many sizes."""
    narrow, six = fitted("measured")
    start = {"R": FAULHABER["R"], "T_lc": 1e-10}
    wide = begin(narrow, six, [TERMS["quadratic-load"]], fixed={}, start=start).roughly()
    records, white = wide.records, plain(wide.records, wide.solution)
    assert records[0].standing.takes_several
    rng = np.random.default_rng(2)
    size = len(white.records[0].residual)
    many = Candidate(TERMS["ripple"], 1.0, {}, {}, changes=(rng.standard_normal((4, size)),))
    straight = [predicted_gain._straight(records[0], white, many, 0)]
    before = straight[0].simulated
    unknowns = [*predicted_gain._moves(white), *predicted_gain._sizes(many)]
    lent = predicted_gain._maximum(unknowns, straight, white)
    anew = maximise(unknowns, straight, enough=predicted_gain.ENOUGH)
    assert anew.objective == pytest.approx(lent.objective, abs=0.1)
    with opened() as allowance:
        allowance.most = 0.0
        ended = predicted_gain._maximum(unknowns, straight, white)
    assert ended.objective == lent.objective  # it takes nothing of what has ended
    assert not allowance.ended
    assert straight[0].simulated == before
