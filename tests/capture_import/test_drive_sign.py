"""Drives that a log holds as magnitudes get the sign of the motion."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.drive_sign import signs_of, with_sign
from motorid.capture.model import POSITION, SPEED, VOLTAGE, Channel

LEVELS = np.repeat([0.0, 200.0, 0.0, -200.0, 0.0, 120.0, -160.0, 0.0], 40)
TIME = 0.01 * np.arange(len(LEVELS))


def speed_of(drive: np.ndarray, lag: int = 8) -> np.ndarray:
    out, now = [], 0.0
    for one in drive:
        now += (0.5 * one - now) / lag
        out.append(now)
    return np.array(out)


SPEEDS = speed_of(LEVELS)


@pytest.mark.parametrize("name", ["command", VOLTAGE])
@pytest.mark.parametrize("motion", [SPEED, POSITION])
def test_levels_take_the_sign_of_the_speed_at_their_ends(name: str, motion: str) -> None:
    values = SPEEDS if motion == SPEED else np.cumsum(SPEEDS) * 0.01
    channels = {
        name: Channel(name, "1", np.abs(LEVELS), unsigned=True),
        motion: Channel(motion, "rad", values),
    }
    notes: list[str] = []
    found = with_sign(channels, TIME, notes)
    assert np.array_equal(found[name].values, LEVELS)
    assert not found[name].unsigned
    assert len(notes) == 1


def test_a_drive_that_changes_all_the_time_is_signed_between_its_zeros() -> None:
    sine = 200.0 * np.sin(TIME * 2.0)
    found = signs_of(np.abs(sine), speed_of(sine, 2))
    assert found is not None
    assert np.mean(found == np.sign(sine)) > 0.97


@pytest.mark.parametrize(
    ("drive", "speed"),
    [
        (LEVELS, SPEEDS),  # it has a sign
        (np.abs(LEVELS), np.abs(SPEEDS)),  # one way
        (LEVELS + 250.0, SPEEDS),  # an inverter whose middle is its stop
        (np.full(len(LEVELS), 200.0), SPEEDS),  # it turns against any sign
        (np.abs(LEVELS), np.zeros(len(LEVELS))),
        (np.where(LEVELS > 0, np.nan, np.abs(LEVELS)), SPEEDS),
    ],
)
def test_other_drives_stay_as_they_are(drive: np.ndarray, speed: np.ndarray) -> None:
    assert signs_of(drive, speed) is None


def test_a_speed_that_is_a_magnitude_tells_no_sign() -> None:
    channels = {
        "command": Channel("command", "1", np.abs(LEVELS)),
        SPEED: Channel(SPEED, "rad/s", SPEEDS, unsigned=True),
    }
    assert with_sign(channels, TIME, []) == channels
