"""A log whose motion comes late is fitted, not refused for a start value."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.foreign.plant import Motor, turn
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.fit import lagging_start, start_values
from motorid.estimate.fit.lagging_start import Doubt, mechanics
from motorid.estimate.fit.start_signals import Signals, signals
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from tests.six_parameters import fit

MOTOR = Motor(R=2.0, L=1e-3, K=0.05, B=2e-5, J=2e-5, T0=4e-3)  # a time constant of 16 ms
PERIOD_S, LATE = 6e-3, 10  # samples
NOISE = {VOLTAGE: 0.01, CURRENT: 0.01, SPEED: 0.3}


def log(late: int = 0) -> Capture:
    true = turn(MOTOR, lambda t, w: 6.0 if t > 0.03 else 0.0, 0.3)
    stamps = np.arange(2e-3, 0.295, PERIOD_S)
    rng = np.random.default_rng(1)
    speed = true.at(true.speed, stamps - late * PERIOD_S)
    series = {VOLTAGE: true.at(true.volts, stamps), CURRENT: true.at(true.current, stamps)}
    channels = {
        name: Channel(name, unit, y + NOISE[name] * rng.standard_normal(len(y)))
        for (name, y), unit in zip(
            {**series, SPEED: speed}.items(), ("V", "A", "rad/s"), strict=True
        )
    }
    return Capture(np.rint(stamps * 1e6).astype(np.int64), 1e6, channels)


def begun(capture: Capture) -> tuple[dict[str, float], object]:
    return start_values.begun([MotorRecord(capture, PARAMETERS, {})], {})


def test_a_motion_that_comes_late_begins_with_its_lag() -> None:
    assert begun(log())[1] is None
    start, doubt = begun(log(LATE))
    assert isinstance(doubt, Doubt)
    assert doubt.late_s == pytest.approx(LATE * PERIOD_S, rel=0.3)
    assert 0.3 * MOTOR.J < start["J"] < 3.0 * MOTOR.J
    assert "earlier" in str(doubt.refusal())


@pytest.mark.slow
def test_it_is_fitted_and_the_lag_is_said() -> None:
    found = fit([log(LATE)])
    (said,) = [d.message for d in found.diagnostics if d.code == "motion_late"]
    assert "--delay" in said
    for name in ("R", "K"):
        p = found.parameters[name]
        assert p.value == pytest.approx(getattr(MOTOR, name), abs=4.0 * p.total)


def test_a_start_is_guessed_where_no_lag_helps() -> None:
    def never(*_: object) -> tuple[tuple[float, float, float], float]:
        raise DataError("no")

    data = [signals(MotorRecord(log(), PARAMETERS, {}))]
    motor, doubt = mechanics(data, MOTOR.R, MOTOR.K, {}, never, DataError("why"))
    assert 0.3 * MOTOR.J < motor[1] < 3.0 * MOTOR.J
    assert str(doubt.refusal()) == "why"


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_an_inertia_is_guessed_by_how_long_a_small_voltage_takes(way: float) -> None:
    """From where it begins; friction by half of the current at speed each."""
    at = np.arange(400)
    since = np.maximum(at - 20.0, 0.0)
    speed = 50.0 * (1.0 - np.exp(-since / 60.0))
    volts = np.where(at >= 20, 0.5, 0.0)
    angle = np.cumsum(speed) * 1e-3
    one = Signals(
        1e-3, way * volts, way * np.full(400, 0.2), way * angle, way * speed, (0, 20, 400),
        (False, False), 0.0,
    )  # fmt: skip
    still = replace(one, angle=0.0 * angle, speed=0.0 * speed)
    viscous, inertia, dry = lagging_start._guess([still, one], 2.0, 0.05, {})
    risen = int(np.argmax(speed >= lagging_start.RISEN * speed.max()))
    assert inertia == pytest.approx((risen - 20) * 1e-3 * 0.05**2 / 2.0)
    assert viscous == pytest.approx(0.5 * 0.05 * 0.2 / speed.max())
    assert dry == pytest.approx(0.5 * 0.05 * 0.2)
    held = lagging_start._guess([one], 2.0, 0.05, {"J": 7.0, "B": 0.0})
    assert held == pytest.approx((0.0, 7.0, dry))
    by_angle = lagging_start._guess([replace(one, speed=None)], 2.0, 0.05, {})
    assert by_angle == pytest.approx((viscous, inertia, dry), rel=0.05)
