"""Which fault is named, among those that promise to explain what a fit leaves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.diagnosis import misfit, rank
from motorid.estimate.diagnosis.fault import Hypothesis, Words
from motorid.estimate.diagnosis.rank import Trial
from motorid.estimate.diagnosis.refit import Refit
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.solver.problem import Solution, Unknown

MOTOR = {"R": 2.0, "L": 4e-3, "K": 0.05, "B": 4e-5, "J": 2e-5, "T0": 6e-3}


def solution(**values: float) -> Solution:
    """At these values; noise, bounds and slopes do not matter here."""
    found = {**MOTOR, **values}
    n = len(found)
    return Solution(
        tuple(Unknown(name, value) for name, value in found.items()),
        np.array(list(found.values())), (), (), np.eye(n), np.zeros(n, dtype=bool), tuple, 0.0, 1,
        True,
    )  # fmt: skip


def hypothesis(guard: bool = False) -> Hypothesis:
    def words(size: np.ndarray) -> Words:
        return Words("current", f"it is {size[0]:g} s late", "declare it")

    return Hypothesis("current_lag", _none, ((1.0,),), (1.0,), (0.0,), (9.0,), words, guard)


def _none(*_: Any) -> list[np.ndarray]:
    return []


def trial(
    gain: float = 1.0, share: float = 0.9, shift: float = 0.1, seen: bool = False,
    guard: bool = False,
) -> Trial:  # fmt: skip
    values = np.array([v * (1 + (shift if n == "R" else 0.0)) for n, v in MOTOR.items()])
    found = Refit(values, np.array([3e-4]), 1.0, solution())
    return Trial(hypothesis(guard), found, gain, share, {"R": shift, "K": -shift / 2}, seen)


def suspect(code: str, allowed: bool = False) -> Suspect:
    return Suspect(code, "current", "so", "do", "named", allowed=allowed)


@pytest.mark.parametrize(
    ("one", "named"),
    [
        (trial(gain=0.75, share=0.01), True),  # much for each reading
        (trial(gain=0.65, share=0.01), False),
        (trial(gain=0.11, share=0.31), True),  # or less, and much of all there is
        (trial(gain=0.11, share=0.29), False),
        (trial(gain=0.09, share=0.99), False),
        (trial(gain=0.11, share=0.01, seen=True), True),  # or the plain laws show it
        (trial(gain=0.09, share=0.01, seen=True), False),
        (trial(gain=9.0, shift=0.001), False),  # it moves nothing
        (trial(gain=9.0, shift=-0.003), True),
    ],
)
def test_a_fault_convinces_by_what_it_explains_and_moves(one: Trial, named: bool) -> None:
    assert one.convincing is named


def test_what_the_model_lacks_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    def first(*found: Trial) -> Trial | None:
        monkeypatch.setattr(rank, "trials", lambda *_: list(found))
        return rank.tried([], solution())

    best = trial(gain=2.0)
    assert first(best, trial()) is best
    assert first(trial(gain=2.0, guard=True), best) is None
    assert first(trial(gain=0.01), best) is None  # the best of all has the word
    assert first() is None


def test_some_findings_let_a_fit_go_on() -> None:
    assert rank.spoiling([suspect("samples_dropped")])
    assert not rank.spoiling([suspect("current_offset"), suspect("supply_limited")])
    assert not rank.spoiling([suspect("samples_dropped", allowed=True)])
    assert not rank.spoiling([])


def test_a_named_fault_says_what_it_explains_and_moves() -> None:
    said = rank._said(trial(share=0.42), solution(), " (run 2)")
    assert said.evidence == (
        "it is 0.0003 s late; that explains 42 % of the misfit, and taken into account moves R by "
        "+10.0% (run 2)"
    ).replace("42 %", "42%")
    assert said.strength == "named"
    assert said.moves["R"] == pytest.approx(0.1 * MOTOR["R"])
    assert said.moves["L"] == 0.0


def runs(monkeypatch: pytest.MonkeyPatch, *excesses: float) -> int | None:
    left = iter(excesses)
    monkeypatch.setattr(misfit, "residuals", lambda *_: [])
    monkeypatch.setattr(misfit, "excess", lambda *_: next(left))
    some: Sequence[Any] = [SimpleNamespace() for _ in excesses]
    return rank._odd(some, [solution() for _ in excesses])


def test_the_run_that_misfits_far_more_is_looked_at_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert runs(monkeypatch, 0.1, 0.9, 0.2) == 1
    assert runs(monkeypatch, 0.1, 0.45, 0.2) is None  # not twice the others', and a little
    assert runs(monkeypatch, 0.0, 0.0, 0.11) == 2
    assert runs(monkeypatch, 0.0, 0.0, 0.09) is None
    assert runs(monkeypatch, 5.0) is None  # of one run there is no other


def test_a_fit_begins_with_another_motor_where_that_has_values() -> None:
    at = rank._at(solution(), {"R": 3.0, "J": -1.0, "other": 5.0}, 1e-4)
    assert dict(zip(MOTOR, at.values.tolist(), strict=True)) == {**MOTOR, "R": 3.0}


def test_an_inductance_that_vanished_begins_where_readings_tell_it() -> None:
    period_s = 1e-4
    gone = rank._at(solution(L=0.04 * 2.0 * period_s), {}, period_s)
    assert gone.values[1] == pytest.approx(0.3 * 2.0 * period_s)
    there = rank._at(solution(L=0.06 * 2.0 * period_s), {}, period_s)
    assert there.values[1] == 0.06 * 2.0 * period_s


def test_without_a_current_a_fit_begins_at_the_solution_alone() -> None:
    record = SimpleNamespace(
        names=tuple(MOTOR), motor=lambda values: values, timeline=SimpleNamespace(period_s=1e-4),
        measured=(), capture=SimpleNamespace(path=None, get=lambda _: None),
    )  # fmt: skip
    starts = rank._starts([record], solution())  # type: ignore[list-item]
    assert len(starts) == 1
    assert starts[0].values == pytest.approx(list(MOTOR.values()))
    assert math.isfinite(starts[0].objective)
