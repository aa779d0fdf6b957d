"""A log's voltage between its readings: joined, held, or joined but where it jumps."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.signals.intersample_voltage import BROKEN, LOOSE, Shape, Waveform

TIME_S = np.arange(8.0)
VOLTS = np.array([0.0, 0.2, 0.4, 6.0, 5.8, 5.6, 1.0, 1.2])  # it jumps at 3 and at 6


def waveform(shape: Shape) -> Waveform:
    return Waveform(TIME_S, VOLTS, shape, 1.0)


@pytest.mark.parametrize(
    ("shape", "at_s", "volts"),
    [
        ("joined", 2.5, 3.2), (BROKEN, 2.5, 0.4), (BROKEN, 1.5, 0.3), (BROKEN, 4.5, 5.7),
        ("held", 1.5, 0.2), (LOOSE, 5.5, 5.6), (LOOSE, 4.5, 5.7),
    ],
)  # fmt: skip
def test_its_course(shape: Shape, at_s: float, volts: float) -> None:
    shown = waveform(shape)
    assert float(shown._value(shown.within(np.array([at_s])))[0]) == pytest.approx(volts)
    flux = shown._flux(shown.within(np.array([at_s - 0.1, at_s + 0.1])))
    assert float(np.diff(flux)[0]) / 0.2 == pytest.approx(volts)


def test_only_a_loose_one_has_jumps_at_regular_stamps_that_move() -> None:
    assert list(waveform(BROKEN).jumps) == []
    assert list(waveform(LOOSE).jumps) == [3, 6]
    moved = waveform(LOOSE)._with_jumps([0.25, 0.0])
    assert float(moved._value(moved.within(np.array([2.8])))[0]) == pytest.approx(6.0, abs=0.1)


def test_what_stays_between_its_jumps_does_not_wander() -> None:
    assert waveform(BROKEN).wanders
    level = Waveform(np.arange(20.0), np.repeat([0.0, 6.0], 10), BROKEN, 1.0)
    assert not level.wanders
