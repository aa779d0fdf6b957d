"""Starts that are searched, and noise with its memory: what is handed on, on given answers."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.fit import alternating_fit, multistart
from motorid.estimate.results.estimate import PARAMETERS
from tests.estimate.fit.given_answers import START, note, record, solution


def test_a_fit_is_settled_and_then_whitened_from_its_values(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []
    white = solution(50.0, K=0.06)
    note(monkeypatch, multistart, "settled", seen, white)
    note(monkeypatch, multistart, "whitened", seen, "answer")
    records: Any = [record()]
    found: Any = multistart.solve(records, PARAMETERS, START)
    assert found == "answer"
    assert seen == [
        ("settled", records, PARAMETERS, START),
        ("whitened", records, PARAMETERS, {**START, "K": 0.06}, white),
    ]


@pytest.mark.parametrize(
    ("colour", "weighed", "objective", "settled"),
    [
        (False, False, 50.0, True),  # nothing was new: it began where it had ended
        (False, False, 49.0, False), (False, True, 50.0, False), (True, False, 50.0, False),
    ],
)  # fmt: skip
def test_a_search_that_begins_where_it_ended_has_settled(
    colour: bool, weighed: bool, objective: float, settled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No step leads down from a bend, though the slopes beside it promise one."""
    stuck = replace(solution(objective), converged=False)
    monkeypatch.setattr(multistart.prewhitening, "whiten", lambda *_: colour)
    monkeypatch.setattr(multistart.prewhitening, "thin", lambda *_: weighed)
    monkeypatch.setattr(multistart, "_filtered", lambda *_: None)
    monkeypatch.setattr(multistart, "again", lambda *_, **__: stuck)
    monkeypatch.setattr(multistart, "COLOUR_PASSES", 1)
    found = multistart.whitened([record()], PARAMETERS, START, solution(50.0))
    assert found.converged is settled
    before = replace(solution(50.0), converged=False)
    assert not multistart.whitened([record()], PARAMETERS, START, before).converged


def test_starts_are_searched_in_the_same_records(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that misfits or did not converge; what follows is handed the likelier answer."""
    seen: list[Any] = []
    answers = [solution(100.0), *[solution(200.0)] * 4, solution(90.0)]
    note(monkeypatch, multistart, "with_sources", seen, *answers)
    note(monkeypatch, multistart, "leaves_misfit", seen, True)
    note(monkeypatch, multistart, "unsupported", seen, None)
    note(monkeypatch, multistart, "vanished", seen, True)
    note(monkeypatch, multistart, "_begun_again", seen, "again")
    note(monkeypatch, multistart, "with_promoted", seen, "promoted")
    note(monkeypatch, multistart.added_noise, "judged", seen, "judged")
    records: Any = [record()]
    found: Any = multistart.settled(records, PARAMETERS, START)
    assert found == "judged"
    calls = {name: rest for name, *rest in seen}
    assert calls["with_sources"] == [records, PARAMETERS, START]
    assert calls["leaves_misfit"] == [answers[0], records]
    assert calls["unsupported"] == [records, answers[-1]]
    assert calls["vanished"] == [answers[-1], records]
    assert calls["_begun_again"] == [records, PARAMETERS, START, answers[-1]]
    assert calls["with_promoted"] == [records, PARAMETERS, START, "again"]
    assert calls["judged"] == [records, "promoted"]


@pytest.mark.parametrize(("misfit", "slow"), [(0.19, False), (0.21, True)])
def test_a_residual_that_is_no_noise_is_a_misfit_beyond_a_fiftieth_of_the_range(
    misfit: float, slow: bool
) -> None:
    """Of a channel that reaches from -4 to 6; slow as it is, no noise explains it."""
    at = np.arange(500.0)
    m = SimpleNamespace(values=np.where(at == 3, 6.0, np.where(at == 4, -4.0, 0.0)))
    left = np.sqrt(2.0) * misfit * np.sin(at / 20.0)
    one = SimpleNamespace(measured=[m], departures=lambda values, own: [own * left])
    calm = SimpleNamespace(measured=[m], departures=lambda values, own: [0.0 * left])
    found = replace(solution(1.0), own=(np.ones(1), np.ones(1)))
    records: Any = [calm, one]
    assert multistart.leaves_misfit(found, records) is slow


def test_promoted_quantities_are_searched_in_the_same_records(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []
    note(monkeypatch, multistart, "promoted", seen, ("widened", ["gain"]), ("end", []))
    note(monkeypatch, multistart, "again", seen, "after")
    note(monkeypatch, multistart, "contradicted", seen, False)
    note(monkeypatch, multistart, "in_turn", seen, "turned")
    records, before = ["record"], solution(1.0)
    found: Any = multistart.with_promoted(records, PARAMETERS, START, before)  # type: ignore[arg-type]
    assert found == "turned"
    assert seen == [
        ("promoted", records, before),
        ("again", records, PARAMETERS, START, "widened", alternating_fit.ROUGH),
        ("contradicted", records, "after", ["gain"]),
        ("in_turn", records, PARAMETERS, START, "after"),
        ("promoted", records, "turned"),
    ]


def test_what_repeats_is_searched_in_the_same_records(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []
    note(monkeypatch, multistart, "with_repeating", seen, "widened")
    note(monkeypatch, multistart, "again", seen, "first", "second")
    note(monkeypatch, multistart, "in_turn", seen, "turned", "turned again")
    note(monkeypatch, multistart, "taken_again", seen, "moved", None)
    one, before = record(), solution(1.0)
    one.decide = lambda decided: seen.append(("decide", decided))
    found: Any = multistart.with_repeated([one], PARAMETERS, START, before)
    assert found == "turned again"
    where = ([one], PARAMETERS, START)
    assert seen == [
        ("with_repeating", [one], before), ("decide", False),
        ("again", *where, "widened", alternating_fit.ROUGH), ("in_turn", *where, "first"),
        ("taken_again", [one], "turned"),
        ("again", *where, "moved", alternating_fit.ROUGH), ("in_turn", *where, "second"),
        ("taken_again", [one], "turned again"),
    ]  # fmt: skip


def test_noise_is_judged_by_the_latest_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []
    first, second, third = (solution(x) for x in (10.0, 9.0, 8.0))
    note(monkeypatch, multistart.prewhitening, "whiten", seen, True)
    note(monkeypatch, multistart.prewhitening, "thin", seen, None)
    note(monkeypatch, multistart, "again", seen, second, third)
    records: Any = [record()]
    assert multistart.whitened(records, PARAMETERS, START, first, 0.5, 7) is third
    names = [name for name, *_ in seen]
    assert names == ["whiten", "thin", "again"] * 2
    for (_, *judged), answer in zip(seen[:2] + seen[3:5], (first, first, second, second)):  # noqa: B905
        assert judged == [records, answer]
    _, *how, enough, most = seen[2]
    assert how[:3] == [records, PARAMETERS, START]
    assert (how[3].objective, enough, most) == (10.0, 0.5, ("most", 7))


def test_a_filter_that_hides_what_the_readings_show_is_taken_off(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """White noise explains the current; behind a filter of what it leaves, nothing is explained."""
    seen: list[Any] = []
    white, thinned = solution(50.0, R=2.1), solution(60.0, R=2.2)
    monkeypatch.setattr(multistart.prewhitening, "whiten", lambda *_: True)
    monkeypatch.setattr(multistart.prewhitening, "thin", lambda *_: False)
    monkeypatch.setattr(multistart, "_filtered", lambda *_: None)
    monkeypatch.setattr(multistart, "COLOUR_PASSES", 1)
    note(monkeypatch, multistart, "again", seen, solution(20.0, R=4.0), thinned)
    note(monkeypatch, multistart, "shares", seen, {"current": 0.02}, {"current": 0.37})
    filters: list[Any] = []
    read = record()
    read.measured, read.whiten = ("current",), filters.append
    found = multistart.whitened([read], PARAMETERS, START, white)
    assert found is thinned
    assert filters == [[None]]
    assert seen[-1][4].values.tolist() == white.values.tolist()  # it begins where white noise ended


@pytest.mark.parametrize(
    ("white", "coloured"),
    [
        (0.0016, 0.011),
        (0.001, 0.045),
        (0.12, 0.28),
        (0.02, 0.02),
    ],  # small, or not much more: noise has its memory
)
def test_a_filter_that_costs_little_stays(white: float, coloured: float) -> None:
    assert not multistart._hides({"current": white}, {"current": coloured})
