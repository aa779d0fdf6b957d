"""Noise of a drive and of a motion, and jumps between readings, on readings by turns."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, Capture, Channel, Wiring
from motorid.errors import DataError
from motorid.estimate.partial.mechanical_signals import (
    COASTING,
    JUMPS,
    Motion,
    fresh,
    noise,
    of_capture,
)

Floats = NDArray[np.float64]
COUNT, H = 400, 1e-3
BY_TURNS = (-1.0) ** np.arange(COUNT)
SCATTER = 4.0 / np.sqrt(6.0)  # of readings that are a unit off by turns


def capture(gear: float = 1.0, path: str | None = None, **channels: Any) -> Capture:
    units = {CURRENT: "A", SPEED: "rad/s", POSITION: "rad"}
    made = {
        n: c if isinstance(c, Channel) else Channel(n, units[n], np.asarray(c, float))
        for n, c in channels.items()
    }
    return Capture(np.arange(COUNT) * 1000, 1e6, made, wiring=Wiring(gear_ratio=gear), path=path)


def driven(drive: Floats, quantum: float = 0.0) -> Motion:
    """At 100 rad/s throughout, but for a start from rest."""
    speed = np.where(np.arange(COUNT) < 20, 0.0, 100.0)
    return of_capture(
        capture(speed=speed, current=Channel(CURRENT, "A", drive, resolution=quantum)), CURRENT
    )


@pytest.mark.parametrize(("quantum", "sd"), [(0.0, 0.1 * SCATTER), (2.0, 2.0 / np.sqrt(12.0))])
def test_a_drive_scatters_by_its_readings_or_their_rounding(quantum: float, sd: float) -> None:
    assert driven(0.1 * BY_TURNS, quantum).drive_noise == pytest.approx(sd, rel=1e-3)


def test_eight_readings_tell_a_noise() -> None:
    assert noise(BY_TURNS[:8]) == pytest.approx(SCATTER, rel=1e-3)
    assert noise(BY_TURNS[:7]) == 0.0


@pytest.mark.parametrize(("times", "counts"), [(0.9, False), (1.1, True)])
def test_a_jump_bends_the_drive_by_more_than_its_noise(times: float, counts: bool) -> None:
    """At both ends. One of D anywhere in a period H: D² H² / 12 over the length of the stretch."""
    sd = 1.0 / np.sqrt(12.0)  # of a quantum of 1
    high = times * JUMPS * np.sqrt(6.0) * sd
    jump = np.where(np.arange(COUNT) >= 200, high, 0.0)
    length = (COUNT - 20 - 1) * H
    found = driven(jump, 1.0).jumps_variance(0.02)
    assert found == pytest.approx(high**2 * H**2 / 12.0 / length if counts else 0.0)


@pytest.mark.parametrize("at", [20, COUNT - 1])
def test_a_jump_at_an_end_of_a_stretch_bends_once(at: int) -> None:
    """Before its first reading, or in its last period, nobody tells it from a ramp."""
    jump = np.where(np.arange(COUNT) >= at, 5.0, 0.0)
    assert driven(jump).jumps_variance(0.02) == 0.0


def test_where_nothing_turns_no_jump_counts() -> None:
    wave = 1e-3 * BY_TURNS
    still = of_capture(capture(speed=wave, current=wave), CURRENT)
    assert still.stretches(0.02) == []
    assert still.jumps_variance(0.02) == 0.0


@pytest.mark.parametrize("gear", [1.0, 3.0])
def test_a_position_has_its_quantum_at_the_shaft_and_a_speed_its_own(gear: float) -> None:
    angle = Channel(POSITION, "rad", np.arange(COUNT) * 0.1, resolution=0.02)
    turned = of_capture(capture(gear, position=angle, current=BY_TURNS), CURRENT)
    assert (turned.angle_quantum, turned.speed_quantum) == pytest.approx((0.02 * gear, 0.0))
    speed = Channel(SPEED, "rad/s", np.arange(float(COUNT)), resolution=0.5)
    read = of_capture(capture(gear, speed=speed, current=BY_TURNS), CURRENT)
    assert (read.angle_quantum, read.speed_quantum) == pytest.approx((0.0, 0.5 * gear))


@pytest.mark.parametrize(("path", "name"), [(None, "the capture"), ("a.csv", "a.csv")])
def test_what_cannot_be_used_is_named(path: str | None, name: str) -> None:
    with pytest.raises(DataError, match=f"^{name} lacks current"):
        of_capture(capture(path=path, speed=BY_TURNS), CURRENT)
    with pytest.raises(DataError, match=f"^{name}: speed never changes"):
        of_capture(capture(path=path, speed=np.ones(COUNT)), COASTING)


def test_a_reading_that_is_repeated_once_is_new_every_second_time() -> None:
    twice = Channel(SPEED, "rad/s", np.repeat(np.arange(30.0), 2)[1:])
    kept = np.arange(59)
    assert fresh(kept, twice, {SPEED: 2}).tolist() == list(range(1, 59, 2))
    assert fresh(kept, twice, {SPEED: 1}) is kept
    assert fresh(kept, twice, {}) is kept


def test_a_top_speed_is_of_a_position_over_some_samples() -> None:
    """A count to and fro is no speed; over 16 periods and more it is next to nothing."""
    steady = 100.0 * H * np.arange(COUNT) + 0.05 * BY_TURNS
    motion = of_capture(capture(position=steady, current=BY_TURNS), CURRENT)
    assert motion.top_speed == pytest.approx(100.0, rel=0.1)
    fast = np.where(np.abs(np.arange(COUNT) - 200) < 20, 100.0 * H, 0.0).cumsum()
    burst = of_capture(capture(position=fast, current=BY_TURNS), CURRENT)
    assert burst.top_speed == pytest.approx(100.0, rel=0.05)  # of 39 samples
