"""Which channel of a log is put behind one filter, of which size, and which fit is taken.

On fits of which the objective is given.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, VOLTAGE
from motorid.errors import DataError
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import SECOND_ORDER, UNSTATED
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from motorid.estimate.fit.logs import log_one_filter, log_unknowns
from motorid.estimate.signals.intersample_voltage import BROKEN, JOINED, Rival
from motorid.estimate.solver.problem import Unknown
from tests.estimate.fit.made_fits import (
    LAG,
    NAMES,
    PERIOD_S,
    SMOOTHING,
    SPEED_SMOOTH,
    known,
    record,
    solution,
)

VOLTAGE_SMOOTH, LATE = Instance(VOLTAGE_SMOOTHING), Instance(VOLTAGE_LATE)
NEAR = {"R": 2.0, "L": 3.0, "K": 4.0}


def log(*sizes: tuple[Instance, float], own: Any = None, **facts: Any) -> Any:
    """A record of sizes in samples, each with a prior of one; and these sizes, s."""
    one, found = known(*((i, x * PERIOD_S, PERIOD_S) for i, x in sizes))
    vars(one).update(facts)
    return one, found


@pytest.mark.parametrize(
    ("sizes", "later"),
    [
        # the middle one of three is the usual one; of two, the earlier
        (((SMOOTHING, 4.0), (SPEED_SMOOTH, 1.0), (VOLTAGE_SMOOTH, 0.0)), (3.0, 0.0, -1.0)),
        (((SMOOTHING, 4.0), (SPEED_SMOOTH, 1.0)), (3.0, 0.0, None)),
        (((LAG, 2.5), (SMOOTHING, 4.0), (SPEED_SMOOTH, 1.0)), (5.5, 0.0, None)),
        # a voltage that is late makes all others early
        (((LATE, 2.0), (SMOOTHING, 0.0), (SPEED_SMOOTH, 1.0), (VOLTAGE_SMOOTH, 3.0)), (-1, 0, 0)),
        (((LAG, 2.0), (SPEED_SMOOTH, 1.0)), (None, 0.0, None)),
        (((LAG, 2.0),), (None, None, None)),
    ],
)
def test_a_channel_is_later_than_usual_by_its_lag_and_its_low_pass(
    sizes: Any, later: tuple[float | None, ...]
) -> None:
    one, own = log(*sizes)
    found = log_one_filter.later(one, own.tolist())
    names = (CURRENT, SPEED, VOLTAGE)
    wanted = {n: x * PERIOD_S for n, x in zip(names, later, strict=True) if x is not None}
    assert found == pytest.approx(wanted, abs=1e-12)


class Searches:
    """Instead of searches: what each begins with; their objectives in turn."""

    def __init__(self, *objectives: float, spent: int = 10) -> None:
        self.left, self.asked, self.spent = list(objectives), list[Any](), spent

    def __call__(self, shape: str, found: Any, start: Any) -> Any:
        sizes = [{one: u.start / PERIOD_S for one, u in run.items()} for run in found]
        self.asked.append((shape, sizes, dict(start)))
        one, own = log((SMOOTHING, 9.0), (LAG, 8.0), simulated=self.spent)
        one.found = {SMOOTHING: None}
        objective = self.left.pop(0)
        return [one], solution(objective, None, own)


@pytest.fixture(autouse=True)
def _usual(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quantity is an unknown wherever a log's record does not state its channel."""
    monkeypatch.setattr(
        Instance, "unknown",
        lambda one, record: None
        if one.quantity in getattr(record, "states", ())
        else Unknown(one.name, 0.0, prior_sd=1.0),
    )  # fmt: skip


def tried(search: Searches, channel: str, before: Any, least: float = 0.0) -> list[Any]:
    return list(log_one_filter._of(channel, before, search, NEAR, least))  # type: ignore[arg-type]


def late_current(samples: float, **facts: Any) -> Any:
    one, own = log((SMOOTHING, samples), (SPEED_SMOOTH, 0.0), (VOLTAGE_SMOOTH, 0.0), **facts)
    return [one], solution(100.0, None, own)


def test_a_late_channel_is_tried_behind_two_bends_and_then_other_shapes() -> None:
    search = Searches(50.0, 40.0, 60.0, 30.0, 35.0)
    fits = tried(search, CURRENT, late_current(4.0))
    assert [fit[1].objective for fit in fits] == [50.0, 40.0, 60.0, 30.0, 35.0]
    second = Instance(SECOND_ORDER[CURRENT_SMOOTHING])
    shapes = [shape for shape, *_ in search.asked]
    assert shapes == [JOINED, JOINED, "curved", "held", BROKEN]
    sizes = [found for _, (found,), _ in search.asked]
    assert sizes[0] == pytest.approx({SMOOTHING: 4.0, second: 2.0})
    assert sizes[1] == pytest.approx({SMOOTHING: 4.0, second: 2.8})
    # the others begin with what the likelier of both found, where it ended
    assert sizes[2:] == [pytest.approx({SMOOTHING: 9.0})] * 3
    ends = [start for *_, start in search.asked]
    assert ends == [NEAR, NEAR, *[{"R": 40.0, "L": 2.0, "K": 3.0}] * 3]


@pytest.mark.parametrize(("samples", "enough"), [(0.59, False), (0.61, True)])
def test_a_channel_must_be_late_by_more_than_half_a_sample(samples: float, enough: bool) -> None:
    search = Searches(*[50.0] * 5)
    assert bool(tried(search, CURRENT, late_current(samples))) is enough
    assert bool(search.asked) is enough


def test_where_a_fit_leaves_a_misfit_every_channel_is_tried_by_some_samples() -> None:
    search = Searches(*[50.0] * 4)
    tried(search, VOLTAGE, late_current(4.0), 2.0)
    first = Instance(VOLTAGE_SMOOTHING)
    assert [shape for shape, *_ in search.asked] == ["curved", "curved", JOINED]
    assert search.asked[0][1][0][first] == pytest.approx(2.0)
    more = Searches(*[50.0] * 5)
    tried(more, CURRENT, late_current(4.0), 2.0)
    assert more.asked[0][1][0][SMOOTHING] == pytest.approx(4.0)


def test_every_record_must_be_late_and_none_may_state_its_filter() -> None:
    both = [late_current(4.0), late_current(0.5)]
    before = (
        [r for records, _ in both for r in records],
        solution(100.0, None, *(own for _, found in both for own in found.own)),
    )
    assert tried(Searches(), CURRENT, before) == []
    stated = late_current(4.0, states=(CURRENT_SMOOTHING,))
    assert tried(Searches(), CURRENT, stated) == []
    alike = [late_current(4.0), late_current(3.0)]
    before = (
        [r for records, _ in alike for r in records],
        solution(100.0, None, *(own for _, found in alike for own in found.own)),
    )
    search = Searches(*[50.0] * 5)
    tried(search, CURRENT, before)
    assert [sizes[SMOOTHING] for sizes in search.asked[0][1]] == pytest.approx([4.0, 3.0])


@pytest.mark.parametrize(("spent", "fits"), [(0, 2), (1, 3)])
def test_no_more_shapes_where_responses_are_spent(spent: int, fits: int) -> None:
    """Of all fits so far: two are within the most that is tried, or just beyond it."""
    each = log_one_filter.MOST_TRIED // 2 + 1 - spent
    search = Searches(*[50.0] * 5, spent=each)
    assert len(tried(search, CURRENT, late_current(4.0))) == fits


def test_a_size_is_known_as_well_as_it_is_large() -> None:
    one, _ = log(states=(SPEED_SMOOTHING,))
    found = log_unknowns.of_sizes(one, {SMOOTHING: 3e-3, SPEED_SMOOTH: 1e-3})
    assert {i: (u.start, u.prior_sd) for i, u in found.items()} == {SMOOTHING: (3e-3, 3e-3)}


def taken(
    monkeypatch: pytest.MonkeyPatch, objectives: dict[str, float], **how: Any
) -> tuple[Any, Any, list[Any]]:
    """The fit that is taken, that before it, and what was asked, where fits are that likely."""
    asked: list[Any] = []

    def of(channel: str, *rest: Any) -> Any:
        asked.append((channel, *rest))
        if channel not in objectives:
            raise DataError("no motor")
        yield [record(channel)], solution(objectives[channel])

    monkeypatch.setattr(log_one_filter, "_of", of)
    before = [record("before", rivals=(Rival(np.zeros(3), 1.0),))], solution(100.0)
    captures: Any = ["run"]
    fixed = {"J": 7.0}
    return log_one_filter.taken(before, captures, NAMES, NEAR, fixed, **how), before, asked


def test_the_likeliest_channel_is_taken_with_the_rivals_of_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found, before, asked = taken(monkeypatch, {CURRENT: 90.0, VOLTAGE: 80.0})
    assert found[1].objective == 80.0
    assert [r.behind for r in found[0][0].rivals] == [1.0 + 20.0]
    assert [channel for channel, *_ in asked] == [CURRENT, SPEED, VOLTAGE]
    _, first, search, near, least = asked[0]
    assert first is before
    assert (search.as_read, search.free, search.fixed) == (["run"], NAMES, {"J": 7.0})
    assert (near, least) == ({"R": 100.0, "L": 2.0, "K": 3.0}, 0.0)
    found, before, _ = taken(monkeypatch, {CURRENT: 100.0, VOLTAGE: 101.0})
    assert found is before
    _, _, asked = taken(monkeypatch, {}, sought=True)
    assert asked[0][-1] == 2.0  # samples at least


def test_a_search_has_what_was_found_and_all_that_nobody_states(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}

    class Made:
        def __init__(self, *given: Any) -> None:
            self.given = given

        def estimate(self, *asked: Instance) -> None:
            self.asked = asked

        def find(self, found: Any) -> None:
            self.found = found

    def noted(name: str) -> Any:
        return lambda *asked: seen.update({name: asked}) or name

    monkeypatch.setattr(log_unknowns, "MotorRecord", Made)
    monkeypatch.setattr(log_one_filter, "settled", noted("settled"))
    monkeypatch.setattr(log_one_filter, "widened", noted("widened"))
    captures: Any = ["one", "two"]
    search: Any = log_one_filter._Search(captures, NAMES, {"J": 7.0}, 5.0)
    records, found = search("held", ["first", "second"], NEAR)
    assert [r.given for r in records] == [(c, NAMES, {"J": 7.0}, "held") for c in captures]
    assert [r.found for r in records] == ["first", "second"]
    assert [one.quantity for one in records[0].asked] == list(UNSTATED)
    assert found == "widened"
    assert seen["settled"] == (records, NAMES, NEAR, 5.0)
    assert seen["widened"] == (records, NAMES, NEAR, "settled", 5.0)
