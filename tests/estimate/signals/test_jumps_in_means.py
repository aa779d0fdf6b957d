"""A voltage logged as means: where it jumped within one of them, and what the grid shows then."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel
from motorid.estimate.signals import jumps_in_means
from motorid.estimate.signals.time_grid import FINEST, lay
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
    begun, levels = jumps_in_means.split(ENDS - PERIOD_S, ENDS, MEANS, MEANS)
    assert len(levels) == COUNT + 2
    for moment in MOMENTS_S:
        assert np.abs(begun - moment).min() < 2e-3 * PERIOD_S
    widths = np.diff(np.append(begun, ENDS[-1]))
    total = np.cumsum(widths * levels)
    np.testing.assert_allclose(total[-1], PERIOD_S * MEANS.sum(), atol=1e-12)


def test_levels_are_as_quiet_as_the_means_beside_a_jump_are_made() -> None:
    quiet = MEANS - NOISE
    begun, levels = jumps_in_means.split(ENDS - PERIOD_S, ENDS, MEANS, quiet)
    told = [LEVELS_V[int(np.sum(at + PERIOD_S / 1e3 >= np.array(MOMENTS_S))) - 1] for at in begun]
    driven = begun > MOMENTS_S[0] - PERIOD_S / 1e3
    np.testing.assert_allclose(levels[driven], np.array(told)[driven], atol=1e-9)
    np.testing.assert_allclose(levels[~driven], 0.0, atol=1e-9)


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

    calm = MEANS - 0.9 * NOISE  # its sum wanders, as that of the means does
    fine = lay(log(calm))
    assert fine.period_s == PERIOD_S / FINEST
    found = sense(log(calm), fine)
    assert found is not None
    edges = ENDS[0] + fine.period_s * np.arange(-1, fine.count)
    true = np.diff(flux(edges)) / fine.period_s
    inside = slice(4, fine.count - 8)
    off = np.cumsum(found.volts[inside] - true[inside]) * fine.period_s
    jump = float(np.abs(np.diff(MEANS)).max())
    assert np.abs(off).max() < 5e-4 * PERIOD_S * jump  # as far as the moments are off


@pytest.mark.parametrize(
    ("volts", "at"),
    [
        ((0, 0, 0, 4, 10, 10, 10, 10), [3]),
        ((0, 0, 0, 4, 10, 10, 10, 10, 10.2, 10.55, 10.55, 10.55), [3, 8]),
        ((0, 0, 0, 4, 10, 10, 10, 10, 10.2, 10.45, 10.45, 10.45), [3]),  # a twentieth is more
        ((0, 0, 0, 10, 10, 10, 10, 10), []),  # at a moment that begins a mean
        ((0, 0, 0, 12, 10, 10, 10, 10), []),  # no mean of both
        ((-1.5, -1.5, 0, 4, 10, 10, 10, 10), [3]),  # a fifth of the jump before it is 2 V
        ((-2.5, -2.5, 0, 4, 10, 10, 10, 10), []),
        ((0, 0, 0, 4, 10, 11.5, 11.5, 11.5), [3]),
        ((0, 0, 0, 4, 10, 12.5, 12.5, 12.5), []),
        ((10, 10, 10, 4, 0, 0, 0, 0), [3]),
    ],
)
def test_a_jump_is_from_a_level_to_another(volts: tuple[float, ...], at: list[int]) -> None:
    """Between levels that last."""
    whole = np.pad(np.array(volts, float), 20, mode="edge")
    assert (jumps_in_means.within(whole) - 20).tolist() == at


@pytest.mark.parametrize(("after", "found"), [(3, []), (4, [3])])
def test_of_eight_readings_one_may_hold_a_jump(after: int, found: list[int]) -> None:
    volts = np.array([0.0, 0.0, 0.0, 4.0] + [10.0] * after)
    assert jumps_in_means.within(volts).tolist() == found


@pytest.mark.parametrize(("mean", "found"), [(0.055, False), (0.08, True), (0.48, False)])
def test_both_parts_of_a_jump_are_more_than_noise(mean: float, found: bool) -> None:
    """Readings that are .01 off by turns: neighbours scatter by .016, four times which is .065."""
    volts = np.where(np.arange(60) < 30, 0.0, 0.5) + 0.01 * (-1.0) ** np.arange(60)
    volts[30] = volts[29] + mean
    assert (jumps_in_means.within(volts).tolist() == [30]) is found


def test_a_mean_is_split_by_the_levels_beside_it() -> None:
    """8 V: three tenths of its 2 s at 1 V, as before it, and seven at 11 V, as after."""
    volts = np.pad([0.0, 0.5, 1.0, 8.0, 11.0, 11.5, 12.0], 20, mode="edge")
    begun = 2.0 * (np.arange(47.0) - 20.0)
    starts, levels = jumps_in_means.split(begun, begun + 2.0, volts, volts)
    assert levels[20:28] == pytest.approx([0.0, 0.5, 1.0, 1.0, 11.0, 11.0, 11.5, 12.0])
    assert starts[20:28] == pytest.approx([0.0, 2.0, 4.0, 6.0, 6.6, 8.0, 10.0, 12.0])
    assert len(levels) == len(starts) == 48


def test_means_without_a_jump_stay_as_they_are() -> None:
    begun, volts = np.arange(40.0), np.full(40, 3.0)
    starts, levels = jumps_in_means.split(begun, begun + 1.0, volts, volts)
    assert starts.tolist() == begun.tolist()
    assert levels.tolist() == volts.tolist()
