"""No value excludes those of a model that the data half support."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.estimate.effects.friction.windage import WINDAGE
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import Alternative, Estimate, Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.selection import forward_selection as forward
from motorid.estimate.selection.evidence import Evidence
from motorid.estimate.selection.forward_selection import Trial
from motorid.estimate.selection.unsettled_models import Unsettled, with_left_out, with_unsettled
from tests.report.example import estimate

LOAD, SLOW, SIDED, COGS = (
    TERMS[name] for name in ("quadratic-load", "stribeck", "direction", "cogging")
)


def values(given: Estimate, **factors: float) -> dict[str, float]:
    """The estimate's, each times a factor."""
    return {n: (p.value or 0.0) * factors.get(n, 1.0) for n, p in given.parameters.items()}


def half(p: Parameter) -> float:
    assert p.interval_95 is not None
    return (p.interval_95[1] - p.interval_95[0]) / 2.0


def test_an_interval_reaches_as_far_beyond_each_of_them_as_it_did_beyond_its_value() -> None:
    usual = estimate()
    models = [Unsettled(LOAD, values(usual, B=0.6)), Unsettled(SLOW, values(usual, B=1.3))]
    found = with_unsettled(usual, models)
    before, after = usual.parameters["B"], found.parameters["B"]
    assert before.value is not None
    assert before.interval_95 is not None
    assert after.interval_95 is not None
    assert after.status is Status.DOUBTFUL
    low, high = after.interval_95
    assert low == pytest.approx(max(before.interval_95[0] - 0.4 * before.value, 0.0))
    assert high == pytest.approx(before.interval_95[1] + 0.3 * before.value)
    assert after.value == before.value
    assert found.parameters["K"] == usual.parameters["K"]
    said = found.diagnostics[0]
    assert (said.code, said.severity) == ("model_unsettled", "warning")
    assert f"{LOAD.title} or {SLOW.title}" in said.message
    assert f"can move B; {WINDAGE.remedy}, or name it" in said.message
    assert said.message.endswith("--model quadratic-load")
    slow = with_unsettled(usual, models[1:]).diagnostics[0]
    assert "can move B; record more levels of speed, or name it" in slow.message


@pytest.mark.parametrize(("part", "said"), [(0.99, False), (1.01, True)])
def test_a_value_that_the_interval_holds_changes_nothing(part: float, said: bool) -> None:
    usual = estimate()
    J = usual.parameters["J"]
    assert J.value is not None
    moved = values(usual, J=1.0 + part * half(J) / J.value)
    found = with_unsettled(usual, [Unsettled(LOAD, moved)])
    assert (found != usual) is said
    assert with_unsettled(usual, []) is usual


def test_the_better_model_reaches_to_them_too() -> None:
    usual = estimate()
    beside = {**usual.parameters, "B": replace(usual.parameters["B"], value=1.0, total=0.1,
                                               interval_95=(0.8, 1.2))}  # fmt: skip
    better = Alternative("wider", ("stribeck",), ("slow",), (), False, beside, {}, 1.0, 1, 1, ())
    at_odds = replace(usual, alternative=better)
    found = with_unsettled(at_odds, [Unsettled(LOAD, values(usual))])  # as the six say
    assert found.parameters == usual.parameters
    assert found.alternative is not None
    B = found.alternative.parameters["B"]
    assert B.status is Status.DOUBTFUL
    assert B.interval_95 is not None
    assert B.interval_95[0] <= (usual.parameters["B"].value or 0.0) <= B.interval_95[1]
    assert found.alternative.parameters["K"] == usual.parameters["K"]
    (said,) = [d for d in found.diagnostics if d.code == "model_unsettled"]
    assert said.moves == {}  # of the six nothing moves


GOOD, OPEN, BAD = (
    Evidence(300.0, 1.0, 20.0, 9.0), Evidence(300.0, 1.0, 20.0, 3.0), Evidence(9.0, 1.0, 20.0, 9.0)
)  # fmt: skip


def selected(monkeypatch: pytest.MonkeyPatch, *rounds: list[tuple[Any, Evidence, float]]) -> Any:
    """A search whose rounds end with such trials: a term, its evidence, what it moves."""
    left = list(rounds)

    class Search:
        left_out: tuple[()] = ()
        untried: tuple[()] = ()

        def __init__(self, *_: Any) -> None:
            pass

        def round(self, _now: Any) -> Any:
            return [
                (SimpleNamespace(terms=(term,), values={"B": moves}, records=(), solution=None,
                                 took=0, width=10),
                 Trial(term, (), evidence, moves))
                for term, evidence, moves in (left.pop(0) if left else [])
            ]  # fmt: skip

    monkeypatch.setattr(forward, "_Search", Search)
    monkeypatch.setattr(forward._Model, "width", 10)
    return forward.select((), None, {}, {})  # type: ignore[arg-type]


def test_what_half_supported_terms_say_counts_until_one_earns_its_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = selected(monkeypatch, [(LOAD, OPEN, 5.0), (SLOW, BAD, 7.0)])
    assert found.unsettled == (Unsettled(LOAD, {"B": 5.0}),)
    assert found.stages == ()
    later = selected(monkeypatch, [(LOAD, OPEN, 5.0)], [(SLOW, GOOD, 7.0)])
    assert [stage.terms for stage in later.stages] == [(SLOW,)]
    assert later.unsettled == ()  # what it leaves is screened anew
    for size in (OPEN, replace(OPEN, gain=45.0)):
        still = selected(monkeypatch, [(SLOW, GOOD, 7.0)], [(LOAD, size, 5.0), (SIDED, BAD, 2.0)])
        assert still.unsettled == (Unsettled(LOAD, {"B": 5.0}),)


def test_what_a_bounded_search_left_out_is_one_remark_with_what_to_do() -> None:
    one = estimate()
    said = with_left_out(one, [COGS, SIDED, COGS]).diagnostics[-1]
    assert (said.code, said.severity) == ("search_ended", "info")
    assert "before it tried cogging, direction: name one" in said.message
    assert said.message.endswith("--model cogging")
    assert with_left_out(one, []) is one
    model = (LOAD, COGS)
    said = with_left_out(one, [], model, [LOAD]).diagnostics[-1]
    assert (said.code, said.severity) == ("search_ended", "info")
    assert "whether another effect takes the place of quadratic-load: a model" in said.message
    assert said.message.endswith("--model quadratic-load+cogging")
    found = with_left_out(one, [SIDED], model, [LOAD], settled_model=False)
    assert len(found.diagnostics) == len(one.diagnostics) + 1
    said = found.diagnostics[-1]
    assert said.severity == "info"
    assert said.message == (
        "the search for a better model ended before it tried direction and before it asked whether "
        "another effect takes the place of quadratic-load and before the last passes of the better "
        "model were done: name one of them, as by --model direction"
    )
