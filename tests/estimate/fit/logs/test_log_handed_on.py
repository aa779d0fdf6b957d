"""What each stage of a log's fit is handed: records, parameters and captures that are given."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.fit.logs import log_fit, log_lags, log_readings, log_shapes
from motorid.estimate.signals.intersample_voltage import Rival
from motorid.estimate.signals.time_grid import IRREGULAR
from tests.estimate.fit.made_fits import LAG, NAMES, PERIOD_S, known, record, solution

START, FIXED = {"R": 2.0, "L": 3.0, "K": 4.0, "J": 7.0}, {"J": 7.0}
SOLVED = {"L": 2.0, "K": 3.0, "J": 7.0}  # by every answer, whose R is its objective


class Handed:
    """A log's fit that goes through all stages; each notes what it was handed, by its name."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, misfit: bool = False) -> None:
        self.seen, self.compared = dict[str, Any](), list[Any]()
        self.plain = [record("held", capture="read otherwise")], solution(100.0, None, (0.1,))
        self.wider = solution(60.0, None, (0.2,))
        self.ways = {n: ([record(n)], solution(61.0)) for n in ("second", "means", "lags", "alone")}
        heard = [SimpleNamespace(shifts=(), step=0.0, needed=5.0, asked_for=True)]
        monkeypatch.setattr(log_shapes, "turns_otherwise", lambda *_: False)
        self.note(monkeypatch, log_shapes, "of_every_shape", [self.plain])
        self.note(monkeypatch, log_shapes, "otherwise_shaped", self.plain)
        self.note(monkeypatch, log_fit.log_readings, "taken", self.plain)
        self.note(monkeypatch, log_fit, "told", heard)
        self.note(monkeypatch, log_fit.log_grid, "settled", self.plain, "grid")
        self.note(monkeypatch, log_fit.log_averages, "taken", self.plain, "averages")
        self.note(monkeypatch, log_fit, "vanished", False)
        self.note(monkeypatch, log_fit.smoothed_voltage, "begun", [])
        self.note(monkeypatch, log_fit, "unsupported", None)
        self.note(monkeypatch, log_fit, "_leaves_much", misfit)
        self.note(monkeypatch, log_fit, "_comes_far", False)
        self.note(monkeypatch, log_fit, "like", [record("like")])
        self.note(monkeypatch, log_fit, "settled", solution(90.0, None, (0.3,)))
        self.note(monkeypatch, log_fit, "widened", self.wider)
        self.note(monkeypatch, log_fit, "moved", True)
        self.note(monkeypatch, log_fit, "readings", 1000)
        self.note(monkeypatch, log_fit, "serves_few", False)
        self.note(monkeypatch, log_fit.log_second_order, "taken", self.ways["second"], "second")
        self.note(monkeypatch, log_fit.log_means, "taken", self.ways["means"], "means")
        self.note(monkeypatch, log_fit.log_lags, "taken", self.ways["lags"], "lags")
        self.note(monkeypatch, log_fit.log_one_filter, "taken", self.ways["alone"], "alone")
        likelier = log_fit.log_means.likelier
        monkeypatch.setattr(
            log_fit.log_means, "likelier",
            lambda *of: self.compared.append(of) or likelier(*of),
        )  # fmt: skip
        monkeypatch.setattr(log_fit.log_readings, "reconsidered", self.passed_on("reconsidered"))
        monkeypatch.setattr(
            log_fit.log_second_order, "without_vanished", self.passed_on("without vanished")
        )
        monkeypatch.setattr(
            log_fit, "MotorRecord", lambda *given: record(given[3], made_of=given[:3])
        )
        self.first = [record(capture="as read")]
        self.found = log_fit.best(self.first, solution(200.0), NAMES, START, FIXED)

    def note(
        self,
        monkeypatch: pytest.MonkeyPatch,
        module: Any,
        name: str,
        answer: Any,
        known_as: str = "",
    ) -> None:
        def stage(*asked: Any, **how: Any) -> Any:
            self.seen.setdefault(known_as or name, (*asked, *how.items()))
            return answer

        monkeypatch.setattr(module, name, stage)

    def passed_on(self, name: str) -> Any:
        def stage(*asked: Any) -> Any:
            self.seen[name] = asked
            return asked[0]

        return stage


def test_every_stage_is_handed_what_the_one_before_it_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    handed = Handed(monkeypatch)
    seen = handed.seen
    first, joined, free, start, fresh = seen["of_every_shape"]
    assert (first, joined.objective, free, start) == (handed.first, 200.0, NAMES, START)
    assert seen["begun"] == (first, joined, NAMES, {"R": 200.0, **SOLVED}, FIXED)
    assert seen["told"] == handed.plain
    assert seen["grid"] == (handed.plain, NAMES, START, FIXED)
    assert seen["otherwise_shaped"] == (handed.plain, NAMES, START, FIXED)
    assert seen["vanished"] == (handed.wider, seen["widened"][0])
    assert seen["unsupported"] == seen["_leaves_much"] == handed.plain
    (plain, records), known = seen["like"], {"R": 100.0, **SOLVED}
    assert plain == handed.plain
    # the readings as they turned out to be, and the shape that was the likeliest
    assert [(r.shape, r.made_of) for r in records] == [("held", ("read otherwise", NAMES, FIXED))]
    (later,) = fresh("curved")
    assert (later.shape, later.made_of[0]) == ("curved", "read otherwise")
    assert seen["settled"][1:] == (NAMES, known)
    assert seen["widened"][1:3] == (NAMES, known)
    assert seen["widened"][3].objective == 90.0
    assert seen["moved"][1].tolist() == [0.2]
    wider = seen["second"][0]
    assert wider[1] is handed.wider
    for name in ("second", "means"):
        assert seen[name] == (wider, NAMES, known, FIXED)
    assert seen["averages"] == (handed.plain, ["as read"], NAMES, START, FIXED, 100.0)
    for name in ("lags", "alone"):  # from the captures as they were read
        assert seen[name] == (wider, ["as read"], NAMES, known, FIXED)
    assert seen["serves_few"] == (handed.plain, wider)
    assert seen["reconsidered"] == (wider, NAMES, known, FIXED)
    assert seen["without vanished"] == (wider, NAMES, known, FIXED)
    assert handed.found[0][0].as_stamped == known


def test_a_misfit_has_one_filter_sought_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    handed = Handed(monkeypatch, misfit=True)
    before, as_read, *how, sought = handed.seen["alone"]
    assert before[1] is handed.wider
    assert (as_read, how) == (["as read"], [NAMES, {"R": 100.0, **SOLVED}, FIXED])
    assert sought == ("sought", True)
    price = np.log(1000.0)  # of each unknown more, of so many readings
    first, *others = handed.compared
    assert (first[0][1], first[1], first[2]) == (handed.wider, handed.ways["alone"], price)
    assert [other for _, other, _ in others] == [*handed.ways.values()]


def waves(noise: float, slow: float, value: float = 10.0, **facts: Any) -> Any:
    """A record whose channel has that range, and is left noise and a slow wave."""
    at = np.arange(400.0)
    left = noise * (-1.0) ** at + slow * np.sin(at / 30.0)
    values = np.where(at == 0, value, 0.0)
    m = SimpleNamespace(values=values, block=SimpleNamespace(name="speed"))
    facts = {"capture": "run", "timeline": SimpleNamespace(jitter=0.0), **facts}
    return record(measured=[m], departures=lambda *_: [left], **facts)


@pytest.mark.parametrize(
    ("noise", "slow", "much"),
    [
        (0.0, 0.3, True),  # rms .21, beyond a fiftieth of the range
        (0.0, 0.25, False),
        (1.0, 0.0, False),  # which is all between neighbours
        (0.5, 0.95, False),  # a mean square of .25 + .45; 1.5 · half of 1 between neighbours
        (0.5, 1.05, True),
    ],
)
def test_a_fit_leaves_much_where_neighbours_are_off_alike(
    noise: float, slow: float, much: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By more than half again of what would be noise alone, and of a fiftieth of the range."""
    monkeypatch.setattr(log_fit, "motion", lambda _: "speed")
    assert log_fit._leaves_much([waves(noise, slow)], solution(0.0, None, ())) is much


@pytest.mark.parametrize(
    ("facts", "much"),
    [({}, True), ({"jitter": 1.01 * IRREGULAR}, False), ({"moves": False}, False)],
)
def test_of_irregular_or_still_logs_nobody_knows(
    facts: dict[str, Any], much: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    jitter, moves = facts.get("jitter", IRREGULAR), facts.get("moves", True)
    monkeypatch.setattr(log_fit, "motion", lambda _: "speed" if moves else None)
    one = waves(0.0, 3.0, timeline=SimpleNamespace(jitter=jitter))
    calm = waves(0.0, 0.01)
    assert log_fit._leaves_much([calm, one], solution(0.0, None, (), ())) is much


def test_typical_sizes_are_the_largest_of_all_records_and_no_less_than_the_floor() -> None:
    def run(**sizes: float) -> Any:
        blocks = [SimpleNamespace(block=SimpleNamespace(name=n, floor=0.5)) for n in sizes]
        left = [np.array([-size, 9.0, size]) for size in sizes.values()]
        return record(measured=blocks, departures=lambda *_: left)

    runs = [run(current=1.0, speed=0.1), run(current=3.0, speed=0.2), run(current=2.0)]
    found = log_fit._typical((runs, solution(0.0, None, (), (), ())))
    assert found == {"current": 3.0, "speed": 0.5}


# ways to read, once lags are found


def test_a_speed_is_reconsidered_with_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {}
    before = [record("held")], solution(50.0, None, (0.1,))
    answer = solution(40.0)

    def averaged(fit: Any, name: str, again: Any) -> Any:
        assert (fit, name) == (before, "speed")
        return again(["one", "two"], "curved", before)

    def noted(name: str, result: Any) -> Any:
        return lambda *asked: seen.update({name: asked}) or result(*asked)

    monkeypatch.setattr(log_readings, "_averaged", averaged)
    monkeypatch.setattr(log_readings, "MotorRecord", lambda *given: given)
    monkeypatch.setattr(log_readings, "like", noted("like", lambda _, records: records))
    monkeypatch.setattr(log_readings, "settled", noted("settled", lambda *_: "settled"))
    monkeypatch.setattr(log_readings, "widened", noted("widened", lambda *_: answer))
    records, found = log_readings.reconsidered(before, NAMES, START, FIXED)
    assert records == [(name, NAMES, FIXED, "curved") for name in ("one", "two")]
    assert found is answer
    near = {"R": 50.0, **SOLVED}
    assert seen["like"] == (before, records)
    assert seen["settled"] == (records, NAMES, near)
    assert seen["widened"] == (records, NAMES, near, "settled")


def test_other_readings_are_searched_from_where_the_fit_before_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[Any] = []
    before = [record("held", capture="run")], solution(50.0)

    def averaged(fit: Any, _name: str, again: Any) -> Any:
        seen.append(again(["run"], "loose", fit))
        return fit

    monkeypatch.setattr(log_readings, "_averaged", averaged)
    monkeypatch.setattr(log_readings, "_loosened", lambda fit, _: fit)
    monkeypatch.setattr(log_readings, "motion", lambda _: "speed")
    monkeypatch.setattr(log_readings, "MotorRecord", lambda *given: given)
    monkeypatch.setattr(log_readings, "settled", lambda *asked: asked)
    log_readings.taken(*before, NAMES, START, FIXED)
    records = [("run", NAMES, FIXED, "loose")]
    assert seen[0] == (records, (records, NAMES, {"R": 50.0, **SOLVED}))


def test_the_same_shape_is_searched_with_the_other_readings() -> None:
    """One record may have nothing to read otherwise: it stays as it is beside the others."""
    asked: list[Any] = []
    stated = record("held", capture="stated", block=lambda _: None)
    before = [stated], solution(50.0)
    never: Any = lambda *given: asked.append(given)  # noqa: E731
    assert log_readings._averaged(before, "speed", never) is before
    assert asked == []


# a current of whole samples


def test_a_current_whose_lag_was_found_in_some_records_alone_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(log_lags, "_of_shapes", lambda *_: pytest.fail("searched"))
    one, own = known((LAG, 3.0 * PERIOD_S, PERIOD_S), found=[LAG])
    other, same = known((LAG, 3.0 * PERIOD_S, PERIOD_S))
    before = [one, other], solution(9.0, None, own, same)
    assert log_lags.taken(before, ["a", "b"], NAMES, {}, {}) is before  # type: ignore[list-item]


def test_each_current_is_taken_earlier_by_its_own_lag(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def of_shapes(captures: Any, *how: Any) -> Any:
        asked.append((captures, *how))
        return [([record(), record()], solution(100.0))]

    monkeypatch.setattr(log_lags, "_of_shapes", of_shapes)
    monkeypatch.setattr(
        log_lags, "_earlier", lambda read, late_s: (read, round(late_s / PERIOD_S, 6))
    )
    one, own = known((LAG, 3.2 * PERIOD_S, PERIOD_S), found=[LAG])
    other, more = known((LAG, 5.9 * PERIOD_S, PERIOD_S), found=[LAG])
    before = [one, other], solution(9.0, None, own, more)
    captures: Any = ["a", "b"]
    assert log_lags.taken(before, captures, NAMES, START, FIXED) is before
    assert [list(captures) for captures, *_ in asked] == [
        [("a", 3), ("b", 6)], [("a", 2), ("b", 5)], [("a", 4), ("b", 7)],
    ]  # fmt: skip
    assert all(how == [NAMES, START, FIXED] for _, *how in asked)


def test_a_taken_current_has_the_rivals_and_the_doubts_of_its_records(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    better = [record(), record()], solution(1.0)
    monkeypatch.setattr(log_lags, "_of_shapes", lambda *_: [better])
    monkeypatch.setattr(log_lags, "_earlier", lambda *_: "earlier")

    def told(records: Any, found: Any) -> Any:
        assert (records, found) == better
        return [SimpleNamespace(shifts=(n,), step=-n) for n in (1, 2)]

    monkeypatch.setattr(log_lags, "told", told)
    one, own = known((LAG, 3.2 * PERIOD_S, PERIOD_S), found=[LAG])
    other, more = known((LAG, 5.9 * PERIOD_S, PERIOD_S), found=[LAG])
    one.rivals, other.rivals = (Rival(np.zeros(3), 1.0),), ()
    before = [one, other], solution(9.0, None, own, more)
    records, _ = log_lags.taken(before, ["a", "b"], NAMES, START, FIXED)  # type: ignore[list-item]
    assert [r.left_open for r in records] == [(1, -1), (2, -2)]
    assert [[r.behind for r in one.rivals] for one in records] == [[1.0 + 8.0], []]
