"""What is read from the residuals of steady running, by signals made for it."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.results.estimate import Curve
from motorid.quality.ripple import (
    BUSY,
    NEAR,
    SLOW,
    Window,
    _of_run,
    brush_noise,
    segment_ripple,
)

RESISTANCE, LEVEL, SEGMENTS = 2.0, 6.0, 5


@pytest.mark.parametrize("bad", [0, 3])
def test_the_segment_that_departs_is_named_with_the_share_of_its_current(bad: int) -> None:
    angle = np.linspace(0.0, 20 * np.pi, 5000, endpoint=False)
    place = (angle * SEGMENTS / (2 * np.pi)).astype(int) % SEGMENTS
    current = 1e-3 * np.random.default_rng(1).standard_normal(len(angle))
    current[place == bad] += 0.06
    window = Window(angle, current, np.zeros_like(angle), LEVEL, 0.5, 100.0)
    back = Window(-angle - 1e-9, np.zeros_like(angle), np.zeros_like(angle), -LEVEL, -0.5, -100.0)
    relative, sd, worst = segment_ripple([window], RESISTANCE, SEGMENTS)
    assert worst == bad
    assert relative == pytest.approx(0.06 * RESISTANCE / LEVEL, abs=4 * sd)
    assert sd < 0.1 * relative
    halved, _, _ = segment_ripple([window, back], RESISTANCE, SEGMENTS)
    assert halved == pytest.approx(relative / 2, rel=0.05)  # of two windows, one departs


def test_brush_noise_leaves_out_moments_of_much_current() -> None:
    """Where fewer than half of the samples around carry current, their mean is no slow course."""
    rng = np.random.default_rng(2)
    flowing, hump = 4000, SLOW // 2 - 4
    quiet = np.full(400, 0.9 * BUSY)
    fitted = np.concatenate((np.ones(flowing), np.linspace(1.0, 0.9 * BUSY, 200), quiet))
    brief = slice(flowing + 400, flowing + 400 + hump)
    fitted[brief] = 1.1 * BUSY
    error = 0.01 * fitted * rng.standard_normal(len(fitted))
    error[brief] += 0.5 * (-1.0) ** np.arange(hump)
    curve = Curve(0, "current", "A", np.arange(len(fitted)) * 1e-4, fitted + error, fitted, 0.01)
    rms, sd = brush_noise(curve)
    assert rms == pytest.approx(0.01, rel=0.1)
    assert sd == pytest.approx(rms / np.sqrt(flowing), rel=0.05)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_window_begins_where_the_speed_is_near_its_last(sign: float) -> None:
    """A motor that runs up to 200 rad/s at 6 V, after a rest, and then coasts."""
    R, K, tau = 2.0, 0.02, 0.05
    time = np.arange(3000) * 1e-3
    on = (time >= 0.5) & (time < 2.5)
    speed = np.where(on, 200.0 * (1 - np.exp(-(time - 0.5) / tau)), 0.0)
    speed = np.where(time >= 2.5, 200.0 * np.exp(-(time - 2.5) / 1.0), speed)
    current = np.where(on, (6.0 - K * speed) / R, 0.0)
    angle = np.cumsum(speed) * 1e-3
    amps = Curve(0, "current", "A", time, sign * (current + 0.01), sign * current, 0.01)
    turned = Curve(0, "position", "rad", time, sign * angle, sign * angle, 1e-3)
    (found,) = _of_run(amps, turned, R, K)
    near = on & (speed > (1 - NEAR) * 200.0)
    assert len(found.angle) == pytest.approx(near.sum(), abs=5)
    assert abs(found.angle[0]) == pytest.approx(angle[near][0], abs=1.0)
    assert found.level == pytest.approx(sign * 6.0, rel=1e-3)
    assert found.speed == pytest.approx(sign * 199.5, rel=5e-3)
    assert found.mean_current == pytest.approx(sign * current[near].mean(), rel=0.02)
    assert found.current == pytest.approx(np.full(len(found.angle), sign * 0.01))
