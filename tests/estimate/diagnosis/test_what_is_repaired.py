"""Which named fault a fit allows for, and of which fits with it the likeliest is taken."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.diagnosis import repair
from motorid.estimate.diagnosis.faults import missing_samples
from motorid.estimate.diagnosis.rank import Convicted
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.solver.problem import Solution, Unknown

MOTOR = {"R": 2.0, "K": 0.05}


def solution(objective: float = 5.0, converged: bool = True) -> Solution:
    return Solution(
        tuple(Unknown(n, v) for n, v in MOTOR.items()), np.array(list(MOTOR.values())), (), (),
        np.eye(2), np.zeros(2, dtype=bool), tuple, objective, 1, converged,
    )  # fmt: skip


def suspect(code: str, **facts: Any) -> Suspect:
    return Suspect(code, "time", "so", "do", **{"strength": "named", "moves": {"R": 1.0}, **facts})


def convicted(one: Suspect, records: tuple[int, ...] = (0,), **hypothesis: Any) -> Convicted:
    h = SimpleNamespace(
        **{
            "quantity": None,
            "remedy": None,
            "afterwards": False,
            "whole": False,
            "place": None,
            "scatter": None,
            **hypothesis,
        }
    )
    found = SimpleNamespace(size=np.array([-3e-4]), values=np.array([2.5, 0.06]))
    trial: Any = SimpleNamespace(hypothesis=h, found=found)
    return Convicted(one, records, trial)


LOST, LAG, ZERO = suspect(missing_samples.CODE), suspect("current_lag"), suspect("current_offset")


def mended(
    monkeypatch: pytest.MonkeyPatch, found: list[Suspect], guilty: Convicted | None = None,
    left: float = 0.05, was: float = 0.5, converged: bool = True, fails: str = "", none: str = "",
) -> tuple[repair.Repaired | None, list[str]]:  # fmt: skip
    """Which is repaired, and what was tried; ``fails`` and ``none``: of which nothing comes."""
    tried: list[str] = []

    def fit(name: str) -> Any:
        def made(records: Any, *given: Any) -> Any:
            tried.append(name)
            assert records == []
            began = {"T0": 0.0, "R": 2.0, "K": 0.05}
            assert given[1:] == ((guilty, {"T0": 0.0}) if name == "size" else (began,))
            assert name == "size" or given[0] == {"T0": 0.0}
            if name == fails:
                raise DataError("no start")
            after = replace(solution(converged=converged), values=np.array([2.6, 0.05]))
            return None if name == none else (["again"], after)

        return made

    for name in ("_with_time", "_with_size", "_with_zero"):
        monkeypatch.setattr(repair, name, fit(name[6:]))
    misfits = iter([was, *[left] * len(found)])
    monkeypatch.setattr(repair.misfit, "of_fit", lambda *_: next(misfits))
    monkeypatch.setattr(repair.misfit, "residuals", lambda *_: [])
    monkeypatch.setattr(repair.misfit, "excess", lambda *_: next(misfits))
    return repair.repaired([], solution(), found, guilty, {"T0": 0.0}, ()), tried


def test_the_first_that_can_be_estimated_is(monkeypatch: pytest.MonkeyPatch) -> None:
    found, tried = mended(monkeypatch, [suspect("encoder_sign"), ZERO, LOST])
    assert tried == ["zero"]
    assert found is not None
    assert found.records == ["again"]
    said = found.suspect
    assert said.evidence == "so; the fit allows for it"
    assert (said.moves, said.allowed) == ({}, True)
    assert said.without == {"T0": 0.0, "R": 2.0, "K": 0.05}
    assert mended(monkeypatch, [LOST])[1] == ["time"]
    assert mended(monkeypatch, [LAG], convicted(LAG))[1] == ["size"]
    assert mended(monkeypatch, [LAG], convicted(replace(LAG)))[1] == []  # another one was
    assert mended(monkeypatch, [replace(ZERO, allowed=True)])[1] == []
    assert mended(monkeypatch, [replace(ZERO, strength="not excluded")])[1] == []


def test_the_next_is_tried_where_one_does_not_explain_it(monkeypatch: pytest.MonkeyPatch) -> None:
    both = [LOST, ZERO]
    for how in ({"fails": "time"}, {"none": "time"}):
        found, tried = mended(monkeypatch, both, **how)  # type: ignore[arg-type]
        assert tried == ["time", "zero"]
        assert found is not None
        assert found.suspect.code == "current_offset"
    assert mended(monkeypatch, both, left=0.11) == (None, ["time", "zero"])
    assert mended(monkeypatch, both, left=0.09)[1] == ["time"]
    for was, left, first in ((2.0, 0.29, True), (2.0, 0.31, False), (9.0, 0.69, True),
                             (9.0, 0.71, False)):  # fmt: skip
        found, tried = mended(monkeypatch, both, left=left, was=was)
        assert (found is not None) is first
        if found is not None:  # as much of what the fault did may be left
            share = np.sqrt(left / was)
            assert found.suspect.moves["R"] == pytest.approx(share * 0.6)
            assert found.suspect.allowed
        assert tried == (["time"] if first else ["time", "zero"])
    assert mended(monkeypatch, both, converged=False) == (None, ["time", "zero"])


class Again:
    """A record that notes what it is asked to find."""

    def __init__(self, capture: str = "run", log: bool = False) -> None:
        self.capture, self.timeline, self.shape = capture, "line", "joined"
        self.sensed = SimpleNamespace(waveform="logged" if log else None)
        self.found = dict[Any, Any]()
        self.measured, self.colour, self.rivals = [1, 2], "coloured", ()
        self.instances, self.unknowns = (), ()

    def twin(self) -> Again:
        return Again(self.capture)

    def whiten(self, filters: list[None]) -> None:
        self.colour = f"white in {len(filters)}"

    def find(self, sizes: Any) -> None:
        self.found.update(sizes)


def fitted(monkeypatch: pytest.MonkeyPatch, objectives: tuple[float, ...] = (5.0,)) -> list[Any]:
    """Where fits begin; they end with these objectives in turn."""
    began: list[Any] = []
    left = list(objectives)

    def fit(records: Any, held: Any, start: Any) -> Any:
        began.append((records, dict(start)))
        return records, solution(left.pop(0))

    monkeypatch.setattr(repair, "_fitted", fit)
    return began


def test_a_fault_with_a_quantity_is_an_unknown_of_about_the_trials_size(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    began = fitted(monkeypatch, (5.0, 5.0))
    guilty = convicted(LAG, (1,), quantity=CURRENT_OFFSET, scale=(1e-4,), lower=(-1e-3,),
                       upper=(2e-3,))  # fmt: skip
    records: Any = [Again(), Again()]
    assert repair._with_size(records, solution(), guilty, {"T0": 0.0}) is not None
    ((again, start),) = began
    assert start == {"T0": 0.0, "R": 2.5, "K": 0.06}  # where the trial ended
    assert again[0].found == {}
    (unknown,) = again[1].found.values()
    assert set(again[1].found) == {Instance(CURRENT_OFFSET)}
    assert (unknown.start, unknown.prior_sd) == (-3e-4, 3e-4)
    assert (unknown.lower, unknown.upper, unknown.scale) == (-1e-3, 2e-3, 1e-4)
    assert [r.colour for r in again] == ["white in 2"] * 2
    assert records[0].colour == "coloured"
    logs: Any = [Again(log=True), Again(log=True)]
    assert repair._with_size(logs, solution(), guilty, {}) is None
    guilty.trial.hypothesis.afterwards = True  # which no fit of logs looks for
    assert repair._with_size(logs, solution(), guilty, {}) is not None


def test_a_size_that_is_a_whole_number_is_held_there(monkeypatch: pytest.MonkeyPatch) -> None:
    began = fitted(monkeypatch)
    guilty = convicted(LAG, (0,), quantity=CURRENT_OFFSET, scale=(1.0,), lower=(0.0,),
                       upper=(200.0,), whole=True)  # fmt: skip
    guilty.trial.found.size[0] = 6.97
    assert repair._with_size([Again()], solution(), guilty, {}) is not None  # type: ignore[list-item]
    (unknown,) = began[0][0][0].found.values()
    assert (unknown.start, unknown.lower, unknown.upper) == (7.0, 7.0, 7.0)


def test_else_the_likeliest_of_the_captures_that_declare_it_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    began = fitted(monkeypatch, (9.0, 4.0, 6.0))
    fresh: list[Any] = []
    monkeypatch.setattr(repair, "_fresh", lambda *given: fresh.append(given[1:]) or Again(given[0]))
    asked: list[Any] = []

    def remedy(capture: str, size: float) -> list[str]:
        asked.append((capture, size))
        return [f"{capture} {n}" for n in range(3)]

    records: Any = [Again("one"), Again("two")]
    found = repair._with_size(records, solution(), convicted(LAG, (1,), remedy=remedy), {})
    assert asked == [("two", -3e-4)]
    assert fresh == [(records[0], {}), (records[1], {})] * 3
    assert [[r.capture for r in again] for again, _ in began] == [
        ["one", "two 0"], ["one", "two 1"], ["one", "two 2"],
    ]  # fmt: skip
    assert found is not None
    assert found[1].objective == 4.0
    assert [r.behind for r in found[0][0].rivals] == [5.0, 2.0]
    assert repair._with_size(records, solution(), convicted(LAG), {}) is None


def test_samples_are_put_back_where_all_of_them_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    began = fitted(monkeypatch, (5.0, 5.0))
    monkeypatch.setattr(repair, "_fresh", lambda capture, _r, _h: Again(capture))
    monkeypatch.setattr(
        missing_samples, "put_back", lambda c, _: "mended" if c == "short" else None
    )
    monkeypatch.setattr(repair.lost_samples, "suspects", lambda *_: [])
    records: Any = [Again("short"), Again("whole")]
    assert repair._with_time(records, {}, {}) is not None
    assert [r.capture for r in began[0][0]] == ["mended", "whole"]
    assert repair._with_time(records[1:], {}, {}) is None
    monkeypatch.setattr(repair.lost_samples, "suspects", lambda *_: ["still short"])
    assert repair._with_time(records, {}, {}) is None


def test_a_zero_is_about_as_far_off_as_it_reads(monkeypatch: pytest.MonkeyPatch) -> None:
    began = fitted(monkeypatch)
    seen = iter([-0.02, None])
    monkeypatch.setattr(repair.current_zero, "seen", lambda _: next(seen))
    usual = Unknown("current offset", 0.0, prior_sd=1e-3)
    monkeypatch.setattr(Instance, "unknown", lambda *_: usual)
    records: Any = [Again(), Again()]
    assert repair._with_zero(records, {}, {}) is not None
    one, other = began[0][0]
    (unknown,) = one.found.values()
    assert (unknown.start, unknown.prior_sd) == (-0.02, 0.02)
    assert other.found == {}


def test_another_capture_has_what_was_found_of_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """And nothing of what every record has by itself."""
    asked: list[Any] = []

    def made(*given: Any) -> Again:
        asked.append(given)
        return Again()

    monkeypatch.setattr(repair, "MotorRecord", made)
    monkeypatch.setattr(repair, "searched", lambda held: ("free of", *held))
    first: Any = Again()
    first.instances, first.unknowns, first.found = ("lag", "offset"), (1.0, 2.0), {"lag": 1.0}
    capture: Any = "mended"
    again: Any = repair._fresh(capture, first, {"K": 2.0})
    assert asked == [("mended", ("free of", "K"), {"K": 2.0}, "joined")]
    assert again.found == {"lag": 1.0}
