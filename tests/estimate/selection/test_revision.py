"""Older terms looked at again: which stay, which go, which give way to another; on given fits."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.extended_terms import TERMS, Term
from motorid.estimate.selection import evidence, revision
from motorid.estimate.selection.evidence import Evidence, Price
from motorid.estimate.selection.revision import Revision
from motorid.estimate.selection.score_test import Candidate
from motorid.estimate.solver.allowance import Allowance
from motorid.estimate.solver.problem import Solution, Unknown

OLD, OTHER, LAST = TERMS["direction"], TERMS["quadratic-load"], TERMS["cogging"]
DROP, HEAT = TERMS["brush-drop"], TERMS["heating"]
GOOD, BAD = Evidence(99.0, 1.0, 20.0, 9.0), Evidence(9.0, 1.0, 20.0, 9.0)
WEIGHED, FITTED, WIDTH = 7, 5, 2  # responses: to weigh a term, to fit, of a set of derivatives


def fit(*terms: Term) -> Any:
    """As far as a revision looks at a fit."""
    free = tuple(n for t in terms for n in t.free)
    return SimpleNamespace(
        terms=terms, free=free, solution="solution", records=["record"], width=WIDTH,
        values=dict.fromkeys(free, 1.0),
    )  # fmt: skip


class Given:
    """Sizes of terms, evidence for them, and F of fits that would replace one."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **sizes: float) -> None:
        self.monkeypatch, self.sizes = monkeypatch, sizes
        self.evidence = dict[str, Evidence]()
        self.weighed, self.begun = list[tuple[str, ...]](), list[tuple[str, ...]]()
        self.paid, self.unknowns = dict[tuple[str, ...], float](), dict[tuple[str, ...], int]()
        self.screened, self.beside = list[Candidate](), list[Candidate]()
        for name in ("weigh", "size_of", "screen", "priced"):
            monkeypatch.setattr(revision, name, getattr(self, name))
        monkeypatch.setattr(revision, "_begun", self.begin)
        monkeypatch.setattr(revision, "plain", lambda *_: "white")

    def size_of(self, _s: Any, k: int, _shapes: Any) -> float:
        return self.sizes[self.free[k]]

    def of(
        self, fitted: Any, most: float = 1e9, but: tuple[Term, ...] = ()
    ) -> tuple[Any, Revision]:
        self.free, self.allowance = fitted.free, Allowance(most=most)
        looked = Revision(but, self.allowance)
        return looked.of(fitted), looked

    def spend(self, responses: int) -> None:
        """As the engine does: what goes beyond the allowance ends."""
        self.allowance.count.responses += responses
        self.allowance.ends()

    def weigh(self, _f: Any, rest: Any, _s: Any, term: Term) -> Evidence:
        self.weighed.append((term.name, *(t.name for t in rest)))
        self.spend(WEIGHED)
        return self.evidence[term.name]

    def begin(self, _f: Any, terms: Any, _candidate: Any = None) -> Any:
        names = tuple(t.name for t in terms)
        self.begun.append(names)
        rough = fit(*terms)
        self.spend(FITTED)
        return SimpleNamespace(
            roughly=lambda: rough, followed=lambda: rough, nearly=lambda one: one
        )

    def screen(self, *given: Any) -> list[Candidate]:
        taken, names = given[3:]
        if OLD in taken:
            return [c for c in self.beside if c.term.name in names]
        self.names = names
        return self.screened

    def priced(self, fitted: Any, _term: Term) -> Price:
        names = tuple(t.name for t in fitted.terms)
        return Price(self.paid[names], self.unknowns.get(names, 1), 10.0)


def candidate(term: Term, gain: float) -> Candidate:
    return Candidate(term, gain, {}, {})


def test_a_term_of_a_clear_size_is_not_asked_about(monkeypatch: pytest.MonkeyPatch) -> None:
    given = Given(monkeypatch, d_T0=12.1, T_c=0.0)
    given.screened = []
    given.paid = {("direction", "cogging"): 100.0}
    fitted = fit(OLD, LAST)
    found, looked = given.of(fitted)
    assert found is fitted
    assert given.weighed == []
    assert given.allowance.spent == FITTED  # of the fit without it
    assert looked.left_out == ()


@pytest.mark.parametrize(("weight", "kept"), [(GOOD, True), (BAD, False)])
def test_a_faint_one_stays_where_the_data_support_it_beside_the_others(
    weight: Evidence, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = Given(monkeypatch, d_T0=11.9, T_c=0.0)
    given.evidence = {"direction": weight}
    given.paid = {("direction", "cogging"): 100.0}
    found, looked = given.of(fit(OLD, LAST))
    assert given.weighed == [("direction", "cogging")]
    assert found.terms == ((OLD, LAST) if kept else (LAST,))
    assert given.allowance.spent == WEIGHED + FITTED
    assert given.allowance.kept == 0.0
    assert looked.left_out == ()


def test_another_takes_its_place_where_it_leaves_clearly_less(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = Given(monkeypatch, d_T0=20.0, T_c=0.0)
    given.screened = [candidate(OLD, 100.0), candidate(OTHER, 51.0), candidate(DROP, 60.0),
                      candidate(HEAT, 90.0), candidate(LAST, 99.0)]  # fmt: skip
    given.paid = {
        ("direction", "cogging"): 100.0, ("cogging", "quadratic-load"): 89.0,
        ("cogging", "brush-drop"): 88.0, ("cogging", "heating"): 1.0,
    }  # fmt: skip
    found, looked = given.of(fit(OLD, LAST))
    assert given.begun == [
        ("cogging",), ("direction", "cogging"),  # as roughly as those that may replace it
        ("cogging", "quadratic-load"), ("cogging", "brush-drop"),
    ]  # fmt: skip
    assert found.terms == (LAST, DROP)  # the better of the two that are tried
    assert given.allowance.spent == 4 * FITTED
    given.paid |= {("cogging", "quadratic-load"): 91.0, ("cogging", "brush-drop"): 90.5}
    same = fit(OLD, LAST)
    kept, looked = given.of(same)
    assert kept is same
    assert looked.possible == []


def test_about_as_good_with_fewer_unknowns_takes_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """A windage has one unknown, Stribeck friction two."""
    given = Given(monkeypatch, d_T0=20.0, T_c=0.0)
    given.screened = [candidate(OLD, 100.0), candidate(OTHER, 90.0)]
    given.paid = {("direction", "cogging"): 100.0, ("cogging", "quadratic-load"): 109.0}
    given.unknowns = {("direction", "cogging"): 2}
    found, looked = given.of(fit(OLD, LAST))
    assert found.terms == (LAST, OTHER)
    assert [one.term for one in looked.possible] == [OLD]
    given.paid["cogging", "quadratic-load"] = 111.0
    fitted = fit(OLD, LAST)
    kept, looked = given.of(fitted)
    assert kept is fitted
    assert looked.possible == []


@pytest.mark.parametrize(("beside", "replaced"), [(45.0, False), (44.0, True)])
def test_what_promises_as_much_beside_a_term_explains_something_else(
    beside: float, replaced: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A ripple that moves nothing took the place of a windage that moved B by a third."""
    given = Given(monkeypatch, d_T0=20.0, T_c=0.0)
    given.screened, given.beside = [candidate(HEAT, 90.0)], [candidate(HEAT, beside)]
    given.paid = {("direction", "cogging"): 100.0, ("cogging", "heating"): 1.0}
    found, _ = given.of(fit(OLD, LAST))
    assert (found.terms == (LAST, HEAT)) is replaced


@pytest.mark.parametrize(("paid", "possible"), [(51.0, True), (49.0, False)])
def test_a_term_that_gives_way_to_a_little_better_one_stays_possible(
    paid: float, possible: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It explains 100: half of that more than it does would refute it."""
    given = Given(monkeypatch, d_T0=20.0, T_c=0.0)
    given.screened = [candidate(OLD, 100.0), candidate(HEAT, 90.0)]
    given.paid = {("direction", "cogging"): 100.0, ("cogging", "heating"): paid}
    fitted = fit(OLD, LAST)
    found, looked = given.of(fitted)
    assert found.terms == (LAST, HEAT)
    expected = [(OLD, fitted.values)] if possible else []
    assert [(one.term, one.values) for one in looked.possible] == expected


def test_a_rival_must_promise_half_of_what_the_term_does(monkeypatch: pytest.MonkeyPatch) -> None:
    given = Given(monkeypatch, d_T0=20.0, T_c=0.0)
    given.screened = [candidate(OLD, 100.0), candidate(OTHER, 49.0)]
    given.paid = {("direction", "cogging"): 100.0, ("cogging", "quadratic-load"): 1.0}
    fitted = fit(OLD, LAST)
    assert given.of(fitted)[0] is fitted
    given.screened = [candidate(OTHER, 1.0)]  # nothing of its own is left
    assert given.of(fitted)[0].terms == (LAST, OTHER)


def test_what_is_not_looked_for_is_not_screened(monkeypatch: pytest.MonkeyPatch) -> None:
    given = Given(monkeypatch, d_T0=20.0, T_c=0.0)
    given.paid = {("direction", "cogging"): 100.0}
    given.of(fit(OLD, LAST), but=(DROP,))
    assert "brush-drop" not in given.names
    assert "cogging" not in given.names
    assert "quadratic-load" in given.names


def test_where_the_responses_are_spent_nothing_is_exchanged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = Given(monkeypatch, d_T0=3.0, T_lc=20.0, T_c=0.0)
    given.evidence = {"direction": GOOD}
    fitted = fit(OLD, OTHER, LAST)
    found, looked = given.of(fitted, most=12.0)  # half of it is for the search
    assert (found, given.begun, given.allowance.spent) == (fitted, [], WEIGHED)
    assert looked.left_out == (OLD, OTHER)


@pytest.mark.parametrize(
    ("most", "begun", "left"),
    [(11.9, 0, (OLD,)), (12.0, 2, (OLD,)), (30.0, 3, (OLD,)), (31.0, 3, ())],
)
def test_what_was_cut_changes_nothing_and_is_told(
    most: float, begun: int, left: tuple[Term, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """None begins with less than three sets of derivatives in its half of what is left."""
    given = Given(monkeypatch, d_T0=20.0, T_c=0.0)
    given.screened = [candidate(OLD, 100.0), candidate(OTHER, 90.0)]
    given.paid = {("direction", "cogging"): 100.0, ("cogging", "quadratic-load"): 1.0}
    fitted = fit(OLD, LAST)
    found, looked = given.of(fitted, most=most)
    assert (len(given.begun), looked.left_out) == (begun, left)
    assert (found is fitted) is bool(left)


def test_a_term_that_was_not_weighed_to_the_end_is_not_dropped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = Given(monkeypatch, d_T0=3.0, T_c=0.0)
    given.evidence = {"direction": BAD}
    for most, begun in ((14.0, 0), (20.0, 1)):  # the second in the fit without it
        given.begun.clear()
        fitted = fit(OLD, LAST)
        found, looked = given.of(fitted, most=most)
        assert found is fitted
        assert (len(given.begun), looked.left_out) == (begun, (OLD,))


def test_a_fit_without_a_term_begins_without_its_parameters(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: dict[str, Any] = {}
    monkeypatch.setattr(revision, "begin", lambda *a, **k: asked.update(k, terms=a[2]))
    monkeypatch.setattr(revision, "sizes_by_name", lambda *_: [{"own": 1.0}])
    values = {"R": 2.0, "J": 3.0, "d_T0": 0.1, "T_c": 5.0, "N_c": 7.0, "B": 0.0}
    fitted: Any = SimpleNamespace(
        terms=(OLD, LAST), free=("R", "J", "d_T0", "T_c"), values=values, records=(), solution=None
    )
    revision._begun(fitted, (OLD,))
    assert asked["start"] == {"R": 2.0, "J": 3.0, "d_T0": 0.1, "B": 0.0}
    assert asked["fixed"] == {"B": 0.0}
    assert asked["own"] == [{"own": 1.0}]
    more = Candidate(OTHER, 9.0, {}, {"T_lc": 4.0}, ({"phase": 2.0},))
    revision._begun(fitted, (OLD, OTHER), more)
    assert asked["start"] == {"R": 2.0, "J": 3.0, "d_T0": 0.1, "B": 0.0, "T_lc": 4.0}
    assert asked["own"] == [{"own": 1.0, "phase": 2.0}]


# sizes and prices of solutions


def solution(objective: float = 100.0) -> Solution:
    return Solution(
        (Unknown("a", 1.0), Unknown("b", 1.0, log=True)), np.array([0.3, 2.0]), (), (),
        np.diag([400.0, 100.0]), np.zeros(2, dtype=bool), tuple, objective, 1, True,
    )  # fmt: skip


def test_a_price_is_f_and_schwarzs_cost_of_each_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence, "inflation", lambda _: 2.0)
    block = SimpleNamespace(count=300.0)
    line: Any = SimpleNamespace(blocks=[block, block], residual=np.zeros(1), slices=())
    rough: Any = SimpleNamespace(
        solution=SimpleNamespace(objective=50.0, records=[line]), records=["one", "two"]
    )
    each = 2.0 * np.log(600.0 / 2.0)
    shared = evidence.priced(rough, OTHER)
    assert shared.unknowns == 1
    assert shared.paid == pytest.approx(50.0 + each)
    assert shared.open == pytest.approx(2.0 * evidence.MARGIN)
    phased = evidence.priced(rough, LAST)  # a phase of each record
    assert phased.unknowns == 3
    assert phased.paid == pytest.approx(50.0 + 3 * each)


def weighed(
    monkeypatch: pytest.MonkeyPatch, gain: float, sizes: tuple[float, float], records: int = 1,
    left_out: tuple[float, float] = (0.0, 0.0), moved: float = 0.0,
) -> Evidence:  # fmt: skip
    """``moved``: variance that noise of the voltage adds to the size, of what it had."""
    wider = SimpleNamespace(
        solution=SimpleNamespace(own=[np.zeros(2)] * records), free=("R", *DROP.free),
        records=["record"] * records,
    )  # fmt: skip
    null = SimpleNamespace(
        solution=SimpleNamespace(own=[np.zeros(1)] * records), free=("R",),
    )  # fmt: skip
    asked: list[int] = []

    def found(_w: Any, _n: Any, more: int) -> Evidence:
        asked.append(more)
        return Evidence(gain, 2.0, 20.0)

    def size_of(_s: Any, k: int, shapes: Any = ()) -> float:
        assert k == 1
        assert list(shapes) in ([], [2])
        return sizes[bool(len(shapes))]

    def less(found: Evidence, of: Any, k: int, held: Any) -> Evidence:
        assert (of, k) == (wider, 1)
        assert held == ([2] if sizes[False] <= 4.0 and found.exceeds else [])
        return replace(found, inflation=found.inflation * (1.0 + moved))

    monkeypatch.setattr(evidence, "_less_by_input_noise", less)
    monkeypatch.setattr(evidence, "_nested", lambda *_: null)
    monkeypatch.setattr(evidence, "evidence", found)
    monkeypatch.setattr(evidence, "size_of", size_of)
    unseen = {id(null.solution): left_out[0], id(wider.solution): left_out[1]}
    foretold = lambda gain, a, b: gain - unseen[id(a)] + unseen[id(b)]  # noqa: E731
    monkeypatch.setattr(evidence, "foretold", foretold)
    weigh: Any = evidence.weigh
    out = weigh(wider, (), None, DROP)
    assert asked == [2 + records]  # two shared, and one of each record
    return out


def test_a_size_that_its_shape_leaves_open_is_taken_at_that_shape_where_much_is_gained(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert weighed(monkeypatch, 300.0, (4.1, 50.0)).size == 4.1
    assert weighed(monkeypatch, 201.0, (3.9, 50.0)).size == 50.0
    assert weighed(monkeypatch, 199.0, (3.9, 50.0)).size == 3.9


def test_captures_are_left_out_where_there_are_several_and_it_suffices(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert weighed(monkeypatch, 300.0, (9.0, 9.0)).left_out is None
    several = weighed(monkeypatch, 300.0, (9.0, 9.0), 3, (70.0, 55.0))
    assert several.left_out == pytest.approx(315.0)  # of the gain, with what each gives up
    assert weighed(monkeypatch, 30.0, (9.0, 9.0), 3, (70.0, 55.0)).left_out is None


def test_what_noise_of_the_voltage_moves_too_must_suffice_without_that(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a gain of 300 in an inflation of 2 a seventh is left, and 20 are needed."""
    for moved, suffices in ((6.4, True), (6.6, False)):
        found = weighed(monkeypatch, 300.0, (9.0, 9.0), 3, (70.0, 55.0), moved)
        assert found.counted == pytest.approx(150.0 / (1.0 + moved))
        assert (found.suffices, found.left_out is not None) == (suffices, suffices)
