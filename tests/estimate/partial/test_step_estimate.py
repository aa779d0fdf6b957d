"""The estimate of single steps whose rise is told: its fields, its curves, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import POSITION, SPEED, Channel
from motorid.errors import DataError
from motorid.estimate.partial import step_response as room
from motorid.estimate.partial.exponential_fit import Record, Rise
from motorid.estimate.partial.levels import single_level
from motorid.estimate.partial.mechanical_signals import COMMAND
from motorid.estimate.partial.step_response import Step
from motorid.estimate.results.estimate import Estimate
from tests.estimate.partial.test_step_figures import (
    JUDGE,
    TAU,
    TIME,
    WHOLE,
    capture,
    rise,
    said,
    step,
)


def fitted(
    patch: pytest.MonkeyPatch, steps: list[Step], found: Rise, without: tuple[str, ...] = (),
    **fix: float,
) -> Estimate:  # fmt: skip
    patch.setattr(room.exponential_fit, "rise", lambda records: found)
    return room.fit(steps, fix, without)


def test_an_estimate_of_a_step_states_what_it_is_of(monkeypatch: pytest.MonkeyPatch) -> None:
    found = fitted(monkeypatch, [step()], rise([0.1], [100.0]), K=0.05)
    assert found.model.endswith("/τ))")
    assert (found.degrees_of_freedom, found.evaluations, found.free) == (1000, 7, ("JR/(K²+RB)",))
    assert found.correlation.shape == (1, 1)
    assert (found.parameters["K"].value, found.parameters["K"].status) == (0.05, "fixed")
    others = {p.status for n, p in found.parameters.items() if n != "K"}
    assert others == {"not_identifiable"}
    assert found.options == {"fix": {"K": 0.05}, "without": []}
    assert WHOLE in found.combinations
    alone = fitted(monkeypatch, [step()], rise([0.1], [100.0]), ("T0",))
    assert WHOLE not in alone.combinations
    assert alone.options["without"] == ["T0"]


def test_a_second_lag_is_named_in_the_model_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    lags = rise([0.1, 0.02], [100.0], variances={0: 4e-6, 1: 1e-6})
    found = fitted(monkeypatch, [step()], lags)
    assert found.model.endswith(", with a second lag")
    second = found.combinations["second lag"]
    assert (second.name, second.unit, second.value) == ("second lag", "s", 0.02)
    assert second.statistical == pytest.approx(np.sqrt(5e-6))  # of the two, which are one sum


def test_chi_square_is_of_what_the_curve_leaves_over_its_deviation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one, other, exact = step(), step(), step()
    three = rise([0.1], [100.0, 100.0, 100.0], (None, None, None))
    left = [np.full(100, 0.5), np.tile([0.3, -0.3], 50), np.zeros(100)]
    curves = tuple(s.record.values - x for s, x in zip((one, other, exact), left, strict=True))
    known = replace(three, fitted=curves, deviations=np.array([0.25, 0.1, 0.0]))
    found = fitted(monkeypatch, [one, other, exact], known)
    assert found.chi_square == pytest.approx(100 * 2.0**2 + 100 * 3.0**2)
    first, second, _ = found.curves
    assert (first.capture, second.capture, second.channel, second.unit) == (0, 1, SPEED, "rad/s")
    assert second.time_s == pytest.approx(TIME)
    assert second.measured == pytest.approx(other.record.values)
    assert second.fitted == pytest.approx(curves[1])
    assert second.sigma == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("tau", "refused"), [(0.019, True), (0.021, False), (3.9, False), (4.1, True)]
)
def test_a_motor_without_a_time_constant_is_refused(
    tau: float, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Below its uncertainty of 20 ms, or above four lengths of the record, of .99 s each."""
    longer = Record(TIME * 1.01, np.arange(100.0))
    steps = [replace(step(), record=longer), step()]
    found = rise([tau], [100.0, 100.0], (None, None), variances={0: 4e-4})
    if refused:
        with pytest.raises(DataError, match="does not settle"):
            fitted(monkeypatch, steps, found)
    else:
        assert TAU in fitted(monkeypatch, steps, found).combinations


def test_a_second_lag_that_hides_is_in_what_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    hidden = replace(rise([0.1], [100.0]), hidden_s=0.11)
    with pytest.raises(DataError, match="does not settle"):
        fitted(monkeypatch, [step()], hidden)


def test_the_worst_clock_counts() -> None:
    slow = replace(step(None), capture=replace(capture(), clock_uncertainty=0.02))
    out = room._combinations(
        JUDGE, [step(None), slow], rise([0.1], [100.0, 100.0], (None, None)), False, False
    )
    assert out[TAU].instrument == pytest.approx(0.1 * 0.02)


def test_steps_of_one_size_are_averaged_by_their_variances_and_half_their_scatter() -> None:
    steps = [step(10.0), step(-10.0)]
    found = rise([0.1], [100.0, -106.0], (None, None), {3: 1.0, 4: 4.0})
    one = room._by_drive(JUDGE, steps, found, "rad/s", False)[WHOLE]
    assert one.value == pytest.approx((4 * 10.0 + 10.6) / 5)
    variances = np.array([0.01, 0.04])
    assert one.statistical == pytest.approx(np.sqrt(1.0 / (1.0 / variances).sum() + 0.3**2))
    single = room._by_drive(JUDGE, steps[:1], rise([0.1], [100.0], variances={2: 1.0}), "rad/s",
                            False)[WHOLE]  # fmt: skip
    assert single.statistical == pytest.approx(0.1)


def test_a_gain_is_as_unsure_as_its_two_channels() -> None:
    one = step(12.0, gain_uncertainty=0.04)  # the drive's is .03
    found = room._by_drive(JUDGE, [one], rise([0.1], [120.0]), "rad/s", True)["K/(K²+RB)"]
    assert found.instrument == pytest.approx(0.05 * 10.0)
    assert found.unit == "rad/s/V"
    beside = {
        **one.capture.channels,
        POSITION: Channel(POSITION, "rad", TIME, gain_uncertainty=0.1),
    }
    assert room._gain(replace(one.capture, channels=beside), (SPEED, POSITION)) == 0.1
    duty = replace(one, capture=capture(drive=np.full(100, 0.5), name=COMMAND), level=0.5)
    known = room._by_drive(JUDGE, [duty], rise([0.1], [120.0]), "m/s", True)["K/(K²+RB)"]
    assert (known.unit, known.value) == ("m/s/1", pytest.approx(240.0))


def test_each_run_is_named_in_what_is_said_of_it() -> None:
    steps = [step(), step()]
    slow = rise([0.5], [100.0, 100.0], (None, None))
    words = [d.message for d in room._findings(steps, slow, [np.zeros(100)] * 2)]
    assert sum("in run 1" in w for w in words) == sum("in run 2" in w for w in words) == 1
    assert "in run" not in said(step(), rise([0.5], [100.0]))["not_settled"]


@pytest.mark.parametrize(("wander", "lacks"), [(1.0, False), (2.0, True)])
def test_residuals_that_wander_lack_fit(wander: float, lacks: bool) -> None:
    noisy = step(speed=100.0 * (1.0 - np.exp(-TIME / 0.1)) + 0.1 * (-1.0) ** np.arange(100))
    found = replace(rise([0.1], [100.0]), wander=wander)
    assert ("lack_of_fit" in said(noisy, found, np.full(100, 5.0))) is lacks


def test_a_record_ends_with_its_last_reading_and_begins_with_its_first() -> None:
    """One that is not even: .3 s before its last, .2 s after its first."""
    times = np.concatenate([[0.0], 0.2 + 0.01 * np.arange(40), [0.89]])
    late = replace(step(None), record=Record(times, times))
    assert "not_settled" not in said(late, rise([0.295], [100.0]), np.zeros(42))
    assert "2.9 time constants" in said(late, rise([0.31], [100.0]), np.zeros(42))["not_settled"]
    assert "few_samples" in said(late, rise([0.08], [100.0]), np.zeros(42))  # of .24 s since 0
    assert "few_samples" not in said(late, rise([0.1], [100.0]), np.zeros(42))


@pytest.mark.parametrize("first", [45, 76, 88])
def test_a_level_may_follow_a_long_rest(first: int) -> None:
    drive = np.where(np.arange(100) >= first, 12.0, 0.0)
    onset = (0.01 * first - 0.005, 0.005)
    assert single_level.level_of(TIME, drive) == (12.0, pytest.approx(onset), np.inf)
    assert (
        single_level.level_of(TIME, np.where(np.arange(100) >= 89, 12.0, 0.0)) is None
    )  # too few readings


@pytest.mark.parametrize(("geared", "moves"), [(3.0, True), (0.3, True)])
def test_a_motion_is_four_quanta_at_the_shaft_that_was_read(geared: float, moves: bool) -> None:
    one = capture(drive=np.full(100, 12.0), resolution=20.0)  # 100 rad/s
    geared_one = replace(one, wiring=replace(one.wiring, gear_ratio=geared))
    (found,) = room.steps([geared_one]) or []
    assert found.record.quantum == pytest.approx(20.0 * geared)
    still = capture(drive=np.full(100, 12.0), resolution=26.0)
    assert room.steps([replace(still, wiring=replace(still.wiring, gear_ratio=geared))]) is None
    plain = replace(one, wiring=replace(one.wiring, gear_ratio=0.0))
    (bare,) = room.steps([plain]) or []
    assert bare.record.quantum == 20.0


def test_a_step_that_is_seen_says_when_it_began() -> None:
    on = np.where(np.arange(100) >= 20, 12.0, 0.0)
    late = 100.0 * (1.0 - np.exp(-np.maximum(TIME - 0.2, 0.0) / 0.1))
    (found,) = room.steps([capture(late, on)]) or []
    assert found.record.onset_s == pytest.approx(0.195)
    place = Channel(POSITION, "rad", np.cumsum(late) * 0.01, kind="mean", aperture_s=0.01)
    one = capture(late, on)
    by_place: Any = {n: c for n, c in one.channels.items() if n != SPEED}
    (turned,) = room.steps([replace(one, channels={**by_place, POSITION: place})]) or []
    assert (turned.record.is_position, turned.record.aperture_s) == (True, 0.0)


@pytest.mark.parametrize(("speed", "faster"), [(40.0, True), (60.0, False)])
def test_a_motor_gets_faster_from_its_first_two_readings_to_its_last_eighth(
    speed: float, faster: bool
) -> None:
    """By half of the highest, of 100; a third reading says nothing."""
    values = np.full(88, 100.0)
    values[:2] = speed
    values[60:77] = 0.0  # before the last eighth, of 11
    assert room._gets_faster(TIME[:88], values, SPEED) is faster
    few = np.array([10.0, 10.0, 90.0, 50.0, 100.0, 40.0])  # of two at least
    assert room._gets_faster(TIME[:6], few, SPEED) is True


@pytest.mark.parametrize(("quantum", "moves"), [(25.0, False), (24.0, True)])
def test_four_quanta_themselves_are_no_motion(quantum: float, moves: bool) -> None:
    ramp = capture(np.arange(101.0)[1:] - 1.0, np.full(100, 12.0), resolution=quantum)
    ramp.channels[SPEED].raw[-1] = 100.0
    assert (room.steps([ramp]) is not None) is moves
