"""What each stage of a fit is handed: records, parameters and solutions that are given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.fit import alternating_fit, joint_fit, rough_fit
from motorid.estimate.fit.lagging_start import Doubt
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.problem import Solution
from tests.estimate.fit.given_answers import START, note, record, solution

FREE = tuple(n for n in PARAMETERS if n != "B")
FIXED = {"B": 4e-5}


class Fit:
    """A joint fit of which every stage notes what it was handed, and answers as is given."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **facts: Any) -> None:
        self.seen = dict[str, Any]()
        waveform = facts.get("waveform")
        doubt = facts.get("doubt")
        supported = facts.get("supported", True)
        answers = {
            "settled": solution(90.0), "whitened": solution(50.0, K=0.06),
            "with_repeated": solution(60.0), "_with_other_friction": solution(70.0),
            "unsupported": None if supported else "so", "_begun": (START, doubt),
            "_doubted": (["doubted"], solution(75.0)), "lossless": "lossless",
            "again": solution(45.0, converged=False),
        }  # fmt: skip
        for name, answer in answers.items():
            monkeypatch.setattr(joint_fit, name, self.noted(name, answer))
        self.logs = [record()], solution(80.0)
        modules: list[tuple[Any, str, Any]] = [
            (joint_fit.sign_check, "insist", None),
            (joint_fit.log_fit, "best", self.logs),
            (joint_fit.log_grid, "settled", self.logs),
            (joint_fit.subsample_inductance, "told", facts.get("told")),
        ]
        for module, name, answer in modules:
            place = f"{module.__name__.rpartition('.')[2]}.{name}"
            monkeypatch.setattr(module, name, self.noted(place, answer))
        self.made = list[Any]()

        def made(*given: Any) -> Any:
            self.made.append(given)
            one = record()
            one.sensed = SimpleNamespace(waveform=waveform)
            return one

        monkeypatch.setattr(joint_fit, "MotorRecord", made)
        captures: Any = ["one", "two"]
        self.found = joint_fit.solved(captures, facts.get("fix", FIXED), facts.get("without", ()))

    def noted(self, name: str, answer: Any) -> Callable[..., Any]:
        def stage(*asked: Any, **how: Any) -> Any:
            self.seen.setdefault(name, (*asked, *how.items()))
            return answer

        return stage


def test_a_capture_of_a_board_is_settled_repeated_and_whitened(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fit = Fit(monkeypatch)
    records, found = fit.found
    assert fit.made == [("one", list(FREE), FIXED), ("two", list(FREE), FIXED)]
    assert found.objective == 50.0
    assert fit.seen["sign_check.insist"] == (records,)
    assert fit.seen["_begun"] == (records, FIXED)
    assert fit.seen["settled"] == (records, list(FREE), START)
    assert fit.seen["with_repeated"][:3] == (records, list(FREE), START)
    assert fit.seen["with_repeated"][3].objective == 90.0
    assert fit.seen["whitened"][:3] == (records, list(FREE), START)
    assert fit.seen["whitened"][3].objective == 60.0
    told = fit.seen["subsample_inductance.told"]
    assert told == (records, list(FREE), FIXED, {**START, "K": 0.06}, found)
    skipped = {
        "log_fit.best",
        "log_grid.settled",
        "_with_other_friction",
        "_doubted",
        "lossless",
        "again",
    }
    assert not skipped & set(fit.seen)


def test_an_inductance_within_a_period_has_a_fit_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told: Any = (["others"], solution(1.0))
    assert Fit(monkeypatch, told=told).found is told


def test_a_log_is_fitted_by_all_its_ways(monkeypatch: pytest.MonkeyPatch) -> None:
    fit = Fit(monkeypatch, waveform="logged")
    first, settled, *how = fit.seen["log_fit.best"]
    assert (settled.objective, how) == (90.0, [list(FREE), START, FIXED])
    assert len(first) == 2
    assert fit.seen["log_grid.settled"] == (fit.logs, list(FREE), START, FIXED)
    friction = fit.seen["_with_other_friction"]
    assert friction == (*fit.logs, list(FREE), START)
    assert fit.seen["with_repeated"][3].objective == 70.0
    assert fit.found[0] is fit.logs[0]
    records, free, start, whitened, *fine = fit.seen["again"]
    assert (records, free, start) == (fit.logs[0], list(FREE), START)
    assert (whitened.objective, fine) == (
        50.0, [joint_fit.FINE, ("most", joint_fit.FINE_STEPS)],
    )  # fmt: skip
    # few steps are no search that failed
    assert (fit.found[1].objective, fit.found[1].converged) == (45.0, True)


def test_a_late_motion_is_doubted_before_it_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    doubt = Doubt(DataError("why"), 0.01)
    fit = Fit(monkeypatch, doubt=doubt)
    records, settled, *how = fit.seen["_doubted"]
    assert (len(records), settled.objective) == (2, 90.0)
    assert how == [list(FREE), START, FIXED, doubt]
    assert fit.found[0] == ["doubted"]
    assert fit.seen["with_repeated"][3].objective == 75.0


def test_what_no_motor_gives_ends_there(monkeypatch: pytest.MonkeyPatch) -> None:
    fit = Fit(monkeypatch, supported=False)
    assert fit.found[1].objective == 90.0
    assert {"with_repeated", "whitened", "subsample_inductance.told"}.isdisjoint(fit.seen)


@pytest.mark.parametrize(
    ("how", "captures"),
    [
        ({"without": ("L",), "fix": {}}, ["lossless"] * 2), ({"fix": {"L": 0.0}}, ["lossless"] * 2),
        ({"fix": {"L": 1e-3}}, ["one", "two"]), ({"fix": {"R": 0.0}}, ["one", "two"]),
    ],
)  # fmt: skip
def test_without_an_inductance_the_rise_of_the_current_is_no_drop(
    how: dict[str, Any], captures: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert [given[0] for given in Fit(monkeypatch, **how).made] == captures


@pytest.mark.parametrize("suits", [True, False])
def test_a_search_begins_by_the_motion_where_there_is_one(
    suits: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    doubt = Doubt(DataError("why"))
    without = joint_fit.start_values_without_motion
    monkeypatch.setattr(without, "suits", lambda *of: asked.append(of) or suits)
    monkeypatch.setattr(without, "start_values", lambda *of: asked.append(of) or {"K": 1.0})
    monkeypatch.setattr(
        joint_fit.start_values, "begun", lambda *of: asked.append(of) or ({"K": 2.0}, doubt)
    )
    records: Any = ["record"]
    found = joint_fit._begun(records, FIXED)
    assert found == (({"K": 1.0}, None) if suits else ({"K": 2.0}, doubt))
    assert asked == [(records, FIXED)] * 2


@pytest.mark.parametrize(("objective", "taken"), [(49.9, True), (50.0, False)])
def test_a_motion_is_taken_earlier_in_every_capture(
    objective: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Records of the same shapes are settled from the same start."""
    asked: list[Any] = []
    monkeypatch.setattr(joint_fit, "taken_earlier", lambda capture, late_s: (capture, late_s))
    monkeypatch.setattr(joint_fit, "MotorRecord", lambda *given: given)
    monkeypatch.setattr(joint_fit, "settled", lambda *of: asked.append(of) or solution(objective))
    monkeypatch.setattr(joint_fit, "leaves_misfit", lambda *_: False)
    before: Any = [record(), record()]
    before[0].capture, before[1].capture, before[1].shape = "one", "two", "held"
    doubt = Doubt(DataError("why"), 0.4)
    records, found = joint_fit._doubted(before, solution(50.0), FREE, START, FIXED, doubt)
    first = joint_fit.TRIED[0] * 0.4
    assert asked[0] == (
        [(("one", first), FREE, FIXED, "joined"), (("two", first), FREE, FIXED, "held")],
        FREE, START,
    )  # fmt: skip
    assert (records is not before) is taken
    assert found.objective == (objective if taken else 50.0)


def test_a_fit_that_lacks_support_is_not_refused_for_its_lag(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Any] = []

    def noted(name: str, answer: Any) -> Any:
        return lambda *of: asked.append((name, *of)) or answer

    monkeypatch.setattr(joint_fit, "leaves_misfit", noted("misfit", True))
    monkeypatch.setattr(joint_fit, "unsupported", noted("unsupported", "so"))
    before, found = [record()], solution(50.0)
    assert joint_fit._doubted(before, found, FREE, START, {}, Doubt(DataError("why"))) == (
        before, found,
    )  # fmt: skip
    assert asked == [("misfit", found, before), ("unsupported", before, found)]


# shares of friction


@pytest.mark.parametrize(
    ("free", "tried"),
    [(PARAMETERS, True), (("B", "T0"), True), (("R", "B"), False), (("R", "T0"), False)],
)
def test_friction_is_shared_otherwise_where_both_parts_are_searched(
    free: tuple[str, ...], tried: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(joint_fit.scales, "speed", lambda _: 100.0)
    monkeypatch.setattr(joint_fit, "again", lambda *of: asked.append(of) or of[3])
    whole = solution(50.0)
    places = [PARAMETERS.index(n) for n in free]
    found = replace(
        whole, unknowns=tuple(whole.unknowns[k] for k in places), values=whole.values[places]
    )
    records: Any = [record()]
    assert joint_fit._with_other_friction(records, found, free, START) is found
    assert bool(asked) is tried
    for seen, known, start, _ in asked:
        assert (seen, known, start) == (records, free, START)


@pytest.mark.parametrize(("objective", "taken"), [(49.4, True), (49.5, False), (49.6, False)])
def test_another_share_must_surely_be_likelier(
    objective: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joint_fit.scales, "speed", lambda _: 100.0)
    monkeypatch.setattr(joint_fit, "again", lambda *_: solution(objective))
    records: Any = [record()]
    found = joint_fit._with_other_friction(records, solution(50.0), PARAMETERS, START)
    assert found.objective == (objective if taken else 50.0)


# a rough fit


def test_a_rough_fit_judges_its_sources_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """From what is given and, where that lacks a value, from what a fit would begin with."""
    seen: list[Any] = []

    class Run:
        measured = tuple(
            SimpleNamespace(block=SimpleNamespace(name=n)) for n in ("current", "speed")
        )

        def __init__(self, *given: Any) -> None:
            self.given = given

        def retake_sources(self, values: Any, own: Any) -> None:
            seen.append(("sources", float(values[0]), own.tolist()))

        def departures(self, values: Any, own: Any) -> Any:
            return [f"current {values[0]:g}", f"speed {own[0]:g}"]

    def answer(R: float) -> Solution:
        return replace(solution(1.0, R=R), own=(np.array([R]),))

    monkeypatch.setattr(rough_fit, "MotorRecord", Run)
    monkeypatch.setattr(rough_fit, "pieces", lambda captures: [f"piece of {captures[0]}"])
    note(monkeypatch, rough_fit, "begun", seen, ({"R": 9.0, "K": 8.0}, None))
    note(monkeypatch, rough_fit, "unknowns_of", seen, "unknowns")
    note(monkeypatch, rough_fit, "maximise", seen, answer(1.0))
    note(monkeypatch, rough_fit, "again", seen, answer(2.0), answer(3.0))
    captures: Any = ["run"]
    found: Any = rough_fit.departures(captures, {"R": 5.0}, {"J": 7.0}, ("B",))
    assert found == ["current 3", "speed 3"]
    (one,) = seen[0][1]
    free, held = ["R", "L", "K", "T0"], {"B": 0.0, "J": 7.0}
    assert one.given == ("piece of run", free, held)
    start = {"R": 5.0, "K": 8.0}
    assert seen[0] == ("begun", [one], held)
    assert seen[1] == ("unknowns_of", [one], free, start)
    assert seen[2] == ("maximise", "unknowns", [one], ("enough", alternating_fit.ROUGH))
    assert [call for call in seen if call[0] == "sources"] == [
        ("sources", 1.0, [1.0]), ("sources", 2.0, [2.0]),
    ]  # fmt: skip
    again = [call for call in seen if call[0] == "again"]
    for (_, *how, near, enough), R in zip(again, (1.0, 2.0), strict=True):
        assert how == [[one], free, start]
        assert (near.values[0], enough) == (R, alternating_fit.ROUGH)
