"""Means, second orders, finer grids and low-passes of a log: what each search is handed, record by
record.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture, Channel
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import SECOND_ORDER, UNSTATED
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.fit.logs import (
    log_grid,
    log_means,
    log_second_order,
    log_unknowns,
    smoothed_voltage,
)
from motorid.estimate.signals.intersample_voltage import Rival
from motorid.estimate.solver.problem import Unknown
from tests.estimate.fit.made_fits import (
    LAG,
    NAMES,
    SMOOTHING,
    SPEED_SMOOTH,
    known,
    record,
    solution,
)

START, FIXED = {"R": 2.0, "L": 3.0, "K": 4.0, "J": 7.0}, {"J": 7.0}


class Made:
    """A record that notes of what it was made, and what it is asked to estimate and to find."""

    def __init__(self, capture: Any, free: Any, fixed: Any, shape: str) -> None:
        self.capture, self.how, self.shape = capture, (free, fixed), shape
        self.found, self.instances, self.asked = dict[Instance, Unknown](), (), ()
        self.unknowns, self.rivals = (), ()
        self.measured = [SimpleNamespace(values=np.zeros(1000))]
        self.timeline = SimpleNamespace(period_s=1.0)

    def estimate(self, *instances: Instance) -> None:
        self.asked = instances

    def find(self, sizes: dict[Instance, Unknown]) -> None:
        self.found |= sizes

    def go_on(self, last: Any, own: Any) -> None:
        self.from_ = last, own.tolist()


def noted(seen: dict[str, Any], name: str, answer: Any) -> Callable[..., Any]:
    return lambda *asked: seen.setdefault(name, []).append(asked) or answer


def searches(
    monkeypatch: pytest.MonkeyPatch, module: Any, answer: Any, last: str = "widened"
) -> dict[str, Any]:
    """What the module's two searches are handed; the second one has the answer."""
    seen: dict[str, Any] = {}
    monkeypatch.setattr(module, "MotorRecord", Made)
    monkeypatch.setattr(module, "settled", noted(seen, "settled", "settled"))
    monkeypatch.setattr(module, last, noted(seen, last, answer))
    return seen


# means


def of_current(name: str) -> Capture:
    current = Channel(CURRENT, "A", np.zeros(4))
    other = Channel("speed", "rad/s", np.zeros(4))
    return Capture(np.arange(4), 1e3, {CURRENT: current, "speed": other}, path=name)


def test_means_take_the_place_of_the_low_pass_in_a_search_from_where_it_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen = searches(monkeypatch, log_means, solution(5.0))
    one, own = known((SMOOTHING, 2e-3, 1e-3), (SPEED_SMOOTH, 1e-3, 1e-3), found=[SMOOTHING])
    one.capture = of_current("one")
    before = [one], solution(9.0, None, own)
    records, found = log_means._over(before, 5e-3, NAMES, START, FIXED)
    (made,) = records
    assert found.objective == 5.0
    assert (made.how, made.shape) == ((NAMES, FIXED), one.shape)
    current = made.capture.channels[CURRENT]
    assert (current.kind, current.aperture_s) == ("mean", 5e-3)
    assert made.capture.channels["speed"] is one.capture.channels["speed"]
    assert [i.quantity for i in made.asked] == list(UNSTATED)
    # what another channel's low-pass had goes on; of the current's nothing is left
    assert {i: u.start for i, u in made.found.items()} == {SPEED_SMOOTH: 1e-3}
    near = {"R": 9.0, "L": 2.0, "K": 3.0, "J": 7.0}
    assert seen["settled"] == [(records, NAMES, near, 9.0)]  # held against F of the one before
    assert seen["widened"] == [(records, NAMES, near, "settled", 9.0)]


@pytest.mark.parametrize(("late", "sd"), [(2.0, 1.0), (0.1, 0.7)])
def test_a_lag_beside_means_is_as_unsure_as_usual_or_as_it_is_large(
    late: float, sd: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mean of 4 ms in the place of a low-pass of 2 ms leaves the lag what it was."""
    searches(monkeypatch, log_means, solution(5.0))
    monkeypatch.setattr(
        type(LAG), "unknown", lambda one, _: Unknown(one.name, 0.0, prior_sd=sd * 1e-3)
    )
    one, own = known((LAG, late * 1e-3, 1e-3), (SMOOTHING, 2e-3, 1e-3), found=[SMOOTHING])
    one.capture = of_current("one")
    before = [one], solution(9.0, None, own)
    (made,), _ = log_means._over(before, 4e-3, NAMES, START, FIXED)
    assert made.found[LAG].start == pytest.approx(late * 1e-3)
    assert made.found[LAG].prior_sd == pytest.approx(max(late, sd) * 1e-3)


def test_the_smoothest_record_says_how_wide_means_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """In samples of the slowest log; √12 times the time constant, and two samples at least."""
    widths: list[float] = []

    def over(_before: Any, width_s: float, *how: Any) -> Any:
        widths.append(width_s)
        assert how == (NAMES, START, FIXED)
        return [record()], solution(200.0)

    monkeypatch.setattr(log_means, "_over", over)
    one, own = known((SMOOTHING, 3e-3, 1e-3))
    other, more = known((SMOOTHING, 0.4e-3, 1e-3))
    other.sensed.waveform.period_s = 2e-3
    before = [one, other], solution(100.0, None, own, more)
    assert log_means.taken(before, NAMES, START, FIXED) is before
    assert widths[0] == pytest.approx(round(math.sqrt(12.0) * 1.5) * 2e-3)
    widths.clear()
    slight, own = known((SMOOTHING, 0.61e-3, 1e-3))
    log_means.taken(([slight], solution(100.0, None, own)), NAMES, START, FIXED)
    assert widths[0] == pytest.approx(2e-3)


@pytest.mark.parametrize(("objective", "taken"), [(99.9, True), (100.0, False)])
def test_means_must_be_likelier(
    objective: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_means, "_over", lambda *_: ([record()], solution(objective)))
    monkeypatch.setattr(log_means, "vanished", lambda *_: False)
    one, own = known((SMOOTHING, 3e-3, 1e-3))
    before = [one], solution(100.0, None, own)
    found = log_means.taken(before, NAMES, START, FIXED)
    assert (found is not before) is taken


# second order


def test_each_low_pass_that_was_found_is_bent_beside_what_was_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Records without it keep their first order; what pays is where the next search begins."""
    seen = searches(monkeypatch, log_second_order, solution(10.0, None, (), ()))
    likes: list[Any] = []
    monkeypatch.setattr(
        log_second_order, "like", lambda before, records: likes.append(before) or records
    )
    monkeypatch.setattr(type(LAG), "unknown", lambda one, _: Unknown(one.name, 0.0))
    one, own = known((SMOOTHING, 2e-3, 1e-3), found=[SMOOTHING])
    other, more = known((SMOOTHING, 3e-3, 1e-3))
    for k, run in enumerate((one, other)):
        run.capture, run.measured = f"run {k}", [SimpleNamespace(values=np.zeros(500))]
    one.rivals = (Rival(np.zeros(3), 4.0),)
    before = [one, other], solution(100.0, None, own, more)
    monkeypatch.setattr(
        log_second_order, "_size",
        lambda run, _, first: 2e-3 if run is one and first is CURRENT_SMOOTHING else 0.0,
    )  # fmt: skip
    records, found = log_second_order.taken(before, NAMES, START, FIXED)
    assert found.objective == 10.0
    assert [(r.capture, r.how, r.shape) for r in records] == [
        (f"run {k}", (NAMES, FIXED), "joined") for k in (0, 1)
    ]
    second = Instance(SECOND_ORDER[CURRENT_SMOOTHING])
    first, last = (asked[0] for asked in seen["settled"])
    assert first[0].found[second].start == pytest.approx(0.3 * 2e-3)
    assert last[0].found[second].start == pytest.approx(0.7 * 2e-3)
    assert first[1].found == {}
    assert likes[0] is before
    assert likes[1] == (first, found)
    assert seen["settled"][0][1:] == (NAMES, {"R": 100.0, "L": 2.0, "K": 3.0, "J": 7.0})
    assert seen["settled"][1][1:] == (NAMES, {"R": 10.0, "L": 1.0, "K": 3.0, "J": 7.0})
    assert [asked[1:] for asked in seen["widened"]] == [
        (*asked[1:], "settled") for asked in seen["settled"]
    ]
    # 90 likelier once; the second bend is no better
    assert [r.rivals and r.rivals[0].behind for r in records] == [94.0, ()]


# finer grids


def test_a_finer_grid_goes_on_from_each_record(monkeypatch: pytest.MonkeyPatch) -> None:
    ended = solution(20.0)
    seen = searches(monkeypatch, log_grid, ended, "with_sources")
    judged = replace(ended, noise=3.0)
    monkeypatch.setattr(log_grid.added_noise, "judged", noted(seen, "judged", judged))
    captures = [Capture(np.arange(9), 1e3, {}, provenance={"n": k}) for k in (1, 2)]
    last = [
        record(shape, capture=c, timeline=SimpleNamespace(period_s=9.0))
        for shape, c in zip(("held", "curved"), captures, strict=True)
    ]
    before = last, solution(50.0, None, (1.5,), (2.5,))
    monkeypatch.setattr(log_grid, "readings", lambda records: 9 * len(records))
    found = log_grid._gone_on(before, NAMES, START, FIXED)
    assert found is not None
    records, answer = found
    assert answer.objective == 20.0
    assert answer.fair == 17.0
    assert [r.shape for r in records] == ["held", "curved"]
    assert [r.capture.provenance["n"] for r in records] == [1, 2]
    assert [r.how for r in records] == [(NAMES, FIXED)] * 2
    assert [r.from_ for r in records] == [(last[0], [1.5]), (last[1], [2.5])]
    assert seen["with_sources"] == [(records, NAMES, START)]
    assert seen["judged"] == [(records, ended)]


def test_a_grid_is_settled_from_the_values_of_the_fit_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: dict[str, Any] = {}
    before = [record("first")], solution(50.0)
    monkeypatch.setattr(log_grid, "_coarse", noted(seen, "coarse", True))
    monkeypatch.setattr(log_grid, "_gone_on", noted(seen, "gone_on", None))
    assert log_grid.settled(before, NAMES, START, FIXED) is before
    near = {"R": 50.0, "L": 2.0, "K": 3.0, "J": 7.0}
    assert seen["coarse"] == [(before[0][0], before[1].own[0], near)]
    assert seen["gone_on"] == [(before, NAMES, near, FIXED)]


def test_one_coarse_record_is_enough_and_one_that_gets_finer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of several; inductances to begin with are in samples of the slowest log."""
    monkeypatch.setattr(log_grid, "readings", lambda _: 100)
    began: list[Any] = []

    def search(_records: Any, _free: Any, start: Any) -> Any:
        began.append(start["L"])
        return solution(90.0)

    finer = [Made("a", (), {}, "held"), Made("b", (), {}, "held")]
    left = list(finer) * 3
    monkeypatch.setattr(log_grid, "_finer", lambda *_: left.pop(0))
    monkeypatch.setattr(log_grid, "_as_fine", lambda one, _: one is finer[0])
    monkeypatch.setattr(log_grid, "with_sources", search)
    periods = {"a": 1e-3, "b": 4e-3}
    monkeypatch.setattr(log_grid.default, "period_s", lambda one: periods[one.shape])
    before = [record("a"), record("b")], solution(50.0, None, (), ())
    assert log_grid._gone_on(before, NAMES, START, FIXED) is None
    assert began == pytest.approx([3.0, 0.1 * 4e-3 * 2.0, 0.3 * 4e-3 * 2.0])


# a voltage behind a low-pass


def test_records_of_several_logs_begin_by_the_longest_delay(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each with the low-pass that leaves its own delay; the smoothest says how long it is."""
    seen = searches(monkeypatch, smoothed_voltage, solution(7.0))
    sizes: list[tuple[Any, float, int]] = []
    late, share = {"a": 0.2e-3, "b": 0.9e-3}, {"a": math.exp(-1.0 / 2.0), "b": math.exp(-1.0)}
    monkeypatch.setattr(smoothed_voltage, "_goes_on", lambda one: share[one.capture])
    monkeypatch.setattr(smoothed_voltage, "_delay_s", lambda one, *_: late[one.capture])
    monkeypatch.setattr(
        smoothed_voltage, "_smooth", lambda one, size, order: sizes.append((one, size, order))
    )
    monkeypatch.setattr(smoothed_voltage, "LOW_PASS", SimpleNamespace(unknown=lambda _: 1))
    steady = SimpleNamespace(jitter=0.0)
    first = [record(capture=name, timeline=steady) for name in "ab"]
    fits = smoothed_voltage.begun(first, solution(9.0, None, (), ()), NAMES, START, FIXED)
    # 2 ms that are seen, and .9; then 3 samples: of 1, .1 would be left
    rises = [asked[2]["L"] / 2.0 for asked in seen["settled"]]
    assert rises[:2] == pytest.approx([2.9e-3, 3e-3])
    assert [size for _, size, _ in sizes[:2]] == pytest.approx([2.7e-3, 2.0e-3])
    records, _ = fits[0]
    assert [(r.capture, r.how, r.shape) for r in records] == [
        (name, (NAMES, FIXED), "curved") for name in "ab"
    ]
    start = {**START, "L": seen["settled"][0][2]["L"]}
    assert seen["settled"][0] == (records, NAMES, start)
    assert seen["widened"][0] == (records, NAMES, start, "settled")
    assert len(fits) == 2 + 5
    orders = [order for one, _, order in sizes if one.capture == "a"]
    assert orders == [1, 1, 2, 1, 2, 1, 2]


@pytest.mark.parametrize("slow", [0, 1])
def test_low_passes_are_begun_in_samples_of_the_slowest_log(
    slow: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 4 ms here: one that is seen over two samples, and the winding's of 1 and 3 of them."""
    seen = searches(monkeypatch, smoothed_voltage, solution(7.0))
    monkeypatch.setattr(smoothed_voltage, "_goes_on", lambda _: math.exp(-1.0 / 2.0))
    monkeypatch.setattr(smoothed_voltage, "_delay_s", lambda *_: 0.0)
    monkeypatch.setattr(smoothed_voltage, "_smooth", lambda *_: None)
    monkeypatch.setattr(smoothed_voltage, "LOW_PASS", SimpleNamespace(unknown=lambda _: 1))
    first = [record(capture="run", timeline=SimpleNamespace(jitter=0.0)) for _ in range(2)]
    first[slow].sensed.waveform.period_s = 4e-3
    smoothed_voltage.begun(first, solution(9.0, None, (), ()), NAMES, START, FIXED)
    rises = [asked[2]["L"] / 2.0 for asked in seen["settled"][:3]]
    assert rises == pytest.approx([8e-3, 4e-3, 12e-3])  # of .3 samples less than .4 would be left


@pytest.mark.parametrize("irregular", [0, 1])
def test_one_log_of_irregular_stamps_is_enough_to_try_nothing(
    irregular: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(smoothed_voltage, "LOW_PASS", SimpleNamespace(unknown=lambda _: 1))
    monkeypatch.setattr(smoothed_voltage, "_goes_on", lambda _: pytest.fail("looked at"))
    lines = [SimpleNamespace(jitter=9.0 * (k == irregular)) for k in (0, 1)]
    first = [record(timeline=line) for line in lines]
    assert smoothed_voltage.begun(first, solution(9.0), NAMES, START, FIXED) == []


# unknowns of a fit in the next


def test_records_begin_with_what_those_before_found(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def found_sizes(other: Any, own: Any, one: Any, whole: bool) -> dict[Any, Any]:
        asked.append((other, own.tolist(), one, whole))
        return {other: own}

    monkeypatch.setattr(log_unknowns, "found_sizes", found_sizes)
    before = ["one", "two"], solution(1.0, None, (1.0,), (2.0,))
    records: Any = [Made("a", (), {}, "held"), Made("b", (), {}, "held")]
    assert log_unknowns.like(before, records) is records  # type: ignore[arg-type]
    assert asked == [("one", [1.0], records[0], False), ("two", [2.0], records[1], False)]
    assert [list(r.found) for r in records] == [["one"], ["two"]]
    assert [i.quantity for i in records[1].asked] == list(UNSTATED)
    log_unknowns.like(before, records, True)  # type: ignore[arg-type]
    assert asked[2][3] is True


def test_one_record_in_which_more_is_found_is_enough() -> None:
    calm, own = known((LAG, 0.5, 1.0))
    far, more = known((LAG, -2.5, 1.0), (SMOOTHING, 2.0, 1.0))
    assert log_unknowns._find([calm, far], solution(0.0, None, own, more))
    assert log_unknowns._find([far, calm], solution(0.0, None, more, own))
    assert (list(calm.found), list(far.found)) == ([], [LAG])
