"""A motion that comes late in a log without a current: a cause, and no lack of fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mistakes.plant import Motor
from bench.stranger import chain
from bench.stranger.plant import Source, turn
from motorid.capture.model import SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.partial import unstated_lag
from motorid.estimate.partial.mechanical_fit import fit

RATE, TICKS, CLOCK_HZ = 500.0, 80, 1e9
MOTOR = Motor(0.5, 0.5 * 0.3 / RATE, 0.038, 7e-5, 5e-5, 8e-3, 12.0)
NOT_STATED = frozenset({"delay", "filter", "aperture"})


def logged(wander_v: float = 0.0, stated: bool = False) -> Capture:
    """A board's log: a speed that is the mean since the row before; ``wander_v``: by which the
    voltage's readings wander, V."""
    rng = np.random.default_rng(3)
    volts = np.tile(chain.wave("steps", MOTOR.volts, MOTOR.tau_s, RATE, rng), 3)
    dt = 1.0 / RATE / TICKS
    true = turn(MOTOR, np.repeat(volts, TICKS), dt, Source())
    stamps = np.arange(1, len(volts)) / RATE
    angle = chain.instants(true.angle, dt, stamps, False)
    speed = np.diff(angle, prepend=0.0) * RATE
    speed = speed + rng.normal(0.0, 0.5, len(speed))
    wander = wander_v * np.sin(stamps / MOTOR.tau_s)
    read = chain.instants(true.terminal, dt, stamps, True) + wander
    shown = chain.converted(read, 15.0, 10, 0.7, rng)
    facts = frozenset() if stated else NOT_STATED
    channels = {
        VOLTAGE: replace(Channel(VOLTAGE, "V", shown), undeclared=facts),
        SPEED: replace(Channel(SPEED, "rad/s", speed), undeclared=facts),
    }
    return Capture(np.rint(stamps * CLOCK_HZ).astype(np.int64), CLOCK_HZ, channels)


def codes(capture: Capture) -> set[str]:
    """Of what is said of it."""
    return {one.code for one in fit([capture]).diagnostics}


@pytest.mark.slow
def test_a_lag_that_nobody_stated_is_the_cause_and_is_in_the_intervals() -> None:
    found = fit([logged()])
    said = {one.code: one for one in found.diagnostics}
    assert said["unstated_lag"].severity == "info"
    assert "lack_of_fit" not in said
    m = MOTOR
    gain = m.K**2 + m.R * m.B
    for name, truth in (("JR/(K²+RB)", m.J * m.R / gain), ("K/(K²+RB)", m.K / gain)):
        low, high = found.combinations[name].interval_95
        assert low <= truth <= high, name


@pytest.mark.slow
def test_a_delay_that_is_stated_is_believed() -> None:
    assert {"lack_of_fit"} <= codes(logged(stated=True))
    assert "unstated_lag" not in codes(logged(stated=True))


@pytest.mark.slow
def test_a_misfit_that_no_lag_explains_stays_one() -> None:
    assert {"lack_of_fit"} <= codes(logged(wander_v=2.0))


@pytest.mark.slow
def test_a_motion_is_taken_earlier_by_samples_and_nothing_else() -> None:
    capture = logged()
    early = unstated_lag._earlier(capture, 1.5)
    late_s = early.channels[SPEED].delay_s - capture.channels[SPEED].delay_s
    assert np.isclose(late_s, 1.5 / RATE)
    assert early.channels[VOLTAGE] is capture.channels[VOLTAGE]
