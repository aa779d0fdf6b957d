"""A voltage logged as means: where it jumped within one of them, and what the grid shows then."""

from __future__ import annotations

import numpy as np

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel
from motorid.estimate.signals import jumps_in_means
from motorid.estimate.signals.time_grid import FINER, lay
from motorid.estimate.signals.voltage_sensing import sense

PERIOD_S, COUNT = 1e-3, 200
MOMENTS_S, LEVELS_V = (0.0203, 0.0907, 0.15), (6.0, -3.0, 2.0)  # the last is on the grid
ENDS = PERIOD_S * np.arange(1, COUNT + 1)
NOISE = 1e-3 * np.random.default_rng(0).standard_normal(COUNT)


def flux(at_s: np.ndarray) -> np.ndarray:
    """Integral of the true voltage, V·s."""
    since = np.maximum(at_s[:, None] - np.array(MOMENTS_S), 0.0)
    return since @ np.diff(np.array([0.0, *LEVELS_V]))


MEANS = (flux(ENDS) - flux(ENDS - PERIOD_S)) / PERIOD_S + NOISE


def test_a_jump_is_found_at_its_moment_and_its_mean_stays() -> None:
    begun, levels = jumps_in_means.split(ENDS - PERIOD_S, ENDS, MEANS)
    assert len(levels) == COUNT + 2
    for moment in MOMENTS_S:
        assert np.abs(begun - moment).min() < 2e-3 * PERIOD_S
    widths = np.diff(np.append(begun, ENDS[-1]))
    total = np.cumsum(widths * levels)
    np.testing.assert_allclose(total[-1], PERIOD_S * MEANS.sum(), atol=1e-12)


def test_noise_ramps_and_waves_hold_no_jump() -> None:
    for smooth in (0.0 * ENDS, 30.0 * ENDS, np.sin(300.0 * ENDS)):
        assert not len(jumps_in_means.within(smooth + NOISE))
    assert not len(jumps_in_means.within(MEANS[:4]))


def test_a_mean_that_holds_a_jump_is_two_levels_on_the_grid() -> None:
    def log(volts: np.ndarray) -> Capture:
        mean = {"kind": "mean", "aperture_s": PERIOD_S}
        channels = {
            VOLTAGE: Channel(VOLTAGE, "V", volts, **mean),
            CURRENT: Channel(CURRENT, "A", volts, **mean),
        }
        return Capture(np.rint(ENDS * 1e6).astype(np.int64), 1e6, channels)

    fine = lay(log(MEANS))
    assert fine.period_s == PERIOD_S / FINER
    found = sense(log(MEANS), fine)
    assert found is not None
    edges = ENDS[0] + fine.period_s * np.arange(-1, fine.count)
    true = np.diff(flux(edges)) / fine.period_s
    inside = slice(4, fine.count - 8)
    np.testing.assert_allclose(found.volts[inside], true[inside], atol=0.05)
