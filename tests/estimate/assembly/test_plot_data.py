"""What a report plots: times, readings and segments, as the capture has them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture.model import POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.assembly import plot_data
from motorid.estimate.diagnosis.facts.steady_levels import Level, Reached
from motorid.motor.parameters import Motor
from motorid.segment.types import Segment, SegmentKind
from tests.estimate.uncertainty.test_budget import fitted


def test_a_curve_is_the_readings_beside_the_model() -> None:
    records, solution = fitted("measured")
    curves = plot_data.curves(solution, records)
    assert len(curves) == len(records[0].measured)
    for curve, m in zip(curves, records[0].measured, strict=True):
        values = vars(curve).values()
        assert any(value is m.values for value in values)
        assert m.block.name in values


def test_segments_say_when_they_are_and_empty_ones_are_left_out() -> None:
    records, _ = fitted("measured")
    capture = records[0].capture
    stretches = [
        Segment(SegmentKind.REST, 0, 20), Segment(SegmentKind.STEADY, 20, 20),
        Segment(SegmentKind.COAST, 300, 400, "open"),
    ]  # fmt: skip
    first, last = plot_data.segments([(capture, stretches)])
    assert list(vars(first).values())[:2] == [0, "rest"]
    assert list(vars(last).values())[2:] == [
        pytest.approx(0.03), pytest.approx(0.0399), "open",
    ]  # fmt: skip


def test_a_curve_has_its_times_its_scatter_and_its_unit() -> None:
    records, solution = fitted("measured")
    (record,), own = records, solution.own[0]
    left = record.weighed(record.departures(solution.values, own), filtered=False)
    for curve, m, model, rest in zip(
        plot_data.curves(solution, records), record.measured,
        record.fitted(solution.values, own), left, strict=True,
    ):  # fmt: skip
        assert curve.measured is m.values
        assert curve.fitted == pytest.approx(model)
        assert curve.unit == {"current": "A", "position": "rad", "back_emf": "V"}[m.block.name]
        assert len(curve.time_s) == len(m.values)
        past = 0 if m.past is None else m.past
        assert curve.time_s == pytest.approx((m.keep + past) * record.timeline.period_s)
        scatter = np.sqrt(np.square(rest).sum() / m.block.count)
        assert curve.sigma == pytest.approx(max(scatter, m.block.floor))
        assert curve.ripple is None
        assert curve.smooth is curve.fitted


STEADY = Segment(SegmentKind.STEADY, 10, 31)
MOTOR = Motor(R=2.0, L=1e-3, K=0.05, B=4e-5, J=2e-5, T0=6e-3)


def level(
    turn: float = 1.0, gear: float = 1.0, reached: tuple[Level, ...] = (), **channels: Any
) -> Any:
    """A sample a millisecond; the position moves by 40 rad/s of the wheel."""
    position = Channel(POSITION, "rad", turn * 0.04 * np.arange(50.0))
    volts = np.linspace(5.0, 7.0, 50)
    volts[12] = np.nan
    given = {VOLTAGE: Channel(VOLTAGE, "V", volts), POSITION: position, **channels}
    capture = Capture(1000 * np.arange(50), 1e6, {n: c for n, c in given.items() if c is not None})
    stretches = [
        Segment(SegmentKind.REST, 0, 10), STEADY, Segment(SegmentKind.STEADY, 31, 32),
        Segment(SegmentKind.COAST, 32, 50),
    ]  # fmt: skip
    return plot_data.steady(MOTOR, [gear], [(capture, stretches)], reached)


@pytest.mark.parametrize(("turn", "gear"), [(1.0, 1.0), (-1.0, 1.0), (1.0, 20.0)])
def test_a_level_has_the_current_that_friction_asks_at_the_motors_speed(
    turn: float, gear: float
) -> None:
    (row,) = level(turn, gear)
    speed = 40.0 * turn * gear
    assert (row.capture, row.start_s, row.end_s) == (0, 0.010, pytest.approx(0.030))
    assert row.speed_rad_s == pytest.approx(speed)
    torque = MOTOR.B * speed + np.copysign(MOTOR.T0, speed)
    assert row.fitted_current_a == pytest.approx(torque / MOTOR.K)
    every = np.delete(np.linspace(5.0, 7.0, 50)[10:31], 2)  # one reading is missing
    assert row.voltage_v == pytest.approx(every.mean())
    assert row.current_a is None
    assert row.foretold_speed_rad_s is None


def test_a_speed_is_taken_where_no_position_is() -> None:
    speed = Channel(SPEED, "rad/s", np.linspace(30.0, 50.0, 50))
    (row,) = level(speed=speed, position=None)
    assert row.speed_rad_s == pytest.approx(speed.values[10:31].mean())
    (row,) = level(position=None, current=Channel("current", "A", np.full(50, np.nan)))
    assert (row.speed_rad_s, row.fitted_current_a, row.current_a) == (None, None, None)


def test_what_the_fit_foretells_of_a_level_is_beside_its_own_speed() -> None:
    def foretold(capture: int, start_s: float) -> float | None:
        (row,) = level(
            reached=(Level(capture, start_s, 0.03, Reached("speed", "rad/s", 39.0, 41.0, 1.0)),)
        )
        return row.foretold_speed_rad_s  # type: ignore[no-any-return]

    assert foretold(0, 0.01) == 41.0
    assert foretold(1, 0.01) is None
    assert foretold(0, 0.02) is None
