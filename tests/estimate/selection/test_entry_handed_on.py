"""What each stage of an answer with a better model is handed, and which way it takes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.errors import DataError
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import TermTrial
from motorid.estimate.results.status import Status
from motorid.estimate.selection import entry
from motorid.estimate.solver.allowance import Allowance
from tests.estimate.selection.noted_stages import noting
from tests.estimate.solutions import MOTOR, solution
from tests.report.example import estimate

DROP, SIDED, COGS, TWO = (
    TERMS[name] for name in ("brush-drop", "direction", "cogging", "two-masses")
)
FIX, WITHOUT = {"B": 4e-5}, ("T0",)
HELD = {"B": 4e-5, "T0": 0.0}


def k_of(status: Status) -> Any:
    one = estimate()
    return replace(
        one, parameters={**one.parameters, "K": replace(one.parameters["K"], status=status)}
    )


class Answer:
    """An answer whose stages are given."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, model: str = "auto",
        status: Status = Status.ESTIMATED, outlying: bool = False, best: bool = True,
    ) -> None:  # fmt: skip
        self.seen = dict[str, Any]()
        self.records: Any = [SimpleNamespace(outlying=False), SimpleNamespace(outlying=outlying)]
        self.six, self.known = k_of(status), SimpleNamespace(solution=solution(R=9.0))
        self.trials = (SimpleNamespace(name="a"), SimpleNamespace(name="b"))
        stated = {
            "a": TermTrial("direction", "", (), 1.0, 2.0, 3.0, None, 4.0, True),
            "b": TermTrial("cogging", "", (), 1.0, 2.0, 3.0, None, 4.0, True),
        }
        self.chosen = chosen = SimpleNamespace(
            stages=("stage",), trials=self.trials, left_out=("left",), harmless="harmless"
        )
        self.fitted = SimpleNamespace(terms=(SIDED,), records="wide", solution="its own")
        self.found = SimpleNamespace(name="findings")
        narrow = ("narrow", "its solution", "its values")
        noting(
            monkeypatch, entry, self.seen, _closed=("captures", "records", "solved"),
            answered=(self.six, self.records, self.known), looked_for=(chosen, narrow),
            _with_left_out=replace(self.six, suspects=("left out",)),
            standing_out=((self.fitted, self.found) if best else None, ("unsettled",)),
            alternative="alternative", _with_trials="with trials", _said="said",
            with_unsettled="settled", with_seen="seen", _narrow=narrow,
            asked_for=self.fitted, findings=self.found, reach={"R": 0.5}, known_beside="widest",
            with_lack="lack",
        )  # fmt: skip
        monkeypatch.setattr(entry, "_stated", lambda trial: stated[trial.name])
        captures: Any = ["run"]
        self.answer: Any = entry._of(captures, FIX, WITHOUT, model)


def test_a_better_model_is_looked_for_and_offered_beside_the_six(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = Answer(monkeypatch)
    seen = made.seen
    assert made.answer == "lack"
    assert seen["with_lack"] == [("seen", "wide", "its own")]
    assert seen["_closed"] == [(["run"], FIX, WITHOUT, True)]
    assert seen["answered"] == [("captures", "records", "solved", FIX, WITHOUT)]
    assert seen["reach"] == [(made.six.parameters,)]
    assert seen["looked_for"] == [(made.records, made.known.solution, HELD, {"R": 0.5})]
    assert seen["_with_left_out"] == [(made.six, made.chosen, made.fitted)]
    assert seen["standing_out"] == [(made.chosen, FIX, WITHOUT)]
    ((fitted, found, records, before, trials, asked),) = seen["alternative"]
    assert (fitted, found, records, before) == (made.fitted, made.found, "narrow", "its solution")
    # what was taken on the way is no part of what is offered
    assert [(t.term, t.taken) for t in trials] == [("direction", True), ("cogging", False)]
    assert asked == ("asked", False)
    ((said, fitted),) = seen["_said"]
    assert (said.alternative, said.suspects, fitted) == ("alternative", ("left out",), made.fitted)
    assert seen["with_unsettled"] == [("said", ("unsettled",))]
    assert seen["known_beside"] == [(made.found, "harmless", FIX, WITHOUT)]
    assert seen["with_seen"] == [("settled", "widest")]


def test_where_none_stands_out_what_was_tried_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    made = Answer(monkeypatch, best=False)
    ((estimated, trials),) = made.seen["_with_trials"]
    assert estimated.suspects == ("left out",)
    assert [t.taken for t in trials] == [True, True]
    assert made.seen["with_unsettled"] == [("with trials", ("unsettled",))]
    assert made.seen["known_beside"] == [(made.known, "harmless", FIX, WITHOUT)]
    assert made.seen["with_seen"] == [("settled", "widest")]
    assert made.seen["with_lack"] == [("seen", made.records, made.known.solution)]
    assert "alternative" not in made.seen


WIDER: Any = SimpleNamespace(width=5)


@pytest.mark.parametrize(("harmless", "sizes", "asked"), [
    (WIDER, (0.0, 4.5), True), (WIDER, (0.0,), False), (None, (4.5,), False),
])  # fmt: skip
def test_what_is_still_seen_is_asked_beside_what_explains_more_and_moves_nothing(
    harmless: Any, sizes: tuple[float, ...], asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: dict[str, Any] = {}
    noting(monkeypatch, entry, seen, findings="beside it", finished="finished")
    known: Any = SimpleNamespace(undetected=[SimpleNamespace(seen=size) for size in sizes])
    assert entry.known_beside(known, harmless, FIX, WITHOUT) == ("beside it" if asked else known)
    assert seen.get("finished") == ([(WIDER,)] if asked else None)
    assert seen.get("findings") == ([("finished", FIX, WITHOUT)] if asked else None)


def test_where_no_room_is_left_what_is_still_seen_is_asked_of_a_fit_that_was_judged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Twelve sets of derivatives, of 5 responses here, end another."""
    known: Any = SimpleNamespace(undetected=[SimpleNamespace(seen=4.5)])
    for most, ended in ((59.0, False), (60.0, True)):
        seen: dict[str, Any] = {}
        noting(monkeypatch, entry, seen, findings="beside it", finished="finished")
        monkeypatch.setattr(entry, "current", lambda most=most: Allowance(most=most))
        assert entry.known_beside(known, WIDER, FIX, WITHOUT) == "beside it"
        assert seen["findings"] == [("finished" if ended else WIDER, FIX, WITHOUT)]


def test_named_terms_are_fitted_from_a_fit_that_leaves_them_what_they_explain(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = Answer(monkeypatch, "direction+cogging")
    seen = made.seen
    values = {**MOTOR, "R": 9.0}
    assert seen["_narrow"] == [(made.records, made.known.solution, values, HELD, (SIDED, COGS))]
    assert seen["asked_for"] == [("narrow", "its solution", "its values", (SIDED, COGS))]
    assert seen["findings"] == [(made.fitted, FIX, WITHOUT)]
    ((*_, trials, asked),) = seen["alternative"]
    assert (trials, asked) == ((), ("asked", True))
    assert seen["with_seen"] == [("settled", made.found)]
    assert "looked_for" not in seen


@pytest.mark.parametrize(
    ("model", "status", "outlying", "goes_on"),
    [
        ("auto", Status.ESTIMATED, False, True), ("six", Status.ESTIMATED, False, False),
        ("auto", Status.ESTIMATED, True, False), ("direction", Status.ESTIMATED, True, True),
        ("auto", Status.NOT_IDENTIFIABLE, False, False),
        ("direction", Status.NOT_IDENTIFIABLE, False, True),
        ("direction", Status.NOT_SUPPORTED, False, False),
        ("auto", Status.NOT_SUPPORTED, False, False), ("six", Status.NOT_SUPPORTED, False, False),
    ],
)  # fmt: skip
def test_the_six_are_the_answer_where_no_wider_model_would_know_more(
    model: str, status: Status, outlying: bool, goes_on: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One record of which few readings lie far off is enough."""
    made = Answer(monkeypatch, model, status, outlying)
    assert made.answer == "lack"
    ((answer, records, found),) = made.seen["with_lack"]
    assert (answer == "seen") is goes_on
    if not goes_on:
        assert answer is made.six
        assert records is made.records
        assert found is made.known.solution


def test_a_wrong_sign_is_put_right_and_said_before_all_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one, asked = estimate(), list[Any]()

    def of(*how: Any) -> Any:
        asked.append(how)
        if len(asked) == 1:
            raise entry.sign_check.WrongSignError(
                entry.sign_check.Suspect("current_sign", "current", "it flows", "swap", "named")
            )
        return one

    monkeypatch.setattr(entry, "_of", of)
    monkeypatch.setattr(entry.sign_check, "put_right", lambda captures, _: ["right", *captures])
    spike = entry.sign_check.Suspect("spikes", "current", "they stand alone", "look", "named")
    monkeypatch.setattr(entry.spikes, "removed", lambda given: (given[1:], (spike,)))
    far = entry.sign_check.Suspect("spikes", "speed", "they stand far", "look", "named")
    monkeypatch.setattr(entry.log_spikes, "removed", lambda given: (given, (far,)))
    captures: Any = ["spiked", "run"]
    found = entry.fit(captures, FIX, WITHOUT, "six")
    assert asked == [(["run"], FIX, WITHOUT, "six"), (["right", "run"], FIX, WITHOUT, "six")]
    first, *others = found.suspects
    assert (first.code, first.allowed) == ("current_sign", True)
    named = [s for s in one.suspects if s.strength == "named"]
    assert others == [*named, spike, far, *(s for s in one.suspects if s not in named)]
    entry.fit(captures, FIX)
    assert asked[2] == (["run"], FIX, (), "auto")


# captures with an open bridge


def test_whole_and_cut_captures_are_fitted_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """And judged by what their own residuals leave."""
    seen: dict[str, Any] = {}
    whole, cut = ["abcdef"], ["ab", "ef"]
    noting(monkeypatch, entry, seen, unbroken=whole, pieces=cut)
    records = [SimpleNamespace(measured=[SimpleNamespace(block=SimpleNamespace(count=50.0))])]
    noting(monkeypatch, entry.joint_fit, seen, solved=(records, "solution"))
    noting(monkeypatch, entry.misfit, seen, residuals="residuals", excess=1.0)
    captures: Any = ["run"]
    assert entry._closed(captures, FIX, WITHOUT) == (cut, records, "solution")
    assert seen["unbroken"] == seen["pieces"] == [(["run"],)]
    assert seen["solved"] == [(whole, FIX, WITHOUT), (cut, FIX, WITHOUT)]
    assert seen["residuals"] == [(records, "solution")] * 2
    assert seen["excess"] == [(records, "residuals")] * 2


def test_captures_that_nothing_cuts_are_fitted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}
    noting(monkeypatch, entry, seen, unbroken=["abcd"], pieces=["efgh"])
    noting(monkeypatch, entry.joint_fit, seen, solved=("records", "solution"))
    assert entry._closed([], FIX, WITHOUT) == (["efgh"], "records", "solution")
    assert seen["solved"] == [(["efgh"], FIX, WITHOUT)]


def test_a_whole_capture_without_a_start_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def solved(*how: Any) -> Any:
        asked.append(how)
        if len(asked) == 1:
            raise DataError("no start")
        return "records", "solution"

    noting(monkeypatch, entry, {}, unbroken=["abcdef"], pieces=["ab"])
    monkeypatch.setattr(entry.joint_fit, "solved", solved)
    assert entry._closed([], FIX, WITHOUT) == (["ab"], "records", "solution")
    assert asked == [(["abcdef"], FIX, WITHOUT), (["ab"], FIX, WITHOUT)]


# what is looked for


def test_both_looks_are_held_against_their_own_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}
    none = entry.Selection((), (), ())
    noting(
        monkeypatch, entry, seen, carry_loss=True, is_heavy=True, loss_stands_out=True, select=none,
        drop_gives=False, _bare=("bare", "solved", "values"),
    )  # fmt: skip
    records, found = ["record"], solution(R=9.0)
    chosen, narrow = entry.looked_for(records, found, HELD, {"R": 0.5})  # type: ignore[arg-type]
    assert chosen.stages == ()
    assert narrow == ("bare", "solved", "values")
    values = {**MOTOR, **HELD, "R": 9.0, "B": MOTOR["B"], "T0": MOTOR["T0"]}
    assert seen["carry_loss"] == [(records,)]
    assert seen["is_heavy"] == [(records, found)]
    assert seen["_bare"] == [
        (records, values, HELD, None, True), (records, "values", HELD, lossless, True),
    ]  # fmt: skip
    assert seen["drop_gives"] == [(records, found)]
    assert seen["loss_stands_out"] == [(records, found, {"R": 0.5})]
    first, second = seen["select"]
    assert first[:4] == second[:4] == ("bare", "solved", "values", {"R": 0.5})


@pytest.mark.parametrize("before", [True, False])
def test_where_the_second_look_has_no_room_its_terms_are_left_out(
    before: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is left for the fit that it begins from, or that was cut: the first one stands."""
    allowance = Allowance(most=-1.0 if before else 1.0)
    seen: list[Any] = []

    def bare(*of: Any) -> Any:
        seen.append(of)
        allowance.count.responses += 2
        allowance.ends()
        return "bare", "solved", "values"

    none = entry.Selection((), (), (COGS,))
    noting(monkeypatch, entry, {}, carry_loss=True, is_heavy=False, loss_stands_out=True,
           select=none, drop_gives=False)  # fmt: skip
    monkeypatch.setattr(entry, "_bare", bare)
    monkeypatch.setattr(entry, "current", lambda: allowance)
    records, found = ["record"], solution(R=9.0)
    chosen, narrow = entry.looked_for(records, found, HELD, {"R": 0.5})  # type: ignore[arg-type]
    assert len(seen) == (0 if before else 1)
    assert narrow[:2] == (records, found)
    assert chosen.left_out == (COGS, *entry.ALLOWED)


def test_a_bare_fit_is_of_the_same_parameters(monkeypatch: pytest.MonkeyPatch) -> None:
    """With what repeats as it was, and with the inductance that was foretold."""
    seen: dict[str, Any] = {}
    answer = solution(R=7.0)
    noting(monkeypatch, entry, seen, repeat_as=None, vanished=False)
    noting(monkeypatch, entry.multistart, seen, solve=answer)
    monkeypatch.setattr(
        entry, "MotorRecord", lambda *given: SimpleNamespace(given=given, foretold=None)
    )
    records: Any = [SimpleNamespace(capture="one", foretold=1.0),
                    SimpleNamespace(capture="two", foretold=2.0)]  # fmt: skip
    bare: Any
    bare, found, known = entry._bare(records, {**MOTOR, "T_lc": 1.0}, HELD, None, False)
    free = ["R", "L", "K", "J"]
    assert [r.given for r in bare] == [("one", free, HELD), ("two", free, HELD)]
    assert [r.foretold for r in bare] == [1.0, 2.0]
    assert found is answer
    assert known == {**HELD, **MOTOR, "R": 7.0}
    assert seen["repeat_as"] == [(bare, records)]
    assert seen["solve"] == [(bare, free, MOTOR)]
    assert seen["vanished"] == [(answer, bare)]


# terms that a person names


def test_what_was_found_is_covered_where_the_six_do_without_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    noting(
        monkeypatch, entry, seen,
        covering=SimpleNamespace(moves={"R": 0.5}, sides={"R": (0.0, 0.5)}), settled=estimate(),
    )  # fmt: skip
    better: Any = SimpleNamespace(asked=False, nuisance={}, parameters={})
    bare = replace(estimate(), alternative=better)
    fitted: Any = SimpleNamespace(terms=(SIDED,))
    said = entry._said(bare, fitted).diagnostics[0]
    assert (said.moves, said.sides) == ({"R": 0.5}, {"R": (0.0, 0.5)})
    assert seen["covering"] == [(bare, better, bare.parameters)]
    assert seen["settled"] == [(bare, [said])]
    assert "do without it" in said.message


def test_what_the_six_allow_for_is_covered_where_they_allow_for_too_little(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """That is where an interval does not hold the better model's value. R of such a model means
    something else: alone it says nothing, and beside another it counts as well.
    """
    seen: dict[str, Any] = {}
    more = SimpleNamespace(moves={"K": 0.5}, sides={"K": (0.0, 0.5)})
    noting(monkeypatch, entry, seen, covering=more, excluded=["K"], settled=estimate())
    better: Any = SimpleNamespace(asked=False, nuisance={}, parameters={})
    bare = replace(estimate(), alternative=better)
    fitted: Any = SimpleNamespace(terms=(DROP,))
    said = entry._said(bare, fitted).diagnostics[0]
    assert seen["covering"] == [(bare, better, ["K"])]
    assert seen["excluded"] == [(bare, better, ("but", ("R",))), (bare, better)]
    assert (said.moves, said.severity) == ({"K": 0.5}, "warning")
    assert "the six parameters allow for less of it and are biased" in said.message
    seen.clear()
    nothing = SimpleNamespace(moves={}, sides={})
    noting(monkeypatch, entry, seen, covering=nothing, excluded=[])
    said = entry._said(bare, fitted).diagnostics[0]
    assert seen["excluded"] == [(bare, better, ("but", ("R",)))]
    assert seen["covering"] == [(bare, better, [])]
    assert (said.moves, said.severity) == ({}, "info")
