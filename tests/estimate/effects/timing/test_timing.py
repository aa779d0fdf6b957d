"""Which way a delay, the clock and a log's stamps move the readings, and by how much."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.timing.clock import CLOCK
from motorid.estimate.effects.timing.current_delay import CURRENT_DELAY
from motorid.estimate.effects.timing.motion_delay import MOTION_DELAY
from motorid.estimate.effects.timing.voltage_delay import VOLTAGE_DELAY
from motorid.estimate.effects.timing.voltage_jump import VOLTAGE_JUMP
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.signals.measurements import EMF
from tests.estimate.effects.benches import moved, record, ticks, usual, within

PERIOD_S = 1e-4


@pytest.mark.parametrize(
    ("bench", "quantity", "shown", "part"),
    [
        ("measured", CURRENT_DELAY, CURRENT, 1),
        ("measured", MOTION_DELAY, POSITION, 1),
        ("measured", VOLTAGE_DELAY, EMF, 3),
        ("moving", MOTION_DELAY, SPEED, 0),
    ],
)
def test_a_later_reading_shows_what_was_before(
    bench: str, quantity: InfluenceQuantity, shown: str, part: int
) -> None:
    """y(t − d): less the slope for a second of delay. Nothing else moves."""
    change = moved(bench, quantity)
    slope = np.gradient(usual(bench)[shown], PERIOD_S)
    here = np.flatnonzero(within(bench, shown, part))[20:60]  # past the step's own corner
    assert change[shown][here] == pytest.approx(-slope[here], rel=0.05, abs=0.01 * slope.max())
    assert not any(p.any() for name, p in change.items() if name != shown)


def test_longer_ticks_are_later_moments() -> None:
    """While the coast begins, at t, the angle is ω t s farther on for a share s."""
    change, angle = moved("measured", CLOCK)[POSITION], usual("measured")[POSITION]
    assert (change[within("measured", POSITION, 1)][20:] > 0.0).all()
    # the whole run is one of a slower board: in the end it has driven longer, and turned more
    assert change[-1] > 0.5 * (angle[-1] - angle[0])


def test_a_log_that_came_later_drives_later() -> None:
    change, angle = moved("log", VOLTAGE_LATE)[POSITION], usual("log")[POSITION]
    slope = np.gradient(angle, PERIOD_S)
    early = slice(30, 100)  # readings of the first level, which began at rest: all is shifted
    # a rotor breaks away within an interval of the grid: near to it by a hundredth
    assert change[early] == pytest.approx(-slope[early], rel=0.02)


def test_an_earlier_step_drives_so_much_longer() -> None:
    """It came within the missing period: so much less of the higher voltage drove the motor."""
    subject = record("held_log")
    waveform = subject.sensed.waveform
    assert waveform is not None
    (jump,) = waveform.jumps
    rise = waveform.volts[jump] - waveform.volts[jump - 1]
    change = moved("held_log", VOLTAGE_JUMP)[POSITION]
    keep = ticks("held_log", POSITION) * subject.timeline.period_s
    before = keep < waveform.time_s[jump - 1]
    assert np.abs(change[before]).max() < 1e-9 * np.abs(change).max()
    assert np.sign(change[-1]) == np.sign(rise)


def test_only_an_instant_amid_ripple_is_told_its_delay() -> None:
    assert not CURRENT_DELAY.told(record("measured"))  # a mean over two whole periods
    assert CURRENT_DELAY.told(record("instants"))
