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
from motorid.estimate.signals.intersample_voltage import LOOSE, LOOSE_SOURCE, MEANS, Rival
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


def jumped(near: float, shape: str = "held", window_s: float = 0.0) -> Any:
    """Residuals of the current that are ``near`` within three samples of a jump, 1 elsewhere."""
    left = np.ones(200)
    jumps = np.array([50, 120])
    for at in jumps:
        left[at : at + 3] = near
    waveform = SimpleNamespace(
        shape=shape, steps_off=jumps, time_s=PERIOD_S * (np.arange(200.0) - 0.3),
        period_s=PERIOD_S, window_s=window_s,
    )  # fmt: skip
    current = SimpleNamespace(keep=np.arange(200))
    return record(
        sensed=SimpleNamespace(waveform=waveform), block=lambda _: current, measured=[current],
        departures=lambda *_: [left], timeline=SimpleNamespace(period_s=PERIOD_S),
    )  # fmt: skip


@pytest.mark.parametrize(("near", "asks"), [(1.2, False), (1.25, True), (-1.25, True)])
def test_larger_residuals_after_jumps_ask_for_their_moments(near: float, asks: bool) -> None:
    assert log_readings._asks(jumped(near), np.zeros(6), np.zeros(0)) is asks


def test_shapes_without_jumps_of_their_own_ask_for_none() -> None:
    assert not log_readings._asks(jumped(9.0, LOOSE), np.zeros(6), np.zeros(0))
    assert not log_readings._asks(jumped(9.0, MEANS), np.zeros(6), np.zeros(0))
    assert log_readings._asks(jumped(9.0), np.zeros(6), np.zeros(0))
    assert not log_readings._asks(jumped(9.0, window_s=1e-4), np.zeros(6), np.zeros(0))
    calm = jumped(9.0)
    calm.sensed.waveform.steps_off = np.zeros(0, dtype=int)
    assert not log_readings._asks(calm, np.zeros(6), np.zeros(0))


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


def test_without_a_motion_nothing_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_readings, "_averaged", lambda *_: "asked")
    monkeypatch.setattr(log_readings, "motion", lambda _: None)
    records = [record(capture="run")]
    before = solution(100.0)
    assert log_readings.taken(records, before, ("K",), {}, {}) == (records, before)
    monkeypatch.setattr(log_readings, "motion", lambda _: "a motion")
    assert log_readings.taken(records, before, ("R", "L"), {}, {}) == (records, before)


def loosened(
    monkeypatch: pytest.MonkeyPatch, gain: float, asks: bool = False,
    colours: tuple[float, float] = (1.0, 1.0), shape: str = "held", jumps: int = 3,
    window_s: float = 0.0, sourced: float | None = None, jump: int = 3,
) -> tuple[Any, Any, Any, list[Any]]:  # fmt: skip
    """The fit before, the one with three moments more, the one that is taken, and what was asked;
    ``colours``: what either leaves; ``sourced``: by how much more one of a source gains, which
    has ``jump`` moments.
    """
    measured = [SimpleNamespace(values=np.zeros(1000))]
    waveform = SimpleNamespace(shape=shape, steps_off=np.arange(jumps), window_s=window_s)
    one = record(measured=measured, capture="run", unknowns=("offset",),
                 sensed=SimpleNamespace(waveform=waveform))  # fmt: skip
    before = [one], replace(solution(100.0), own=(np.zeros(1),))
    loose = [record(measured=measured, unknowns=("offset", 1, 2, 3))], solution(100.0 - gain)
    asked: list[Any] = []

    def again(captures: object, shape: str, near: object) -> Any:
        asked.append((captures, shape, near))
        if shape == LOOSE_SOURCE and sourced is not None:
            moments = ("offset", *range(1, jump + 1))
            one = record(measured=measured, unknowns=moments)
            return [one], solution(100.0 - gain - sourced)
        return loose

    ohms = 0.0 if sourced is None else 0.2
    monkeypatch.setattr(log_readings, "source_ohms_of", lambda _: ohms)
    monkeypatch.setattr(log_readings, "_asks", lambda *_: asks)
    monkeypatch.setattr(log_readings, "inflation", lambda of: colours[of is loose[1]])
    found = log_readings._loosened(before, again)
    return before, loose, found, asked


@pytest.mark.parametrize("more", [-1.0, 1.0])
def test_a_source_that_the_log_shows_is_tried_with_the_moments(
    more: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The likelier of both is taken."""
    before, loose, found, asked = loosened(monkeypatch, 50.0, asks=True, sourced=more)
    assert asked == [(["run"], LOOSE, before), (["run"], LOOSE_SOURCE, before)]
    assert found[1].objective == pytest.approx(100.0 - 50.0 - max(more, 0.0))
    assert (found is loose) is (more < 0.0)
    assert loosened(monkeypatch, 50.0, True, shape=LOOSE_SOURCE)[3] == []


@pytest.mark.parametrize(("more", "taken"), [(6.9, False), (6.92, True)])
def test_a_source_with_a_jump_more_must_pay_for_it(
    more: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, loose, found, _ = loosened(monkeypatch, 50.0, asks=True, sourced=more, jump=4)
    assert (found is not loose) is taken


@pytest.mark.parametrize(("gain", "taken"), [(3 * 6.9, False), (3 * 6.92, True)])
def test_moments_of_jumps_must_pay_for_each_of_them(
    gain: float, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three unknowns more, at ln 1000 = 6.908 each."""
    before, loose, found, asked = loosened(monkeypatch, gain, asks=True)
    assert asked == [(["run"], LOOSE, before)]
    assert found is (loose if taken else before)
    before, _, found, asked = loosened(monkeypatch, gain, asks=False)
    assert asked == []
    assert found is before


@pytest.mark.parametrize(
    ("colour", "left", "gain", "tried", "taken"),
    [
        (4.0, 3.9, 50.0, True, True),
        (4.0, 4.0, 50.0, True, False),  # they are not what the residuals lack
        (3.9, 1.0, 50.0, False, False),
        (4.0, 1.0, 3 * 6.9, True, False),  # and they must pay as well
    ],
)
def test_moments_of_jumps_are_tried_of_coloured_residuals_and_must_leave_none(
    colour: float, left: float, gain: float, tried: bool, taken: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    before, loose, found, asked = loosened(monkeypatch, gain, colours=(colour, left))
    assert bool(asked) is tried
    assert found is (loose if taken else before)


@pytest.mark.parametrize(("asks", "taken"), [(True, True), (False, False)])
def test_residuals_that_ask_for_moments_may_stay_coloured(
    asks: bool, taken: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, loose, found, asked = loosened(monkeypatch, 50.0, asks, (9.0, 8.0))
    assert len(asked) == 1
    assert (found is loose) is taken


def test_moments_are_tried_of_every_shape_that_jumps_but_where_they_are_unknowns_already(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for shape in ("joined", "held", MEANS):
        assert len(loosened(monkeypatch, 50.0, colours=(9.0, 1.0), shape=shape)[3]) == 1
    assert loosened(monkeypatch, 50.0, colours=(9.0, 1.0), shape=LOOSE)[3] == []
    assert loosened(monkeypatch, 50.0, True, (9.0, 1.0), jumps=0)[3] == []


@pytest.mark.parametrize("asks", [True, False])
def test_stated_means_have_no_moments(asks: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    before, _, found, asked = loosened(monkeypatch, 50.0, asks, (9.0, 1.0), MEANS, window_s=1e-4)
    assert asked == []
    assert found is before


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
