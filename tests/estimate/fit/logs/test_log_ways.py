"""Means, instants and whole samples in the place of what a log's fit found: which is
taken, on fits of which the objective is given.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, Capture, Channel
from motorid.estimate.fit.logs import log_lags, log_means, log_readings
from motorid.estimate.signals.intersample_voltage import Rival
from motorid.estimate.solver.problem import Unknown
from tests.estimate.fit.made_fits import (
    LAG,
    NAMES,
    PERIOD_S,
    SMOOTHING,
    SPEED_SMOOTH,
    Found,
    fit,
    known,
    record,
    solution,
)

# means


def test_smoothing_of_the_current_counts_beside_that_of_the_others() -> None:
    assert log_means._smoothed(*known((SMOOTHING, 3.0, 1.0))) == 3.0
    assert log_means._smoothed(*known((SMOOTHING, 3.0, 1.0), (SPEED_SMOOTH, 2.0, 1.0))) == 3.0
    assert log_means._smoothed(*known((SMOOTHING, 3.0, 1.0), (SPEED_SMOOTH, -2.0, 1.0))) == 5.0
    assert log_means._smoothed(*known((SMOOTHING, -1.0, 1.0))) == 0.0
    assert log_means._smoothed(*known((SPEED_SMOOTH, -2.0, 1.0))) == 0.0


def means_tried(
    monkeypatch: pytest.MonkeyPatch, smoothed: float, best: int, least: float = 80.0,
    lost: bool = False,
) -> tuple[list[int], Any, Any]:  # fmt: skip
    """Numbers of samples that are tried where ``best`` is likeliest; the fit before, and taken."""
    tried: list[int] = []

    def over(_before: Any, width_s: float, *_: Any) -> Any:
        count = round(width_s / PERIOD_S)
        tried.append(count)
        return fit(least + (count - best) ** 2)

    monkeypatch.setattr(log_means, "_over", over)
    monkeypatch.setattr(log_means, "vanished", lambda *_: lost)
    one, own = known((SMOOTHING, smoothed * PERIOD_S, PERIOD_S))
    one.rivals = (Rival(np.zeros(3), 3.0),)
    before = [one], replace(solution(100.0), own=(own,))
    return tried, before, log_means.taken(before, NAMES, {}, {})


def test_means_are_tried_about_as_wide_as_the_low_pass_says(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried, _, taken = means_tried(monkeypatch, 1.5, 5)
    assert tried[0] == round(np.sqrt(12.0) * 1.5)
    assert sorted(tried) == [4, 5, 6]
    assert taken[1].objective == 80.0
    assert [r.behind for r in taken[0][0].rivals] == [3.0 + 20.0]
    walked, _, _ = means_tried(monkeypatch, 1.5, 1)
    assert walked == [5, 4, 3, 2]
    far, _, _ = means_tried(monkeypatch, 1.5, 40)
    assert len(far) == log_means.MOST


def test_a_mean_that_is_no_likelier_or_takes_the_inductance_is_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, before, taken = means_tried(monkeypatch, 1.5, 5, least=100.0)
    assert taken is before
    _, before, taken = means_tried(monkeypatch, 1.5, 5, lost=True)
    assert taken is before
    tried, before, taken = means_tried(monkeypatch, 0.55, 5)
    assert (tried, taken) == ([], before)


# instants or means


def log(kind: Any = "instant", aperture_s: float = 0.0, undeclared: Any = ("aperture",)) -> Any:
    channel = Channel(SPEED, "rad/s", np.zeros(20), kind=kind, aperture_s=aperture_s,
                      undeclared=undeclared)  # fmt: skip
    capture = Capture(np.arange(20) * 1000, 1e6, {SPEED: channel})
    measured = SimpleNamespace(channel=channel, values=np.zeros(1000))
    return record(capture=capture, block=lambda name: measured if name == SPEED else None,
                  measured=[measured])  # fmt: skip


def test_a_channel_may_be_of_instants_or_of_means() -> None:
    other = log_readings.otherwise(log(), SPEED)
    assert other is not None
    assert other.channels[SPEED].window_s == PERIOD_S
    back = log_readings.otherwise(log("mean", 2e-3), SPEED)
    assert back is not None
    assert back.channels[SPEED].kind == "instant"
    assert back.channels[SPEED].window_s == 0.0
    assert log_readings.otherwise(log(undeclared=()), SPEED) is None
    assert log_readings.otherwise(log(), CURRENT) is None


@pytest.mark.parametrize(
    ("name", "gain", "changed"),
    [(SPEED, 0.1, True), (SPEED, 0.0, False), (SPEED, -3.0, False),
     (CURRENT, 13.0, False), (CURRENT, 14.5, True)],
)  # fmt: skip
def test_the_likelier_of_both_is_taken_and_the_other_is_its_rival(
    name: str, gain: float, changed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A current of means costs twice ln 1000; a speed of means nothing."""
    monkeypatch.setattr(log_readings, "otherwise", lambda *_: "other capture")
    monkeypatch.setattr(log_readings, "vanished", lambda *_: False)
    before = [log()], solution(100.0)
    before[0][0].rivals = (Rival(np.array([7.0]), 4.0),)
    other = [log()], solution(100.0 - gain)
    found = log_readings._averaged(before, name, lambda *_: other)
    assert (found is other) is changed
    older, newer = found[0][0].rivals
    assert older.behind == pytest.approx(4.0 + (gain if changed else 0.0))
    assert newer.behind == pytest.approx(gain if changed else -gain)
    assert newer.values[0] == (100.0 if changed else 100.0 - gain)


def test_a_mean_that_takes_the_windings_time_constant_is_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(log_readings, "otherwise", lambda *_: "other capture")
    monkeypatch.setattr(log_readings, "vanished", lambda *_: True)
    before, other = ([log()], solution(100.0)), ([log()], solution(10.0))
    assert log_readings._averaged(before, CURRENT, lambda *_: other) is before
    assert log_readings._averaged(before, SPEED, lambda *_: other) is other
    monkeypatch.setattr(log_readings, "otherwise", lambda *_: None)
    assert log_readings._averaged(before, SPEED, lambda *_: other) is before


# a current that is late


def test_a_current_is_declared_later_and_that_is_kept() -> None:
    channel = Channel(CURRENT, "A", np.zeros(20), delay_s=2e-4)
    capture = Capture(
        np.arange(20) * 1000, 1e6, {CURRENT: channel}, provenance={log_lags.TAKEN: 1e-3}
    )
    found = log_lags._earlier(capture, 3e-3)
    assert found.channels[CURRENT].delay_s == pytest.approx(3.2e-3)
    assert found.provenance[log_lags.TAKEN] == pytest.approx(4e-3)
    assert capture.channels[CURRENT].delay_s == 2e-4


def lags_tried(
    monkeypatch: pytest.MonkeyPatch, lag: float, objectives: dict[int, float]
) -> tuple[list[int], Any, Any]:
    """Samples by which the current is taken earlier; the fit before, and that taken."""
    tried: list[int] = []

    def of_shapes(captures: Any, *_: Any) -> Any:
        tried.append(round(captures[0] / PERIOD_S))
        return [fit(objectives.get(tried[-1], 200.0)), fit(300.0)]

    heard = SimpleNamespace(shifts=("a", "b"), step="c")
    monkeypatch.setattr(log_lags, "_of_shapes", of_shapes)
    monkeypatch.setattr(log_lags, "_earlier", lambda _, late_s: late_s)
    monkeypatch.setattr(log_lags, "told", lambda *_: [heard])
    one, own = known((LAG, lag * PERIOD_S, PERIOD_S), found=[LAG])
    one.rivals = (Rival(np.zeros(3), 3.0),)
    before = [one], replace(solution(100.0), own=(own,))
    capture: Any = "as read"
    return tried, before, log_lags.taken(before, [capture], NAMES, {}, {})


def test_lags_of_whole_samples_about_the_one_that_was_found_are_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried, _, taken = lags_tried(monkeypatch, 3.3, {4: 90.0, 3: 95.0})
    assert tried == [3, 2, 4]
    assert taken[1].objective == 90.0
    assert [r.behind for r in taken[0][0].rivals] == [3.0 + 10.0]
    assert taken[0][0].left_open == ("a", "b", "c")


def test_an_early_current_is_not_taken_later(monkeypatch: pytest.MonkeyPatch) -> None:
    assert lags_tried(monkeypatch, 1.2, {})[0] == [1, 2]
    assert lags_tried(monkeypatch, 0.2, {})[0] == [1]
    assert lags_tried(monkeypatch, -3.0, {})[0] == []
    _, before, taken = lags_tried(monkeypatch, 3.0, {3: 100.0})
    assert taken is before


# readings of a log: in which order ways are asked for


def test_ways_are_asked_for_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    best, loose = fit(10.0), fit(9.0, "loose")

    def averaged(before: object, name: str, _: object) -> object:
        asked.append(f"{name} of {before[1].objective:g}")  # type: ignore[index]
        return {100.0: best, 9.0: loose, 10.0: best}[before[1].objective]  # type: ignore[index]

    monkeypatch.setattr(log_readings, "_averaged", averaged)
    monkeypatch.setattr(log_readings, "_loosened", lambda before, _: loose)
    monkeypatch.setattr(log_readings, "motion", lambda _: "a motion")
    records = [record(capture="run")]
    found: object = log_readings.taken(records, solution(100.0), ("K", "R"), {}, {})
    assert asked == ["speed of 100", "speed of 9", "current of 9"]
    assert found is loose
    asked.clear()
    monkeypatch.setattr(log_readings, "_loosened", lambda before, _: before)
    log_readings.taken(records, solution(100.0), ("K", "R"), {}, {})
    assert asked == ["speed of 100", "current of 10"]


def test_without_a_motion_no_means_are_asked_but_the_moments_of_jumps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(log_readings, "_averaged", lambda *_: "asked")
    monkeypatch.setattr(log_readings, "_loosened", lambda fit, _: fit)
    monkeypatch.setattr(log_readings, "motion", lambda _: None)
    records = [record(capture="run")]
    before = solution(100.0)
    assert log_readings.taken(records, before, ("K",), {}, {}) == (records, before)
    monkeypatch.setattr(log_readings, "motion", lambda _: "a motion")
    assert log_readings.taken(records, before, ("R", "L"), {}, {}) == (records, before)


def test_a_mean_is_as_late_as_the_low_pass_was(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mean over T is late by T/2, a low-pass by its time constant: the lag has the rest."""
    monkeypatch.setattr(log_means, "MotorRecord", Found)
    monkeypatch.setattr(log_means, "settled", lambda *_: solution(5.0))
    monkeypatch.setattr(log_means, "widened", lambda _r, _f, _s, found, _w: found)
    monkeypatch.setattr(type(LAG), "unknown", lambda one, _: Unknown(one.name, 0.0, prior_sd=1e-4))
    current = Channel(CURRENT, "A", np.zeros(4))
    capture = Capture(np.arange(4), 1e3, {CURRENT: current})
    last, own = known((LAG, 0.5e-3, 1e-3), (SMOOTHING, 2e-3, 1e-3), found=[SMOOTHING])
    last.capture = capture
    still, none = known((LAG, 0.2e-3, 1e-3), (SMOOTHING, -1e-3, 1e-3))
    still.capture = capture
    before = [last, still], replace(solution(9.0), own=(own, none))
    records, found = log_means._over(before, 7e-3, NAMES, {}, {})
    one, other = records
    assert found.objective == 5.0
    assert one.capture.channels[CURRENT].window_s == 7e-3
    assert other.capture is capture
    lag = one.sizes[LAG]
    late_s = 0.5e-3 + 2e-3 - 7e-3 / 2
    assert (lag.start, lag.prior_sd) == pytest.approx((late_s, abs(late_s)))
    assert SMOOTHING not in one.sizes
    assert other.sizes == {}


def test_every_shape_begins_at_the_start_values_and_then_where_the_first_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    started: list[tuple[str, dict[str, float]]] = []

    def settled(records: Any, _free: Any, near: Any) -> Any:
        started.append((records[0].shape, dict(near)))
        return f"solution of {records[0].shape}"

    def made(capture: Any, free: Any, fixed: Any, shape: str) -> Any:
        assert (capture, free, fixed) == ("run", NAMES, {"J": 7.0})
        return SimpleNamespace(shape=shape)

    monkeypatch.setattr(log_lags, "MotorRecord", made)
    monkeypatch.setattr(log_lags, "start_values", lambda runs, _: {"R": 2.0 * bool(runs[0].shape)})
    monkeypatch.setattr(log_lags, "settled", settled)
    monkeypatch.setattr(log_lags, "merged", lambda near, solution: {**near, "from": solution})
    fits = list(log_lags._of_shapes(["run"], NAMES, {"R": 1.0, "K": 5.0}, {"J": 7.0}))  # type: ignore[list-item]
    first, *others = log_lags.SHAPES
    assert started[0] == (first, {"R": 2.0, "K": 5.0})
    ended = {"R": 2.0, "K": 5.0, "from": f"solution of {first}"}
    assert started[1:] == [(shape, ended) for shape in others]
    assert [solution for _, solution in fits] == [f"solution of {s}" for s in log_lags.SHAPES]
