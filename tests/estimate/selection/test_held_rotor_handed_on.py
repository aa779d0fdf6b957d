"""What each stage of a held rotor's answer is handed."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.selection import held_rotor
from tests.estimate.selection.noted_stages import noting
from tests.estimate.solutions import MOTOR, solution
from tests.report.example import estimate

SIDED = TERMS["direction"]


class Held:
    """A held rotor's answer whose stages are given."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, model: str, terms: Any = (SIDED,)) -> None:
        self.seen = dict[str, Any]()
        self.six = replace(estimate(), diagnostics=("own",))
        self.fitted = SimpleNamespace(terms=terms)
        noting(monkeypatch, held_rotor.locked_rotor, self.seen, still_motor={"K": 1.0, "R": 3.0},
               estimate=self.six)  # fmt: skip
        noting(monkeypatch, held_rotor.joint_fit, self.seen, solved=("records", solution(L=5.0)))
        noting(
            monkeypatch, held_rotor, self.seen, asked_for=self.fitted, findings="findings",
            alternative="better", _without_mechanics="electrical", _with="beside",
            _supported=(self.fitted, ("trial",)), reach={"L": 0.1},
        )  # fmt: skip
        remarks = {"one": None, "two": "gave way"}
        monkeypatch.setattr(held_rotor, "_gave_way", remarks.__getitem__)
        monkeypatch.setattr(held_rotor, "stilled", lambda capture: f"still {capture}")
        captures: Any = ["one", "two"]
        self.answer: Any = held_rotor.fit(captures, {"R": 3.0}, ("L", "R"), model)


def test_a_held_rotor_is_fitted_with_what_iron_does(monkeypatch: pytest.MonkeyPatch) -> None:
    made = Held(monkeypatch, "auto")
    seen, still = made.seen, ["still one", "still two"]
    (how,) = seen["still_motor"]
    assert how == (still, {"L": 0.0, "R": 3.0})
    motor = {"K": 1.0, "R": 3.0}
    assert seen["solved"] == [(still, motor, ())]
    ((captures, records, solved, *rest),) = seen["estimate"]
    assert (captures, records, solved.objective) == (still, "records", 0.0)
    assert rest == [motor, {"R": 3.0}, ("L", "R"), held_rotor.WHY]
    values = {**MOTOR, "L": 5.0}
    assert seen["asked_for"] == [("records", solved, values, held_rotor.IRON)]
    ((fitted, moves),) = seen["_supported"]
    assert fitted is made.fitted
    assert (moves.values, moves.matters) == (values, {"L": 0.1})
    assert seen["findings"] == [(made.fitted, motor, ("L", "R"))]
    assert seen["alternative"] == [
        (made.fitted, "findings", "records", solved, ("trial",), ("asked", False))
    ]
    assert seen["_without_mechanics"] == [("better", {"R": 3.0}, ("L", "R"))]
    ((six, better),) = seen["_with"]
    assert six.diagnostics == ("gave way", "own")
    assert (better, made.answer) == ("electrical", "beside")


def test_a_held_rotors_terms_may_be_named_or_none(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = Held(monkeypatch, "saturation")
    assert asked.seen["asked_for"][0][3] == (TERMS["saturation"],)
    assert "_supported" not in asked.seen
    *_, trials, flag = asked.seen["alternative"][0]
    assert (trials, flag) == ((), ("asked", True))
    six = Held(monkeypatch, "six")
    assert six.answer.diagnostics == ("gave way", "own")
    assert "asked_for" not in six.seen
    none = Held(monkeypatch, "auto", terms=())
    assert none.answer.diagnostics == ("gave way", "own")
    assert "findings" not in none.seen


def test_terms_that_go_are_fitted_without_from_where_the_others_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    noting(monkeypatch, held_rotor, seen, asked_for="refitted")
    fitted: Any = SimpleNamespace(model=("records", "solution", "values"))
    assert held_rotor._refitted(fitted, (SIDED,)) == "refitted"  # type: ignore[comparison-overlap]
    assert seen["asked_for"] == [("records", "solution", "values", (SIDED,))]
    monkeypatch.setattr(held_rotor, "replace", lambda one, **new: (one, new))
    assert held_rotor._refitted(fitted, ()) == (fitted, {"terms": ()})  # type: ignore[comparison-overlap]
