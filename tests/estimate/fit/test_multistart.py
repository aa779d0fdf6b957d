"""Which starts are tried, which answer is kept, and when a search gives up: on given answers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.fit import joint_fit, multistart
from motorid.estimate.fit.lagging_start import Doubt
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.problem import Derivatives, Solution
from tests.estimate.fit.given_answers import START, record, solution, without_noise


class Searches:
    """Instead of searches: the answers in turn, and where each began."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, *answers: Solution, misfits: bool = True,
        supported: bool = True, lost: bool = False,
    ) -> None:  # fmt: skip
        self.left, self.began = list(answers), list[Mapping[str, float]]()
        monkeypatch.setattr(multistart, "with_sources", self.search)
        monkeypatch.setattr(multistart, "leaves_misfit", lambda *_: misfits)
        monkeypatch.setattr(multistart, "unsupported", lambda *_: None if supported else "so")
        monkeypatch.setattr(multistart, "vanished", lambda *_: lost)
        monkeypatch.setattr(multistart, "with_promoted", lambda _r, _f, _s, found: found)
        without_noise(monkeypatch)

    def search(self, _records: Any, _free: Any, start: Mapping[str, float]) -> Solution:
        self.began.append(dict(start))
        return self.left.pop(0)

    def ratios(self) -> list[dict[str, float]]:
        each = ({n: s[n] / START[n] for n in PARAMETERS} for s in self.began)
        return [{n: round(r, 9) for n, r in one.items() if round(r, 9) != 1.0} for one in each]


def test_a_good_answer_needs_no_other_start(monkeypatch: pytest.MonkeyPatch) -> None:
    searches = Searches(monkeypatch, solution(10.0), misfits=False)
    assert multistart.settled([record()], PARAMETERS, START).objective == 10.0
    assert searches.began == [START]


@pytest.mark.parametrize(("worth", "starts"), [(99.9, 1), (100.1, 6)])
def test_what_leaves_more_than_it_is_worth_begins_nowhere_else(
    worth: float, starts: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    searches = Searches(monkeypatch, *[solution(100.0)] * 6)
    multistart.settled([record()], PARAMETERS, START, worth)
    assert len(searches.began) == starts


@pytest.mark.parametrize("converged", [True, False])
def test_other_starts_are_tried_and_the_best_is_followed_to_its_end(
    converged: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = [solution(100.0, converged), solution(99.5), solution(60.0, K=0.07), solution(70.0),
               solution(80.0), solution(55.0)]  # fmt: skip
    searches = Searches(monkeypatch, *answers, misfits=converged)
    assert multistart.settled([record()], PARAMETERS, START).objective == 55.0
    assert searches.ratios()[1:5] == list(multistart.OTHER_STARTS)
    assert searches.began[5]["K"] == 0.07


def test_other_starts_are_within_what_start_values_are_off_by() -> None:
    """A winding's resistance to a half, an inertia to about two, an inductance to five times."""
    most = {"R": 1.5, "J": 2.5, "L": 5.0}
    for factors in multistart.OTHER_STARTS:
        for name, factor in factors.items():
            assert 1.0 < max(factor, 1.0 / factor) <= most[name]
    inductances = [one["L"] for one in multistart.OTHER_STARTS if "L" in one]
    assert min(inductances) < 1.0 < max(inductances)  # both ways


def test_another_answer_must_be_better_by_more_than_chance(monkeypatch: pytest.MonkeyPatch) -> None:
    answers = [solution(100.0, K=0.09), *[solution(99.1, K=0.01)] * 4, solution(99.0)]
    searches = Searches(monkeypatch, *answers)
    multistart.settled([record()], PARAMETERS, START)
    assert searches.began[5]["K"] == 0.09


def test_where_the_responses_are_spent_the_untried_starts_are_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    busy = [record(multistart.MOST_TRIED), record(multistart.MOST_TRIED + 1)]
    searches = Searches(monkeypatch, solution(100.0, K=0.09), solution(99.0))
    assert multistart.settled(busy, PARAMETERS, START).objective == 99.0
    assert [one.untried for one in busy] == [4, 4]
    assert searches.began[1]["K"] == 0.09
    hopeless = Searches(monkeypatch, solution(100.0), supported=False)
    assert multistart.settled(busy, PARAMETERS, START).objective == 100.0
    assert len(hopeless.began) == 1


def test_an_inductance_that_vanished_begins_again_from_the_likelier_of_two(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    searches = Searches(
        monkeypatch, solution(100.0, R=3.0), solution(40.0), misfits=False, lost=True
    )
    held: list[float] = []
    judged: list[float] = []

    def near_inductance(_r: Any, _f: Any, known: Any, _n: Any, henry: float) -> Solution:
        assert known["R"] == 3.0
        held.append(henry)
        return solution(90.0 if len(held) == 2 else 95.0, L=henry)

    monkeypatch.setattr(multistart, "near_inductance", near_inductance)
    monkeypatch.setattr(multistart, "judge_at", lambda _r, _s, henry: judged.append(henry))
    assert multistart.settled([record()], PARAMETERS, START).objective == 40.0
    assert held == pytest.approx([rise * 3.0 * 1e-4 for rise in multistart.RISES])
    assert judged == [held[1]]
    assert searches.began[1]["L"] == held[1]


def test_what_no_motor_gives_is_left_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    Searches(monkeypatch, solution(100.0), misfits=False, supported=False, lost=True)
    assert multistart.settled([record()], PARAMETERS, START).objective == 100.0


# quantities that the data tell


def test_quantities_are_promoted_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    left = [["a"], ["b"], []]
    monkeypatch.setattr(multistart, "promoted", lambda _, found: (found, left.pop(0)))
    monkeypatch.setattr(multistart, "again", lambda _r, _f, _s, found, _e: found)
    monkeypatch.setattr(multistart, "contradicted", lambda *_: False)
    turns: list[float] = []

    def in_turn(_r: Any, _f: Any, _s: Any, found: Solution) -> Solution:
        turns.append(found.objective)
        return replace(found, objective=found.objective - 1.0)

    monkeypatch.setattr(multistart, "in_turn", in_turn)
    found = multistart.with_promoted([record()], PARAMETERS, START, solution(10.0))
    assert (found.objective, turns) == (8.0, [10.0, 9.0])


def test_one_that_contradicts_its_declaration_is_propagated_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one, before = record(), solution(10.0)
    one.propagate = lambda *found: setattr(one, "back", found)
    monkeypatch.setattr(multistart, "promoted", lambda _, found: (found, ["gain"]))
    monkeypatch.setattr(multistart, "again", lambda _r, _f, _s, _b, _e: solution(1.0))
    monkeypatch.setattr(multistart, "contradicted", lambda *_: True)
    assert multistart.with_promoted([one], PARAMETERS, START, before) is before
    assert one.back == ("gain",)


def test_what_repeats_is_taken_anew_a_few_times(monkeypatch: pytest.MonkeyPatch) -> None:
    one, before = record(), solution(10.0)
    one.decide = lambda decided: setattr(one, "decided", decided)
    monkeypatch.setattr(multistart, "with_repeating", lambda *_: None)
    assert multistart.with_repeated([one], PARAMETERS, START, before) is before
    monkeypatch.setattr(multistart, "with_repeating", lambda _, found: found)
    monkeypatch.setattr(multistart, "again", lambda _r, _f, _s, found, _e: found)
    monkeypatch.setattr(
        multistart, "in_turn", lambda _r, _f, _s, f: replace(f, objective=f.objective - 1.0)
    )
    monkeypatch.setattr(multistart, "taken_again", lambda _, found: found)
    assert multistart.with_repeated([one], PARAMETERS, START, before).objective == 10.0 - 4
    assert one.decided is False
    monkeypatch.setattr(multistart, "taken_again", lambda *_: None)
    assert multistart.with_repeated([one], PARAMETERS, START, before).objective == 9.0


@pytest.mark.parametrize(("coloured", "fits"), [(False, 1), (True, multistart.COLOUR_PASSES)])
def test_a_noise_with_memory_is_fitted_twice(
    coloured: bool, fits: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    one = record()
    one.filtered_rows = lambda table: 2.0 * table

    def again(_r: Any, _f: Any, _s: Any, lent: Solution, enough: float, **_: Any) -> Solution:
        asked.append((lent.derivatives, enough))
        return replace(lent, objective=lent.objective - 1.0)

    monkeypatch.setattr(multistart.prewhitening, "whiten", lambda *_: coloured)
    monkeypatch.setattr(multistart.prewhitening, "thin", lambda *_: None)
    monkeypatch.setattr(multistart, "again", again)
    table = np.ones((6, 4))
    white = Derivatives(np.zeros(6), (np.zeros(1),), (table,), (table[:1],))
    before = replace(solution(10.0), derivatives=white)
    found = multistart.whitened([one], PARAMETERS, START, before, 0.5)
    assert found.objective == 10.0 - fits
    for lent, enough in asked:  # always those of white readings, as they are weighed now
        assert lent.shared[0] == pytest.approx(2.0 * table)
        assert lent.own_slopes[0] == pytest.approx(2.0 * table[:1])
        assert enough == 0.5


# a motion that is late


def doubted(
    monkeypatch: pytest.MonkeyPatch, objectives: Sequence[float], late_s: float = 2e-3,
    misfits: bool = False, supported: bool = True,
) -> tuple[Any, list[float], Any]:  # fmt: skip
    left, taken = list(objectives), []

    def taken_earlier(capture: Any, late: float) -> Any:
        taken.append(late)
        return capture

    monkeypatch.setattr(joint_fit, "taken_earlier", taken_earlier)
    monkeypatch.setattr(joint_fit, "MotorRecord", lambda *_: record())
    monkeypatch.setattr(joint_fit, "settled", lambda *_: solution(left.pop(0)))
    monkeypatch.setattr(joint_fit, "leaves_misfit", lambda *_: misfits)
    monkeypatch.setattr(joint_fit, "unsupported", lambda *_: None if supported else "so")
    before = [record()]
    doubt = Doubt(DataError("no inertia"), late_s)
    found = joint_fit._doubted(before, solution(50.0), PARAMETERS, START, {}, doubt)
    return found, taken, before


def test_a_motion_is_taken_earlier_by_parts_and_more_of_what_the_start_says(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (records, found), taken, before = doubted(monkeypatch, [60.0, 40.0, 20.0, 30.0, 70.0, 80.0])
    assert taken == pytest.approx([s * 2e-3 for s in joint_fit.TRIED])
    assert found.objective == 20.0
    assert records is not before
    (records, found), _, before = doubted(monkeypatch, [60.0] * 6)
    assert (records, found.objective) == (before, 50.0)
    _, taken, _ = doubted(monkeypatch, [], late_s=0.0)
    assert taken == []


def test_a_motion_that_no_lag_explains_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DataError, match=r"no inertia; the motion follows .* 2 ms earlier"):
        doubted(monkeypatch, [60.0] * 6, misfits=True)
    found, _, _ = doubted(monkeypatch, [60.0] * 6, misfits=True, supported=False)
    assert found[1].objective == 50.0  # the refusal says more
