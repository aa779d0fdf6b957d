"""Terms of the last model that are of no use, or do not stand out, when the search has ended."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.extended_terms import TERMS, Term
from motorid.estimate.selection import extended_results, revision
from motorid.estimate.selection.evidence import SURE
from motorid.estimate.selection.revision import Revision
from motorid.estimate.selection.unsettled_models import Unsettled
from motorid.estimate.solver.allowance import Allowance

SIDED, LOAD = TERMS["direction"], TERMS["quadratic-load"]
REACH = {"R": 0.1}
WIDTH, TAKES = 2, 5  # responses: of a set of derivatives, of a fit
BELOW = 1.0 - 1e-9


class Fit:
    """R of 2 and the terms' sizes, as far as they are looked at."""

    width = WIDTH

    def __init__(self, *terms: Term, R: float = 2.0, deviation: float = 0.1) -> None:
        self.terms, self.free = terms, ("R", *(t.size for t in terms))
        self.values = {"R": R}
        self.open = deviation
        count = len(self.free)
        covariance = 0.04 * np.eye(count)
        covariance[0, 1:] = covariance[1:, 0] = 0.01
        self.solution = SimpleNamespace(
            values=np.array([R, *(0.3 for _ in terms)]),
            slopes=np.array([R, *(1.0 for _ in terms)]), covariance=covariance,
        )  # fmt: skip

    def deviation(self, _name: str) -> float:
        return self.open


def lean(
    monkeypatch: pytest.MonkeyPatch, without: Fit, reach: float = 0.1, most: float = 1e9,
    size: float = 9.0, companions: tuple[Term, ...] = (SIDED,),
) -> tuple[Any, Any, Allowance]:  # fmt: skip
    """(before, after, allowance): the model of both terms, and what is left of it."""
    allowance, whole = Allowance(most=most), Fit(SIDED, LOAD)

    def begun(_f: Any, terms: Any) -> Any:
        assert terms == (LOAD,)
        allowance.count.responses += TAKES
        allowance.ends()
        return SimpleNamespace(roughly=lambda: without, nearly=lambda one: one)

    monkeypatch.setattr(revision, "_begun", begun)
    monkeypatch.setattr(revision, "size_of", lambda *_: size)
    found = Revision((), allowance).lean(whole, companions, {"R": reach})  # type: ignore[arg-type]
    return whole, found, allowance


def test_one_that_moves_nothing_is_no_part_of_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    less = Fit(LOAD, R=2.0 + 0.1 * BELOW, deviation=np.hypot(0.1, 0.05) * BELOW)
    _, found, allowance = lean(monkeypatch, less, reach=0.151)
    assert found is less
    assert allowance.spent == TAKES


@pytest.mark.parametrize(
    "without",
    [Fit(LOAD, R=2.16), Fit(LOAD, R=1.84), Fit(LOAD, deviation=0.1265)],
)
def test_one_without_which_a_parameter_moves_or_is_less_sure_stays(
    without: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is open besides counts from half of what matters, in squares."""
    whole, found, _ = lean(monkeypatch, without, reach=0.151)
    assert found is whole


def test_one_without_which_another_does_not_stand_out_stays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole, found, _ = lean(monkeypatch, Fit(LOAD), reach=0.151, size=SURE)
    assert found is whole


def test_one_that_straight_lines_see_move_a_parameter_is_not_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """R follows by 2 · .01/.04 of a size of .3: by .15."""
    whole, found, allowance = lean(monkeypatch, Fit(LOAD), reach=0.149)
    assert (found, allowance.spent) == (whole, 0)


def test_one_that_earned_its_place_or_is_the_last_is_not_asked_about(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for companions in ((), (LOAD,), (TERMS["cogging"],)):
        whole, found, allowance = lean(monkeypatch, Fit(LOAD), reach=9.0, companions=companions)
        assert (found, allowance.spent) == (whole, 0)


@pytest.mark.parametrize(("most", "spent"), [(23.9, 0), (24.0, TAKES)])
def test_a_fit_without_it_begins_where_there_is_room(
    most: float, spent: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    *_, allowance = lean(monkeypatch, Fit(LOAD), reach=9.0, most=most)
    assert allowance.spent == spent


def test_a_fit_that_was_cut_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(revision, "AGAIN", 1)
    whole, found, allowance = lean(monkeypatch, Fit(LOAD), reach=9.0, most=TAKES)
    assert found is whole
    assert allowance.ended


def test_a_size_at_its_bound_moves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    fitted: Any = Fit(SIDED, LOAD)
    fitted.solution.covariance[1, 1] = 0.0
    assert revision._moved_by(fitted, SIDED, REACH) == 0.0


@pytest.mark.parametrize(
    ("faint", "most", "settled", "others", "goes"),
    [
        (True, 72.0, True, True, True), (False, 72.0, True, True, False),
        (True, 71.9, True, True, False), (True, 72.0, False, True, False),
        (True, 72.0, True, False, False),
    ],
)  # fmt: skip
def test_an_older_term_that_does_not_stand_out_is_not_offered_but_stays_possible(
    faint: bool, most: float, settled: bool, others: bool, goes: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """If the others do, in a fit that has room for its end."""
    whole: Any = Fit(SIDED, LOAD)
    less: Any = Fit(LOAD)
    whole.settled, less.settled = True, settled
    asked: list[Any] = []
    monkeypatch.setattr(extended_results, "current", lambda: Allowance(most=most))
    monkeypatch.setattr(extended_results, "finished", lambda fitted: fitted)
    monkeypatch.setattr(extended_results, "findings", lambda *of: of)

    def left(*of: Any) -> Any:
        asked.append(of)
        return less

    monkeypatch.setattr(revision, "without", left)
    monkeypatch.setattr(
        extended_results, "stands_out", lambda of, _: not faint if of == "whole" else others
    )
    before = Unsettled(TERMS["cogging"], {"R": 9.0})
    looked: Any = extended_results.without_faint
    found, half = looked(whole, "whole", {}, (), [before])
    if goes:
        assert asked == [(whole, [SIDED])]
        assert found == (less, (less, {}, ()))
        assert half == [before, Unsettled(SIDED, whole.values)]
    else:
        assert found == (whole, "whole")
        assert half == [before]
