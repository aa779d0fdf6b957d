"""The fit with terms that a person names: in which order, and from where."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from motorid.errors import DataError
from motorid.estimate.fit import alternating_fit
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.selection import named_terms
from motorid.estimate.selection.score_test import Candidate
from tests.estimate.selection.noted_stages import noting
from tests.estimate.solutions import MOTOR, solution

DROP, HEAT, SIDED, COGS, TWO = (
    TERMS[name] for name in ("brush-drop", "heating", "direction", "cogging", "two-masses")
)


def test_terms_that_repeat_with_the_rotor_come_after_the_others_and_ripple_first() -> None:
    ripple = TERMS["ripple"]
    assert named_terms._stages([COGS, DROP, ripple, SIDED]) == [(DROP, SIDED), (ripple,), (COGS,)]
    assert named_terms._stages([COGS]) == [(COGS,)]
    assert named_terms._stages([DROP]) == [(DROP,)]


@pytest.mark.parametrize(
    ("term", "why"),
    [
        (COGS, "do not repeat with the rotor's angle"), (SIDED, "the motor turns one way"),
        (TERMS["ke-kt"], "scale together; hold one"),
    ],
)  # fmt: skip
def test_a_term_that_the_captures_cannot_tell_is_refused(
    term: Any, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(named_terms, "plain", lambda *_: "white")
    monkeypatch.setattr(named_terms, "starts", lambda *_: {})
    monkeypatch.setattr(named_terms, "sizes_by_name", lambda *_: [{}])
    with pytest.raises(DataError, match=why):
        named_terms._starts([], solution(), MOTOR, (), (term,))
    start, _ = named_terms._starts([], solution(), MOTOR, (), (DROP,))
    assert start == MOTOR  # what does not show yet may show beside the others


def test_terms_begin_where_straight_lines_see_them_beside_those_that_are_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Any] = []

    def starts(_r: Any, white: Any, _v: Any, terms: Any) -> Any:
        asked.append((white, list(terms)))
        return {COGS: ({"T_c": 1.0}, ({"phase": 0.5}, {"phase": 0.7})), DROP: ({"V_b": 2.0}, ())}

    monkeypatch.setattr(named_terms, "plain", lambda *_: "white")
    monkeypatch.setattr(named_terms, "starts", starts)
    monkeypatch.setattr(named_terms, "sizes_by_name", lambda *_: [{"a": 1.0}, {"a": 2.0}])
    start, own = named_terms._starts([], solution(), {"R": 3.0}, (SIDED,), (SIDED, COGS, DROP)[1:])
    assert asked == [("white", [COGS, DROP])]
    assert start == {"R": 3.0, "T_c": 1.0, "V_b": 2.0}
    assert own == [{"a": 1.0, "phase": 0.5}, {"a": 2.0, "phase": 0.7}]


def test_each_stage_begins_where_the_one_before_ended_and_the_last_is_the_nearest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    enough, begun = list[float](), list[Any]()

    class Stage:
        def __init__(self, name: str) -> None:
            self.records, self.solution, self.values = name, name, {"R": 1.0}

        def roughly(self, near: float) -> Any:
            enough.append(near)
            return self

        def nearly(self, rough: Any, lent: bool) -> Any:
            assert not lent
            return rough

    def begin(records: Any, _s: Any, terms: Any, **_: Any) -> Stage:
        begun.append((records, terms))
        return Stage("+".join(t.name for t in terms))

    monkeypatch.setattr(named_terms, "begin", begin)
    monkeypatch.setattr(named_terms, "_starts", lambda *_: ({}, []))
    monkeypatch.setattr(named_terms, "finished", lambda fitted: fitted)
    records: Any = "six"
    found: Any = named_terms.asked_for(records, solution(), MOTOR, (COGS, DROP, TERMS["ripple"]))
    assert [on for on, _ in begun] == ["six", "brush-drop", "brush-drop+ripple"]
    assert found.records == "brush-drop+ripple+cogging"
    assert enough[0] == enough[1] > enough[2]


def test_stages_begin_with_what_the_one_before_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """Values that were not searched are held; the last stage is judged as near as any."""
    seen: dict[str, Any] = {}
    rough = [
        SimpleNamespace(records=f"records {k}", solution=solution(R=k + 1.0), values=f"values {k}")
        for k in (0, 1)
    ]
    left = list(rough)

    class Begun:
        def roughly(self, enough: float) -> Any:
            seen.setdefault("enough", []).append(enough)
            return left.pop(0)

        def nearly(self, last: Any, lent: bool) -> Any:
            assert not lent  # nothing bounds it
            seen["nearly"] = last
            return "near"

    noting(
        monkeypatch, named_terms, seen, begin=Begun(), _starts=("start", "own"), finished="finished"
    )
    values = {**MOTOR, "d_Ke": 0.1}
    found: Any = named_terms.asked_for("records", solution(), values, (COGS, SIDED))  # type: ignore[arg-type]
    assert found == "finished"
    assert seen["finished"] == [("near",)]
    assert seen["nearly"] is rough[1]
    assert seen["enough"] == [named_terms.COARSE, alternating_fit.ROUGH]
    first, second = seen["_starts"]
    assert (first[0], *first[2:]) == ("records", values, (), (SIDED,))
    assert second == ("records 0", rough[0].solution, "values 0", (SIDED,), (COGS,))
    how = (("fixed", {"d_Ke": 0.1}), ("start", "start"), ("own", "own"))
    (old, before, *first_how), later = seen["begin"]
    assert (old, before.values.tolist()) == ("records", list(MOTOR.values()))
    assert tuple(first_how) == ((SIDED,), *how)
    assert later == ("records 0", rough[0].solution, (SIDED, COGS), *how)


def test_where_terms_begin_is_seen_in_white_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two masses where a resonance is, though the residuals be like noise."""
    seen: dict[str, Any] = {}
    shaft = Candidate(TWO, 9.0, {}, {"Ks": 3.0}, ())
    noting(
        monkeypatch, named_terms, seen, plain="white", starts={SIDED: ({"d_T0": 0.2}, ())},
        springs=[shaft], sizes_by_name=[{"a": 1.0}],
    )  # fmt: skip
    found = solution()
    start, own = named_terms._starts("records", found, MOTOR, (DROP,), (SIDED, TWO, DROP))  # type: ignore[arg-type]
    assert start == {**MOTOR, "d_T0": 0.2, "Ks": 3.0}
    assert own == [{"a": 1.0}]
    assert seen["plain"] == seen["sizes_by_name"] == [("records", found)]
    assert seen["starts"] == [("records", "white", MOTOR, [SIDED, TWO])]
    assert seen["springs"] == [("records", "white", MOTOR, (DROP,), ("asked", True))]
    seen.clear()
    named_terms._starts("records", found, MOTOR, (), (SIDED,))  # type: ignore[arg-type]
    assert "springs" not in seen
