"""The stages of a log's fit: plain shapes, lags where the readings ask for them, and what is taken,
on fits of which the objective is given.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from motorid.estimate.fit.logs import log_fit, log_shapes
from tests.estimate.fit.made_fits import NAMES, record, solution

FIRST, PLAIN, AGAIN, WIDER, ELSEWHERE, SMOOTHED, FINER, RESHAPED, OTHER = (
    f"fit {name}" for name in "ABCDEFGHI"
)
STEP = np.array([1.0])


class Stages:
    """A log's fit whose stages end at given objectives, and note how they were asked."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **facts: Any) -> None:
        self.objectives = {
            PLAIN: 100.0, AGAIN: 100.0, WIDER: 80.0, ELSEWHERE: 81.0, SMOOTHED: 99.0,
            RESHAPED: 90.0,
        }  # fmt: skip
        self.asked_for, self.needed, self.moved = False, 10.0, True
        self.found, self.lost, self.much, self.few = False, set[str](), False, False
        self.finer, self.answered = 0.0, False  # F on a finer grid, 0: none; it asks for no more
        self.turned, self.shaped = False, [PLAIN, RESHAPED]  # the speed's way, and shapes for it
        self.other, self.content = 0.0, False  # I of the other speed, 0: none; it asks for no more
        vars(self).update(facts)
        self.asked = list[str]()
        self.ways = {"second": 1.0, "means": 2.0, "lags": 3.0, "alone": 4.0}
        answers = {
            "told": lambda records, _: [self.heard(records[0].capture)],
            "vanished": lambda found, _: float(found.objective) in self.gone(),
            "MotorRecord": lambda capture, _free, _fixed, shape: record(shape, capture=capture),
            "like": lambda _, records: records,
            "settled": lambda *_: solution(self.objectives[AGAIN]),
            "_leaves_much": lambda *_: self.much,
            "_comes_far": lambda *_: False,
            "serves_few": lambda *_: self.few,
            "unsupported": lambda *_: None,
            "widened": self.widened,
            "_begun_elsewhere": self.elsewhere,
            "moved": lambda *_: self.moved,
            "readings": lambda _: 1000.0,
        }
        for name, other in answers.items():
            monkeypatch.setattr(log_fit, name, other)
        shapes = {
            "of_every_shape": lambda *_: [self.fit(self.shaped.pop(0))],
            "turns_otherwise": lambda *_: self.turned,
            "settled": answers["settled"],
            "otherwise_shaped": self.otherwise,
        }
        for name, other in shapes.items():
            monkeypatch.setattr(log_shapes, name, other)
        monkeypatch.setattr(log_fit.log_readings, "taken", lambda *fit: fit[:2])
        monkeypatch.setattr(log_fit.log_averages, "taken", lambda before, *_: before)
        monkeypatch.setattr(log_fit.log_grid, "settled", self.on_grid)
        monkeypatch.setattr(log_fit.log_readings, "reconsidered", self.reconsidered)
        monkeypatch.setattr(log_fit.smoothed_voltage, "begun", lambda *_: [self.fit(SMOOTHED)])
        monkeypatch.setattr(log_fit.log_second_order, "taken", lambda *_: self.way("second"))
        monkeypatch.setattr(log_fit.log_second_order, "without_vanished", lambda fit, *_: fit)
        monkeypatch.setattr(log_fit.log_means, "taken", lambda *_: self.way("means"))
        monkeypatch.setattr(log_fit.log_lags, "taken", lambda *_: self.way("lags"))
        monkeypatch.setattr(log_fit.log_one_filter, "taken", lambda *_, **_how: self.way("alone"))
        monkeypatch.setattr(log_fit.log_means, "likelier", self.likelier)

    def fit(self, name: str) -> Any:
        one = record(found={"lag": 1} if self.found else {}, capture=name)
        return [one], solution(self.objectives[name])

    def gone(self) -> set[float]:
        return {self.objectives[name] for name in self.lost}

    def heard(self, of: str) -> Any:
        answered = {FINER: self.answered, OTHER: self.content}
        asks = self.asked_for and not answered.get(of, False)
        step = {FINER: 5.0, OTHER: 7.0}.get(of, 1.0) * STEP
        return SimpleNamespace(shifts=(2.0 * STEP,), step=step, needed=self.needed, asked_for=asks)

    def on_grid(self, before: Any, *_: Any) -> Any:
        return self.instead("grid", FINER, self.finer, before)

    def otherwise(self, before: Any, *_: Any) -> Any:
        return self.instead("otherwise", OTHER, self.other, before)

    def instead(self, asked: str, name: str, objective: float | None, before: Any) -> Any:
        self.asked.append(asked)
        if not objective:
            return before
        self.objectives[name] = objective
        return self.fit(name)

    def widened(self, records: Any, _free: Any, _start: Any, _solution: Any) -> Any:
        self.asked.append("widened")
        return self.fit(WIDER)[1]

    def elsewhere(self, before: Any, *_: Any) -> Any:
        self.asked.append("elsewhere")
        return [before, self.fit(ELSEWHERE)]

    def way(self, name: str) -> Any:
        self.asked.append(name)
        return [record(capture=name)], solution(self.ways[name])

    def likelier(self, one: Any, other: Any, price: float) -> Any:
        assert price == pytest.approx(np.log(1000.0))
        return min(one, other, key=lambda fit: fit[1].objective)

    def reconsidered(self, fit: Any, *_: Any) -> Any:
        self.asked.append("reconsidered")
        return fit

    def best(self) -> Any:
        start = {"R": 2.0, "L": 3.0, "K": 4.0}
        return log_fit.best([record(capture="first")], solution(200.0), NAMES, start, {})


@pytest.mark.parametrize(
    ("turned", "objective", "ended"),
    [(True, 90.0, 90.0), (True, 98.9, 98.9), (True, 99.1, 100.0), (False, 90.0, 100.0)],
)
def test_another_way_of_the_speed_has_shapes_of_its_own(
    monkeypatch: pytest.MonkeyPatch, turned: bool, objective: float, ended: float
) -> None:
    """One that is likelier by more than a little answers, and what there was is its rival."""
    stages = Stages(monkeypatch, turned=turned)
    stages.objectives[RESHAPED] = objective
    (one,), found = stages.best()
    assert found.objective == ended
    assert bool(one.rivals) is (ended < 100.0)


def test_most_logs_need_no_more_than_the_plain_shapes(monkeypatch: pytest.MonkeyPatch) -> None:
    stages = Stages(monkeypatch)
    (one,), found = stages.best()
    assert found.objective == 100.0
    assert stages.asked == []
    assert [step.tolist() for step in one.left_open] == [[2.0], [1.0]]


@pytest.mark.parametrize(
    "asks",
    [{"asked_for": True}, {"lost": {PLAIN}}, {"much": True}, {"needed": 0.9}, {"needed": 1.1}],
)
def test_lags_are_unknowns_where_something_asks_for_them(
    asks: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A low-pass of the voltage is 1 likelier here: it asks where that is more than is needed."""
    stages = Stages(monkeypatch, **asks)
    stages.best()
    assert ("widened" in stages.asked) is (asks.get("needed") != 1.1)


def test_a_finer_grid_that_answers_what_is_asked_is_all_that_is_needed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stages = Stages(monkeypatch, asked_for=True, finer=95.0, answered=True)
    (one,), found = stages.best()
    assert (found.objective, one.capture) == (95.0, FINER)
    assert not hasattr(one, "as_stamped")  # its channels are as they were stamped
    assert stages.asked == ["grid"]
    assert [step.tolist() for step in one.left_open] == [[2.0], [5.0]]


def test_a_finer_grid_that_leaves_it_asked_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    stages = Stages(monkeypatch, asked_for=True, finer=95.0, needed=21.0)
    _, found = stages.best()
    assert found.objective == 100.0
    assert stages.asked == ["grid", "otherwise", "widened"]


@pytest.mark.parametrize(
    ("asks", "searched"),
    [
        ({"asked_for": True}, True),
        ({"asked_for": True, "finer": 95.0}, True),
        ({"asked_for": True, "finer": 95.0, "answered": True}, False),  # nothing is asked any more
        ({"lost": {PLAIN}}, False),
        ({"much": True}, False),
        ({"needed": 0.9}, False),
        ({}, False),
    ],
)
def test_shapes_for_another_speed_are_searched_where_residuals_ask_alone(
    asks: dict[str, Any], searched: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the finer grid, which may answer it."""
    stages = Stages(monkeypatch, **asks)
    stages.best()
    assert stages.asked.count("otherwise") == searched
    if searched:
        assert stages.asked[:2] == ["grid", "otherwise"]


def test_what_another_speed_answers_is_told_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    stages = Stages(monkeypatch, asked_for=True, other=94.0, content=True)
    (one,), found = stages.best()
    assert (found.objective, one.capture) == (94.0, OTHER)
    assert stages.asked == ["grid", "otherwise"]  # it asks for no more
    assert [step.tolist() for step in one.left_open] == [[2.0], [7.0]]


def test_another_speed_that_leaves_it_asked_is_taken_and_asks_itself(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Lags are compared with it, and begin where it ended: 15 likelier is not enough of 16."""
    stages = Stages(monkeypatch, asked_for=True, other=95.0, needed=16.0)
    (one,), found = stages.best()
    assert (found.objective, one.capture) == (95.0, OTHER)
    assert stages.asked == ["grid", "otherwise", "widened"]
    stages = Stages(monkeypatch, asked_for=True, other=95.0, needed=14.0)
    (one,), _ = stages.best()
    assert one.as_stamped == {"R": 95.0, "L": 2.0, "K": 3.0}


@pytest.mark.parametrize(("needed", "taken"), [(19.0, True), (21.0, False)])
def test_they_are_taken_where_they_gain_enough(
    needed: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    stages = Stages(monkeypatch, asked_for=True, needed=needed)
    (one,), found = stages.best()
    assert found.objective == (1.0 if taken else 100.0)
    ways = [name for name in stages.asked if name in stages.ways]
    assert ways == (["second", "means", "lags", "alone"] if taken else [])
    assert ("reconsidered" in stages.asked) is taken
    assert hasattr(one, "as_stamped") is taken
    if taken:
        assert one.as_stamped == {"R": 100.0, "L": 2.0, "K": 3.0}
    else:
        assert one.left_open == ()  # as much information: nothing is left open


@pytest.mark.parametrize(
    ("colour", "white", "asked", "taken"),
    [
        (3.9, False, False, False),
        (4.0, False, True, True),
        (4.0, True, True, False),
        (5.1, False, True, False),
    ],
)
def test_residuals_of_one_colour_ask_too_and_make_them_dearer(
    colour: float, white: bool, asked: bool, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """20 likelier here, where each unknown that needs 4 of white readings needs 4 times as much.
    What is likelier for white residuals alone is not taken.
    """
    monkeypatch.setattr(log_fit, "inflation", lambda _: colour)
    monkeypatch.setattr(log_fit, "_white_alone", lambda *_: white)
    stages = Stages(monkeypatch, needed=4.0)
    stages.objectives[SMOOTHED] = 100.0
    _, found = stages.best()
    assert ("widened" in stages.asked) is asked
    assert found.objective == (1.0 if taken else 100.0)


@pytest.mark.parametrize(("ends", "alone"), [((5.0, 4.9), False), ((5.0, 5.1), True)])
def test_fits_are_held_against_each_other_with_the_memory_of_their_residuals(
    ends: tuple[float, float], alone: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In twins of their records, each from where it ended: those of the fits stay as they are."""
    begun = []

    def whitened(records: Any, free: Any, start: Any, solution: Any) -> Any:
        begun.append((records, start, solution))
        return SimpleNamespace(objective=solution.ends)

    def fit(name: str, value: float, end: float) -> Any:
        record = SimpleNamespace(twin=lambda: f"twin of {name}")
        unknowns = [SimpleNamespace(name="R")]
        return [record], SimpleNamespace(unknowns=unknowns, values=np.array([value]), ends=end)

    monkeypatch.setattr(log_fit, "whitened", whitened)
    before, after = fit("a", 2.0, ends[0]), fit("b", 3.0, ends[1])
    assert log_fit._white_alone(before, after, ("R",), {"R": 1.0, "L": 5.0}) is alone
    assert [records for records, *_ in begun] == [["twin of a"], ["twin of b"]]
    assert [start for _, start, _ in begun] == [{"R": 2.0, "L": 5.0}, {"R": 3.0, "L": 5.0}]


def test_a_colour_is_that_of_the_most_coloured_channel() -> None:
    rng = np.random.default_rng(1)
    white = rng.standard_normal(4000)
    slow = lfilter([1.0], [1.0, -0.7], white)
    both: Any = SimpleNamespace(
        residual=np.concatenate([white, slow]), slices=(slice(4000), slice(4000, 8000))
    )
    alone: Any = SimpleNamespace(residual=white, slices=(slice(4000),))
    assert log_fit.inflation(SimpleNamespace(records=[alone, both])) > 4.0  # type: ignore[arg-type]
    assert log_fit.inflation(SimpleNamespace(records=[alone])) < 1.5  # type: ignore[arg-type]


def test_what_serves_a_few_readings_alone_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    stages = Stages(monkeypatch, asked_for=True, needed=19.0, few=True)
    (one,), found = stages.best()
    assert (found.objective, one.outlying) == (100.0, True)
    assert not {"reconsidered", *stages.ways} & set(stages.asked)


@pytest.mark.parametrize(("worse", "few"), [(1.0, False), (1.4, False), (1.6, True)])
def test_what_leaves_most_readings_off_by_more_serves_few(worse: float, few: bool) -> None:
    def fit(size: float, outliers: float) -> Any:
        left = size * np.tile([1.0, -1.0], 50)
        left[:3] = outliers
        block = SimpleNamespace(name="current", floor=1e-6)
        kept = record(measured=(SimpleNamespace(block=block),), departures=lambda *_: [left])
        return [kept], solution(0.0, None, ())

    assert log_fit.serves_few(fit(1.0, 50.0), fit(worse, 5.0)) is few


def test_the_likeliest_of_its_ways_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("second", "means", "lags"):
        stages = Stages(monkeypatch, asked_for=True)
        stages.ways = {**stages.ways, name: 0.5}
        (one,), _ = stages.best()
        assert one.capture == name


@pytest.mark.parametrize(
    ("facts", "begun"),
    [({}, False), ({"found": True}, True), ({"lost": {WIDER}}, True), ({"lost": {PLAIN}}, False)],
)
def test_other_places_are_tried_where_something_was_found_or_the_inductance_went(
    facts: dict[str, Any], begun: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    likely = {PLAIN: 100.0, AGAIN: 100.0, WIDER: 80.0, ELSEWHERE: 81.0, SMOOTHED: 79.0}
    stages = Stages(monkeypatch, asked_for=True, objectives=likely, **facts)
    if facts.get("lost") == {WIDER}:
        likely[SMOOTHED] = 99.0
    stages.best()
    assert ("elsewhere" in stages.asked) is begun


@pytest.mark.parametrize(("moved", "again", "objective"), [(False, 85.0, 85.0), (True, 85.0, 1.0)])
def test_what_is_as_likely_without_lags_has_none(
    moved: bool, again: float, objective: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The plain shape, begun anew where the lags ended, is 15 likelier: they gain 5 of 10."""
    likely = {PLAIN: 100.0, AGAIN: again, WIDER: 80.0, ELSEWHERE: 81.0, SMOOTHED: 99.0}
    stages = Stages(monkeypatch, asked_for=True, moved=moved, objectives=likely)
    assert stages.best()[1].objective == objective
