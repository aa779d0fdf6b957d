"""What a rise under one level says of the motor, by formula; which captures are single steps."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import POSITION, SPEED, VOLTAGE, Capture, Channel, Wiring
from motorid.estimate.partial import step_response as room
from motorid.estimate.partial.exponential_fit import Record, Rise
from motorid.estimate.partial.levels import single_level
from motorid.estimate.partial.mechanical_results import Judge
from motorid.estimate.partial.step_response import Step

TAU, WHOLE = "JR/(K²+RB)", "(K−T0·R/V)/(K²+RB)"
TIME = 0.01 * np.arange(100)
JUDGE = Judge(1000)


def capture(speed: Any = None, drive: Any = None, name: str = VOLTAGE, **facts: Any) -> Capture:
    values = 100.0 * (1.0 - np.exp(-TIME / 0.1)) if speed is None else speed
    channels = {SPEED: Channel(SPEED, "rad/s", values, **facts)}
    if drive is not None:
        channels[name] = Channel(name, "V", np.asarray(drive, float), gain_uncertainty=0.03)
    return Capture(np.rint(TIME * 1e6).astype(np.int64), 1e6, channels, clock_uncertainty=0.001)


def rise(lags: list[float], after: list[float], onsets: tuple[float | None, ...] = (None,),
         variances: dict[int, float] | None = None) -> Rise:  # fmt: skip
    n, runs = len(lags), len(after)
    shown = sum(onset is not None for onset in onsets)
    covariance = np.zeros((n + shown + 2 * runs,) * 2)
    for k in range(len(covariance)):
        covariance[k, k] = (variances or {}).get(k, 1e-6)
    return Rise(np.array(lags), onsets, np.zeros(runs), np.array(after), covariance, 1000,
                np.ones(runs), 1.0, tuple(np.zeros(100) for _ in after), 7)  # fmt: skip


def step(
    level: float | None = 12.0, onset: tuple[float, float] | None = None, **facts: Any
) -> Step:
    one = capture(drive=None if level is None else np.full(100, level), **facts)
    return Step(one, level, onset, Record(TIME, one.channels[SPEED].values))


def told(steps: list[Step], found: Rise, without: bool = False) -> dict[str, Any]:
    return room._combinations(JUDGE, steps, found, False, without)


def test_the_time_constant_has_the_clocks_doubt() -> None:
    out = told([step(None)], rise([0.1], [100.0], variances={0: 4e-6}))
    one = out[TAU]
    assert (one.value, one.unit) == (0.1, "s")
    assert one.statistical == pytest.approx(2e-3)
    assert one.instrument == pytest.approx(0.1 * 0.001)
    assert one.note == "mechanical time constant"
    assert set(out) == {TAU, "steady speed"}


def test_a_second_lag_may_be_the_windings_or_a_filters() -> None:
    """It counts in the constant or not, evenly: half of it, ± its length over √12."""
    out = told([step(None)], rise([0.1, 0.02], [100.0]))
    assert out[TAU].value == pytest.approx(0.12 - 0.01)
    assert out[TAU].instrument == pytest.approx(np.hypot(0.12 * 0.001, 0.02 / np.sqrt(12.0)))
    assert out["second lag"].value == 0.02
    assert "if it is the winding's, not if it is a filter's" in out[TAU].note


def test_each_runs_steady_speed_has_its_own_doubt_and_the_channels_gain() -> None:
    steps = [step(None, gain_uncertainty=0.02)] * 2
    out = told(steps, rise([0.1], [100.0, -50.0], (None, None), {3: 9.0, 4: 4.0}))
    first, second = out["steady speed of run 1"], out["steady speed of run 2"]
    assert (first.value, first.unit, second.value) == (100.0, "rad/s", 50.0)
    assert (first.statistical, second.statistical) == pytest.approx((3.0, 2.0))
    assert first.instrument == pytest.approx(2.0)


def test_speed_for_the_drive_is_the_mean_by_variances() -> None:
    steps = [step(10.0), step(-10.2)]
    out = told(steps, rise([0.1], [100.0, -104.0], (None, None), {3: 9.0, 4: 4.0}))
    each = np.array([10.0, 104.0 / 10.2])
    variances = np.array([9.0 / 100.0, 4.0 / 10.2**2])
    weights = 1 / variances / (1 / variances).sum()
    one = out[WHOLE]
    assert one.value == pytest.approx(float(weights @ each))
    scatter = (each[1] - each[0]) / 2
    assert one.statistical == pytest.approx(np.sqrt(1 / (1 / variances).sum() + scatter**2))
    assert one.instrument == pytest.approx(one.value * 0.03)
    assert one.unit == "rad/s/V"
    for name in ("K/(K²+RB)", "T0·R/K"):
        assert out[name].value is None
        assert out[name].note == room.SEPARATE
    gain = told(steps, rise([0.1], [100.0, -104.0], (None, None)), without=True)
    assert gain["K/(K²+RB)"].value == pytest.approx(10.1, rel=0.01)
    assert WHOLE not in gain


def test_a_dead_time_is_from_the_command_to_the_rise() -> None:
    one = step(12.0, (0.2, 0.005), delay_uncertainty_s=0.002)
    found = room._dead_times(JUDGE, [one], rise([0.1], [100.0], (0.23,), {1: 1e-4}))
    late = found["dead time"]
    assert late.value == pytest.approx(0.03)
    assert late.statistical == pytest.approx(0.01)
    assert late.instrument == pytest.approx(np.hypot(0.005 / np.sqrt(3.0), 0.002))
    early = room._dead_times(JUDGE, [one], rise([0.1], [100.0], (0.17,), {1: 1e-4}))
    assert early["dead time"].value == pytest.approx(-0.03)
    assert room._dead_times(JUDGE, [step(12.0)], rise([0.1], [100.0], (0.23,))) == {}
    assert room._dead_times(JUDGE, [one], rise([0.1], [100.0])) == {}
    two = room._dead_times(JUDGE, [step(12.0), one], rise([0.1], [1.0, 1.0], (None, 0.23)))
    assert list(two) == ["dead time of run 2"]


def said(one: Step, found: Rise, left: np.ndarray | None = None) -> dict[str, str]:
    none = np.zeros(100) if left is None else left
    return {d.code: d.message for d in room._findings([one], found, [none])}


@pytest.mark.parametrize(("constant", "few", "settled"), [(0.028, False, True), (0.025, True, True),
                                                          (0.34, False, False)])  # fmt: skip
def test_few_readings_and_an_end_that_is_not_reached_are_said(
    constant: float, few: bool, settled: bool
) -> None:
    out = said(step(), rise([constant], [100.0]))
    assert ("few_samples" in out) is few
    assert ("not_settled" in out) is not settled
    if few:
        assert "only 7 readings were taken while the speed rose, so" in out["few_samples"]
        assert f"sample every {constant / 8:.2g} s" in out["few_samples"]
    if not settled:
        assert "ends 2.9 time constants after" in out["not_settled"]


def test_an_onset_within_the_record_is_where_the_rise_begins() -> None:
    out = said(step(12.0, (0.2, 0.005)), rise([0.3], [100.0], (0.23,)))
    assert "ends 2.5 time constants after" in out["not_settled"]
    assert "dead_time" not in out  # three samples
    late = said(step(12.0, (0.2, 0.005)), rise([0.1], [100.0], (0.2316,)))
    assert late["dead_time"].startswith("the speed begins to rise 31.6 ms (3 samples) after the")
    assert "dead_time" in said(step(12.0, (0.2, 0.005)), rise([0.1], [100.0], (0.168,)))


def test_more_than_noise_is_left_of_a_curve_that_is_no_exponential() -> None:
    rng = np.random.default_rng(3)
    noisy = 100.0 * (1.0 - np.exp(-TIME / 0.1)) + 0.5 * rng.standard_normal(100)
    one = step(speed=noisy)
    wandering = replace(rise([0.1], [100.0]), wander=4.0)
    for size, lacks in ((0.9, True), (0.5, False)):
        left = np.full(100, size)
        assert ("lack_of_fit" in said(one, wandering, left)) is lacks
    assert "lack_of_fit" not in said(one, rise([0.1], [100.0]), np.full(100, 9.0))  # white


# single steps


def level(drive: Any) -> Any:
    return single_level.level_of(TIME, np.asarray(drive, float))


def test_a_level_begins_once_and_stays() -> None:
    on = np.where(np.arange(100) >= 20, 12.0, 0.0)
    known, onset, until_s = level(on)
    assert (known, until_s) == (12.0, np.inf)
    assert onset == pytest.approx((0.195, 0.005))
    assert level(np.full(100, -3.0)) == (-3.0, None, np.inf)
    off = np.where(np.arange(100) >= 89, 0.0, on)  # the logger's last rows
    assert level(off) == (12.0, onset, pytest.approx(0.89))
    assert level(np.where(np.arange(100) >= 88, 0.0, on)) is None  # a coast of its own
    assert level(np.where(np.arange(100) >= 60, 0.0, 12.0)) is None
    assert level(np.zeros(100)) is None
    assert level(np.where(np.arange(100) == 50, 0.0, on)) is None
    few = np.full(100, np.nan)
    few[:11] = 5.0
    assert level(few) is None
    few[11] = 5.0
    assert level(few) == (5.0, None, np.inf)


@pytest.mark.parametrize(("before", "step"), [(0.47, True), (0.49, False), (-0.49, False)])
def test_before_a_step_there_is_next_to_nothing(before: float, step: bool) -> None:
    drive = np.where(np.arange(100) >= 20, 12.0, before)
    assert (level(drive) is not None) is step


@pytest.mark.parametrize(("scatter", "constant"), [(0.23, True), (0.25, False)])
def test_a_level_varies_by_little(scatter: float, constant: bool) -> None:
    drive = 12.0 + scatter * np.tile([1.0, -1.0], 50)
    assert (level(drive) is not None) is constant


def test_a_motor_that_gets_faster_does_not_coast() -> None:
    up = 100.0 * (1.0 - np.exp(-TIME / 0.3))
    assert room._gets_faster(TIME, up, SPEED)
    assert room._gets_faster(TIME, -up, SPEED)
    assert not room._gets_faster(TIME, up[::-1], SPEED)
    assert room._gets_faster(TIME, np.cumsum(up) * 0.01, POSITION)
    assert not room._gets_faster(TIME, np.cumsum(up[::-1]) * 0.01, POSITION)
    assert not room._gets_faster(TIME, np.linspace(52.0, 100.0, 100), SPEED)
    assert room._gets_faster(TIME, np.linspace(40.0, 100.0, 100), SPEED)


def test_a_step_is_read_at_the_motor_without_what_was_late() -> None:
    one = capture(drive=np.full(100, 12.0), delay_s=0.004, resolution=0.5, kind="mean",
                  aperture_s=0.01)  # fmt: skip
    (found,) = room.steps([replace(one, wiring=Wiring(gear_ratio=3.0))]) or []
    assert found.record.time_s == pytest.approx(TIME - 0.004)
    assert found.record.values == pytest.approx(3.0 * one.channels[SPEED].values)
    assert (found.record.quantum, found.record.aperture_s) == (1.5, 0.01)
    assert (found.level, found.onset_s, found.record.onset_s) == (12.0, None, None)
    assert not found.record.is_position
    still = capture(drive=np.full(100, 12.0), resolution=30.0)
    assert room.steps([still]) is None
    held = capture(drive=np.full(100, 12.0), raw_max=90.0)
    (cut,) = room.steps([held]) or []
    assert float(cut.record.values.max()) < 90.0


def test_steps_are_alike_in_size_and_all_have_a_drive_or_none() -> None:
    def driven(*levels: float) -> Any:
        return room.steps([capture(drive=np.full(100, v)) for v in levels])

    assert driven(12.0, -11.77) is not None
    assert driven(12.0, 11.75) is None
    assert room.steps([capture(drive=np.full(100, 12.0)), capture()]) is None
    assert room.steps([capture(), capture()]) is not None
    assert room.steps([]) is None
    program: Any = SimpleNamespace(steps=())
    assert room.steps([replace(capture(), program=program)]) is None


@pytest.mark.parametrize(("size", "lacks"), [(0.40, False), (0.42, True)])
def test_rounding_is_expected_of_what_is_left(size: float, lacks: bool) -> None:
    """A quantum q has a variance of q²/12, and twice that is still no lack of fit."""
    one = step(None)
    rounded = replace(one, record=replace(one.record, values=np.arange(100.0), quantum=2.0))
    wandering = replace(rise([0.1], [100.0]), wander=4.0)
    assert ("lack_of_fit" in said(rounded, wandering, np.full(100, 2.0 * size))) is lacks


@pytest.mark.slow
def test_a_short_record_beside_a_long_one_shows_its_part_of_a_rise() -> None:
    """Positions of a linear motor; the second record is an eighth of the time constant long."""
    found = []
    for time in (np.linspace(0.0, 1.5, 50), np.linspace(0.0, 0.025, 13)):
        risen = 0.3 * (time - 0.2 * (1.0 - np.exp(-time / 0.2)))
        moved = risen + 1e-6 * np.random.default_rng(1).standard_normal(len(time))
        channels = {POSITION: Channel(POSITION, "m", moved)}
        one = Capture(np.rint(time * 1e9).astype(np.int64), 1e9, channels)
        found += room.steps([one]) or []
    told = room.fit(found, {}, ())
    assert told.combinations[TAU].value == pytest.approx(0.2, rel=0.01)
    first = told.combinations["steady speed of run 1"]
    assert (first.unit, first.value) == ("m/s", pytest.approx(0.3, rel=1e-3))
