"""Valleys of friction without a motion: a narrow one beside a wide one, by stubbed searches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis import remarks
from motorid.estimate.fit.logs import log_friction
from motorid.estimate.solver.problem import Solution, Unknown
from motorid.estimate.uncertainty import log_scatter

MOTOR = {"R": 2.0, "J": 0.02, "B": 0.025, "T0": 1e-4}
KNOWN = {"K": 1.0}
FREE = tuple(MOTOR)
NARROW = {"R": 1e3, "J": 1e3, "B": 1e-3, "T0": 1e-4}  # standard deviations (search coordinates)
WIDE = {**NARROW, "T0": 1.0}
TOP_V = 6.0


def solution(objective: float, deviations: Mapping[str, float], **values: float) -> Solution:
    values = {**MOTOR, **values}
    unknowns = tuple(Unknown(n, values[n], 0.0, log=n in "RJ") for n in FREE)
    return Solution(
        unknowns, np.array(list(values.values())), (), (),
        np.diag([deviations[n] ** -2.0 for n in FREE]), np.zeros(len(FREE), dtype=bool), tuple,
        objective, 1, True,
    )  # fmt: skip


class Searches:
    """In place of searches: those with T0 held, those that let it go, and those gone on with."""

    def __init__(self, held: Solution, ends: Solution) -> None:
        self.held, self.ends, self.asked = held, ends, list[float]()

    def maximise(self, unknowns: Any, _records: Any, **_: Any) -> Solution:
        (dry,) = (u for u in unknowns if u.name == "T0")
        assert dry.lower == dry.upper == dry.start
        self.asked.append(dry.start)
        values = [dry.start if u.name == "T0" else u.start for u in unknowns]
        return replace(self.held, values=np.array(values))

    def again(self, _records: Any, _free: Any, _start: Any, before: Solution) -> Solution:
        if before.objective != self.held.objective:
            return before  # no search ends lower
        return replace(self.ends, values=before.values)


def shared(
    monkeypatch: pytest.MonkeyPatch, found: Solution, held: Solution, ends: Solution
) -> tuple[Solution, Any, Searches]:
    searches = Searches(held, ends)
    monkeypatch.setattr(log_friction, "maximise", searches.maximise)
    monkeypatch.setattr(log_friction, "again", searches.again)
    monkeypatch.setattr(log_friction.scales, "volts", lambda _: TOP_V)
    record = SimpleNamespace(rivals=("another",))
    answer = log_friction.shared([record], found, FREE, KNOWN)  # type: ignore[list-item]
    return answer, record, searches


def test_the_valley_that_holds_more_is_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    narrow, wide = solution(-103.0, NARROW), solution(-100.0, WIDE)
    answer, record, searches = shared(monkeypatch, narrow, wide, replace(wide, objective=-100.5))
    assert answer.objective == -100.5  # it lies higher, but is a thousand times as wide
    assert record.rivals == ("another",)
    torque = MOTOR["B"] * TOP_V + MOTOR["T0"]
    assert np.array(searches.asked) / torque == pytest.approx(log_friction.SHARES)


def test_a_wide_valley_that_no_search_stays_in_is_a_rival(monkeypatch: pytest.MonkeyPatch) -> None:
    narrow, wide = solution(-103.0, NARROW), solution(-100.0, WIDE)
    answer, record, searches = shared(monkeypatch, narrow, wide, narrow)
    assert answer is narrow
    first, *rivals = record.rivals
    assert first == "another"
    assert [one.values[3] for one in rivals] == searches.asked
    assert all(one.friction and one.behind < 0.0 for one in rivals)
    record.rivals = tuple(rivals)
    (near, far) = log_scatter.rivals(narrow, record, friction=True)
    assert log_scatter.rivals(narrow, record) == []  # they are no shapes of the voltage
    assert far[3] > 0.9 * searches.asked[1]  # likelier than the answer: all of the way
    assert 0.0 < near[3] < far[3]
    (said,) = remarks._shared_friction([record])
    assert said.code == "friction_shared"
    record.rivals = tuple(replace(one, behind=remarks.EXCLUDED) for one in rivals)
    assert list(remarks._shared_friction([record])) == []


@pytest.mark.parametrize(
    ("deviation", "behind"),
    [
        (1e-4, log_friction.FALLEN + 1.0),  # noise excludes it
        (0.05, 1.0),  # a parabola says as much: it is the same valley
    ],
)
def test_nothing_else_is_looked_for(
    deviation: float, behind: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = solution(-103.0, {**NARROW, "T0": deviation})
    held = solution(-103.0 + behind, WIDE)
    answer, record, _ = shared(monkeypatch, found, held, replace(held, objective=-1e3))
    assert answer is found
    assert record.rivals == ("another",)


def test_one_that_is_held_is_shared_with_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_friction, "maximise", None)
    found = solution(-103.0, NARROW)
    assert log_friction.shared([], found, ("R", "J", "B"), KNOWN) is found
    idle = solution(-103.0, NARROW, B=0.0, T0=0.0)
    monkeypatch.setattr(log_friction.scales, "volts", lambda _: TOP_V)
    record: Any = SimpleNamespace(rivals=())
    assert log_friction.shared([record], idle, FREE, KNOWN) is idle
