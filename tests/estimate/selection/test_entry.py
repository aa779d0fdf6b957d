"""The answer of six parameters with a better model beside it: what matters, what is said, what is
tried, on answers that are given.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.errors import DataError
from motorid.estimate.effects.brush_and_heating import lossless, undropped
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic, Parameter, TermTrial
from motorid.estimate.results.status import Status
from motorid.estimate.selection import entry
from motorid.estimate.selection.evidence import Evidence
from motorid.estimate.selection.forward_selection import Selection, Trial
from motorid.estimate.selection.unsettled_models import Unsettled
from tests.estimate.solutions import MOTOR, solution
from tests.report.example import estimate

DROP, HEAT, SIDED, COGS = (
    TERMS[name] for name in ("brush-drop", "heating", "direction", "cogging")
)


def parameter(value: float | None, half: float = 0.1, name: str = "R") -> Parameter:
    if value is None:
        return Parameter(name, "", None, None, None, None, None, Status.NOT_IDENTIFIABLE)
    interval = (value - half, value + half)
    return Parameter(name, "", value, half / 2, 0.0, half / 2, interval, Status.ESTIMATED)


def test_half_an_interval_matters_or_a_hundredth_of_the_value() -> None:
    found = entry.reach({
        "R": parameter(2.0, 0.01), "K": parameter(2.0, 0.5), "T0": parameter(0.0, 0.3),
        "L": parameter(None), "J": parameter(-2.0, 0.5), "B": parameter(1.0, 0.0),
    })  # fmt: skip
    assert found == pytest.approx({"R": 0.005, "K": 0.02, "T0": 0.15, "J": 0.02, "B": math.inf})


@pytest.mark.parametrize(("half", "matters"), [(0.19, 0.02), (0.21, 0.105)])
def test_of_an_inductance_that_readings_hardly_tell_the_interval_alone_counts(
    half: float, matters: float
) -> None:
    assert entry.reach({"L": parameter(2.0, half)})["L"] == pytest.approx(matters)


def test_what_was_found_is_said_by_whether_the_six_allow_for_it() -> None:
    better: Any = SimpleNamespace(parameters={}, nuisance={}, asked=False)
    bare = replace(estimate(), alternative=better, parameters={}, combinations={}, derived={})
    fitted: Any = SimpleNamespace(terms=(SIDED, COGS))
    said = entry._said(bare, fitted).diagnostics[0]
    assert (said.code, said.severity) == ("better_model", "warning")
    assert said.message == (
        f"the residuals show {SIDED.title} and {COGS.title}: the six parameters do without it and "
        "are biased, so use those of the better model"
    )
    fitted.terms = (DROP,)
    said = entry._said(bare, fitted).diagnostics[0]
    assert said.severity == "info"
    assert "the six parameters allow for it" in said.message
    better.asked = True
    said = entry._said(bare, fitted).diagnostics[0]
    assert (said.code, said.severity) == ("model_asked", "info")
    assert said.message == f"beside it, as asked: a model with {DROP.title}"


@pytest.mark.parametrize(
    ("grown", "stays"), [({"winding warming": 0.0}, False), ({"winding warming": -0.05}, True),
                         ({}, True)],
)  # fmt: skip
def test_a_winding_that_seemed_to_cool_is_not_said_beside_a_model_in_which_it_does_not(
    grown: dict[str, float], stays: bool
) -> None:
    """Nor where that model has the winding's heat among its own parameters."""
    sizes = {name: parameter(value, 0.01, name) for name, value in grown.items()}
    better: Any = SimpleNamespace(parameters={"R": parameter(2.0)}, nuisance=sizes, asked=False)
    cools = Diagnostic("winding_cools", "warning", "R falls")
    one = replace(
        estimate(), alternative=better, parameters={}, combinations={}, derived={},
        diagnostics=(cools,),
    )  # fmt: skip
    fitted: Any = SimpleNamespace(terms=(SIDED,))
    codes = [d.code for d in entry._said(one, fitted).diagnostics]
    assert codes == ["better_model", *(["winding_cools"] if stays else [])]


def test_what_was_tried_or_had_no_room_is_said_by_name() -> None:
    one = estimate()
    before = len(one.diagnostics)
    tried = TermTrial("cogging", "", (), 1.0, 2.0, 3.0, None, 4.0, False)
    found = entry._with_trials(one, [tried, replace(tried, term="eddy"), tried])
    assert len(found.diagnostics) == before + 1
    said = found.diagnostics[-1]
    assert (said.code, said.severity) == ("model_tried", "info")
    assert said.message.startswith("a model with cogging, eddy was tried")
    assert entry._with_trials(one, []) is one
    chosen = Selection((), (), (COGS, SIDED, COGS), not_revised=(DROP,))
    said = entry._with_left_out(one, chosen, None).diagnostics[-1]
    assert "before it tried cogging, direction: name one" in said.message
    cut: Any = SimpleNamespace(terms=(DROP, SIDED), settled=False)
    said = entry._with_left_out(one, replace(chosen, left_out=()), cut).diagnostics[-1]
    assert "takes the place of brush-drop and before the last passes" in said.message
    other: Any = SimpleNamespace(terms=(SIDED,), settled=True)  # what was not revised is not in it
    assert entry._with_left_out(one, replace(chosen, left_out=()), other) is one


def test_a_trial_is_stated_by_what_was_gained_for_what_was_needed() -> None:
    evidence = Evidence(90.0, 3.0, 20.0, 7.0, 4.0)
    stated = entry._stated(Trial(COGS, (SIDED,), evidence, 2.5, True))
    assert stated == TermTrial(
        "cogging", COGS.title, ("direction",), 30.0, 20.0, 7.0, 4.0, 2.5, True
    )


def test_of_the_stages_the_widest_counts_whose_last_term_stands_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stages: Any = [
        SimpleNamespace(terms=terms, values={"R": float(len(terms))})
        for terms in (("a",), ("a", "b"))
    ]
    monkeypatch.setattr(entry, "finished", lambda stage: stage)
    monkeypatch.setattr(entry, "findings", lambda stage, *_: len(stage.terms))
    monkeypatch.setattr(entry, "stands_out", lambda _, term: term == "a")
    before = Unsettled(COGS, {"R": 9.0})
    chosen = Selection(tuple(stages), (), (), (before,))
    first, second = (Unsettled(s.terms[-1], s.values) for s in stages)
    assert entry.standing_out(chosen, {}, ()) == ((stages[0], 1), [before, second])
    monkeypatch.setattr(entry, "stands_out", lambda _, term: True)
    monkeypatch.setattr(entry, "without_faint", lambda fit, of, _f, _w, half: ((fit, of), half))
    assert entry.standing_out(chosen, {}, ()) == ((stages[1], 2), [before])
    monkeypatch.setattr(entry, "stands_out", lambda *_: False)
    assert entry.standing_out(chosen, {}, ()) == (None, [before, second, first])


def test_a_term_that_another_could_feign_stands_out_in_the_fit_with_both(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stages: Any = [
        SimpleNamespace(terms=tuple(terms), values={"R": float(len(terms))})
        for terms in ("a", "ab", "abc")
    ]
    clear: set[tuple[int, str]] = {(2, "a")}  # in the fit of two terms, the first
    monkeypatch.setattr(entry, "finished", lambda stage: stage)
    monkeypatch.setattr(entry, "findings", lambda stage, *_: len(stage.terms))
    monkeypatch.setattr(entry, "stands_out", lambda found, term: (found, term) in clear)
    third, second = (Unsettled(s.terms[-1], s.values) for s in reversed(stages[1:]))
    chosen = Selection(tuple(stages), ())
    assert entry.standing_out(chosen, {}, ()) == ((stages[1], 2), [third])
    clear |= {(1, "a")}  # by itself too: what is added to it stays open
    assert entry.standing_out(chosen, {}, ()) == ((stages[0], 1), [third, second])
    other = replace(chosen, stages=(SimpleNamespace(terms=("c",), values={}), stages[1]))
    assert entry.standing_out(other, {}, ())[0] is None  # "a" was exchanged for "c"


class Looked:
    """What is looked for, on given selections."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, *selections: Selection, loss: bool = True,
        stands_out: bool = True, heavy: bool = False, gives: bool = False,
    ) -> None:  # fmt: skip
        self.left, self.but, self.bare = list(selections), list[Any](), list[Any]()
        monkeypatch.setattr(entry, "carry_loss", lambda _: loss)
        monkeypatch.setattr(entry, "is_heavy", lambda *_: heavy)
        monkeypatch.setattr(entry, "loss_stands_out", lambda *_: stands_out)
        monkeypatch.setattr(entry, "drop_gives", lambda *_: gives)
        monkeypatch.setattr(entry, "select", self.select)
        monkeypatch.setattr(entry, "_bare", self.without)
        self.found, self.narrow = entry.looked_for([], solution(R=9.0), {"T0": 0.0}, {"R": 1.0})

    def select(self, _r: Any, _s: Any, values: Any, matters: Any, but: Any) -> Selection:
        assert matters == {"R": 1.0}
        self.but.append(tuple(but))
        return self.left.pop(0)

    def without(self, _r: Any, values: Any, _h: Any, less: Any, anew: bool) -> Any:
        self.bare.append((less, anew))
        return ([], solution(), values)


def chosen(*terms: Any, left_out: Any = ()) -> Selection:
    stages: Any = tuple(SimpleNamespace(terms=(t,)) for t in terms)
    return Selection(
        stages, tuple(Trial(t, (), Evidence(1.0, 1.0, 1.0), 1.0) for t in terms), left_out
    )


NONE = Selection((), (), ())


def test_terms_are_looked_for_beside_what_the_captures_have_unknowns_of(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked = Looked(monkeypatch, chosen(SIDED))
    assert looked.but == [entry.ALLOWED]
    assert looked.bare == []
    assert looked.narrow[2] == {**MOTOR, "R": 9.0}
    assert Looked(monkeypatch, NONE, loss=False).but == [()]


def test_a_loss_that_stands_out_is_looked_for_by_its_own_terms(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = replace(NONE, trials=chosen(SIDED).trials, left_out=(COGS,))
    looked = Looked(monkeypatch, first, chosen(DROP, left_out=(HEAT,)))
    assert looked.but[1] == tuple(t for t in TERMS.values() if t not in entry.ALLOWED)
    assert looked.bare == [(lossless, False)]
    assert [s.terms for s in looked.found.stages] == [(DROP,)]
    assert [t.term for t in looked.found.trials] == [SIDED, DROP]
    assert looked.found.left_out == (COGS, HEAT)
    assert Looked(monkeypatch, NONE, stands_out=False).bare == []
    assert Looked(monkeypatch, NONE, loss=False).bare == []


def test_where_brushes_seem_to_give_voltage_others_are_looked_for_without_their_drop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = replace(NONE, trials=chosen(SIDED).trials)
    looked = Looked(monkeypatch, first, chosen(COGS), gives=True)
    assert looked.but == [entry.ALLOWED, entry.ALLOWED]
    assert looked.bare == [(undropped, False)]
    assert [s.terms for s in looked.found.stages] == [(COGS,)]
    assert [t.term for t in looked.found.trials] == [SIDED, COGS]
    assert Looked(monkeypatch, chosen(SIDED), gives=True).bare == []
    assert Looked(monkeypatch, NONE, gives=True, loss=False).bare == []


def test_what_repeats_heavily_is_looked_for_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Looked(monkeypatch, chosen(SIDED), heavy=True).bare == [(None, True)]
    assert Looked(monkeypatch, NONE, NONE, heavy=True).bare == [(None, True), (lossless, True)]


@pytest.mark.parametrize(
    ("terms", "loss", "repeats", "heavy", "bare"),
    [
        ((SIDED,), True, False, False, None),
        ((DROP,), True, False, False, (True, False)),
        ((DROP,), False, False, False, None),
        ((COGS,), False, True, False, (False, True)),
        ((COGS,), False, False, True, None),
        ((SIDED,), False, True, True, (False, True)),
        ((SIDED,), False, True, False, None),
        ((DROP, COGS), True, True, False, (True, True)),
    ],
)
def test_named_terms_begin_from_a_fit_that_leaves_them_what_they_explain(
    terms: Any, loss: bool, repeats: bool, heavy: bool, bare: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    records: Any = [SimpleNamespace(repeating=SimpleNamespace(slopes="slopes" if repeats else ""))]
    monkeypatch.setattr(entry, "carry_loss", lambda _: loss)
    monkeypatch.setattr(entry, "is_heavy", lambda *_: heavy)
    monkeypatch.setattr(entry, "_bare", lambda _r, _v, _h, less, anew: (less is lossless, anew))
    now: Any = "solution"
    found = entry._narrow(records, now, MOTOR, {}, terms)
    assert found == (bare if bare is not None else (records, now, MOTOR))


def test_a_bare_fit_whose_inductance_goes_is_fitted_with_the_one_that_was_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[Any] = []
    asked: list[Any] = []

    def record(capture: Any, free: Any, held: Any) -> Any:
        made.append(SimpleNamespace(capture=capture, free=free, held=held))
        return made[-1]

    def held(records: Any, free: Any, known: Any, near: Any, henry: float) -> Any:
        asked.append((records, tuple(free), known, henry))
        return solution(L=3e-3)

    monkeypatch.setattr(entry, "MotorRecord", record)
    monkeypatch.setattr(
        entry, "repeat_as", lambda bare, _: [vars(r).update(repeats=True) for r in bare]
    )
    monkeypatch.setattr(entry.multistart, "solve", lambda *_: solution(R=5.0))
    monkeypatch.setattr(entry, "vanished", lambda *_: True)
    monkeypatch.setattr(entry, "with_inductance", held)
    records: Any = [SimpleNamespace(capture="run", foretold="told")]
    values = {**MOTOR, "T_lc": 1.0}
    bare, found, known = entry._bare(records, values, {"B": 0.0}, "lossless {}".format, False)
    assert bare[0].capture == "lossless run"
    assert bare[0].foretold == "told"
    assert bare[0].repeats
    assert asked == [(bare, ("R", "L", "K", "J", "T0"), MOTOR, MOTOR["L"])]
    assert known == {**MOTOR, "L": 3e-3}
    bare, found, _ = entry._bare(records, values, {"L": 0.0}, None, True)
    assert bare[0].capture == "run"
    assert not hasattr(bare[0], "repeats")
    assert dict(zip(PARAMETERS, found.values, strict=True))["R"] == 5.0  # a held one cannot go


def closed(
    monkeypatch: pytest.MonkeyPatch, whole: list[str], cut: list[str], left: float = 0.0,
    left_cut: float = 0.0, converged: bool = True, fails: bool = False, readings: float = 100.0,
) -> Any:  # fmt: skip
    """The captures that are taken; ``left``: to explain, of each of so many ``readings``."""
    half = SimpleNamespace(block=SimpleNamespace(count=readings / 2.0))

    def solved(captures: Any, *_: Any) -> Any:
        if fails and captures is whole:
            raise DataError("no start")
        records = [SimpleNamespace(of=captures, measured=[half, half])]
        return records, replace(solution(), converged=converged)

    monkeypatch.setattr(entry, "unbroken", lambda _: whole)
    monkeypatch.setattr(entry, "pieces", lambda _: cut)
    monkeypatch.setattr(entry.joint_fit, "solved", solved)
    monkeypatch.setattr(entry.misfit, "residuals", lambda *_: [])
    monkeypatch.setattr(
        entry.misfit, "excess", lambda records, _: left if records[0].of is whole else left_cut
    )
    captures, (record,), _ = entry._closed([], {}, ())
    assert record.of is captures  # type: ignore[attr-defined]
    return captures


def test_stretches_with_an_open_bridge_are_cut_where_a_connected_motor_does_not_fit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole, cut = ["abcdef"], ["ab", "ef"]
    assert closed(monkeypatch, whole, cut, left=0.09) is whole
    assert closed(monkeypatch, whole, cut, left=0.11) is cut
    assert closed(monkeypatch, whole, cut, left=0.11, left_cut=0.12) is whole
    assert closed(monkeypatch, whole, cut, fails=True) is cut
    shorter = ["abcd"]
    assert closed(monkeypatch, whole, shorter, left=0.09) is whole
    same = ["ghijkl"]
    assert closed(monkeypatch, whole, same, left=0.09) is same


def test_a_cut_of_a_few_samples_is_tried_for_less(monkeypatch: pytest.MonkeyPatch) -> None:
    """For 20 of chi-square altogether; a cut of more costs what it leaves out."""
    whole, more = [50 * "ab"], [50 * "a", 47 * "b"]
    assert closed(monkeypatch, whole, more, left=0.021, readings=1000.0) is whole
    cut = [50 * "a", 48 * "b"]
    assert closed(monkeypatch, whole, cut, left=0.019, readings=1000.0) is whole
    assert closed(monkeypatch, whole, cut, left=0.021, readings=1000.0) is cut
    assert closed(monkeypatch, whole, cut, left=0.021, left_cut=0.022, readings=1000.0) is whole
    assert closed(monkeypatch, whole, cut, left=0.11, readings=10.0) is cut


def test_a_fit_that_explains_all_is_not_cut_for_a_search_that_did_not_settle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A late current looks like an open bridge: R was then off by 81 u."""
    assert closed(monkeypatch, ["abcdef"], ["ab", "ef"], left=0.09, converged=False) == ["abcdef"]
