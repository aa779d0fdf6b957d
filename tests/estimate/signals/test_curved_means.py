"""Means of a voltage that moves within their time, by its true flux and by exact steps of the
motor's linear law.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.linalg import expm

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.signals import curved_means
from motorid.estimate.signals.intersample_voltage import CURVED_MEANS, MEANS, Waveform, of_log
from motorid.estimate.signals.time_grid import Part, Timeline
from tests.six_parameters import fit

Floats = NDArray[np.float64]

R, L, K, B, J, T0 = 0.2, 4e-4, 0.12, 3e-4, 8e-4, 0.06
PERIOD_S, WITHIN = 2e-3, 10  # of a row, which is as long as L/R; steps of the law in it
CORNERS_S = (0.0, 0.1, 0.137, 0.3, 0.4198, 0.6, 0.6552, 0.9, 0.981, 1.2, 1.25, 1.6)
CORNERS_V = (9.0, 9.0, 42.0, 42.0, 12.0, 12.0, 45.0, 45.0, 6.0, 6.0, 32.0, 32.0)


def turned() -> dict[str, Floats]:
    """Means over rows of a voltage that ramps from corner to corner, within rows; the rotor turns
    one way.
    """
    law = np.zeros((7, 7))  # current, speed, their integrals and that of the voltage; voltage, V/s
    law[0, [0, 1, 5]] = -R / L, -K / L, 1 / L
    law[1, [0, 1]] = K / J, -B / J
    law[2, 0] = law[3, 1] = law[4, 5] = law[5, 6] = 1.0
    step_s = PERIOD_S / WITHIN
    drag = np.zeros((8, 8))
    drag[:7, :7], drag[1, 7] = law, -T0 / J
    step = expm(drag * step_s)
    speed = (K * CORNERS_V[0] - R * T0) / (K**2 + R * B)
    state = np.array([(B * speed + T0) / K, speed, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    rows = [state[2:5]]
    for n in range(round(CORNERS_S[-1] / step_s)):
        volts = np.interp([n * step_s, (n + 1) * step_s], CORNERS_S, CORNERS_V)
        state[5:7] = volts[0], np.diff(volts)[0] / step_s
        state = step @ state
        if (n + 1) % WITHIN == 0:
            rows.append(state[2:5].copy())
    amperes, omega, volts = np.diff(rows, axis=0).T / PERIOD_S
    return {VOLTAGE: volts, CURRENT: amperes, SPEED: omega}


def log() -> Capture:
    rng, shown = np.random.default_rng(4), turned()
    noise = {VOLTAGE: 5e-3, CURRENT: 0.03, SPEED: 0.1}
    units = {VOLTAGE: "V", CURRENT: "A", SPEED: "rad/s"}
    channels = {
        name: Channel(
            name, units[name], x + noise[name] * rng.standard_normal(len(x)),
            kind="mean", aperture_s=PERIOD_S,
        )
        for name, x in shown.items()
    }  # fmt: skip
    ticks = np.rint(np.arange(1, len(shown[VOLTAGE]) + 1) * PERIOD_S * 1e9).astype(np.int64)
    return Capture(ticks, 1e9, channels)


@pytest.mark.slow
def test_ramps_in_rows_as_long_as_the_winding_s_time_constant_bias_nothing() -> None:
    found = fit([log()]).parameters
    for name, true in {"R": R, "L": L, "K": K, "J": J}.items():
        assert abs(found[name].value - true) < 3.0 * found[name].total


def over(times: Floats, levels: Floats, at: Floats) -> Floats:
    """V (m,) at times, by the parabolas of levels that begin at ``times``."""
    starts, slopes, bends = curved_means.parabolas(times, levels, 0.1)
    k = np.searchsorted(times, at, side="right") - 1
    past = at - times[k]
    return np.asarray(starts[k] + slopes[k] * past + bends[k] * past**2)


TIMES = np.array([0.0, 1.0, 2.5, 3.0, 4.0, 5.0, 6.0])


def test_a_straight_line_is_told_exactly() -> None:
    steps = np.diff(TIMES, append=7.0)
    levels = 3.0 - 2.0 * (TIMES + steps / 2)
    at = np.linspace(0.0, 5.9, 60)
    assert over(TIMES, levels, at) == pytest.approx(3.0 - 2.0 * at)


def test_every_mean_is_kept_and_neighbours_meet() -> None:
    levels = np.array([1.0, 2.0, 3.0, 4.2, 3.2, 2.1, 1.2])
    for k in range(6):
        mean = quad(lambda t: over(TIMES, levels, np.array([t]))[0], TIMES[k], TIMES[k + 1])[0]
        assert mean / (TIMES[k + 1] - TIMES[k]) == pytest.approx(levels[k])
    before, after = (over(TIMES, levels, TIMES[1:6] + by) for by in (-1e-9, 1e-9))
    assert before == pytest.approx(after, abs=1e-7)


def test_a_jump_is_none_of_a_curve() -> None:
    levels = np.array([1.0, 1.1, 1.2, 9.0, 8.9, 8.8, 8.7])
    times = np.arange(7.0)
    assert curved_means.jumps_alone(levels).tolist() == [3]
    before, after = over(times, levels, np.array([3.0 - 1e-9, 3.0]))
    assert before == pytest.approx(1.25)
    assert after == pytest.approx(9.05)
    lone = np.array([1.0, 1.0, 9.0, 9.0, 9.0])
    assert over(times[:5], lone, np.array([1.5, 2.5])) == pytest.approx([1.0, 9.0])


def test_changes_as_large_on_end_are_a_course() -> None:
    wave = np.sin(2.0 * np.pi * np.arange(236) / 12.0)
    assert not len(curved_means.jumps_alone(wave))
    assert curved_means.move(wave)
    assert not curved_means.move(np.repeat([0.0, 5.0, -3.0, 5.0], 24))


def test_short_levels_and_the_last_stay() -> None:
    times = np.array([0.0, 1.0, 1.05, 2.0])
    starts, slopes, bends = curved_means.parabolas(times, np.array([0.0, 1.0, 2.0, 3.0]), 0.1)
    assert starts[[1, 3]].tolist() == [1.0, 3.0]
    assert not slopes[[1, 3]].any()
    assert not bends[[1, 3]].any()


def test_a_log_s_means_are_those_of_its_parabolas() -> None:
    """Over any grid, with what lies outside of it as before."""
    levels = np.sin(0.7 * np.arange(12.0))
    wave = Waveform(np.arange(12.0), levels, CURVED_MEANS, 1.0)
    line = Timeline(0.25, 40, np.arange(40), (Part(0, 40),), 0.0)
    means = wave.means(line)
    wanted = [
        quad(lambda t: over(wave.time_s, levels, np.array([t]))[0], 0.25 * k, 0.25 * (k + 1))[0]
        for k in range(39)
    ]
    assert 0.25 * means[1:] == pytest.approx(wanted, abs=1e-9)
    assert means[0] == pytest.approx(levels[0])
    assert means[1:37].reshape(-1, 4).mean(axis=1) == pytest.approx(levels[:9])
    behind = wave.means(line, filter_s=0.5) - means  # v + filter dv/dt
    assert 0.25 * behind[1:] == pytest.approx(
        0.5 * np.diff(over(wave.time_s, levels, 0.25 * np.arange(40))), abs=1e-9
    )


def test_only_whoever_asks_for_a_curve_has_one_of_declared_means() -> None:
    capture = log()
    declared = of_log(capture, capture.channels[VOLTAGE], "joined")
    curved = of_log(capture, capture.channels[VOLTAGE], CURVED_MEANS)
    assert declared is not None
    assert curved is not None
    assert (declared.shape, curved.shape) == (MEANS, CURVED_MEANS)
    assert curved.window_s == declared.window_s == pytest.approx(PERIOD_S)
    assert curved.volts == pytest.approx(declared.volts)
    assert not len(curved.jumps)
