"""Drives at one level: what cannot be separated there is not stated, and above all not tightly."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel
from motorid.errors import DataError
from motorid.estimate.partial import mechanical_fit
from motorid.estimate.partial.levels.one_level import refuse
from motorid.estimate.partial.mechanical_signals import of_capture

TIME = np.arange(0.0, 4.0, 0.01)
NOISE = np.random.default_rng(2).standard_normal(len(TIME))


def log(name: str, drive: np.ndarray, speed: np.ndarray) -> Capture:
    unit = {"terminal_voltage": "V", "current": "A"}.get(name, "1")
    channels = {name: Channel(name, unit, drive), "speed": Channel("speed", "rad/s", speed)}
    return Capture(np.rint(TIME * 1e9).astype(np.int64), 1e9, channels)


def test_a_steady_motor_at_one_current_is_refused() -> None:
    """Its friction was the whole drive, ± 1e-10 of it."""
    with pytest.raises(DataError, match=r"cannot be separated at one level"):
        mechanical_fit.fit([log("current", np.full(len(TIME), 9.0), 100.0 + NOISE)])


@pytest.mark.parametrize("name", ["terminal_voltage", "command"])
def test_a_steady_motor_at_one_level_shows_its_speed_alone(name: str) -> None:
    found = mechanical_fit.fit([log(name, np.full(len(TIME), 9.0), 100.0 + NOISE)])
    told = {n for n, p in found.combinations.items() if p.value is not None}
    assert told == {"steady speed", "(K−T0·R/V)/(K²+RB)"}
    assert "no_rise" in {d.code for d in found.diagnostics}


@pytest.mark.parametrize(
    ("name", "swing", "one"),
    [
        ("terminal_voltage", 0.06, True),
        ("terminal_voltage", 0.08, False),
        ("current", 0.012, True),
        ("current", 0.016, False),
    ],
)
def test_a_drive_that_varies_is_more_than_one_level(name: str, swing: float, one: bool) -> None:
    drive = 9.0 * (1.0 + swing * np.sin(np.pi * TIME))  # rms: swing / √2
    motion = of_capture(log(name, drive, 10.0 * drive), name)
    if one:
        with pytest.raises(DataError):
            refuse([motion])
    else:
        refuse([motion])


def test_noise_of_a_voltage_is_no_second_level() -> None:
    drive = 9.0 + 0.8 * np.random.default_rng(4).standard_normal(len(TIME))
    with pytest.raises(DataError):
        refuse([of_capture(log("terminal_voltage", drive, 100.0 + NOISE), "terminal_voltage")])


def test_no_friction_is_stated_where_the_gain_is_not_told() -> None:
    """A controller answers the noise of the speed: the drive falls where the speed reads high."""
    drive = 90.0 - 4.0 * NOISE - 9.0 * np.sin(np.pi * TIME)
    found = mechanical_fit.fit([log("command", drive, 100.0 + NOISE)])
    assert found.combinations["K/(K²+RB)"].value is None
    assert found.combinations["T0·R/K"].value is None
    assert "one_level" in {d.code for d in found.diagnostics}
    assert all("T0·R/K" not in moves for moves in found.not_stated.values())
