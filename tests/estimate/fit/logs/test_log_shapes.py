"""Which shapes of a log's voltage are tried, where each begins, and when all are tried again: on
fits of which the objective is given.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import SPEED
from motorid.estimate.fit.logs import log_shapes
from motorid.estimate.signals.intersample_voltage import CURVED_MEANS, MEANS, SHAPES
from motorid.estimate.solver.problem import Solution
from tests.estimate.fit.made_fits import NAMES, PERIOD_S, fit, record, solution


def test_stated_means_have_no_shape_but_of_means() -> None:
    stated = record()
    stated.sensed.waveform.window_s = PERIOD_S
    assert log_shapes._shapes([stated]) == (MEANS,)
    assert log_shapes._shapes([stated, record()]) == SHAPES
    none = record(sensed=SimpleNamespace(waveform=None))
    assert log_shapes._shapes([none]) == SHAPES


def shapes_tried(
    monkeypatch: pytest.MonkeyPatch, supported: bool = True, first_L: float = 2.0,
    free: Sequence[str] = NAMES, ends: Callable[[str, float], float] = lambda *_: 50.0,
    deviation: float = 0.5 * log_shapes.HARDLY, **facts: Any,
) -> tuple[list[Any], list[Any]]:  # fmt: skip
    """Fits by shape, the first one with R = 40 and ``first_L``, and where each other begins.

    ``ends``: the objective of a search, by its shape and the L it begins with. ``deviation``: of
    the first one's ln L.
    """
    begun: list[Any] = []

    def settled(records: Any, _free: Any, start: Any) -> Solution:
        begun.append((records[0].shape, dict(start)))
        records[0].begun_at = start["L"]
        return solution(ends(records[0].shape, start["L"]))

    monkeypatch.setattr(log_shapes, "settled", settled)
    monkeypatch.setattr(log_shapes, "unsupported", lambda *_: None if supported else "so")

    def fresh(shape: Any) -> list[Any]:
        one = record(shape)
        vars(one.sensed.waveform).update(facts)
        return [one]

    first = [record(motor=lambda values: values, timeline=SimpleNamespace(period_s=PERIOD_S))]
    told = np.diag([1.0, deviation**-2, 1.0])
    ended = replace(solution(40.0, told), values=np.array([40.0, first_L, 3.0]))
    found = log_shapes.of_every_shape(first, ended, free, {"J": 7.0}, fresh)
    assert found[0][0] is first
    return found, begun


def shapes(found: Sequence[Any]) -> set[str]:
    return {one[0][0].shape for one in found}


def test_each_shape_begins_where_the_smoothest_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    _, begun = shapes_tried(monkeypatch, wanders=True, ohms=0.2)
    assert [shape for shape, _ in begun] == list(SHAPES[1:])
    for _, start in begun:
        assert start == {"J": 7.0, "R": 40.0, "L": 2.0, "K": 3.0}


def test_a_shape_that_is_another_one_is_not_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    level, _ = shapes_tried(monkeypatch, wanders=False, ohms=0.0)
    assert set(SHAPES) - shapes(level) == {"broken", "sourced"}
    wandering, _ = shapes_tried(monkeypatch, wanders=True, ohms=0.0)
    assert set(SHAPES) - shapes(wandering) == {"sourced"}
    unordered, _ = shapes_tried(monkeypatch, supported=False, wanders=True, ohms=0.2)
    assert set(SHAPES) - shapes(unordered) == {MEANS}


MOVING, STEPPED = np.linspace(0.0, 9.0, 99), np.repeat([0.0, 9.0, 4.0], 33)


@pytest.mark.parametrize(
    ("volts", "means_end", "tried"),
    [(MOVING, 30.0, True), (STEPPED, 30.0, False), (MOVING, 45.0, False)],
)
def test_means_that_are_likeliest_and_move_are_tried_as_those_of_a_curve(
    volts: Any, means_end: float, tried: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From where they ended."""
    found, begun = shapes_tried(
        monkeypatch, ends=lambda shape, _: means_end if shape == MEANS else 50.0, volts=volts
    )
    assert (CURVED_MEANS in shapes(found)) is tried
    shape, start = begun[-1]
    assert shape == (CURVED_MEANS if tried else MEANS)
    assert start["R"] == (means_end if tried else 40.0)


GONE = 0.01 * 40.0 * PERIOD_S  # H, of which readings tell nothing


def test_where_an_inductance_vanished_each_shape_begins_from_another_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The better of both is kept: of a curved voltage the first, of all others the second."""
    again = log_shapes.RISES[0] * PERIOD_S * 40.0

    def ends(shape: str, L: float) -> float:
        return 30.0 + 5.0 * ((L == GONE) is (shape != "curved"))

    found, begun = shapes_tried(monkeypatch, first_L=GONE, ends=ends, wanders=True, ohms=0.2)
    assert [shape for shape, _ in begun] == [s for s in SHAPES[1:] for _ in range(2)]
    assert [start["L"] for _, start in begun] == pytest.approx([GONE, again] * len(SHAPES[1:]))
    assert all({**start, "L": 0.0} == {"J": 7.0, "R": 40.0, "L": 0.0, "K": 3.0}
               for _, start in begun)  # fmt: skip
    assert [one[1].objective for one in found] == [40.0] + [30.0] * len(SHAPES[1:])
    assert [one[0][0].shape for one in found] == list(SHAPES)
    kept = [again if shape != "curved" else GONE for shape in SHAPES[1:]]
    assert [one[0][0].begun_at for one in found[1:]] == kept  # records of its own


def test_an_inductance_that_is_told_or_held_begins_once(monkeypatch: pytest.MonkeyPatch) -> None:
    held, hardly = {"free": ("R", "K")}, {"deviation": 2.0 * log_shapes.HARDLY}
    told = {"first_L": 0.03 * 40.0 * PERIOD_S, "deviation": 0.99 * log_shapes.HARDLY}
    for facts in (told, {"first_L": GONE, **held}, {**hardly, **held}):
        _, begun = shapes_tried(monkeypatch, wanders=True, ohms=0.2, **facts)
        assert [shape for shape, _ in begun] == list(SHAPES[1:])


def test_where_an_inductance_is_hardly_told_each_shape_begins_from_next_to_none_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The better of both is kept: of a curved voltage the first, of all others the second."""
    none = log_shapes.QUICK * PERIOD_S * 40.0

    def ends(shape: str, L: float) -> float:
        return 30.0 + 5.0 * ((L == 2.0) is (shape != "curved"))

    found, begun = shapes_tried(
        monkeypatch, ends=ends, deviation=1.01 * log_shapes.HARDLY, wanders=True, ohms=0.2
    )
    assert [shape for shape, _ in begun] == [s for s in SHAPES[1:] for _ in range(2)]
    assert [start["L"] for _, start in begun] == pytest.approx([2.0, none] * len(SHAPES[1:]))
    assert all({**start, "L": 0.0} == {"J": 7.0, "R": 40.0, "L": 0.0, "K": 3.0}
               for _, start in begun)  # fmt: skip
    assert [one[1].objective for one in found] == [40.0] + [30.0] * len(SHAPES[1:])
    kept = pytest.approx([none if shape != "curved" else 2.0 for shape in SHAPES[1:]])
    assert [one[0][0].begun_at for one in found[1:]] == kept


def test_one_that_vanished_is_no_quicker_for_being_hardly_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, begun = shapes_tried(monkeypatch, first_L=GONE, deviation=9.0, wanders=True, ohms=0.2)
    again = log_shapes.RISES[0] * PERIOD_S * 40.0
    assert [start["L"] for _, start in begun] == pytest.approx([GONE, again] * len(SHAPES[1:]))


# a speed that is read otherwise


def test_a_speed_that_is_read_otherwise_asks_for_them() -> None:
    speed, means = ({"speed": object()} for _ in range(2))
    other = {**speed, "current": object()}
    for now, was, asks in (
        (speed, speed, False), (means, speed, True), (other, speed, False),
        ({}, {}, False), (means, {}, True),
    ):  # fmt: skip
        assert log_shapes.turns_otherwise(([record(capture=now)], None), [was]) is asks


START, FIXED = {"R": 2.0, "L": 3.0, "K": 4.0, "J": 7.0}, {"J": 7.0}


def test_nobodys_speed_can_be_otherwise_where_all_is_stated(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(log_shapes.log_readings, "otherwise", lambda *_: None)
    monkeypatch.setattr(log_shapes, "shaped_again", lambda *_: pytest.fail("searched"))
    before = [record(capture="a"), record(capture="b")], solution(50.0)
    assert log_shapes.otherwise_shaped(before, NAMES, START, FIXED) is before


@pytest.mark.parametrize("stated", ["a", "b"])
def test_all_shapes_are_tried_again_with_the_other_speed_of_whoever_may_have_it(
    stated: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One record may have nothing to read otherwise: it stays as it is beside the others."""
    asked: list[Any] = []
    before, answer = ([record(capture="a"), record(capture="b")], solution(50.0)), fit(40.0)

    def otherwise(one: Any, name: str) -> Any:
        assert name == SPEED
        return None if one.capture == stated else f"{one.capture} otherwise"

    def again(*given: Any) -> Any:
        asked.append(given)
        return answer

    monkeypatch.setattr(log_shapes.log_readings, "otherwise", otherwise)
    monkeypatch.setattr(log_shapes, "shaped_again", again)
    monkeypatch.setattr(log_shapes, "MotorRecord", lambda *given: given)
    assert log_shapes.otherwise_shaped(before, NAMES, START, FIXED) is answer
    ((fit_before, free, start, fresh),) = asked
    assert fit_before is before
    assert (free, start) == (NAMES, START)
    captures = [name if name == stated else f"{name} otherwise" for name in ("a", "b")]
    for shape in ("joined", "held"):
        assert fresh(shape) == [(capture, NAMES, FIXED, shape) for capture in captures]


@pytest.mark.parametrize(("objective", "taken"), [(49.1, False), (48.9, True)])
def test_shapes_that_are_tried_again_must_be_better_by_a_little(
    objective: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They begin where the fit before ended, with the smoothest; it is their rival then."""
    begun: list[Any] = []
    before, other = fit(50.0), fit(60.0, "curved")

    def settled(records: Any, free: Any, near: Any) -> Solution:
        begun.append((records, free, near))
        return solution(70.0)

    def of_every_shape(first: Any, joined: Any, free: Any, start: Any, of: Any) -> list[Any]:
        assert (first, joined.objective, free, start) == (begun[0][0], 70.0, NAMES, START)
        assert of is fresh
        return [(first, joined), fit(objective, "held"), other]

    def fresh(shape: Any) -> list[Any]:
        return [record(shape)]

    monkeypatch.setattr(log_shapes, "settled", settled)
    monkeypatch.setattr(log_shapes, "of_every_shape", of_every_shape)
    found = log_shapes.shaped_again(before, NAMES, START, fresh)
    ((records, free, near),) = begun
    assert (records[0].shape, free) == ("joined", NAMES)
    assert near == {"R": 50.0, "L": 2.0, "K": 3.0, "J": 7.0}
    if not taken:
        assert found is before
        return
    assert found[0][0].shape == "held"
    behind = [rival.behind for rival in found[0][0].rivals]
    assert behind == pytest.approx([70.0 - objective, 60.0 - objective, 50.0 - objective])
