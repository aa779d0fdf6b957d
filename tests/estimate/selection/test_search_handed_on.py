"""What the search for terms hands on: fits, noise, sizes and what was spent; on given fits."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.selection import forward_selection as forward
from motorid.estimate.selection import revision, score_test
from motorid.estimate.selection.evidence import Evidence, Price
from motorid.estimate.selection.forward_selection import Trial
from motorid.estimate.selection.score_test import Candidate
from motorid.estimate.selection.unsettled_models import Unsettled
from motorid.estimate.solver.allowance import Allowance
from tests.estimate.selection.noted_stages import noting
from tests.estimate.solutions import MOTOR, solution

SIDED, LOAD, COGS, TWO = (
    TERMS[name] for name in ("direction", "quadratic-load", "cogging", "two-masses")
)
GOOD = Evidence(99.0, 1.0, 20.0, 9.0)


def candidate(term: Any, gain: float = 100.0, **shift: float) -> Candidate:
    return Candidate(term, gain, shift, {term.size: 1.0}, counts=gain)


# a search


def test_a_search_looks_beside_what_the_solution_has_as_far_as_one_allowance_goes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The end of the fit that is offered, 16 sets of derivatives, is kept while it looks."""
    seen: list[Any] = []
    allowance = Allowance(most=1000.0)
    allowance.kept = 7.0

    class Search:
        def __init__(self, *given: Any) -> None:
            seen.append(given)
            self.left_out, self.untried = [COGS], [Unsettled(COGS, {"R": 4.0})]

        def round(self, now: Any) -> Any:
            seen.append((now.records, now.solution, now.values, now.taken, allowance.kept))
            return []

    monkeypatch.setattr(forward, "_Search", Search)
    revised = SimpleNamespace(possible=[Unsettled(LOAD, {"R": 3.0})], left_out=(SIDED,))
    monkeypatch.setattr(forward, "Revision", lambda *given: seen.append(given) or revised)
    records: Any = [SimpleNamespace(unknowns=(1, 2)), SimpleNamespace(unknowns=())]
    near = solution()
    monkeypatch.setattr(forward, "current", lambda: allowance)
    found = forward.select(records, near, MOTOR, {"R": 0.1}, [SIDED], [LOAD])
    assert (found.stages, found.trials, found.left_out) == ((), (), (COGS,))
    assert (found.not_revised, allowance.kept) == ((SIDED,), 7.0)
    assert found.unsettled == (*revised.possible, Unsettled(COGS, {"R": 4.0}))
    assert seen == [
        ({"R": 0.1}, [SIDED], allowance), ((SIDED, LOAD), allowance),
        (records, near, MOTOR, (LOAD,), 7.0 + 16 * (7 + 2 + 7)),
    ]  # fmt: skip


def test_older_terms_are_looked_at_again_once_there_are_two(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And the search goes on beside what is left of them."""
    seen: list[Any] = []
    left = [SIDED, COGS]

    def one_round(_: Any, now: Any) -> Any:
        seen.append((now.records, now.solution, now.values, now.taken))
        if not left:
            return []
        terms = (*now.taken, left.pop(0))
        fitted = SimpleNamespace(
            records=terms, solution=f"of {len(terms)}", values={}, terms=terms, took=0
        )
        return [(fitted, Trial(terms[-1], now.taken, GOOD, 2.0))]

    revised: Any = SimpleNamespace(
        records="r", solution="s", values={"R": 1.0}, terms=(LOAD, COGS), took=7
    )
    monkeypatch.setattr(forward._Search, "round", one_round)
    monkeypatch.setattr(forward._Model, "width", 10)
    monkeypatch.setattr(forward.Revision, "of", lambda _, fitted: revised)
    found = forward.select([], "first", MOTOR, {})  # type: ignore[arg-type]
    assert seen == [
        ([], "first", MOTOR, ()), ((SIDED,), "of 1", {}, (SIDED,)),
        ("r", "s", {"R": 1.0}, (LOAD, COGS)),
    ]  # fmt: skip
    assert found.stages[1] is revised
    # a term that was exchanged since is not taken
    assert [(t.term, t.taken) for t in found.trials] == [(SIDED, False), (COGS, True)]


def test_what_the_residuals_ask_for_is_seen_in_white_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    white = solution(400.0)
    asked = [candidate(SIDED, 100.0, R=1.0), candidate(TWO, 100.0, R=2.0)]
    noting(monkeypatch, forward, seen, plain=white, screen=asked[:1], springs=asked[1:])
    now: Any = forward._Model(["record"], "solution", MOTOR, (LOAD,))  # type: ignore[list-item,arg-type]
    found, half, least = forward._asked(now, {"R": 0.1}, [COGS])
    assert [c.term for c in found] == [TWO, SIDED]
    assert (half, least) == ([], white)
    names = [name for name in score_test.SCREENED if name != "cogging"]
    assert seen["plain"] == [(["record"], "solution")]
    assert seen["screen"] == [(["record"], white, MOTOR, (LOAD,), names)]
    assert seen["springs"] == [(["record"], white, MOTOR, (LOAD,))]
    seen.clear()
    noting(monkeypatch, forward, seen, screen=[candidate(SIDED, 100.0, R=1.0)])
    assert [c.term for c in forward._asked(now, {"R": 0.1}, [TWO])[0]] == [SIDED]
    assert "springs" not in seen


@pytest.mark.parametrize(
    ("gain", "moves", "asked"),
    [(5.0, 0.9, False), (5.1, 0.9, True), (1000.0, 0.01, False), (1000.1, 0.01, True)],
)
def test_the_bounds_of_what_is_asked_for(
    gain: float, moves: float, asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """More than 5 of chi-square and half of what matters, or more than 1000 whatever it moves."""
    noting(
        monkeypatch, forward, {}, plain=solution(400.0), screen=[candidate(SIDED, gain, R=moves)],
        springs=[],
    )  # fmt: skip
    now: Any = forward._Model([], "solution", MOTOR)  # type: ignore[arg-type]
    assert bool(forward._asked(now, {"R": 1.0}, [])[0]) is asked


def test_a_fit_is_foreseen_by_the_same_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}
    noting(monkeypatch, forward, seen, foresee=GOOD)
    one = replace(candidate(SIDED), changes=(np.zeros((1, 2)),))
    now: Any = SimpleNamespace(records=["record"])
    assert forward._foreseen(now, "white", one) is GOOD  # type: ignore[arg-type]
    assert seen["foresee"] == [(["record"], "white", one)]


def test_a_fit_with_a_term_begins_beside_what_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not searched stays held, but for what the term itself brings."""
    seen: dict[str, Any] = {}
    noting(monkeypatch, forward, seen, begin="begun", sizes_by_name=[{"a": 1.0}])
    values = {**MOTOR, "T_lc": 0.0, "N_c": 3.0}
    now: Any = forward._Model(["record"], solution(), values, (SIDED,))  # type: ignore[list-item]
    one = Candidate(LOAD, 9.0, {"R": 0.2}, {"T_lc": 4.0}, ({"b": 2.0},), (np.zeros((1, 2)),))
    assert forward._begun(now, one) == "begun"  # type: ignore[comparison-overlap]
    ((records, before, terms, *how),) = seen["begin"]
    assert (records, terms) == (["record"], (SIDED, LOAD))
    assert before is now.solution
    known = dict(how)
    assert known["fixed"] == {"N_c": 3.0}
    moved = {**values, "R": MOTOR["R"] * np.exp(0.1), "T_lc": 4.0}
    assert known["start"] == pytest.approx(moved)
    assert known["own"] == [{"a": 1.0, "b": 2.0}]
    assert seen["sizes_by_name"] == [(["record"], now.solution)]


def test_a_fit_that_failed_begins_once_more_with_little_of_its_term(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where it leaves more than it may, or no motor follows."""
    begun: list[Any] = []
    ends = {1.0: solution(90.0), 0.05: solution(40.0)}

    def begin(_now: Any, one: Candidate) -> Any:
        begun.append(one)
        rough = ends[one.start["d_T0"]]
        found = rough and SimpleNamespace(solution=rough)
        return SimpleNamespace(followed=lambda: found, at=one)

    monkeypatch.setattr(forward, "_begun", begin)
    search = forward._Search({}, (), Allowance())
    one = replace(candidate(SIDED, R=3.0), own=({"a": 1.0},))
    for first, most, tries in ((90.0, 90.0, 1), (90.0, 89.0, 2), (None, 1e9, 2)):
        begun.clear()
        ends[1.0] = solution(first) if first else None  # type: ignore[assignment]
        found, rough = search._rough(None, one, most)  # type: ignore[arg-type]
        assert len(begun) == tries
        at: Any = found
        assert at.at is begun[-1]
        assert rough is not None
        assert rough.solution.objective == (90.0 if tries == 1 else 40.0)
    little = begun[-1]
    assert (little.start, little.shift, little.own) == ({"d_T0": 0.05}, {}, one.own)


def test_a_fit_whose_end_no_motor_has_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    class Begins:
        def __init__(self, term: Any) -> None:
            self.term = term

        def nearly(self, _: Any) -> Any:
            if self.term is SIDED:
                raise DataError("no motor")
            values = {"R": 2.5, "K": 0.9}
            return SimpleNamespace(values=values, terms=(LOAD,))

    seen: dict[str, Any] = {}
    rough = SimpleNamespace(solution=SimpleNamespace(objective=10.0))
    noting(monkeypatch, forward, seen, weigh=GOOD, priced=Price(1.0, 1, 1.0))
    search = forward._Search({"R": 0.25, "K": 0.05}, (), Allowance())
    monkeypatch.setattr(search, "_rough", lambda _now, c, _most: (Begins(c.term), rough))
    now: Any = SimpleNamespace(values={"R": 2.0, "K": 1.0}, taken=(COGS,), solution="before")
    ((fitted, found),) = search._compared(now, [candidate(SIDED), candidate(LOAD)], 10.0)
    assert seen["weigh"] == [(fitted, (COGS,), "before", LOAD)]
    assert found == Trial(LOAD, (COGS,), GOOD, pytest.approx(2.0))
    assert seen["priced"] == [(rough, SIDED), (rough, LOAD)]
    search.reach = {}
    assert next(search._compared(now, [candidate(LOAD)], 10.0))[1].moves == 0.0
    assert list(search._compared(now, [candidate(LOAD)], 9.9)) == []


def test_terms_that_move_half_of_what_matters_are_not_left_out_for_want_of_room(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    waiting = [candidate(SIDED, R=0.5), candidate(LOAD, R=0.50001)]
    monkeypatch.setattr(forward, "_asked", lambda *_: (waiting, [], 1.0))
    search = forward._Search({"R": 1.0}, (), Allowance(most=1.0))
    now: Any = SimpleNamespace(values=MOTOR, width=1)
    assert search.round(now) == []
    assert search.left_out == [LOAD]


# a screen


def test_of_a_terms_shapes_the_most_promising_counts_and_the_best_term_is_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its other shapes have no word, wherever they come."""
    seen: dict[str, Any] = {}
    found = [candidate(SIDED, 30.0), candidate(LOAD, 40.0), candidate(SIDED, 50.0),
             candidate(COGS, 45.0), candidate(LOAD, 10.0)]  # fmt: skip
    noting(monkeypatch, score_test, seen, Probe="probe", everything="tried")

    class Test:
        def __init__(self, *given: Any) -> None:
            seen["test"] = given

        def all(self, tried: Any) -> Any:
            assert tried == "tried"
            return found

    monkeypatch.setattr(score_test, "_Test", Test)
    best = score_test.screen(["r"], "s", MOTOR, [COGS], ["direction", "cogging"])  # type: ignore[arg-type,list-item]
    assert [(c.term, c.gain) for c in best] == [(SIDED, 50.0), (COGS, 45.0), (LOAD, 40.0)]
    assert seen["Probe"] == [(["r"], "s", MOTOR)]
    assert seen["everything"] == [("probe", [SIDED])]
    assert seen["test"] == ("probe", "s")


def test_own_sizes_of_a_term_come_beside_each_records_others() -> None:
    one = replace(candidate(COGS), own=({"phase": 1.0, "a": 9.0}, {"phase": 2.0}))
    assert one.beside([{"a": 0.5}, {"a": 0.6}]) == [
        {"a": 9.0, "phase": 1.0}, {"a": 0.6, "phase": 2.0},
    ]  # fmt: skip
    assert candidate(SIDED).beside([{"a": 0.5}]) == [{"a": 0.5}]


# a revision


def test_an_older_term_is_weighed_and_left_out_beside_all_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    bad = replace(GOOD, gain=1.0)
    rough = SimpleNamespace(name="rough")
    near = SimpleNamespace(terms=(COGS,), free=("T_c",), solution="near")
    begun = SimpleNamespace(roughly=lambda: rough, nearly=lambda one: one is rough and near)
    noting(monkeypatch, revision, seen, size_of=12.0, shapes_of=[7], weigh=bad, _begun=begun)
    fitted: Any = SimpleNamespace(
        terms=(SIDED, COGS), free=("R", "d_T0", "T_c"), solution="s", width=1
    )
    looked = revision.Revision((), Allowance())
    found: Any = looked._pruned(fitted)
    assert found is near
    assert seen["shapes_of"] == [(fitted.free, SIDED)]
    assert seen["size_of"] == [("s", 1, [7])]
    assert seen["weigh"] == [(fitted, (COGS,), "s", SIDED)]
    assert seen["_begun"] == [(fitted, (COGS,))]


def test_rivals_of_a_term_are_screened_where_it_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}
    null = SimpleNamespace(records=["null"], solution="null's", values={"R": 1.0})
    rough = SimpleNamespace(name="rough")
    begun = SimpleNamespace(followed=lambda: null)
    usual = SimpleNamespace(
        records=["mine"], solution="mine, white", values={"R": 2.0}, terms=(SIDED, COGS)
    )
    same = SimpleNamespace(followed=lambda: usual)
    other = SimpleNamespace(
        followed=lambda: rough, nearly=lambda one: "near" if one is rough else None
    )
    left = [begun, same, other]
    monkeypatch.setattr(
        revision, "_begun", lambda *of: seen.setdefault("begun", []).append(of) or left.pop(0)
    )
    prices = {True: Price(100.0, 1, 10.0), False: Price(89.0, 1, 10.0)}
    monkeypatch.setattr(
        revision, "priced",
        lambda *of: seen.setdefault("priced", []).append(of) or prices[of[1] is SIDED],
    )  # fmt: skip
    rivals = [candidate(LOAD, 60.0), candidate(SIDED, 100.0)]
    noting(monkeypatch, revision, seen, plain="white")
    screens = [rivals, [candidate(LOAD, 29.0)]]
    monkeypatch.setattr(
        revision, "screen",
        lambda *of: seen.setdefault("screen", []).append(of) or screens[len(seen["screen"]) - 1],
    )  # fmt: skip
    fitted: Any = SimpleNamespace(
        terms=(SIDED, COGS), records=["mine"], solution="s", values={"R": 4.0}
    )
    looked = revision.Revision((TWO,), Allowance())
    assert looked._exchanged(fitted, SIDED) == "near"  # type: ignore[comparison-overlap]
    assert seen["begun"] == [
        (fitted, (COGS,)), (fitted, (SIDED, COGS)), (null, (COGS, LOAD), rivals[0])
    ]  # fmt: skip
    assert seen["plain"] == [(["null"], "null's"), (["mine"], "mine, white")]
    (records, white, values, rest, names), beside = seen["screen"]
    assert beside == (["mine"], "white", {"R": 2.0}, (SIDED, COGS), [LOAD.name])
    assert (records, white, values, rest) == (["null"], "white", {"R": 1.0}, (COGS,))
    assert names == [n for n in score_test.SCREENED if n != "cogging"]
    assert seen["priced"][0] == (usual, SIDED)
    assert seen["priced"][1] == (rough, LOAD)
    left[:] = [SimpleNamespace(followed=lambda: None)]
    screens += [rivals]
    assert looked._exchanged(fitted, SIDED) is None
    assert looked.possible == [Unsettled(SIDED, {"R": 4.0})]  # it gains 11 of the 100 it is worth


def test_a_fit_of_other_terms_begins_from_the_same_solution(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    noting(monkeypatch, revision, seen, begin="begun", sizes_by_name=[{}])
    fitted: Any = SimpleNamespace(
        terms=(SIDED,), free=("R", "d_T0"), values={"R": 2.0, "d_T0": 0.1}, records=["r"],
        solution="s",
    )  # fmt: skip
    assert revision._begun(fitted, (SIDED,)) == "begun"  # type: ignore[comparison-overlap]
    assert seen["begin"][0][:3] == (["r"], "s", (SIDED,))
    assert seen["sizes_by_name"] == [(["r"], "s")]
