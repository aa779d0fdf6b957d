"""A motion that comes late in a log without a current: a cause, and no lack of fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mistakes.plant import Motor
from bench.stranger import chain
from bench.stranger.plant import Source, turn
from motorid.capture.model import POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.partial.mechanical_fit import fit
from motorid.estimate.results.estimate import Estimate

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
    covers(found)


def covers(found: Estimate) -> None:
    """Its intervals hold the motor."""
    m = MOTOR
    gain = m.K**2 + m.R * m.B
    for name, truth in (("JR/(K²+RB)", m.J * m.R / gain), ("K/(K²+RB)", m.K / gain)):
        interval = found.combinations[name].interval_95
        assert interval is not None
        low, high = interval
        assert low <= truth <= high, name


@pytest.mark.slow
def test_a_delay_that_is_stated_is_believed() -> None:
    assert {"lack_of_fit"} <= codes(logged(stated=True))
    assert "unstated_lag" not in codes(logged(stated=True))


@pytest.mark.slow
def test_a_misfit_that_no_lag_explains_stays_one() -> None:
    assert {"lack_of_fit"} <= codes(logged(wander_v=2.0))


def held(after: bool) -> Capture:
    """Positions of a controller that holds each of its levels from a row to the next, exactly:
    ramps and steps both ways. ``after``: it logs a level as it sets it, not the one before.
    """
    m, step_s = replace(MOTOR, L=0.1 * MOTOR.L), 0.002
    ramp = np.repeat(np.linspace(0.0, 10.0, 100), 4)
    there = np.r_[np.zeros(5), ramp, np.zeros(80), np.full(120, 7.0), np.zeros(80)]
    volts = np.r_[there, -there]
    state, angles = np.zeros(3), [0.0]  # current, speed, angle
    for level in volts:
        state = held_row(m, state, level, step_s)
        angles.append(state[2])
    stamps = step_s * np.arange(1, len(volts))
    shown = volts[1:] if after else volts[:-1]
    counts = np.floor(np.array(angles)[1:-1] / (2 * np.pi) * 8000) / 8000 * 2 * np.pi
    place = Channel(POSITION, "rad", counts, resolution=2 * np.pi / 8000)
    channels = {VOLTAGE: replace(Channel(VOLTAGE, "V", shown), undeclared=NOT_STATED),
                POSITION: replace(place, undeclared=NOT_STATED)}  # fmt: skip
    return Capture(np.rint(stamps * CLOCK_HZ).astype(np.int64), CLOCK_HZ, channels)


def held_row(m: Motor, state: np.ndarray, level: float, step_s: float) -> np.ndarray:
    """The state a row later, in closed form while the motor turns one way; it stops at 0."""
    from scipy.linalg import expm

    turns = float(np.sign(state[1]))
    push = m.K * level / m.R
    way = turns or (float(np.sign(push)) if abs(push) > m.T0 else 0.0)
    if not way:
        return np.array([level / m.R, 0.0, state[2]])
    flow = np.zeros((4, 4))
    flow[0] = [-m.R / m.L, -m.K / m.L, 0.0, level / m.L]
    flow[1] = [m.K / m.J, -m.B / m.J, 0.0, -way * m.T0 / m.J]
    flow[2, 1] = 1.0
    after = np.asarray(expm(flow * step_s) @ np.r_[state, 1.0])[:3]
    if after[1] * way < 0.0:
        return np.array([level / m.R, 0.0, after[2]])
    return after


@pytest.mark.slow
@pytest.mark.parametrize(("after", "words"), [(True, "held until the next"),
                                              (False, "held since the one before")])  # fmt: skip
def test_a_voltage_that_is_held_is_taken_as_held(after: bool, words: str) -> None:
    found = fit([held(after)])
    said = {one.code: one for one in found.diagnostics}
    assert words in said["unstated_lag"].message
    assert "better_model" not in said
    covers(found)
    narrow = found.combinations["JR/(K²+RB)"]
    assert narrow.total is not None
    assert narrow.value is not None
    assert narrow.total < 0.05 * narrow.value
