"""Which model stands beside the six parameters: none, the one that was named, or what is found."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.errors import UsageError
from motorid.estimate.fit import sign_check
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.results.status import Status
from motorid.estimate.selection import entry
from motorid.estimate.selection.evidence import Evidence
from motorid.estimate.selection.forward_selection import Selection, Trial
from tests.estimate.solutions import MOTOR, solution
from tests.report.example import estimate

SIDED, COGS = TERMS["direction"], TERMS["cogging"]


def answer(status: Status = Status.ESTIMATED) -> Estimate:
    one = estimate()
    K = replace(one.parameters["K"], status=status)
    return replace(one, parameters={**one.parameters, "K": K}, alternative=None, diagnostics=())


class Closed(str):
    """Records by a name; whether readings of one lie far off is asked of each."""

    outlying = False

    def __iter__(self) -> Any:
        yield self


class Room:
    """The room with its neighbours replaced by what notes how they were asked."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, status: Status, *offered: Any) -> None:
        self.asked: dict[str, Any] = {}
        self.offered, self.closed = offered, Closed("closed records")
        known: Any = SimpleNamespace(solution=solution(R=7.0))
        neighbours = {
            "_closed": lambda *_: ("captures", "records", solution()),
            "answered": lambda *_: (answer(status), self.closed, known),
            "asked_for": self.named,
            "looked_for": self.looked,
            "_narrow": self.narrow,
            "standing_out": self.best,
            "findings": lambda *rest: ("findings", *rest),
            "alternative": self.alternative,
            "with_seen": self.seen,
        }
        for name, other in neighbours.items():
            monkeypatch.setattr(entry, name, other)

    def narrow(self, records: Any, known: Any, values: Any, held: Any, terms: Any) -> Any:
        assert (records, held, tuple(terms)) == ("closed records", {"B": 0.0}, (SIDED,))
        assert values == {**MOTOR, "R": 7.0}
        return "narrow records", known, values

    def named(self, records: Any, _s: Any, _v: Any, terms: Any) -> Any:
        assert records == "narrow records"
        self.asked["named"] = tuple(terms)
        return SimpleNamespace(terms=tuple(terms), records="wide", solution="its own")

    def looked(self, records: Any, known: Any, held: Any, matters: Any) -> Any:
        assert (records, held) == ("closed records", {"B": 0.0})
        assert matters == entry.reach(answer().parameters)
        self.asked["looked"] = known
        trials = tuple(Trial(t, (), Evidence(1.0, 1.0, 1.0), 1.0, True) for t in (SIDED, COGS))
        return Selection(("stage",), trials, ()), ("narrow records", known, {})  # type: ignore[arg-type]

    def best(self, chosen: Any, fix: Any, without: Any) -> Any:
        assert (chosen.stages, fix, without) == (("stage",), {}, ("B",))
        wide = SimpleNamespace(terms=self.offered, records="wide", solution="its own", settled=True)
        return (wide, "known") if self.offered else None, ()

    def alternative(self, fitted: Any, found: Any, *rest: Any, asked: bool) -> Any:
        self.asked["alternative"] = (fitted.terms, found, *rest)
        return SimpleNamespace(asked=asked, nuisance={}, parameters=answer().parameters)

    def seen(self, given: Estimate, found: Any) -> Estimate:
        self.asked["seen"] = found
        return given

    def tell(self, model: str) -> Estimate:
        return entry.fit([], {}, ("B",), model)


@pytest.mark.parametrize(
    ("status", "model", "way"),
    [
        (Status.ESTIMATED, "six", None),
        (Status.NOT_IDENTIFIABLE, "six", None),
        (Status.NOT_SUPPORTED, "auto", None),
        (Status.NOT_SUPPORTED, "direction", None),
        (Status.NOT_IDENTIFIABLE, "auto", None),
        (Status.ESTIMATED, "auto", "looked"),
        (Status.FIXED, "auto", "looked"),
        (Status.ESTIMATED, "direction", "named"),
        (Status.NOT_IDENTIFIABLE, "direction", "named"),
    ],
)
def test_a_better_model_is_looked_for_or_made_as_named(
    status: Status, model: str, way: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    room = Room(monkeypatch, status)
    found = room.tell(model)
    assert set(room.asked) & {"looked", "named"} == ({way} if way else set())
    assert ("seen" in room.asked) is (way is not None)
    assert (found.alternative is not None) is (way == "named")


def test_one_that_was_named_stands_beside_the_six_whatever_it_says(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room = Room(monkeypatch, Status.ESTIMATED)
    found = room.tell("direction")
    terms, known, records, known_solution, trials = room.asked["alternative"]
    assert (terms, records, trials) == ((SIDED,), "narrow records", ())
    assert (known[0], *known[2:]) == ("findings", {}, ("B",))
    assert known_solution.values[0] == 7.0
    assert room.asked["seen"] == known
    assert [d.code for d in found.diagnostics] == ["model_asked"]
    assert found.alternative is not None
    assert found.alternative.asked


def test_one_that_was_found_says_which_of_its_trials_are_in_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room = Room(monkeypatch, Status.ESTIMATED, SIDED)
    found = room.tell("auto")
    terms, known, records, _, trials = room.asked["alternative"]
    assert (terms, known, records) == ((SIDED,), "known", "narrow records")
    assert [(t.term, t.taken) for t in trials] == [("direction", True), ("cogging", False)]
    assert room.asked["seen"] == "known"
    assert [d.code for d in found.diagnostics] == ["better_model"]
    assert found.alternative is not None
    assert not found.alternative.asked


def test_where_nothing_stands_out_it_is_said_what_was_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room = Room(monkeypatch, Status.ESTIMATED)
    found = room.tell("auto")
    assert [d.code for d in found.diagnostics] == ["model_tried"]
    assert "direction, cogging" in found.diagnostics[0].message
    assert "alternative" not in room.asked
    assert room.asked["seen"].solution.values[0] == 7.0


def test_a_name_of_no_term_is_refused() -> None:
    with pytest.raises(UsageError, match="warp"):
        entry.fit([], {}, (), "warp")


def test_captures_of_a_wrong_sign_are_put_right_and_that_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wrong = sign_check.WrongSignError.__new__(sign_check.WrongSignError)
    given: list[Any] = []

    def of(captures: Any, fix: Any, without: Any, model: str) -> Estimate:
        given.append((captures, fix, without, model))
        if len(given) == 1:
            raise wrong
        return replace(answer(), suspects=("another",))  # type: ignore[arg-type]

    monkeypatch.setattr(entry, "_of", of)
    monkeypatch.setattr(sign_check, "put_right", lambda captures, error: [captures, error])
    monkeypatch.setattr(sign_check, "allowed", lambda error: ("sign", error))
    found = entry.fit([], {"R": 1.0}, ("B",), "six")
    assert given == [([], {"R": 1.0}, ("B",), "six"), ([[], wrong], {"R": 1.0}, ("B",), "six")]
    assert found.suspects == (("sign", wrong), "another")


def test_where_a_few_readings_lie_far_off_no_term_explains_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room = Room(monkeypatch, Status.ESTIMATED, SIDED)
    room.closed.outlying = True
    assert entry.fit((), {}, ("B",)).alternative is None
    assert "looked" not in room.asked
    assert entry.fit((), {}, ("B",), model="direction").alternative is not None  # as asked for
