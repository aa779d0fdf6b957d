"""Captures without a motion: which parts of a fit are asked, and what K held at 1 tells."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Channel
from motorid.errors import DataError, UsageError
from motorid.estimate.assembly.assemble import UNCHANGED
from motorid.estimate.partial import electrical_only
from motorid.estimate.results.estimate import Diagnostic, Suspect
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Unknown
from tests.estimate.partial.test_rotor_routes import COUNT, REST, TURNS, log
from tests.report.example import estimate, parameter


def test_captures_without_a_motion_have_a_current_and_a_voltage() -> None:
    both = log(current=TURNS, terminal_voltage=TURNS)
    assert electrical_only.suits([both, log(current=TURNS, supply_voltage=TURNS)])
    for other in (log(current=TURNS), log(terminal_voltage=TURNS), REST,
                  log(current=TURNS, terminal_voltage=TURNS, position=TURNS)):  # fmt: skip
        assert not electrical_only.suits([both, other])


@pytest.mark.parametrize(("step", "flows"), [(1.4, False), (1.6, True)])
def test_a_current_changes_by_more_than_a_count_and_a_half(step: float, flows: bool) -> None:
    changes = np.where(np.arange(COUNT) < 9, 0.0, step)
    changes[50] = np.nan
    one = log(current=Channel(CURRENT, "A", changes, resolution=1.0))
    if flows:
        electrical_only._insist_on_current([one])
        return
    with pytest.raises(DataError, match="never changes, and no motion"):
        electrical_only._insist_on_current([one])
    with pytest.raises(DataError, match=r"never changes in a\.csv, and no motion"):
        electrical_only._insist_on_current([replace(one, path="a.csv")])
    with pytest.raises(DataError, match="never changes"):
        electrical_only._insist_on_current([log(current=np.full(COUNT, np.nan))])


class Electrical:
    """Parts of the fit with K held, which note what they are given."""

    def __init__(self, patch: pytest.MonkeyPatch, stands: bool = False) -> None:
        self.asked: dict[str, list[tuple[Any, ...]]] = {}
        self.found = replace(estimate(), options={"fix": {}, "other": 1})
        answers: dict[str, Any] = {
            "rotor.still_motor": "still", "rotor.leaves_noise": stands, "rotor.estimate": "rotor",
            "joint_fit.solved": ("records", "solution"), "merged": "merged",
            "held_values": "held values", "_on_scale": ("scaled records", "scaled"),
            "uncertain": "doubts", "unjudged": self.found,
            "accused": "said", "judged": "judged",
        }  # fmt: skip
        self.opened = replace(self.found, model="opened")
        answers["_open"] = self.opened
        for name, answer in answers.items():
            owner: Any = electrical_only
            *rooms, last = name.split(".")
            for room in rooms:
                owner = getattr(owner, room)
            patch.setattr(owner, last, self.noting(name, answer))

    def noting(self, name: str, answer: Any) -> Any:
        def part(*given: Any) -> Any:
            self.asked.setdefault(name, []).append(given)
            return answer

        return part


BOTH = [log(current=TURNS, terminal_voltage=TURNS)]


def test_a_rotor_that_leaves_noise_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = Electrical(monkeypatch, stands=True)
    assert electrical_only.fit(BOTH, {"R": 2.0}, ()) == "rotor"
    assert parts.asked["rotor.still_motor"] == [(BOTH, {"R": 2.0, "K": 1.0})]
    assert parts.asked["rotor.leaves_noise"] == [(BOTH, "still")]
    assert parts.asked["joint_fit.solved"] == [(BOTH, "still", ())]
    assert parts.asked["rotor.estimate"] == [(BOTH, "records", "solution", "still", {"R": 2.0})]


def test_one_that_turns_is_fitted_for_a_constant_of_one(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = Electrical(monkeypatch)
    held = {"R": 2.0, "K": 1.0}
    assert electrical_only.fit(BOTH, {"R": 2.0}, ()) == "judged"
    assert parts.asked["joint_fit.solved"] == [(BOTH, held, ())]
    assert parts.asked["uncertain"] == [("records", "solution", held, ())]
    assert parts.asked["unjudged"] == [(BOTH, "records", "doubts", held, ())]
    assert parts.asked["_open"] == [(parts.found,)]
    ((known, *others),) = parts.asked["judged"]
    assert known == replace(parts.opened, options={"fix": {"R": 2.0}, "other": 1})
    assert others == ["records", "solution", "said", electrical_only.COMBINED]


@pytest.mark.parametrize(
    ("fix", "without"), [({}, ("B",)), ({"K": 0.05}, ()), ({"K": 0.05}, ("B",))]
)
def test_a_rotor_is_not_taken_to_stand_where_more_is_given(
    fix: dict[str, float], without: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = Electrical(monkeypatch, stands=True)
    assert electrical_only.fit(BOTH, fix, without) == "judged"
    assert parts.asked["joint_fit.solved"] == [(BOTH, {"K": fix.get("K", 1.0)}, without)]
    assert "_on_scale" not in parts.asked
    assert ("_open" in parts.asked) is not bool(fix)
    changed = parts.asked["judged"][0][-1]
    assert changed is (UNCHANGED if fix else electrical_only.COMBINED)


def test_another_that_is_given_sets_the_scale(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = Electrical(monkeypatch)
    fix = {"J": 2e-5, "L": 1e-3}
    assert electrical_only.fit(BOTH, fix, ("B",)) == "judged"
    assert parts.asked["joint_fit.solved"] == [(BOTH, {"L": 1e-3, "K": 1.0}, ("B",))]
    assert parts.asked["held_values"] == [({"L": 1e-3, "K": 1.0}, ("B",))]
    assert parts.asked["merged"] == [("held values", "solution")]
    assert parts.asked["_on_scale"] == [("records", "solution", fix, ("B",), "J", "merged")]
    assert parts.asked["uncertain"] == [("scaled records", "scaled", fix, ("B",))]
    assert parts.asked["unjudged"] == [(BOTH, "scaled records", "doubts", fix, ("B",))]


@pytest.mark.parametrize("fix", [{}, {"K": 0.05}])
def test_better_models_are_asked_on_the_scale_that_was_fitted(
    fix: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = Electrical(monkeypatch)
    accused = SimpleNamespace(worst=None)
    monkeypatch.setattr(electrical_only, "accused", lambda *_: accused)
    judged = replace(parts.opened, combinations={"J/K²": parameter("J/K²", "A·s/V", 2.0)},
                     parameters={"J": parameter("J", "kg·m²", 2.0)}, suspects=())  # fmt: skip
    monkeypatch.setattr(electrical_only, "judged", lambda *_: judged)
    said = Diagnostic("better_model", "warning", "a fan", {"J": 3.0}, {"J": (3.0, 1.0)})
    asked: list[Any] = []

    def better(*given: Any) -> list[Diagnostic]:
        asked.append(given)
        return [said]

    found = electrical_only.fit(BOTH, fix, ("B",), better)
    names = UNCHANGED if fix else electrical_only.COMBINED
    held = {"K": fix.get("K", 1.0)}
    assert asked == [(parts.found, "records", "doubts", held, ("B",), names)]
    name = "J" if fix else "J/K²"
    assert found.diagnostics[0].moves == {name: 3.0}
    assert found.diagnostics[0].sides == {name: (3.0, 1.0)}
    table = found.parameters if fix else found.combinations
    assert table[name].status is Status.DOUBTFUL
    accused.worst = "too much"
    assert electrical_only.fit(BOTH, fix, ("B",), better) is judged
    accused.worst = None
    named = Suspect("current_lag", "current", "late", "state it", "named")
    judged = replace(judged, suspects=(named,))
    assert electrical_only.fit(BOTH, fix, ("B",), better) is judged
    assert len(asked) == 1
    judged = replace(judged, suspects=(replace(named, allowed=True),))
    assert electrical_only.fit(BOTH, fix, ("B",), better) is not judged


def test_two_that_are_given_are_too_many() -> None:
    with pytest.raises(UsageError, match="cannot fix K and T0 together"):
        electrical_only.fit(BOTH, {"K": 0.05, "T0": 1e-3}, ())


def test_records_are_made_of_what_is_free_and_what_is_held(monkeypatch: pytest.MonkeyPatch) -> None:
    speed, offset = Unknown("initial speed", 5.0), Unknown("current offset", 0.0)
    made = lambda *given: SimpleNamespace(given=given, unknowns=(speed, offset))  # noqa: E731
    monkeypatch.setattr(electrical_only, "MotorRecord", made)
    monkeypatch.setattr(electrical_only, "searched", lambda fixed: ("free", *fixed))
    monkeypatch.setattr(electrical_only.multistart, "solve", lambda *given: given)
    values = {"R": 2.0, "L": 1e-3, "K": 1.0, "B": 4.0, "J": 2.0, "T0": 6.0}
    held = electrical_only.held_values({"J": 8.0}, ())
    sizes = {"initial speed": 3.0, "current offset": 7.0}
    before: Any = SimpleNamespace(capture=BOTH[0], shape="held", sizes=lambda own: sizes | own)
    solution: Any = SimpleNamespace(own=({},))
    records, solved = electrical_only._on_scale([before], solution, {"J": 8.0}, (), "J", values)
    (record,) = records
    assert record.given == (BOTH[0], ("free", *held), held, "held")  # the voltage's shape stays
    assert [u.start for u in record.unknowns] == [1.5, 0.0]  # at twice the K half the speed
    begun = {"R": 2.0, "L": 1e-3, "K": 2.0, "B": 16.0, "J": 8.0, "T0": 12.0}
    assert solved == (records, ("free", *held), pytest.approx(begun))


def test_what_is_told_for_a_constant_of_one_are_combinations(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(electrical_only, "budget", lambda shares: ("budget of", *shares))
    notes = [Diagnostic("budget", "info", "old"), Diagnostic("other", "info", "kept")]
    found = estimate()
    derived = dict.fromkeys(("stall_current", "no_load_speed"), found.parameters["R"])
    some = replace(
        found, budget={"R": {"noise": 1.0}, "J": {"gain": 1.0}, "K": {"noise": 1.0}},
        not_stated={"a gain": {"T0": 0.5, "R": 1.0}}, diagnostics=tuple(notes), derived=derived,
        free=("R", "J", "T0"), parameters={
            **found.parameters, "B": replace(found.parameters["B"], status=Status.FIXED),
        },
    )  # fmt: skip
    some = replace(some, nuisance={
        name: replace(found.parameters["T0"], name=name, unit=unit)
        for name, unit in (("initial speed of run 2", "rad/s"), ("initial current", "A"))
    })  # fmt: skip
    told = electrical_only._open(some)
    assert {n: (p.name, p.unit) for n, p in told.nuisance.items()} == {
        "initial back-EMF of run 2": ("initial back-EMF of run 2", "V"),
        "initial current": ("initial current", "A"),
    }
    assert set(told.combinations) == {"J/K²", "T0/K"}
    ratio = told.combinations["J/K²"]
    assert (ratio.name, ratio.unit) == ("J/K²", "A·s/V")
    assert ratio.value == found.parameters["J"].value
    assert told.parameters["B"] == some.parameters["B"]
    for name in ("K", "J", "T0"):
        assert told.parameters[name].value is None
        assert told.parameters[name].name == name
    assert set(told.derived) == {"stall_current"}
    assert told.free == ("R", "J/K²", "T0/K")
    assert told.budget == {"R": {"noise": 1.0}, "J/K²": {"gain": 1.0}, "K": {"noise": 1.0}}
    assert told.not_stated == {"a gain": {"T0/K": 0.5, "R": 1.0}}
    said, *others = told.diagnostics
    assert (said.code, said.severity) == ("no_motion", "info")
    assert others == [notes[1], "budget of", "R", "J/K²"]
    unseen = {**some.parameters, "R": parameter("R", "ohm", None)}
    hidden = electrical_only._open(replace(some, parameters=unseen)).combinations["T0/K"]
    assert (hidden.name, hidden.unit, hidden.value) == ("T0/K", "A", None)
    assert hidden.note == electrical_only.UNSEEN
