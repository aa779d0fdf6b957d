"""One round of the search for a better model: what is fitted, judged, and left to the next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.extended_terms import Term
from motorid.estimate.selection import forward_selection as forward
from motorid.estimate.selection.evidence import Evidence, Price
from motorid.estimate.selection.forward_selection import Trial
from motorid.estimate.selection.score_test import Candidate
from motorid.estimate.solver.allowance import Allowance
from tests.estimate.selection.test_forward_selection import (
    BAD,
    GOOD,
    REACH,
    UNSURE,
    WHITE,
    A,
    B,
    C,
    D,
    candidate,
    standing,
)

SMALL = replace(GOOD, gain=50.0)
WIDTH = 1  # responses of a set of derivatives


class Fits:
    """Instead of fits: each term's F when rough, its evidence, and by how much it moves R."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **each: tuple[float, Evidence, float]):
        self.each, self.begun, self.weighed = each, list[str](), list[str]()
        self.allowance = Allowance()
        monkeypatch.setattr(forward, "_begun", lambda _, c: self.begin(c.term.name))
        monkeypatch.setattr(forward, "weigh", self.weigh)
        monkeypatch.setattr(forward, "priced", lambda rough, _: Price(rough.F, 1, 0.0))

    def begin(self, name: str) -> Any:
        self.begun.append(name)
        self.spend(10)
        F = self.each[name.replace("-", "_")][0]
        rough = SimpleNamespace(F=F, solution=SimpleNamespace(objective=F))

        def nearly(_: Any) -> Any:
            self.spend(5)
            moves = self.each[name.replace("-", "_")][2]
            return SimpleNamespace(
                values={"R": 2.0 + moves, "K": 1.0}, terms=(name,), solution=None
            )

        return SimpleNamespace(followed=lambda: rough, nearly=nearly, name=name)

    def spend(self, responses: int) -> None:
        """As the engine does: what goes beyond the allowance ends."""
        self.allowance.count.responses += responses
        self.allowance.ends()

    def weigh(self, _f: Any, _t: Any, _s: Any, term: Term) -> Evidence:
        self.weighed.append(term.name)
        return self.each[term.name.replace("-", "_")][1]


def rounds(
    monkeypatch: pytest.MonkeyPatch, waiting: Sequence[Candidate], allowed: Allowance | None = None
) -> tuple[list[Trial], forward._Search]:
    monkeypatch.setattr(forward, "_asked", lambda *_: (list(waiting), [], WHITE))
    search = forward._Search(REACH, (), allowed or Allowance())
    now: Any = SimpleNamespace(values={"R": 2.0, "K": 1.0}, taken=(), solution=None, width=WIDTH)
    return [t for _, t in search.round(now)], search


def test_rivals_are_all_fitted_roughly_and_judged_from_the_best_until_one_earns(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits = Fits(
        monkeypatch, direction=(400.0, GOOD, 0.5), quadratic_load=(300.0, BAD, 0.5),
        cogging=(350.0, GOOD, -0.5),
    )  # fmt: skip
    waiting = [candidate(t, 100.0, R=1.0) for t in (A, B, C)]
    found, search = rounds(monkeypatch, waiting, fits.allowance)
    assert fits.begun == ["direction", "quadratic-load", "cogging"]
    assert [(t.term, t.earns) for t in found] == [(B, False), (C, True)]
    assert found[1].moves == pytest.approx(5.0)
    assert fits.allowance.spent == 3 * 10 + 2 * 5
    assert search.left_out == []


@pytest.mark.parametrize(
    ("counts", "R", "first"),
    [(49.0, 0.9, "cogging"), (51.0, 0.9, "direction"), (49.0, 1.1, "direction")],
)
def test_one_beside_which_another_counts_twice_as_much_and_moves_more_is_judged_behind(
    counts: float, R: float, first: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the noise that each leaves; by white noise it explains more."""
    fits = Fits(monkeypatch, direction=(200.0, GOOD, 0.5), cogging=(300.0, GOOD, 0.5))
    each = [
        replace(candidate(term, 100.0, R=moves), counts=much)
        for term, much, moves in ((A, counts, R), (C, 100.0, 1.0))
    ]
    monkeypatch.setattr(forward, "_rivals", lambda waiting, *_: (list(waiting), []))
    found, _ = rounds(monkeypatch, each)
    assert fits.weighed == [first]
    assert [t.earns for t in found] == [True]


def test_a_rough_fit_that_keeps_none_of_its_promise_is_not_finished(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits = Fits(monkeypatch, direction=(496.0, GOOD, 0.5), cogging=(494.0, BAD, 0.5))
    found, _ = rounds(monkeypatch, [candidate(t, 100.0, R=1.0) for t in (A, C)])
    assert fits.weighed == ["cogging"]
    assert [t.term for t in found] == [C]


def test_beside_one_that_is_unsure_the_rest_wait_for_the_next_round(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits = Fits(monkeypatch, direction=(300.0, UNSURE, 0.5), cogging=(200.0, GOOD, 0.5))
    waiting = [candidate(A, 100.0, R=1.0), candidate(C, 45.0, R=0.1)]
    found, _ = rounds(monkeypatch, waiting)
    assert [(t.term, t.earns) for t in found] == [(A, False)]
    assert fits.begun == ["direction"]


@pytest.mark.parametrize(
    ("evidence", "promise", "tried"),
    [(GOOD, 49.0, [A]), (GOOD, 49.6, [A, C, D]), (BAD, 4.0, [A, C, D])],
)
def test_beside_one_that_is_there_and_explains_more_than_the_rest_promise_they_wait(
    evidence: Evidence, promise: float, tried: list[Term], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It moves nothing, and would be lost beside what stands for it: friction that follows load."""
    Fits(
        monkeypatch, direction=(300.0, evidence, 0.0), cogging=(200.0, BAD, 0.5),
        brush_drop=(200.0, BAD, 0.5),
    )  # fmt: skip
    waiting = [candidate(A, 100.0, R=1.0), candidate(C, promise, R=0.1), candidate(D, 49.6, R=0.1)]
    found, _ = rounds(monkeypatch, waiting)
    assert sorted(t.term.name for t in found) == sorted(t.name for t in tried)


@pytest.mark.parametrize(
    ("pair", "evidence", "tried"),
    [((C, A), GOOD, [A]), ((C, A), BAD, [A, C]), ((A, C), GOOD, [A, C])],
)
def test_beside_what_the_first_may_only_stand_for_the_rest_wait_too(
    pair: tuple[Term, Term], evidence: Evidence, tried: list[Term], monkeypatch: pytest.MonkeyPatch
) -> None:
    standing(monkeypatch, pair)
    Fits(monkeypatch, direction=(200.0, evidence, 0.0), cogging=(300.0, GOOD, 0.5))
    found, _ = rounds(monkeypatch, [candidate(C, 100.0, R=1.0), candidate(A, 110.0, R=0.9)])
    assert [t.term for t in found] == tried


@pytest.mark.parametrize(
    ("pair", "likelier", "earns"),
    [
        ((A, C), replace(GOOD, gain=90.0, size=3.9), False),
        ((A, C), replace(GOOD, gain=55.0, size=3.9), True),  # no clearer than the first
        ((A, C), replace(GOOD, gain=90.0, size=1.9), True),  # there may be none of it
        ((C, A), replace(GOOD, gain=90.0, size=3.9), True),  # it explains something else
    ],
)
def test_what_stands_for_a_likelier_one_of_an_open_size_is_not_offered(
    pair: tuple[Term, Term], likelier: Evidence, earns: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windage is not, where friction that is higher at low speed explains the same and more."""
    standing(monkeypatch, pair)
    Fits(monkeypatch, direction=(300.0, SMALL, 0.5), cogging=(200.0, likelier, 0.0))
    found, _ = rounds(monkeypatch, [candidate(A, 100.0, R=1.0), candidate(C, 110.0, R=0.9)])
    assert [(t.term, t.earns) for t in found] == [(C, False), (A, earns)]
    assert found[1].goes_on


def test_when_the_responses_are_spent_the_others_are_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fits = Fits(monkeypatch, direction=(300.0, BAD, 0.5))
    fits.allowance.most = 16.0
    next_one = replace(candidate(C, 45.0, R=0.051), changes=(np.ones((1, 2)),))
    waiting = [candidate(A, 100.0, R=1.0), next_one, candidate(D, 40.0, R=0.04)]
    found, search = rounds(monkeypatch, waiting, fits.allowance)
    assert [t.term for t in found] == [A]
    assert search.left_out == [C]  # D moves too little to matter
    assert [one.term for one in search.untried] == [C]
    assert search.untried[0].values["R"] == pytest.approx(2.0 * math.exp(0.051 / 2.0))


@pytest.mark.parametrize(("most", "begun"), [(18.9, 1), (19.0, 2)])
def test_others_begin_as_long_as_four_sets_of_derivatives_are_left(
    most: float, begun: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fit costs 15 responses here; nothing that was tried was taken until a search says so."""
    fits = Fits(monkeypatch, direction=(300.0, BAD, 0.5), cogging=(300.0, BAD, 0.5))
    fits.allowance.most = most
    waiting = [candidate(A, 100.0, R=1.0), candidate(C, 45.0, R=0.1)]
    found, search = rounds(monkeypatch, waiting, fits.allowance)
    assert len(fits.begun) == begun
    assert [one.term for one in found] == [A]  # where the second begins, it is cut
    assert search.left_out == [C]
    assert not any(one.taken for one in found)


@pytest.mark.parametrize("most", [5.0, 12.0])
def test_a_fit_that_was_cut_is_no_trial_and_its_term_stays_open(
    most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While it was rough, or while it was judged; one that waits is left out with it."""
    fits = Fits(monkeypatch, direction=(300.0, GOOD, 0.5))
    fits.allowance.most = most
    waiting = [candidate(A, 100.0, R=1.0), candidate(C, 45.0, R=0.1)]
    found, search = rounds(monkeypatch, waiting, fits.allowance)
    assert (found, fits.begun, search.left_out) == ([], ["direction"], [A, C])
    assert [one.term for one in search.untried] == [A, C]
