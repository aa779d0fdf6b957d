"""Rows of the momentum balance, and their regression, for a motion that is known in closed form."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.partial import (
    block_bootstrap_regression,
    mechanical_remarks,
    mechanical_signals,
    modulating_functions,
    open_circuit_coastdown,
    steady_state_table,
)
from motorid.estimate.partial.mechanical_signals import Motion

Floats = NDArray[np.float64]
A, B, C = 2e-4, 5e-3, 0.04  # drive = a dω/dt + b ω + c sign ω
N, H = 4000, 1e-3
TRUTH = np.array([A, B, C, 0.0])


def swinging(noise: float = 0.0) -> Capture:
    """ω = 100 sin + a little more, and the current that the balance asks for."""
    time = np.arange(N) * H
    speed = 100.0 * np.sin(2 * np.pi * time) + 20.0 * np.sin(7 * np.pi * time)
    slope = 200 * np.pi * np.cos(2 * np.pi * time) + 140 * np.pi * np.cos(7 * np.pi * time)
    drive = A * slope + B * speed + C * np.sign(speed)
    drive = drive + np.random.default_rng(2).normal(0.0, 1.0, N) * noise
    ticks = np.round(time * 1e6).astype(np.int64)
    channels = {SPEED: Channel(SPEED, "rad/s", speed), CURRENT: Channel(CURRENT, "A", drive)}
    return Capture(ticks=ticks, clock_hz=1e6, channels=channels)


def rows(noise: float = 0.0, half_s: float = 0.05) -> modulating_functions.Rows:
    motion = mechanical_signals.of_capture(swinging(noise), CURRENT)
    return modulating_functions.build([motion], half_s)


@pytest.mark.parametrize("half_s", [0.03, 0.06])
def test_every_row_holds_for_the_true_coefficients(half_s: float) -> None:
    found = rows(half_s=half_s)
    assert len(found) > 20
    size = np.sqrt(np.mean(found.drive**2))
    assert np.abs(found.drive - found.matrix @ TRUTH).max() < 0.01 * size


def test_regression_finds_them_and_its_uncertainty_is_honest() -> None:
    found = rows(noise=0.02)
    known = np.zeros(4)
    one = block_bootstrap_regression.solve(found, np.array([1, 1, 1, 0], dtype=bool), known, 0.05)
    off = (one.coefficients - TRUTH)[:3] / one.sigma[:3]
    assert np.abs(off).max() < 4.0
    assert one.sigma[1] < 0.2 * B
    assert one.coefficients[3] == 0.0


def test_a_friction_below_nothing_is_held_at_nothing() -> None:
    found = rows()
    less = replace(found, drive=found.drive - found.matrix @ np.array([0.0, 1.02 * B, 0.0, 0.0]))
    wanted = np.array([1, 1, 1, 0], dtype=bool)
    one = block_bootstrap_regression.solve(less, wanted, np.zeros(4), 0.05)
    assert one.coefficients[1] == 0.0
    assert one.at_bound.tolist() == [False, True, False, False]


def test_blocks_are_neither_few_nor_many() -> None:
    labels = block_bootstrap_regression.blocks(rows())
    assert 2 <= labels.max() + 1 <= block_bootstrap_regression.MOST_BLOCKS
    assert set(labels.tolist()) == set(range(labels.max() + 1))


def test_the_best_of_widths_carries_what_its_neighbours_say() -> None:
    wanted = np.array([1, 1, 1, 0], dtype=bool)

    def fit(half: float) -> block_bootstrap_regression.Regression | None:
        if half > 0.09:
            return None
        return block_bootstrap_regression.solve(rows(0.02, half), wanted, np.zeros(4), half)

    best = block_bootstrap_regression.choose_width([0.03, 0.06, 0.1], fit)
    assert best is not None
    alone = fit(best.half_width_s)
    assert alone is not None
    assert (best.sigma >= alone.sigma - 1e-15).all()
    assert block_bootstrap_regression.choose_width([0.1], fit) is None


def test_second_differences_tell_white_noise() -> None:
    rng = np.random.default_rng(1)
    smooth = np.sin(np.linspace(0.0, 3.0, 20_000))
    found = mechanical_signals.noise(smooth + rng.normal(0.0, 0.01, 20_000))
    assert found == pytest.approx(0.01, rel=0.03)
    assert mechanical_signals.noise(np.arange(7.0)) == 0.0


def test_a_motion_is_split_where_it_turns_back() -> None:
    motion = mechanical_signals.of_capture(swinging(), CURRENT)
    found = motion.stretches(0.05)
    signs = [s.sign for s in found]
    assert all(a == -b for a, b in pairwise(signs))
    speed = motion.speed(0.05)
    for s in found:
        assert (np.sign(speed[s.slice]) == s.sign).all()


def test_what_is_missing_is_said() -> None:
    capture = swinging()
    with pytest.raises(DataError, match="lacks terminal_voltage"):
        mechanical_signals.of_capture(capture, VOLTAGE)
    still = replace(capture.channels[SPEED], raw=np.ones(N))
    stands = replace(capture, channels={**capture.channels, SPEED: still})
    assert mechanical_signals.stands_still(stands)
    with pytest.raises(DataError, match="never changes"):
        mechanical_signals.of_capture(stands, CURRENT)
    assert mechanical_signals.drive_of(capture.channels) == CURRENT


def test_a_good_fit_is_no_lack_of_fit_and_a_fan_is_suspected() -> None:
    wanted = np.array([1, 1, 1, 0], dtype=bool)

    def remarks(more: float) -> dict[str, str]:
        capture = swinging(0.02)
        speed, current = capture.channels[SPEED], capture.channels[CURRENT]
        drive = current.raw + more * speed.raw * np.abs(speed.raw)
        channels = {SPEED: speed, CURRENT: replace(current, raw=drive)}
        capture = replace(capture, channels=channels)
        motion = mechanical_signals.of_capture(capture, CURRENT)
        found = modulating_functions.build([motion], 0.05)
        best = block_bootstrap_regression.solve(found, wanted, np.zeros(4), 0.05)
        return {d.code: d.message for d in mechanical_remarks.find([capture], [motion], best)}

    assert "lack_of_fit" not in remarks(0.0)
    assert "grows with the square of speed" in remarks(2e-4)["lack_of_fit"]
    assert "gain_undeclared" in remarks(0.0)
    assert mechanical_remarks.standing_still(2).message.startswith("2 captures were")


@pytest.mark.parametrize("constant", [None, 0.02])
def test_an_open_motor_is_its_own_tachometer(constant: float | None) -> None:
    volts = Channel(VOLTAGE, "V", np.linspace(2.0, 0.0, 50), scale=2.0, resolution=0.01, noise=0.02)
    capture = Capture(ticks=np.arange(50), clock_hz=1e3, channels={VOLTAGE: volts})
    assert open_circuit_coastdown.is_tachometer(capture)
    speed = open_circuit_coastdown.speed_from_voltage(capture, constant).channels[SPEED]
    K = constant or 1.0
    assert speed.values == pytest.approx(volts.values / K)
    assert (speed.resolution, speed.noise) == pytest.approx((0.01 / K, 0.02 / K))
    assert not open_circuit_coastdown.is_tachometer(swinging())
    assert open_circuit_coastdown.speed_from_voltage(swinging(), 1.0).channels.keys() == {
        SPEED, CURRENT,
    }  # fmt: skip


def test_a_record_in_time_is_no_table() -> None:
    assert not steady_state_table.suits([swinging()])


def test_three_runs_that_differ_widen_what_they_tell() -> None:
    """Leaving out one run at a time shows how runs differ; two runs do not."""
    one = rows(0.02)
    brakes = 0.1 * B * one.matrix[:, 1]
    moved = [
        replace(one, capture=np.full(len(one), k), stretch=one.stretch + 100 * k,
                drive=one.drive + k * brakes) for k in range(3)
    ]  # fmt: skip

    def regressed(count: int) -> block_bootstrap_regression.Regression:
        names = modulating_functions.Rows.__dataclass_fields__
        joined = modulating_functions.Rows(
            *(np.concatenate([getattr(part, name) for part in moved[:count]]) for name in names)
        )
        wanted = np.array([1, 1, 1, 0], dtype=bool)
        return block_bootstrap_regression.solve(joined, wanted, np.zeros(4), 0.05)

    alone = [block_bootstrap_regression.solve(m, np.array([1, 1, 1, 0], bool), np.zeros(4), 0.05)
             .coefficients[1] for m in moved]  # fmt: skip
    mean = float(np.mean(alone))
    left_out = [(sum(alone) - x) / 2 for x in alone]
    jackknife = np.sqrt(2 / 3 * sum((x - mean) ** 2 for x in left_out))
    assert regressed(3).sigma[1] == pytest.approx(jackknife, rel=0.05)
    assert regressed(2).sigma[1] < 0.5 * jackknife


def test_a_variance_is_widened_where_the_other_is_larger() -> None:
    mine = np.array([[4.0, 1.0, 0.0], [1.0, 9.0, 0.0], [0.0, 0.0, 0.0]])
    theirs = np.diag([16.0, 1.0, 5.0])
    found = block_bootstrap_regression.at_least(mine, theirs)
    assert found == pytest.approx(np.array([[16.0, 2.0, 0.0], [2.0, 9.0, 0.0], [0.0, 0.0, 0.0]]))


def test_at_a_bound_a_variance_is_what_it_would_be_without_it() -> None:
    found = rows(noise=0.02)
    less = replace(found, drive=found.drive - found.matrix @ np.array([0.0, 1.5 * B, 0.0, 0.0]))
    wanted = np.array([1, 1, 1, 0], dtype=bool)
    one = block_bootstrap_regression.solve(less, wanted, np.zeros(4), 0.05)
    free = block_bootstrap_regression._estimate(
        less, block_bootstrap_regression.blocks(less), wanted, np.zeros(4)
    )
    assert one.coefficients[1] == 0.0
    assert one.sigma[1] == pytest.approx(np.sqrt(free[1][1, 1]))
    assert one.freedom == len(np.unique(block_bootstrap_regression.blocks(less))) - 1
    assert one.residual == pytest.approx(less.drive - less.matrix @ one.coefficients)


@pytest.mark.parametrize("start", [0, 500, 1400])
def test_a_bump_covers_enough_samples_wherever_it_lies(start: int) -> None:
    motion = mechanical_signals.of_capture(swinging(), CURRENT)
    fewest = modulating_functions.FEWEST_SAMPLES
    speed, half = motion.speed(0.05), H * 20.0
    centre = motion.time_s[start] + half
    for covered in (fewest - 1, fewest, fewest + 3):
        stretch = mechanical_signals.Stretch(start, start + covered, 1)
        line = modulating_functions._line(motion, stretch, speed, centre, half)
        assert (line is not None) is (covered >= fewest)


def test_a_drive_that_acts_later_is_weighed_where_it_acts() -> None:
    """Rows of a drive that reads what acted some samples before are those of the drive itself."""
    n, step = 900, 1e-3
    time = step * np.arange(n)
    drive = 5.0 + np.sin(2 * np.pi * 3.1 * time) + 0.5 * np.cos(2 * np.pi * 7.0 * time)
    speed = 50.0 + 5.0 * np.sin(2 * np.pi * 2.0 * time)

    def motion(read: Floats, late_s: float = 0.0) -> Motion:
        return Motion(
            time, read, (speed[1:] + speed[:-1]) / 2 * step, speed, np.zeros(n - 1, bool),
            "current", "A", False, False, 0.0, 0.0, 0.0, 0.0, late_s,
        )  # fmt: skip

    true = modulating_functions.build([motion(drive)], 0.05)
    for samples in (3, -3):
        read = np.roll(drive, -samples)  # each reading is of what acts so much later
        found = modulating_functions.build([motion(read, samples * step)], 0.05)
        kept = np.isin(true.time_s, found.time_s)
        assert len(true) - 2 <= kept.sum() < len(true)
        inside = slice(1, -1)
        np.testing.assert_allclose(found.drive[inside], true.drive[kept][inside], rtol=1e-6)
        np.testing.assert_allclose(found.matrix, true.matrix[kept])
    little = 1e-5
    sides = (little, -little)
    later, before = (modulating_functions.build([motion(drive, s)], 0.05) for s in sides)
    change = np.interp(later.time_s, before.time_s, before.drive) - later.drive
    np.testing.assert_allclose(
        change[1:-1], 2 * little * np.interp(later.time_s, true.time_s, true.late)[1:-1], atol=1e-7
    )


def test_a_bump_whose_drive_lies_across_a_gap_is_left_out() -> None:
    n, step = 400, 1e-3
    broken = np.zeros(n - 1, dtype=bool)
    broken[200] = True
    speed = np.full(n, 50.0)
    one = Motion(step * np.arange(n), speed / 10, speed[1:] * step, speed, broken, "current", "A",
                 False, False, 0.0, 0.0, 0.0, 0.0)  # fmt: skip
    all_rows = modulating_functions.build([one], 0.02)
    late = modulating_functions.build([replace(one, drive_late_s=5 * step)], 0.02)
    lost = set(np.round(all_rows.time_s, 6)) - set(np.round(late.time_s, 6))
    assert len(lost) == 2  # the first of either side of the gap
    assert min(abs(t - 0.2) for t in lost) < 0.05
