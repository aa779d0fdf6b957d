"""Which terms are fitted, which of them goes on, and when a search ends: on fits that are given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.extended_terms import TERMS, Term
from motorid.estimate.selection import forward_selection as forward
from motorid.estimate.selection.evidence import Evidence, Price
from motorid.estimate.selection.forward_selection import Trial
from motorid.estimate.selection.score_test import Candidate
from motorid.estimate.selection.trigger import largest_move, matters
from motorid.estimate.solver.allowance import Allowance
from tests.estimate.selection.noted_stages import noting

NAMES = ("direction", "quadratic-load", "cogging", "brush-drop")
A, B, C, D = (TERMS[name] for name in NAMES)
GOOD, BAD = Evidence(99.0, 1.0, 20.0, 9.0), Evidence(9.0, 1.0, 20.0, 9.0)
UNSURE = Evidence(303.0, 3.0, 20.0, 3.9)  # explains five times what it costs, of an open size
REACH = {"R": 0.1, "K": 2.0}
WHITE: Any = SimpleNamespace(objective=500.0)


def candidate(term: Term, gain: float = 100.0, **shift: float) -> Candidate:
    return Candidate(term, gain, shift, {term.size: 1.0}, counts=gain)


def trial(term: Term, moves: float = 2.0, evidence: Evidence = GOOD) -> Trial:
    return Trial(term, (), evidence, moves)


def test_a_term_earns_its_place_where_the_data_support_it_and_it_matters() -> None:
    assert trial(A).earns
    assert not trial(A, moves=1.0).earns
    assert not trial(A, evidence=BAD).earns
    assert trial(A, moves=0.0).goes_on
    assert not trial(A, evidence=BAD).goes_on
    assert trial(A, evidence=UNSURE).goes_on
    assert not trial(A, evidence=UNSURE).earns
    assert not trial(A, evidence=replace(UNSURE, gain=299.0)).goes_on
    assert trial(A, evidence=replace(UNSURE, size=9.0, left_out=-1.0)).goes_on  # they disagree
    assert not trial(A, evidence=replace(UNSURE, size=2.0)).goes_on  # there may be none of it
    assert not GOOD.unsure


def test_a_move_counts_in_units_of_what_matters() -> None:
    one = candidate(A, R=-0.03, K=0.5, L=9.0)
    assert largest_move(one, REACH) == pytest.approx(0.3)
    assert largest_move(candidate(A), REACH) == 0.0
    assert not matters(candidate(A, R=0.05), REACH)  # half of what matters
    assert matters(candidate(A, R=0.051), REACH)


def test_the_search_goes_on_beside_what_earns_its_place_or_hides_others() -> None:
    fits = [SimpleNamespace(name=n) for n in "abc"]
    harmless = trial(A, moves=0.1, evidence=Evidence(50.0, 1.0, 20.0, 9.0))
    gains = trial(B, moves=0.1, evidence=Evidence(70.0, 1.0, 20.0, 9.0))
    found: list[Any] = list(zip(fits, [harmless, trial(C), gains], strict=True))
    assert forward._next(found) == found[1]
    assert forward._next([found[0], found[2]]) == found[2]
    assert forward._next([found[2], found[0]]) == found[2]
    assert forward._next([(fits[0], trial(A, evidence=BAD))]) is None
    assert forward._next([]) is None


def standing(monkeypatch: pytest.MonkeyPatch, *pairs: tuple[Term, Term]) -> None:
    """The first of each pair may only stand for the second."""
    monkeypatch.setattr(
        forward, "_stands_for", lambda one, other, _: (one.term, other.term) in pairs
    )


@pytest.mark.parametrize(
    ("gain", "left", "stands"),
    [(101.0, 49.0, True), (101.0, 51.0, False), (99.0, 0.0, False)],
)
def test_one_stands_for_another_that_explains_more_and_most_of_what_it_promises(
    gain: float, left: float, stands: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def beside(*given: Any) -> float:
        seen.append(given)
        return left

    monkeypatch.setattr(forward, "beside", beside)
    lines = (np.zeros((1, 2)),)
    one, other = (replace(candidate(t, g), changes=lines) for t, g in ((A, 100.0), (B, gain)))
    assert forward._stands_for(one, other, WHITE) is stands
    assert all(given == (one, other, WHITE) for given in seen)
    assert not forward._stands_for(one, candidate(B, 900.0), WHITE)  # of no straight line
    assert not forward._stands_for(candidate(A, 1.0), other, WHITE)


def test_rivals_explain_and_move_much_the_same_as_the_first() -> None:
    first = candidate(A, 100.0, R=0.2)
    near = candidate(B, 50.0, R=0.041)
    weak, still = candidate(C, 49.0, R=0.2), candidate(D, 90.0, R=0.039)
    rivals, rest = forward._rivals([first, weak, near, still], REACH)
    assert [c.term for c in rivals] == [A, B]
    assert [c.term for c in rest] == [C, D]
    stronger = candidate(C, 300.0, R=0.051)
    harmless, other = candidate(D, 200.0, R=0.03), candidate(B, 200.0, R=0.03)
    waiting = [candidate(A, 100.0, R=0.9), stronger, other, harmless]
    rivals, rest = forward._rivals(waiting, REACH, [D])
    assert [c.term for c in rivals] == [C, D, A]
    assert [c.term for c in rest] == [B]


def test_rivals_count_by_what_is_foreseen_in_the_noise_that_they_leave() -> None:
    """One that explains more of what wanders, which white noise takes for much, waits."""
    first, wandering = candidate(A, 600.0, R=0.9), candidate(B, 1400.0, R=0.5)
    weaker = candidate(C, 100.0, R=0.3)
    counts = {A: 480.0, B: 80.0, C: 250.0}
    each = [replace(c, counts=counts[c.term]) for c in (first, wandering, weaker)]
    rivals, rest = forward._rivals(each, REACH)
    assert [c.term for c in rivals] == [A, C]
    assert [c.term for c in rest] == [B]


def test_three_rivals_at_most_and_those_that_promise_most() -> None:
    each = [candidate(t, g, R=1.0) for t, g in zip((A, B, C, D), (60, 90, 100, 80), strict=True)]
    rivals, rest = forward._rivals(each, REACH)
    assert [c.term for c in rivals] == [C, B, D]
    assert [c.term for c in rest] == [A]


def test_a_fit_begins_where_straight_lines_see_its_parameters() -> None:
    values = {"R": 2.0, "K": 0.5, "T0": 0.0}
    lines = Candidate(A, 9.0, {"R": 1.0, "K": -4.0, "T0": 3.0}, {}, (), (np.zeros((1, 2)),))
    found = lines.shifted(values)
    assert found["R"] == pytest.approx(2.0 * np.exp(0.5))
    assert found["K"] == pytest.approx(0.5 / np.e)  # by a factor of e at most
    assert found["T0"] == 0.0
    assert candidate(A, R=1.0).shifted(values) == values  # no straight line
    assert values["R"] == 2.0


def asked(
    monkeypatch: pytest.MonkeyPatch, screened: Sequence[Candidate], foreseen: Sequence[Term],
    but: Sequence[Term] = (),
) -> list[Term]:  # fmt: skip
    names: list[Sequence[str]] = []

    def screen(*arguments: Any) -> list[Candidate]:
        names.append(arguments[-1])
        return list(screened)

    monkeypatch.setattr(forward, "plain", lambda *_: WHITE)
    monkeypatch.setattr(forward, "screen", screen)
    monkeypatch.setattr(forward, "springs", lambda *_: [])
    monkeypatch.setattr(forward, "_foreseen", lambda _n, _w, c: GOOD if c.term in foreseen else BAD)
    now: Any = SimpleNamespace(records=(), solution=None, values={}, taken=())
    found, half, white = forward._asked(now, REACH, but)
    assert (half, white) == ([], WHITE)
    assert not {b.name for b in but} & set(names[0])
    return [c.term for c in found]


def test_what_promises_enough_and_matters_is_asked_for_the_largest_move_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    each = [candidate(A, 5.1, R=0.06), candidate(B, 4.9, R=0.9), candidate(C, 40.0, R=0.2)]
    assert asked(monkeypatch, each, [A, B, C]) == [C, A]
    small = [candidate(A, 900.0, R=0.01), candidate(B, 1001.0, R=0.01)]
    assert asked(monkeypatch, small, [A, B]) == [B]  # a gross one is fitted whatever it moves
    assert asked(monkeypatch, each, [A, B, C], [D]) == [C, A]


def test_what_something_that_matters_may_only_stand_for_is_asked_for_whatever_it_moves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As windage does for friction at low speed."""
    each = [candidate(A, 14.0, R=0.2), candidate(B, 26.0, R=0.01), candidate(C, 26.0, R=0.01)]
    standing(monkeypatch, (A, B), (B, C))
    assert asked(monkeypatch, each, [A, B, C]) == [A, B]
    assert asked(monkeypatch, each, [B, C]) == []  # beside none that matters


def test_what_a_harmless_one_may_hide_is_a_reason_to_fit_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """C matters, and no fit is foreseen to support it yet."""
    each = [candidate(A, 40.0, R=0.01), candidate(C, 40.0, R=0.2)]
    assert asked(monkeypatch, each, [A]) == [A]
    assert asked(monkeypatch, each[:1], [A]) == []
    assert asked(monkeypatch, [each[0], candidate(C, 29.0, R=0.2)], [A]) == []


@pytest.mark.parametrize(
    ("gain", "R", "foreseen", "first"),
    [(81.0, 0.2, [A, B], True), (80.0, 0.2, [A, B], False), (81.0, 0.04, [A, B], False),
     (81.0, 0.2, [B], False)],
)  # fmt: skip
def test_two_that_hide_each_other_are_asked_for_first(
    gain: float, R: float, foreseen: list[Term], first: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They explain more than twice what any one explains, and matter."""
    both = replace(candidate(A, gain, R=R), companion=C)
    seen: list[Any] = []
    monkeypatch.setattr(forward, "pair", lambda *of: seen.append(of) or both)
    each = [candidate(B, 40.0, R=0.2), candidate(C, 9.0, R=0.01)]
    found = asked(monkeypatch, each, foreseen)
    assert found == ([A, B] if first else [B])
    assert seen == [(each, WHITE)]


def test_two_terms_are_fitted_at_once_and_the_last_judged_beside_its_companion(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    rough: Any = SimpleNamespace(solution=SimpleNamespace(objective=1.0))
    fitted: Any = SimpleNamespace(values={"R": 2.3, "K": 1.0})
    begun: Any = SimpleNamespace(followed=lambda: rough, nearly=lambda _: fitted)
    noting(monkeypatch, forward, seen, begin=begun, weigh=GOOD, priced=Price(1.0, 2, 1.0),
           sizes_by_name=[])  # fmt: skip
    held: Any = SimpleNamespace(name="R")
    values, solution = {"R": 2.0, "K": 1.0, "J": 4.0}, SimpleNamespace(unknowns=[held])
    now: Any = SimpleNamespace(records=(), solution=solution, values=values, taken=(D,))
    both = replace(candidate(A), companion=C)
    search = forward._Search(REACH, (), Allowance())
    ((_, found),) = search._compared(now, [both], 10.0)
    assert seen["begin"][0][:3] == ((), now.solution, (D, C, A))
    assert seen["priced"] == [(rough, C, A)]
    assert seen["weigh"] == [(fitted, (D, C), now.solution, A)]
    assert replace(found, moves=0.0) == Trial(A, (D, C), GOOD, 0.0)
    assert found.moves == pytest.approx(3.0)


def test_what_has_no_straight_lines_cannot_be_foreseen() -> None:
    now: Any = None
    assert forward._foreseen(now, now, candidate(A)).supports


@pytest.mark.parametrize(
    ("evidence", "fitted", "half"),
    [
        (GOOD, True, False), (BAD, False, False), (UNSURE, True, False),
        (replace(UNSURE, gain=121.0), False, True),  # twice enough, and two deviations
        (replace(UNSURE, gain=119.0), False, False),
        (replace(UNSURE, gain=121.0, size=1.9), False, False),
    ],
)  # fmt: skip
def test_a_fit_is_asked_where_what_is_lacking_leaves_a_size_open(
    evidence: Evidence, fitted: bool, half: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that is half supported has its say by straight lines."""
    lines = replace(candidate(A, R=0.2), changes=(np.zeros((1, 2)),))
    monkeypatch.setattr(forward, "plain", lambda *_: WHITE)
    monkeypatch.setattr(forward, "screen", lambda *_: [lines])
    monkeypatch.setattr(forward, "springs", lambda *_: [])
    monkeypatch.setattr(forward, "foresee", lambda *_: evidence)
    now: Any = SimpleNamespace(records=(), solution=None, values={"R": 2.0}, taken=())
    asked, possible, _ = forward._asked(now, REACH, ())
    assert ([c.term for c in asked], [c.term for c in possible]) == ([A][:fitted], [A][:half])


def test_derivatives_take_a_response_for_each_unknown_of_every_record() -> None:
    records: Any = [SimpleNamespace(unknowns=range(n)) for n in (3, 9, 5)]
    solution: Any = SimpleNamespace(unknowns=("R", "L"))
    assert forward._Model(records, solution, {}).width == 3 * (1 + 2) + 3 + 9 + 5


@pytest.mark.parametrize(("took", "end"), [(0, 416), (208, 416), (209, 418)])
def test_for_the_end_of_a_fit_twice_is_kept_what_judging_it_took(took: int, end: int) -> None:
    """16 sets of derivatives at least: of 26 responses here."""
    records: Any = [SimpleNamespace(unknowns=range(n)) for n in (3, 9, 5)]
    solution: Any = SimpleNamespace(unknowns=("R", "L"))
    assert forward._Model(records, solution, {}, (), took).end == end


def needing(_: Any, fitted: Any, _companions: Any, _reach: Any) -> Any:
    """Every term of a model is of use."""
    return fitted


def selected(
    monkeypatch: pytest.MonkeyPatch, *each: Sequence[tuple[Term, float, Evidence]],
    lean: Any = needing,
) -> tuple[forward.Selection, list[Any]]:  # fmt: skip
    """What is selected where the rounds give these trials; and what each was added to."""
    left, seen = list(each), []

    def one_round(_: Any, now: Any) -> Any:
        seen.append(now.taken)
        found = []
        for term, moves, evidence in left.pop(0) if left else ():
            terms = (*now.taken, term)
            fitted = SimpleNamespace(
                records=(), solution=None, values={}, terms=terms, took=0, width=10
            )
            found.append((fitted, Trial(term, now.taken, evidence, moves)))
        return found

    monkeypatch.setattr(forward._Search, "round", one_round)
    monkeypatch.setattr(forward._Model, "width", 10)
    monkeypatch.setattr(forward.Revision, "of", lambda _, fitted: fitted)
    monkeypatch.setattr(forward.Revision, "lean", lean)
    nothing: Any = None
    return forward.select([], nothing, {}, REACH), seen


def test_terms_are_taken_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    found, seen = selected(monkeypatch, [(A, 2.0, GOOD)], [(B, 2.0, BAD), (C, 3.0, GOOD)])
    assert [s.terms for s in found.stages] == [(A,), (A, C)]
    assert seen == [(), (A,), (A, C)]
    assert [(t.term, t.taken) for t in found.trials] == [(A, True), (B, False), (C, True)]


def test_one_that_moves_nothing_is_part_of_the_answer_only_beside_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found, _ = selected(monkeypatch, [(A, 0.1, GOOD)], [(C, 3.0, GOOD)])
    assert [s.terms for s in found.stages] == [(A, C)]
    assert [t.taken for t in found.trials] == [True, True]
    alone, seen = selected(monkeypatch, [(A, 0.1, GOOD)], [(C, 3.0, BAD)])
    assert alone.stages == ()
    assert not any(t.taken for t in alone.trials)
    assert seen == [(), (A,)]


def test_the_last_model_is_looked_at_for_what_moved_nothing_and_is_of_no_use(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []

    def lean(looked: Any, fitted: Any, companions: Any, reach: Any) -> Any:
        seen.append((fitted.terms, list(companions), reach, looked.allowance.kept))
        return SimpleNamespace(terms=(C,))

    rounds = ([(A, 0.1, GOOD)], [(C, 3.0, GOOD)])
    found, _ = selected(monkeypatch, *rounds, lean=lean)
    assert [s.terms for s in found.stages] == [(C,)]
    assert [t.taken for t in found.trials] == [False, True]
    assert seen == [((A, C), [A], REACH, 160.0)]  # of which the end of its fit is kept
    selected(monkeypatch, [(A, 2.0, GOOD)], lean=lean)
    assert len(seen) == 1


def test_what_is_supported_beyond_the_answer_is_kept_beside_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def terms(*each: Sequence[tuple[Term, float, Evidence]]) -> Any:
        harmless = selected(monkeypatch, *each)[0].harmless
        return None if harmless is None else harmless.terms

    assert terms([(A, 0.1, GOOD)], [(C, 3.0, BAD)]) == (A,)
    assert terms([(A, 0.1, GOOD)], [(C, 0.1, GOOD)]) == (A, C)
    assert terms([(A, 0.1, GOOD)], [(C, 3.0, GOOD)]) is None  # it is part of the answer
    assert terms([(A, 3.0, GOOD)], [(C, 0.1, GOOD)]) == (A, C)
    assert terms([(A, 0.1, GOOD)], [(C, 0.1, UNSURE)]) == (A,)
    assert terms([(A, 0.1, UNSURE)]) is None
    small = replace(GOOD, gain=50.0)
    assert terms([(A, 0.1, small), (C, 0.1, UNSURE)]) is None  # the search goes on beside the other
    assert terms([(C, 0.1, small), (A, 0.1, GOOD)], [(B, 3.0, BAD)]) == (A,)


def test_a_search_has_five_rounds_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    _, seen = selected(monkeypatch, *[[(A, 2.0, GOOD)]] * 9)
    assert len(seen) == forward.ROUNDS
