"""Figures of steady levels from readings that were written down, whose answers are known."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.assembly import measured_levels as module
from motorid.estimate.assembly.measured_levels import FEWEST, measured_levels
from motorid.estimate.effects.brush_and_heating import BENT, DROP
from motorid.estimate.results.estimate import Curve, MeasuredLevel
from motorid.motor.brushes import Brushes
from motorid.motor.parameters import Motor
from motorid.segment import Segment, SegmentKind

Floats = NDArray[np.float64]

PERIOD_S, COUNT = 1e-3, 2000
TIME = PERIOD_S * np.arange(COUNT)
SETTLES_S = 0.5  # J R/(K² + R B) of the motor
MOTOR = Motor(R=2.0, L=1e-3, K=0.05, B=0.0, J=SETTLES_S * 0.05**2 / 2.0, T0=0.0)
W, A, I0, C = 80.0, -30.0, 0.3, 0.05  # rad/s, rad, A, A
STEADY = Segment(SegmentKind.STEADY, 0, COUNT)
UNITS = {POSITION: "rad", SPEED: "rad/s", CURRENT: "A", VOLTAGE: "V"}
VOLTS = Channel(VOLTAGE, "V", np.full(COUNT, 6.0), gain_uncertainty=0.01, offset_uncertainty=0.02)
AMPERES = Channel(CURRENT, "A", np.full(COUNT, I0), gain_uncertainty=0.02, offset_uncertainty=0.004)
TURNED = 7.0 + W * TIME + A * np.exp(-TIME / SETTLES_S)
FLOWN = I0 + C * np.exp(-TIME / SETTLES_S)


def curve(name: str, values: Floats, sigma: float = 0.0) -> Curve:
    return Curve(0, name, UNITS[name], TIME[: len(values)], values, values, sigma)


def capture(*channels: Channel, clock: float = 0.0) -> Capture:
    ticks = np.arange(len(channels[0].raw) if channels else COUNT)
    return Capture(ticks, 1.0 / PERIOD_S, {c.name: c for c in channels}, clock_uncertainty=clock)


def level(
    taken: Capture, *curves: Curve, motor: Motor = MOTOR, brushes: Brushes | None = None
) -> MeasuredLevel:
    (found,) = measured_levels([(taken, [STEADY])], curves, motor, brushes)
    return found


def test_speed_and_current_are_where_the_approach_leads() -> None:
    found = level(capture(VOLTS, AMPERES), curve(POSITION, TURNED), curve(CURRENT, FLOWN))
    assert found.speed_rad_s == pytest.approx(W, rel=1e-9)
    assert found.current_a == pytest.approx(I0, rel=1e-9)
    assert (found.capture, found.start_s, found.end_s) == (0, 0.0, pytest.approx(TIME[-1]))
    assert found.problem == ""


def test_a_speed_that_was_read_is_followed_as_it_is() -> None:
    read = W + 10.0 * np.exp(-TIME / SETTLES_S)
    found = level(capture(VOLTS, Channel(SPEED, "rad/s", read)), curve(SPEED, read))
    assert found.speed_rad_s == pytest.approx(W, rel=1e-9)


def test_a_time_constant_that_is_wrong_by_its_doubt_moves_them_by_what_is_stated() -> None:
    found = level(capture(VOLTS, AMPERES), curve(POSITION, TURNED), curve(CURRENT, FLOWN))
    for name, values, u in (
        (POSITION, TURNED, found.speed_u),
        (CURRENT, FLOWN, found.current_u),
    ):
        ends = []
        for part in (0.9, 1.1):
            columns = [np.ones(COUNT), TIME, np.exp(-TIME / (part * SETTLES_S))]
            design = np.column_stack(columns if name == POSITION else columns[::2])
            ends.append(np.linalg.lstsq(design, values, rcond=None)[0][int(name == POSITION)])
        instrument = 0.0 if name == POSITION else math.hypot(0.02 * I0, 0.004)
        assert u == pytest.approx(math.hypot(instrument, (ends[1] - ends[0]) / 2.0), rel=1e-6)


def test_what_instruments_leave_open_is_added() -> None:
    settled = replace(MOTOR, J=1e-4 * MOTOR.J)
    still = np.full(COUNT, I0)
    taken = capture(VOLTS, AMPERES, clock=3e-3)
    found = level(taken, curve(POSITION, W * TIME), curve(CURRENT, still), motor=settled)
    assert found.speed_u == pytest.approx(3e-3 * W, rel=1e-6)
    assert found.current_u == pytest.approx(math.hypot(0.02 * I0, 0.004), rel=1e-6)
    read = Channel(SPEED, "rad/s", np.full(COUNT, W), gain_uncertainty=0.01, offset_uncertainty=0.5)
    found = level(capture(VOLTS, read, clock=3e-3), curve(SPEED, np.full(COUNT, W)), motor=settled)
    assert found.speed_u == pytest.approx(math.hypot(3e-3 * W, 0.01 * W, 0.5), rel=1e-6)


def test_the_voltage_is_a_mean_with_noise_gain_and_offset() -> None:
    values = 6.0 + 0.5 * np.sin(0.1 * np.arange(COUNT))
    values[5] = np.nan
    found = level(capture(replace(VOLTS, raw=values)), curve(POSITION, TURNED))
    known = values[np.isfinite(values)]
    noise = known.std() / math.sqrt(COUNT - 1)
    assert found.voltage_v == pytest.approx(known.mean(), rel=1e-12)
    assert found.voltage_u == pytest.approx(math.hypot(0.01 * known.mean(), 0.02, noise), rel=1e-9)


@pytest.mark.parametrize(("finite", "given"), [(FEWEST - 1, False), (FEWEST, True)])
def test_too_few_voltages_are_no_mean(finite: int, given: bool) -> None:
    values = np.where(np.arange(COUNT) < finite, 6.0, np.nan)
    found = level(capture(replace(VOLTS, raw=values)), curve(POSITION, TURNED))
    assert (found.voltage_v is not None, found.voltage_u is not None) == (given, given)


@pytest.mark.parametrize("unstated", ["gain", "offset"])
def test_a_scale_that_nobody_stated_has_no_uncertainty(unstated: Any) -> None:
    channels = [replace(c, undeclared=(unstated,)) for c in (VOLTS, AMPERES)]
    found = level(capture(*channels), curve(POSITION, TURNED), curve(CURRENT, FLOWN))
    assert (found.voltage_v, found.voltage_u) == (pytest.approx(6.0), None)
    assert (found.current_a, found.current_u) == (None, None)
    assert found.speed_rad_s == pytest.approx(W)
    read = Channel(SPEED, "rad/s", np.full(COUNT, W), undeclared=(unstated,))
    found = level(capture(VOLTS, read), curve(SPEED, np.full(COUNT, W)))
    assert found.speed_rad_s is None
    assert "gain and the offset of the speed" in found.problem


def test_a_magnitude_is_no_current() -> None:
    found = level(capture(VOLTS, replace(AMPERES, unsigned=True)), curve(CURRENT, FLOWN))
    assert (found.current_a, found.speed_rad_s, found.problem) == (None, None, "")


def test_what_has_no_channel_has_no_figure() -> None:
    found = level(capture(AMPERES), curve(POSITION, TURNED))
    assert (found.voltage_v, found.voltage_u) == (None, None)
    assert (found.current_a, found.current_u) == (None, None)


@pytest.mark.parametrize(("turns", "problem"), [(1.9, True), (2.1, False)])
def test_a_level_of_few_turns_is_not_judged(turns: float, problem: bool) -> None:
    slow = turns * 2.0 * math.pi / TIME[-1]
    found = level(capture(VOLTS), curve(POSITION, -slow * TIME))
    assert found.speed_rad_s == pytest.approx(-slow, rel=1e-6)
    assert ("2 turns" in found.problem) is problem


@pytest.mark.parametrize(("left", "problem"), [(0.018, False), (0.022, True)])
@pytest.mark.parametrize("read", [POSITION, SPEED])
def test_a_speed_with_more_to_go_is_not_judged(left: float, problem: bool, read: str) -> None:
    """``left``: of the speed, at the end of the level."""
    to_go = left * W * np.exp((TIME[-1] - TIME) / SETTLES_S)
    values = W - to_go if read == SPEED else W * TIME + SETTLES_S * to_go
    found = level(capture(VOLTS), curve(read, values))
    assert found.speed_rad_s == pytest.approx(W, rel=1e-6)
    assert ("not settled" in found.problem) is problem


@pytest.mark.parametrize(("count", "levels"), [(FEWEST - 1, 0), (FEWEST, 1)])
def test_a_level_has_enough_samples(count: int, levels: int) -> None:
    steady = Segment(SegmentKind.STEADY, 0, count)
    assert len(measured_levels([(capture(VOLTS), [steady])], (), MOTOR, None)) == levels


def test_too_few_readings_of_a_curve_lead_nowhere() -> None:
    settled = replace(MOTOR, J=1e-4 * MOTOR.J)
    for count in (FEWEST - 1, FEWEST):
        few = replace(curve(POSITION, W * TIME[:count]), time_s=TIME[:count])
        found = level(capture(VOLTS), few, motor=settled).speed_rad_s
        assert found == (None if count < FEWEST else pytest.approx(W, rel=1e-9))


def test_the_uncertainty_by_blocks_holds_for_white_noise() -> None:
    rng = np.random.default_rng(3)
    settled = replace(MOTOR, J=1e-4 * MOTOR.J)
    held = 0
    for _ in range(200):
        noisy = curve(POSITION, W * TIME + 0.1 * rng.standard_normal(COUNT))
        found = level(capture(VOLTS), noisy, motor=settled)
        assert found.speed_rad_s is not None
        assert found.speed_u is not None
        held += abs(found.speed_rad_s - W) < 1.96 * found.speed_u
    assert 180 <= held <= 198  # 95 % of 200, four standard deviations


def test_noise_that_the_fit_knows_bounds_it_from_below() -> None:
    settled = replace(MOTOR, J=1e-4 * MOTOR.J)
    found = level(capture(VOLTS), curve(POSITION, W * TIME, sigma=0.1), motor=settled)
    by_algebra = 0.1 / math.sqrt(((TIME - TIME.mean()) ** 2).sum())
    assert found.speed_u == pytest.approx(by_algebra, rel=1e-6)


def test_the_end_of_the_acceleration_belongs_to_a_level_that_follows_it() -> None:
    speeding = Segment(SegmentKind.ACCELERATION, 0, 1800)
    steady = Segment(SegmentKind.STEADY, 1800, COUNT)
    for motor, from_s in ((replace(MOTOR, J=MOTOR.J / 5.0), TIME[-1] - 0.2), (MOTOR, 1.0)):
        (found,) = measured_levels([(capture(VOLTS), [speeding, steady])], (), motor, None)
        assert found.start_s == pytest.approx(from_s, abs=1.5 * PERIOD_S)
    other = replace(speeding, kind=SegmentKind.BRAKE)
    apart = replace(speeding, stop=1700)
    for before in (other, apart):
        (found,) = measured_levels([(capture(VOLTS), [before, steady])], (), MOTOR, None)
        assert found.start_s == pytest.approx(1.8)


def test_an_acceleration_lends_no_more_than_what_follows_its_first_time_constant() -> None:
    speeding = Segment(SegmentKind.ACCELERATION, 1000, 1800)
    steady = Segment(SegmentKind.STEADY, 1800, COUNT)
    (found,) = measured_levels([(capture(VOLTS), [speeding, steady])], (), MOTOR, None)
    assert found.start_s == pytest.approx(1.5, abs=1.5 * PERIOD_S)


def test_brushes_make_the_approach_slower_and_less_sure() -> None:
    brushes = Brushes(0.4, 0.5)
    more = brushes.slope(I0)
    found = module._approach(capture(AMPERES), STEADY, MOTOR, brushes)
    assert found.constant_s == pytest.approx(SETTLES_S * (2.0 + more) / 2.0)
    assert found.doubt == pytest.approx(0.1 + 0.3 * more / (2.0 + more))
    alone = module._approach(capture(AMPERES), STEADY, MOTOR, None)
    assert (alone.constant_s, alone.doubt) == (pytest.approx(SETTLES_S), 0.1)
    at_rest = module._approach(capture(VOLTS), STEADY, MOTOR, brushes)
    assert at_rest.constant_s == pytest.approx(SETTLES_S * (2.0 + brushes.slope(0.0)) / 2.0)


def record(names: list[str], loss: object) -> Any:
    return SimpleNamespace(
        instances=[SimpleNamespace(name=name) for name in names],
        loss=loss,
        motor=lambda values: np.array([2.0, 1e-3]),
        timeline=SimpleNamespace(parts=[]),
    )


def test_brushes_are_those_of_the_first_capture_that_knows_their_drop() -> None:
    loss = SimpleNamespace(bend_a=lambda ohms: 0.05 * ohms)
    spread = np.array([[4.0, 1.0, 0.5], [1.0, 9.0, 2.0], [0.5, 2.0, 16.0]])
    solution: Any = SimpleNamespace(
        values=np.zeros(2),
        own=[np.zeros(1), np.array([7.0, 0.3, 0.6])],
        own_covariance=[np.eye(1), spread],
    )
    unaware = record([DROP], None)
    both = module.brushes_of(solution, [unaware, record(["other", DROP, BENT], loss)])
    assert both == Brushes(0.3, 0.1, 0.0, (9.0, 16.0, 2.0))
    alone = module.brushes_of(solution, [record(["x"], loss), record(["other", DROP, "x"], loss)])
    assert alone == Brushes(0.3, 0.1, 0.0, (9.0, 0.0, 0.0))
    assert module.brushes_of(solution, [unaware, unaware]) is None
