"""A sweep of steady speeds without a current: gain, what friction takes, and a line that bends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel
from motorid.errors import DataError
from motorid.estimate.partial import mechanical_fit
from motorid.estimate.partial.levels import steady_speeds
from motorid.estimate.partial.without_current import likelihood

VOLTS = np.linspace(-12.0, 12.0, 49)
GAIN, FRICTION = 40.0, 1.5


def table(speed: np.ndarray, name: str = "terminal_voltage", volts: np.ndarray = VOLTS) -> Capture:
    unit = "V" if name == "terminal_voltage" else "1"
    return Capture(
        np.arange(len(volts), dtype=np.int64), 1.0,
        {name: Channel(name, unit, volts), "speed": Channel("speed", "rad/s", speed)},
        provenance={"static": True},
    )  # fmt: skip


def straight(volts: np.ndarray = VOLTS) -> np.ndarray:
    noise = 0.5 * np.random.default_rng(1).standard_normal(len(volts))
    turning = np.abs(volts) > FRICTION
    return np.where(turning, GAIN * np.sign(volts) * (np.abs(volts) - FRICTION) + noise, 0.0)


@pytest.mark.parametrize("name", ["terminal_voltage", "command"])
def test_a_straight_line_gives_gain_and_friction(name: str) -> None:
    found = mechanical_fit.fit([table(straight(), name)])
    for one, true in (("K/(K²+RB)", GAIN), ("T0·R/K", FRICTION)):
        p = found.combinations[one]
        assert p.interval_95[0] < true < p.interval_95[1]
        assert p.total < 0.05 * true
    assert "bent_line" not in {d.code for d in found.diagnostics}


def test_a_line_that_bends_says_so_and_is_as_uncertain() -> None:
    speed = 400.0 * np.sign(VOLTS) * (1.0 - np.exp(-np.abs(VOLTS) / 3.0))
    found = mechanical_fit.fit([table(speed)])
    said = {d.code: d.message for d in found.diagnostics}
    assert "coast between its pulses" in said["bent_line"]
    gain = found.combinations["K/(K²+RB)"]
    assert gain.value is None or gain.total > 0.3 * gain.value


def test_rows_without_an_order_are_no_log_of_volts() -> None:
    one = table(straight())
    assert not likelihood.suits([one])
    assert likelihood.suits([replace(one, provenance={})])


def test_few_points_at_which_the_motor_turns_are_refused() -> None:
    still = np.where(np.abs(VOLTS) > 11.0, 100.0, 0.0)
    with pytest.raises(DataError, match=r"at least 8 rows at which the motor turns"):
        mechanical_fit.fit([table(still)])
    assert steady_speeds.suits([table(still)])


@pytest.mark.parametrize("speed", [np.full(len(VOLTS), 30.0), 100.0 - 5.0 * np.abs(VOLTS)])
def test_a_speed_that_does_not_rise_with_the_drive_is_refused(speed: np.ndarray) -> None:
    with pytest.raises(DataError, match="does not rise with the terminal voltage"):
        mechanical_fit.fit([table(speed)])
