"""Where the current stops within the PWM period, and what is known of it then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Channel, Wiring
from motorid.errors import DataError
from motorid.estimate.signals.source.discontinuous_current import (
    confirmed,
    divided,
    stops_from,
    unclear,
)
from motorid.estimate.signals.source.pwm_bridge import ripple
from motorid.estimate.signals.source.thevenin_source import sources
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.program import Decay, StepKind
from tests.exact_capture import FAULHABER, clean_capture

SUPPLY = 12.0
N = 100
DIODE = Part(0, N, StepKind.DRIVE_DUTY, -0.75, Decay.DIODE)
FLOWING = 0.75 * SUPPLY - 0.25 * (SUPPLY + 1.4)  # V, the mean of the two parts


def line(*parts: Part) -> Timeline:
    return Timeline(1e-4, N, np.arange(N), parts, 0.0)


def test_the_voltage_rises_once_the_current_stops() -> None:
    """By readings with noise, of a motor that runs backwards."""
    noise = np.random.default_rng(3).normal(0, 0.02, N)
    over = 0.005 * SUPPLY * np.clip(np.arange(N) - 40, 0, 40)
    assert abs(stops_from(DIODE, -(FLOWING + over) + noise, SUPPLY) - 40) <= 3
    assert stops_from(DIODE, np.full(N, -FLOWING) + noise, SUPPLY) == N
    assert stops_from(DIODE, np.full(N, -11.0), SUPPLY) == 0


def test_a_part_is_divided_where_the_current_stops() -> None:
    over = 0.005 * SUPPLY * np.clip(np.arange(N) - 40, 0, 40)
    rest = Part(0, 1)
    capture = replace(clean_capture(FAULHABER), wiring=Wiring(supply_voltage_v=SUPPLY), channels={})

    def sensed(volts: np.ndarray, emf: bool = True) -> Sense:
        return Sense(volts, np.zeros(N, dtype=bool), 0.0, 0.0, emf, None)

    before, after = divided(capture, line(DIODE), sensed(-(FLOWING + over))).parts
    assert (before.start, after.stop, before.stop) == (0, N, after.start)
    assert (before.discontinuous, after.discontinuous) == (False, True)
    assert before.level == after.level == DIODE.level
    assert divided(capture, line(DIODE), sensed(np.full(N, -FLOWING))).parts == (DIODE,)
    assert divided(capture, line(rest), sensed(np.zeros(N))).parts == (rest,)


@pytest.mark.parametrize("decay", [Decay.SYNCHRONOUS_SLOW, Decay.FAST])
def test_a_bridge_that_switches_never_stops_the_current(decay: Decay) -> None:
    assert stops_from(replace(DIODE, decay=decay), np.full(N, -11.0), SUPPLY) == N
    assert stops_from(replace(DIODE, level=-1.0), np.full(N, -11.0), SUPPLY) == N


def test_readings_of_an_unknown_part_of_a_period_are_left_out_while_it_stops() -> None:
    parts = replace(DIODE, stop=60), replace(DIODE, start=60, discontinuous=True)
    part = Channel(CURRENT, "A", np.zeros(N, dtype=np.int16), 1e-3, kind="mean", aperture_s=2e-5)

    def hidden(pwm_hz: float, **changes: object) -> np.ndarray:
        return unclear(replace(part, **changes), line(*parts), pwm_hz)  # type: ignore[arg-type]

    assert np.flatnonzero(hidden(21e3)).tolist() == list(range(60, N))
    late = hidden(21e3, delay_s=0.9e-4)  # its window reaches over the tick
    assert np.flatnonzero(late).tolist() == list(range(60, N))
    assert not hidden(20e3).any()  # two periods a sample: the part is always the same
    assert not hidden(21e3, aperture_s=2 / 21e3).any()  # whole periods
    assert not hidden(21e3, kind="instant", aperture_s=0.0, pwm_phase=0.3).any()


def test_duty_times_supply_is_refused_with_diodes() -> None:
    capture = replace(clean_capture(FAULHABER), wiring=Wiring(supply_voltage_v=SUPPLY), channels={})
    commanded = Sense(np.full(N, -9.0), np.zeros(N, dtype=bool), 0.0, 0.0, False, None)
    with pytest.raises(DataError, match="diode decay"):
        divided(capture, line(DIODE), commanded)
    for other in (replace(DIODE, level=1.0), replace(DIODE, decay=Decay.FAST)):
        assert divided(capture, line(other), commanded).parts == (other,)


@pytest.mark.parametrize(("times", "stays"), [(0.5, True), (10.0, False)])
def test_a_current_too_large_for_pulses_flows_on(times: float, stays: bool) -> None:
    L, R = 1e-3, 2.0
    wiring = Wiring(supply_voltage_v=SUPPLY, pwm_hz=20e3)
    capture = replace(clean_capture(FAULHABER), wiring=wiring)
    count = len(capture)
    below, _ = ripple(capture, DIODE, L, R)
    raw = np.full(count, round(-times * below / 1e-4), dtype=np.int64)
    capture = replace(capture, channels={CURRENT: Channel(CURRENT, "A", raw, 1e-4)})
    stopped = replace(DIODE, stop=count, discontinuous=True)
    timeline = Timeline(1e-4, count, np.arange(count), (stopped,), 0.0)
    (part,) = confirmed(capture, timeline, L, R).parts
    assert part.discontinuous is stays


@pytest.mark.parametrize("place", [0, 1])
def test_the_first_readings_of_pulses_are_taken_as_they_are(place: int) -> None:
    """Where it flows on, what departs from the source's line builds up with the current."""
    volts = 0.3 + np.random.default_rng(1).normal(0, 1e-4, N)
    volts[place] += 0.05
    window, mean = np.full(N, 1.0), np.full(N, 1.0)
    window[place] = 0.4  # the reading's window begins before the command
    sensed = Sense(volts, np.zeros(N, dtype=bool), 0.0, 0.0, True, None)

    def taken(stops: bool) -> float:
        part = replace(DIODE, level=0.3, discontinuous=stops)
        (source,) = sources(sensed, window, [part], np.zeros(N, dtype=bool), 0.0, mean)
        assert source is not None
        return float(source.volts[place])

    assert taken(True) == pytest.approx(volts[place], abs=1e-3)
    assert abs(taken(False) - volts[place]) > 0.01


def test_the_moment_it_stops_is_where_the_line_of_the_rise_begins() -> None:
    """A slow rise is clear long after it began."""
    for slope in (5e-4, 1e-3, 4e-3):  # of the supply, in a sample
        rise = slope * SUPPLY * np.clip(np.arange(N) - 40, 0, None)
        assert abs(stops_from(DIODE, -(FLOWING + rise), SUPPLY) - 40) <= 2
    slight = 0.008 * SUPPLY * np.clip((np.arange(N) - 40) / 20, 0, 1)  # less than clear
    assert stops_from(DIODE, -(FLOWING + slight), SUPPLY) == N


@pytest.mark.parametrize("inductance_h", [0.0, 1e-3])
def test_where_nothing_can_be_compared_it_is_left_as_it_was(inductance_h: float) -> None:
    """Without an inductance there is no ripple to compare with; without readings, no current."""
    wiring = Wiring(supply_voltage_v=SUPPLY, pwm_hz=20e3)
    capture = replace(clean_capture(FAULHABER), wiring=wiring)
    count = len(capture)
    stopped = replace(DIODE, stop=count, discontinuous=True)
    timeline = Timeline(1e-4, count, np.arange(count), (stopped,), 0.0)
    gone = np.full(count, np.nan if inductance_h else -50.0)
    amperes = replace(capture, channels={CURRENT: Channel(CURRENT, "A", gone)})
    (part,) = confirmed(amperes, timeline, inductance_h, 2.0).parts
    assert part.discontinuous
    (part,) = confirmed(replace(capture, channels={}), timeline, 1e-3, 2.0).parts
    assert part.discontinuous


@pytest.mark.parametrize(("before_a", "kept"), [(0.5, False), (0.01, True)])
def test_a_reading_while_the_current_of_the_step_before_runs_out_drives_nothing(
    before_a: float, kept: bool
) -> None:
    """The diodes reverse the supply for that while, which the mean of the voltage shows."""
    volts = 0.3 + np.random.default_rng(1).normal(0, 1e-4, N)
    volts[1] += 2.0
    amperes = np.full(N, 0.02)
    amperes[0] = before_a
    sensed = Sense(volts, np.zeros(N, dtype=bool), 0.0, 0.0, True, None)
    part = replace(DIODE, start=1, level=0.3, discontinuous=True)
    (source,) = sources(sensed, amperes, [part], np.zeros(N, dtype=bool), 0.0, amperes)
    assert source is not None
    assert source.volts[0] == pytest.approx(volts[1] if kept else 0.3, abs=1e-3)
