"""The figures of blocks: speeds, means, noise and spikes, by numbers made for them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, Capture, Channel
from motorid.segment import blocks
from motorid.segment.blocks import make_blocks, stretches

NAN = float("nan")
SIGMA = 1.4826 / np.sqrt(6)  # of a median of second differences


def of(ticks: list[int] | None = None, **channels: Any) -> Capture:
    made = {
        name: Channel(name, "", np.asarray(values, dtype=float), resolution=resolution)
        for name, (values, resolution) in channels.items()
    }
    count = len(next(iter(made.values())).raw)
    return Capture(np.arange(count) * 10 if ticks is None else np.array(ticks), 1e4, made)


@pytest.mark.parametrize(
    ("usable", "breaks", "found"),
    [
        ([1, 1, 1, 1], [], [(0, 4)]),
        ([0, 1, 1, 0, 1], [], [(1, 3), (4, 5)]),
        ([1, 1, 1, 1], [1, 3], [(0, 1), (1, 3), (3, 4)]),
        ([1, 1, 0, 0, 1], [3, 4], [(0, 2), (4, 5)]),
        ([0, 0], [1], []),
    ],
)
def test_stretches_lie_between_breaks_and_what_cannot_be_used(
    usable: list[int], breaks: list[int], found: list[tuple[int, int]]
) -> None:
    marks = np.array(usable, dtype=bool)
    assert stretches(marks, np.array(breaks, dtype=np.int64)) == found


def test_the_speed_of_a_position_is_its_slope_and_goes_on_at_an_end() -> None:
    capture = of([0, 10, 30, 40, 90], position=([0.0, 2.0, 8.0, 5.0, 6.0], 0.5))
    speeds, floor, power = blocks._sample_speeds(capture, [(0, 3), (3, 5)])
    # by 1 ms, 2 ms and 5 ms; the ends of both runs go on as they were
    assert speeds == pytest.approx([2000.0, 3000.0, 3000.0, 200.0, 200.0])
    assert floor == pytest.approx(0.5 / np.sqrt(6) / 1.5e-3)  # of the usual period
    assert power == 1.0


def test_a_run_of_the_first_sample_alone_has_its_own_slope() -> None:
    capture = of(position=([0.0, 2.0, 4.0], 0.0))
    speeds, _, _ = blocks._sample_speeds(capture, [(0, 1), (1, 3)])
    assert speeds == pytest.approx([2000.0] * 3)


def test_the_speed_of_a_speed_channel_is_its_own() -> None:
    capture = of(speed=([1.0, 4.0, 9.0], 0.6), position=([0.0, 0.0, 0.0], 1.0))
    speeds, floor, power = blocks._sample_speeds(capture, [(0, 3)])
    assert speeds.tolist() == [1.0, 4.0, 9.0]
    assert (floor, power) == (pytest.approx(3.1 / np.sqrt(12)), 0.0)  # 5 % of the way to 5 from 3


@pytest.mark.parametrize(
    ("values", "declared", "step"),
    [
        ([0.0, 2.0, 2.0, 0.0, NAN, 5.0], 0.5, 2.0),
        ([0.0, 2.0, 4.0], 3.0, 3.0),
        ([1.0, 1.0], 0.25, 0.25),
    ],
)
def test_a_channel_s_step_is_as_declared_or_as_seen(
    values: list[float], declared: float, step: float
) -> None:
    assert blocks._quantum(Channel(SPEED, "", np.array(values), resolution=declared)) == step


def test_means_of_blocks_pass_over_missing_readings() -> None:
    values = np.array([1.0, 3.0, NAN, 6.0, 8.0])
    start, stop = np.array([0, 2, 3]), np.array([2, 3, 5])
    assert blocks._means(values, start, stop) == pytest.approx([2.0, 0.0, 7.0])


@pytest.mark.parametrize(("lag", "period"), [(1, 2), (4, 8)])
def test_the_noise_is_that_of_second_differences(lag: int, period: int) -> None:
    ripple = np.where(np.arange(400) % period < lag, 1.0, -1.0)
    noise = blocks._noise(3.0 + 0.5 * np.arange(400) + ripple, 1)
    assert noise == pytest.approx(4.0 * SIGMA)  # each is 1 + 2 + 1


def test_a_straight_course_has_no_noise_and_a_jump_is_none() -> None:
    course = np.r_[np.arange(50.0), 1000.0 - 3.0 * np.arange(50.0)]
    assert blocks._noise(course, 1) == pytest.approx(0.0, abs=1e-9)
    assert blocks._noise(np.array([0.0, 5.0, 0.0, 5.0]), 1) == 0.0  # too few to say


def test_the_noisiest_part_counts_where_there_are_several() -> None:
    ripple = np.where(np.arange(400) % 2, 1.0, -1.0)
    ripple[:300] = 0.0
    assert blocks._noise(ripple, 1) == 0.0
    assert blocks._noise(ripple, 32) == pytest.approx(4.0 * SIGMA)
    assert blocks._noise(ripple[230:330], 32) == pytest.approx(
        0.0
    )  # of one part alone: most is calm


@pytest.mark.parametrize(
    ("triple", "joined", "cleaned"),
    [
        ([0.0, 9.0, 1.0], [1, 1], 1.0),  # the middle one of the three
        ([0.0, -9.0, 1.0], [1, 1], 0.0),
        ([0.0, 7.9, 1.0], [1, 1], 7.9),  # within eight deviations
        ([0.0, 13.0, 3.1], [1, 1], 13.0),  # which does not come back
        ([0.0, 13.0, 2.5], [1, 1], 2.5),
        ([0.0, 9.0, 1.0], [0, 1], 9.0),  # beside a gap
        ([0.0, 9.0, 1.0], [1, 0], 9.0),
    ],
)
def test_a_single_block_that_no_shaft_can_do_takes_the_middle_value(
    triple: list[float], joined: list[int], cleaned: float
) -> None:
    limit = 0.999 if cleaned != 7.9 else 1.0
    found = blocks._without_spikes(np.array(triple), np.array(joined, dtype=bool), limit)
    assert found.tolist() == [triple[0], cleaned, triple[2]]


def test_quiet_samples_are_blocks_of_their_own() -> None:
    capture = of(speed=(np.linspace(0.0, 100.0, 200), 0.0))
    found = make_blocks(capture, [(0, 120), (150, 200)])
    assert len(found.start) == 170
    assert (found.stop - found.start == 1).all()
    assert np.flatnonzero(~found.joined).tolist() == [119]
    assert found.time_s[[0, 120]] == pytest.approx([0.0, 0.15])
    assert found.speed.mean == pytest.approx(capture.channels[SPEED].values[found.start])
    assert found.speed.scale == pytest.approx(np.percentile(found.speed.mean, 99.5))
    assert found.still == pytest.approx(0.005 * found.speed.scale)
    assert (found.drive, found.drive_samples, found.drive_zero) == (None, None, None)


def test_noise_makes_blocks_longer_up_to_a_ninety_sixth() -> None:
    speed = np.random.default_rng(4).normal(0.0, 1.0, 960)
    found = make_blocks(of(speed=(speed, 0.0)), [(0, 960)])
    assert (found.stop - found.start == 10).all()
    assert found.speed.mean == pytest.approx(speed.reshape(96, 10).mean(axis=1), abs=3.0)


def test_a_position_s_steps_are_smaller_in_a_longer_block() -> None:
    # 1000 counts a second at 1 kHz: a step of one is 1/sqrt(6) of the speed in a sample's slope
    capture = of(position=(np.arange(960.0), 1.0))
    found = make_blocks(capture, [(0, 960)])
    size = int(found.stop[0] - found.start[0])
    assert 1 / np.sqrt(6) / size <= 0.02 or size == 10
    assert found.speed.sigma == pytest.approx(1000.0 / np.sqrt(6) / size)


def test_rest_is_within_a_speed_channel_s_step() -> None:
    found = make_blocks(of(speed=(np.tile([0.0, 3.0], 100), 3.0)), [(0, 200)])
    assert found.still == 3.0


@pytest.mark.parametrize("name", [CURRENT, TORQUE])
def test_a_drive_is_without_its_middle_and_a_torque_s_zero_is_known(name: str) -> None:
    values = np.r_[np.full(60, 2.0), np.full(90, 5.0), np.full(50, 7.0)]
    channels: dict[str, Any] = {POSITION: (np.arange(200.0), 0.0), name: (values, 0.1)}
    found = make_blocks(of(**channels), [(0, 200)])
    assert found.drive is not None
    assert found.drive.mean == pytest.approx(values - 5.0)
    assert found.drive.sigma == pytest.approx(0.1 / np.sqrt(12))
    assert found.drive_samples == pytest.approx(values - 5.0)
    assert found.drive_zero == (None if name == CURRENT else -5.0)


@pytest.mark.parametrize(("height", "seen"), [(0.11, False), (0.12, True)])
def test_a_drive_that_hardly_changes_says_nothing(height: float, seen: bool) -> None:
    # four times .1/sqrt(12) is .1155
    current = np.r_[np.zeros(100), np.full(100, height)]
    found = make_blocks(of(speed=(np.arange(200.0), 0.0), current=(current, 0.1)), [(0, 200)])
    assert (found.drive is not None) is seen
    assert (found.drive_samples is not None) is seen


def test_the_current_drives_where_a_torque_is_known_too() -> None:
    both = of(torque=([1.0], 0.0), current=([1.0], 0.0))
    assert blocks.drive_channel(both) is both.channels[CURRENT]
    alone = of(torque=([1.0], 0.0))
    assert blocks.drive_channel(alone) is alone.channels[TORQUE]
    assert blocks.drive_channel(of(speed=([1.0], 0.0))) is None
