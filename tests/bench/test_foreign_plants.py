"""Plants that are not ours obey what is claimed of them, and their captures show what they did."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.foreign import drawn, joint, spice
from bench.foreign.chain import Trace, capture, seconds
from bench.foreign.drawn import Rig
from bench.foreign.score import How, line, score, table
from bench.iron import Iron, present
from motorid.capture.model import CURRENT, POSITION, VOLTAGE

LEFT = 3e-3  # of the largest angular momentum or flux, which a plant's integrator may miss
IRON = Iron(reaction=0.08, bend=0.2, saturation=0.5, eddy=0.4, windage=0.4, load_friction=0.04)


def grown(time_s: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """The integral of ``rate``."""
    return np.concatenate([[0.0], np.cumsum(np.diff(time_s) * (rate[1:] + rate[:-1]) / 2)])


def left(grew: np.ndarray, state: np.ndarray) -> float:
    """The largest difference of both, over the largest state."""
    return float(np.abs(grew - state).max() / np.abs(state).max())


def pull(rig: Rig, trace: Trace, creep: float) -> np.ndarray:
    """The sum of all torques by the definitions of ``drawn``."""
    motor, iron, i, w = rig.truth, rig.iron, trace.current, trace.speed
    bend = iron.bend * rig.stall_a
    reach = np.hypot(rig.stall_a, bend) - bend
    torque = motor["K"] * (1 - iron.reaction * (np.hypot(i, bend) - bend) / reach) * i
    windage = iron.windage * motor["B"] / rig.idle_rad_s * np.abs(w)
    dry = motor["T0"] + iron.load_friction * np.abs(torque)
    return np.asarray(torque - (motor["B"] + windage) * w - dry * np.tanh(w / creep))


@pytest.mark.slow
@pytest.mark.parametrize("iron", [Iron(), IRON])
def test_a_netlist_obeys_the_motor_that_is_claimed(tmp_path: Path, iron: Iron) -> None:
    if not spice.available():
        pytest.skip("no ngspice")
    rig = replace(drawn.shortened(drawn.draw(1)), iron=iron)
    trace = spice.run(rig, tmp_path)
    assert trace.time_s[-1] == pytest.approx(seconds(rig))
    assert min(trace.speed.max(), -trace.speed.min()) > 0.1 * rig.idle_rad_s
    torque = pull(rig, trace, 1e-3 * rig.idle_rad_s)
    assert left(grown(trace.time_s, torque), rig.truth["J"] * trace.speed) < LEFT
    if iron == Iron() and rig.sense == "terminals":
        motor = rig.truth
        volts = trace.sensed - motor["R"] * trace.current - motor["K"] * trace.speed
        flux = grown(trace.time_s, np.where(np.abs(trace.current) > 1e-6, volts, 0.0))
        assert left(flux, motor["L"] * trace.current) < 0.05  # over edges of some nanoseconds


@pytest.mark.slow
def test_a_hinge_of_mujoco_obeys_the_motor_that_is_claimed(tmp_path: Path) -> None:
    if not joint.available():
        pytest.skip("no mujoco")
    shape = Iron(windage=0.4, load_friction=0.04)
    rig = replace(drawn.shortened(drawn.draw(2, pwm=False)), iron=shape)
    trace = joint.run(rig, tmp_path)
    torque = pull(rig, trace, 1e-9)
    assert left(grown(trace.time_s, torque), rig.truth["J"] * trace.speed) < LEFT


def turning(rig: Rig) -> Trace:
    """A made-up motion: a current that rises, a voltage that alternates fast, a steady speed."""
    time = np.linspace(0.0, seconds(rig), 200_001)
    wave = np.sin(2 * np.pi * time / rig.voltage.aperture_s)
    ones = np.ones_like(time)
    return Trace(time, rig.stall_a * time, 3.0 + wave, 50.0 * ones)


def exact(channel: drawn.Channel) -> drawn.Channel:
    return replace(channel, true_gain=1.0, true_offset=0.0, noise=0.0,
                   true_delay_s=channel.delay_s)  # fmt: skip


def test_a_capture_shows_means_over_the_declared_windows() -> None:
    rig = drawn.shortened(drawn.draw(2))
    rig = replace(rig, current=exact(rig.current), voltage=exact(rig.voltage), clock_error=0.0)
    shown = capture(rig, turning(rig))
    current = shown.channels[CURRENT]
    middle = shown.ticks / shown.clock_hz - current.delay_s - current.aperture_s / 2
    assert np.abs(current.values - rig.stall_a * middle).max() < 0.51 * current.scale
    assert np.abs(shown.channels[VOLTAGE].values - 3.0).max() < shown.channels[VOLTAGE].scale
    turned = shown.channels[POSITION].values
    assert np.abs(turned - 50.0 * shown.time_s).max() < 1.1 * shown.channels[POSITION].scale


def test_what_is_wrong_of_a_converter_is_in_its_readings() -> None:
    rig = drawn.shortened(drawn.draw(2))
    rig = replace(rig, current=exact(rig.current), clock_error=0.0)
    wrong = replace(rig, current=replace(rig.current, true_gain=1.02, true_offset=3.0))
    right, off = (capture(one, turning(rig)).channels[CURRENT].values for one in (rig, wrong))
    assert np.abs(off - 1.02 * right - 3.0 * rig.current.scale).max() < 1.1 * rig.current.scale


@pytest.mark.parametrize("seed", range(1, 20))
def test_a_drawn_rig_says_of_itself_what_its_uncertainties_allow(seed: int) -> None:
    rig = drawn.draw(seed, effects=True)
    assert 1 <= len(present(rig.iron)) <= 3
    assert abs(rig.stated_bridge_ohm - rig.bridge_ohm) < 4 * rig.bridge_u
    assert abs(rig.voltage.true_gain - 1) < 4 * rig.voltage.gain_u
    assert rig == drawn.draw(seed, effects=True)


def test_a_rig_that_breaks_is_a_line_and_no_value(monkeypatch: Any) -> None:
    def broken(*_: Any) -> Trace:
        raise spice.SpiceError("step 3: Timestep too small")

    monkeypatch.setitem(score.__globals__["PLANTS"], "spice", broken)
    rows = [score(1, How("spice", short=True))]
    assert "Timestep too small" in line(rows[0])
    assert "all parameters: 0 of 0 hold" in table(rows)
