"""What bends with the current within the first intervals of a part, against a winding in steps."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture, Channel, Wiring
from motorid.estimate.signals.source.current_transient import rises
from motorid.estimate.signals.source.ripple_average import Flow
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind

R, VOLTS, DROP, BEND = 2.0, 10.0, 0.4, 0.25
PERIOD_S, STEPS = 1e-4, 4000  # of an interval, in steps


def winding(tau: float, lost: np.ndarray) -> np.ndarray:
    """Current at the end of every step, (intervals, STEPS), from rest, ``lost`` (the same) less."""
    rest = np.exp(-1.0 / (tau * STEPS))
    current, out = 0.0, []
    for volts in VOLTS - lost.ravel():
        current = rest * current + (1.0 - rest) * volts / R
        out.append(current)
    return np.array(out).reshape(lost.shape)


@pytest.mark.parametrize("tau", [0.2, 0.7, 2.0])
@pytest.mark.parametrize(("late", "wide"), [(0.1, 0.0), (0.15, 0.4), (0.1, 0.8)])
def test_a_reading_shows_what_the_brushes_took_on_the_way_up(
    tau: float, late: float, wide: float
) -> None:
    """The drop as one voltage for the interval moves the reading as the drop itself, to 1 %, where
    that at the mean current would be off by up to 17 %.
    """
    plain = winding(tau, np.zeros((3, STEPS)))
    one = Capture(
        ticks=np.arange(100, dtype=np.int64) * 100,
        clock_hz=1e6,
        channels={
            CURRENT: Channel(
                CURRENT, "A", np.zeros(100), kind="mean" if wide else "instant",
                aperture_s=wide * PERIOD_S, delay_s=late * PERIOD_S,
            )
        },
        wiring=Wiring(),
    )  # fmt: skip
    parts = [Part(0, 1, StepKind.COAST), Part(1, 100, StepKind.DRIVE_VOLTS, VOLTS, Decay.DIODE)]
    mean, end = np.zeros(100), np.zeros(100)
    mean[1:4], end[1:4] = plain.mean(axis=1), plain[:, -1]
    risen = tuple(rises(one, parts, mean, end, tau * PERIOD_S * R, R))
    assert risen[0].amperes[:3].mean(axis=1) == pytest.approx(mean[1:4], rel=0.01)

    def reading(lost: np.ndarray) -> float:
        shown = winding(tau, lost)[0]
        stop = round((1.0 - late) * STEPS)
        return float(shown[stop - max(round(wide * STEPS), 1) : stop].mean())

    true = reading(DROP * plain / np.hypot(plain, BEND))

    def off(flow: Flow) -> float:
        share, _ = flow.saturation(BEND)
        even = np.repeat(DROP * share[1:4, None], STEPS, axis=1)
        return abs(reading(even) - true) / (reading(np.zeros((3, STEPS))) - true)

    assert off(Flow(mean, rises=risen)) < 0.01
    if tau == 2.0:
        assert off(Flow(mean)) > 0.06


def test_an_inductance_without_end_makes_a_straight_rise() -> None:
    readings = Channel(CURRENT, "A", np.zeros(20), kind="instant")
    one = Capture(np.arange(20, dtype=np.int64) * 100, 1e6, {CURRENT: readings}, wiring=Wiring())
    parts = [Part(0, 1, StepKind.COAST), Part(1, 20, StepKind.DRIVE_VOLTS, VOLTS, Decay.DIODE)]
    end = np.arange(20.0)
    for tau in (1e5, 1e30):
        (risen,) = rises(one, parts, end - 0.5, end, tau * PERIOD_S * R, R)
        straight = end[1] + np.linspace(-1.0 + 1 / 32, -1 / 32, 16)
        assert risen.amperes[0] == pytest.approx(straight, abs=1e-3)
