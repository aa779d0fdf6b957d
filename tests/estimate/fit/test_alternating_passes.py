"""How many passes fit and source make, what they decide, and what is left: on given answers."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.fit import alternating_fit
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.problem import Solution, Unknown
from tests.estimate.fit.given_answers import START, record, solution


class Turns:
    """Records whose searches move R by given steps, in standard deviations."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *moves: float, lost: bool = False) -> None:
        self.moves, self.enough = list(moves), list[float]()
        monkeypatch.setattr(alternating_fit, "again", self.again)
        monkeypatch.setattr(alternating_fit, "vanished", lambda *_: lost)
        self.decided = list[bool]()
        self.record = SimpleNamespace(
            driving=SimpleNamespace(decided=False), loss="loss", names=PARAMETERS, simulated=5,
            volts=np.zeros(3), retake_sources=lambda *_: None, decide=self.decide, unsettled="old",
        )  # fmt: skip

    def decide(self, decided: bool) -> None:
        self.decided.append(decided)

    def again(
        self, _r: Any, _f: Any, _s: Any, before: Any, enough: float, _held: float, _most: int
    ) -> Solution:
        self.enough.append(enough)
        move = self.moves.pop(0) if self.moves else 0.0
        return replace(before, values=before.values + np.r_[move, np.zeros(5)])

    def run(self, **how: Any) -> Solution:
        before = solution(10.0)
        return alternating_fit.in_turn([self.record], PARAMETERS, START, before, **how)  # type: ignore[list-item]


def test_passes_end_where_two_on_end_leave_nothing_to_come(monkeypatch: pytest.MonkeyPatch) -> None:
    turns = Turns(monkeypatch, 1.0, 0.3, 0.09, 0.027, 0.008, 0.0024)
    turns.run()
    assert turns.record.unsettled is None
    # each is .3 of the pass before, so .43 of it is to come: less than .02 decides it
    assert turns.decided[:4] == [False, False, False, True]
    assert turns.enough == [alternating_fit.ROUGH] * 2 + [alternating_fit.CLOSE] * 4


def test_what_never_settles_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    turns = Turns(monkeypatch, *[1.0] * 80)
    turns.run()
    assert len(turns.enough) == alternating_fit.MOST_PASSES - 1
    shift = turns.record.unsettled
    assert shift[0] == pytest.approx(0.95 / 0.05)
    assert not shift[1:].any()
    assert turns.decided.index(True) == alternating_fit.LATEST - 1


@pytest.mark.parametrize(
    ("moves", "left"), [((1.0, -1.0), 1.0), ((-0.3, 0.5, -0.2), 0.5), ((0.05, -0.05), None)]
)
def test_passes_that_hover_end_among_where_they_have_been(
    moves: tuple[float, ...], left: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    turns = Turns(monkeypatch, *moves * 40)
    turns.run()
    shift = turns.record.unsettled
    assert (shift is None) is (left is None)
    assert left is None or abs(shift[0]) == pytest.approx(left)


def test_a_lost_inductance_gets_few_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    turns = Turns(monkeypatch, *[1.0, -1.0] * 40, lost=True)
    turns.run()
    assert len(turns.enough) == alternating_fit.LOST_PASSES - 1
    assert set(turns.enough) == {alternating_fit.ROUGH}


def test_responses_are_spent_at_last(monkeypatch: pytest.MonkeyPatch) -> None:
    turns = Turns(monkeypatch, *[1.0, -1.0] * 40)

    def retake(*_: Any) -> None:
        turns.record.simulated += alternating_fit.MOST_SIMULATED // 2 + 1

    turns.record.retake_sources = retake
    turns.run()
    assert len(turns.enough) == 2


def test_a_wider_model_gets_few_passes_unless_it_asks_for_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One that leads on; what swings in vain ends earlier."""
    for how, passes in (({}, 2), ({"thorough": True}, alternating_fit.MOST_PASSES - 1)):
        turns = Turns(monkeypatch, *[1.0] * 40)
        turns.record.names = (*PARAMETERS, "T_q")
        turns.run(**how)
        assert len(turns.enough) == passes


def test_a_source_that_stays_ends_a_bare_search(monkeypatch: pytest.MonkeyPatch) -> None:
    turns = Turns(monkeypatch, 1.0, 1.0)
    turns.record.loss = None
    turns.run()
    assert turns.enough == []
    moving = Turns(monkeypatch, 1.0, 1.0)
    moving.record.loss = None

    def retake(*_: Any) -> None:
        moving.record.volts = moving.record.volts + 1.0

    moving.record.retake_sources = retake
    moving.run()
    assert len(moving.enough) == alternating_fit.BARE_PASSES - 1
    assert moving.record.unsettled is None


@pytest.mark.parametrize(("henry", "gone"), [(0.019, True), (0.021, False), (0.0, False)])
def test_an_inductance_has_vanished_below_what_readings_tell_from_none(
    henry: float, gone: bool
) -> None:
    """Whether the resistance is searched or held."""
    found = solution(1.0, L=henry * 2.0 * 1e-4)
    records = [record(period_s=1e-4), record(period_s=1.0)]
    records[0].motor = lambda values: values
    assert alternating_fit.vanished(found, records) is gone
    searched = replace(found, unknowns=found.unknowns[1:], values=found.values[1:])
    records[0].motor = lambda values: np.r_[2.0, values]
    assert alternating_fit.vanished(searched, records) is gone


def test_a_parameter_that_stays_at_its_bound_does_not_move() -> None:
    bound = np.array([True, False, False, False, False, False])
    before = replace(solution(1.0), at_bound=bound)
    after = replace(solution(1.0, R=9.0, L=0.5), at_bound=bound, information=4.0 * np.eye(6))
    change = alternating_fit.Change.of(before, after)
    assert change.shift == pytest.approx([0.0, 0.5 - 4e-3, 0, 0, 0, 0])
    assert change.size == pytest.approx(2.0 * (0.5 - 4e-3))
    logs = [replace(one, unknowns=tuple(replace(u, log=u.name == "K") for u in one.unknowns))
            for one in (solution(1.0), solution(1.0, K=0.1))]  # fmt: skip
    assert alternating_fit.Change.of(*logs).shift[2] == pytest.approx(np.log(2.0))


def test_a_held_inductance_is_no_unknown_and_judges_the_source_from_the_start(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}

    def maximise(unknowns: Any, _records: Any, **how: Any) -> Solution:
        seen["bounds"] = {u.name: (u.start, u.lower, u.upper) for u in unknowns}
        return solution(7.0)

    def in_turn(_r: Any, _f: Any, start: Any, found: Solution, held: float) -> Solution:
        seen["start"], seen["held"] = dict(start), held
        return found

    one = record()
    one.decide = lambda decided: seen.update(decided=decided)
    one.retake_sources = lambda values, own: seen.update(judged=values.tolist(), own=own.tolist())
    unknowns = [Unknown(name, value, 0.0) for name, value in START.items()]
    monkeypatch.setattr(alternating_fit, "unknowns_of", lambda *_: unknowns)
    monkeypatch.setattr(alternating_fit, "maximise", maximise)
    monkeypatch.setattr(alternating_fit, "in_turn", in_turn)
    found = alternating_fit.with_inductance([one], PARAMETERS, START, solution(9.0, R=3.0), 1e-3)
    assert found.objective == 7.0
    assert seen["judged"] == [3.0, 1e-3, 0.05, 4e-5, 2e-5, 6e-3]
    assert seen["own"] == []
    assert seen["bounds"]["L"] == (1e-3, 1e-3, 1e-3)
    assert seen["bounds"]["R"] == (2.0, 0.0, np.inf)
    assert (seen["start"]["L"], seen["held"]) == (1e-3, 1e-3)
    assert seen["decided"] is False
    alternating_fit.with_sources([one], PARAMETERS, START)
    assert seen["bounds"]["L"] == (4e-3, 0.0, np.inf)


def test_a_source_is_the_same_but_for_rounding() -> None:
    subject = record()
    for moved, same in ((0.0, True), (0.9e-9, True), (1.1e-9, False)):
        subject.volts = np.array([1.0, -10.0]) + 10.0 * moved * np.array([0.0, 1.0])
        assert alternating_fit._same(np.array([1.0, -10.0]), subject) is same
