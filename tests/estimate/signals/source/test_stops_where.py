"""Where a diode's current stops: levels, votes and windows by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture, Channel, Wiring
from motorid.estimate.signals.source import discontinuous_current as module
from motorid.estimate.signals.source.discontinuous_current import (
    MOST,
    confirmed,
    divided,
    shows_ripple,
    stops_from,
    unclear,
)
from motorid.estimate.signals.source.pwm_bridge import ripple
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]
RAIL, COUNT, DUTY = 12.0, 100, 0.75
PART = Part(20, COUNT, StepKind.DRIVE_DUTY, DUTY, Decay.DIODE)
FLOWING = DUTY * RAIL - (1.0 - DUTY) * (RAIL + 1.4)
READ = Channel(CURRENT, "A", np.zeros(COUNT), kind="mean", aperture_s=3e-5)


def capture(wiring: Wiring, **channels: Channel) -> Capture:
    return Capture(100 * np.arange(COUNT), 1e6, channels, wiring=wiring)


def line(*parts: Part) -> Timeline:
    return Timeline(1e-4, COUNT, np.arange(COUNT), parts, 0.0)


def sensed(volts: Floats) -> Sense:
    return Sense(volts, np.zeros(COUNT, dtype=bool), 0.0, 0.0, True, None)


@pytest.mark.parametrize(("over", "start"), [(0.55, COUNT), (0.65, 20), (-2.0, COUNT)])
def test_a_voltage_a_twentieth_of_the_rail_above_that_of_a_flow_is_of_pulses(
    over: float, start: int
) -> None:
    assert stops_from(PART, np.full(COUNT, FLOWING + over), RAIL) == start


@pytest.mark.parametrize("level", [0.0, 1.0, -1.0])
def test_without_a_switch_that_opens_and_closes_nothing_stops(level: float) -> None:
    high = np.full(COUNT, 14.0 if level >= 0.0 else -14.0)
    assert stops_from(replace(PART, level=level), high, RAIL) == COUNT


@pytest.mark.parametrize(
    ("values", "place"),
    [
        ([0, 0, 0, 1, 1, 1, 1], 3),
        ([0, 0, 0, 1, 0, 0, 1, 1], 6),  # one that is early
        ([0, 0, 0, 1, 1, 1, 0, 0, 1], 3),  # two that are late
        ([1, 1, 1], 0),
        ([0, 1, 1], 1),
        ([0, 0], 2),
        ([0.5, 0.5], 0),
    ],
)
def test_most_values_before_a_rise_are_below_and_most_after_it_above(
    values: list[float], place: int
) -> None:
    assert module._rises(np.array(values, float), 0.5) == place


def test_a_part_that_switches_is_left_beside_one_of_diodes() -> None:
    slow = Part(0, 20, StepKind.DRIVE_DUTY, 0.5, Decay.SYNCHRONOUS_SLOW)
    volts = np.full(COUNT, FLOWING + 2.0)
    found = divided(capture(Wiring(supply_voltage_v=RAIL)), line(slow, PART), sensed(volts)).parts
    assert found == (slow, replace(PART, discontinuous=True))


@pytest.mark.parametrize("unsigned", [False, True])
def test_what_lies_before_the_terminals_takes_its_share_of_the_current(unsigned: bool) -> None:
    """A source that stays, seen behind .8 ohm of a current that falls from 2 A to .4 A: the
    terminals rise."""
    wiring = Wiring(0.3, 0.0, 0.5, 0.0, supply_voltage_v=RAIL)
    amperes = np.linspace(2.0, 0.4, COUNT)
    read = Channel(CURRENT, "A", amperes, unsigned=unsigned)
    parts = divided(
        capture(wiring, current=read), line(PART), sensed(FLOWING - 0.8 * amperes)
    ).parts
    assert [part.discontinuous for part in parts] == ([False, True] if unsigned else [False])


@pytest.mark.parametrize(("share", "stays"), [(0.9, True), (1.1, False)])
def test_pulses_are_judged_by_how_far_a_ripple_swings_below_its_mean(
    share: float, stays: bool
) -> None:
    """Two time constants within the PWM period: it spends more of it near one end."""
    wiring = Wiring(supply_voltage_v=RAIL, pwm_hz=20e3)
    stopped = replace(PART, discontinuous=True)
    henry, ohm = 5e-5, 2.0
    below, above = ripple(capture(wiring), stopped, henry, ohm)
    assert abs(above / below - 1.0) > 0.15
    amperes = np.full(COUNT, share * MOST * below)
    amperes[30:40] = np.nan
    read = capture(wiring, current=Channel(CURRENT, "A", amperes))
    (found,) = confirmed(read, line(stopped), henry, ohm).parts
    assert found.discontinuous is stays


@pytest.mark.parametrize(
    ("pwm_hz", "facts", "shows"),
    [
        (10e3, {}, True),  # a period a sample
        (20e3, {}, True),
        (13e3, {}, False),  # readings wander through the period
        (10e3, {"aperture_s": 1e-4}, False),  # of the whole period
        (13e3, {"kind": "instant", "aperture_s": 0.0, "pwm_phase": 0.3}, True),
        (13e3, {"pwm_phase": 0.3}, False),  # of a mean it is the spacing
        (0.0, {"kind": "instant", "aperture_s": 0.0, "pwm_phase": 0.3}, False),
    ],
)
def test_ripple_shows_where_readings_lie_at_one_place_of_the_period(
    pwm_hz: float, facts: dict[str, object], shows: bool
) -> None:
    assert shows_ripple(replace(READ, **facts), 1e-4, pwm_hz) is shows  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("facts", "hidden"),
    [
        ({"aperture_s": 5e-5}, (20, 60)),
        ({"aperture_s": 5e-5, "delay_s": 2.3e-4}, (22, 62)),  # two to three samples before
        ({"aperture_s": 15e-5, "delay_s": 2.3e-4}, (22, 63)),
        ({"aperture_s": 25e-5, "delay_s": 0.1e-4}, (20, 62)),
        ({"kind": "instant", "aperture_s": 0.0, "delay_s": 1.4e-4}, (21, 61)),
    ],
)
def test_what_a_reading_saw_of_a_current_that_stops_is_unclear(
    facts: dict[str, object], hidden: tuple[int, int]
) -> None:
    """Of intervals 20 to 60, by its delay and its window."""
    flows = Part(0, 20), replace(PART, start=60)
    parts = flows[0], replace(PART, stop=60, discontinuous=True), flows[1]
    found = unclear(replace(READ, **facts), line(*parts), 13e3)  # type: ignore[arg-type]
    assert np.flatnonzero(found).tolist() == list(range(*hidden))
