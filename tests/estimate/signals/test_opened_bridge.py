"""A log whose bridge opens: found whatever its voltage shows then, and left out of the fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.foreign.cases import closed_loop, steps, trace
from bench.foreign.plant import Drive, Motor, Trace, turn
from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.signals.log_sections import left_out, pieces
from motorid.estimate.signals.opened_bridge import openings
from tests.six_parameters import fit

MOTOR = Motor()
PERIOD_S, SUPPLY_V = 1e-3, 12.0
NOISE = {VOLTAGE: 0.01, CURRENT: 5e-3, SPEED: 0.1}
OPENED_S, CLOSED_S, END_S = 0.16, 0.36, 0.62


def pulse_and_coast(t: float, w: float) -> float | None:
    """A pulse that ends amid the acceleration, a coast, and two levels."""
    if t < 0.06:
        return 0.0
    if t < OPENED_S:
        return 6.0
    if t < CLOSED_S:
        return None
    return -3.0 if t < 0.5 else 5.0


@cache
def run() -> Trace:
    return turn(MOTOR, pulse_and_coast, END_S)


def logged(true: Trace, shown: str = "emf", runs_out_s: float = 0.0, offset_a: float = 0.0,
           loud: float = 1.0) -> Capture:  # fmt: skip
    """What somebody logs of it, whose voltage while the bridge is open is ``shown``."""
    stamps = np.arange(0.4e-3, true.time_s[-1], PERIOD_S)
    rng = np.random.default_rng(3)
    volts, current = true.at(true.volts, stamps), true.at(true.current, stamps)
    is_open = (stamps > OPENED_S) & (stamps < CLOSED_S)
    if runs_out_s:  # through diodes, straight
        last = float(true.at(true.current, np.array([OPENED_S - 1e-4]))[0])
        since = np.clip((stamps - OPENED_S) / runs_out_s, 0.0, 1.0)
        current = np.where(is_open, last * (1.0 - since), current)
    other = {"zero": 0.0, "supply": SUPPLY_V, "float": 3.0 + np.sin(60.0 * stamps)}
    volts = np.where(is_open, other.get(shown, volts), volts)
    series = {VOLTAGE: volts, CURRENT: current + offset_a, SPEED: true.at(true.speed, stamps)}
    channels = {
        name: Channel(name, unit, y + loud * NOISE[name] * rng.standard_normal(len(y)))
        for (name, y), unit in zip(series.items(), ("V", "A", "rad/s"), strict=True)
    }
    ticks = np.rint(stamps * 1e6).astype(np.int64)
    return Capture(ticks, 1e6, channels)


@pytest.mark.parametrize("runs_out_s", [0.0, 4e-3])
@pytest.mark.parametrize("shown", ["zero", "supply", "float"])
def test_an_opening_is_found_whatever_the_voltage_shows(shown: str, runs_out_s: float) -> None:
    capture = logged(run(), shown, runs_out_s)
    (found,) = openings(capture)
    time = capture.ticks / capture.clock_hz
    # from before it to after it, and no driven sample but a few
    assert OPENED_S - 5 * PERIOD_S <= time[found.start] <= OPENED_S
    assert CLOSED_S <= time[found.stop] <= CLOSED_S + 3 * PERIOD_S


def test_of_terminals_that_show_the_back_emf_only_the_end_of_the_current_is_left_out() -> None:
    capture = logged(run(), "emf")
    (found,) = openings(capture)
    first, last = capture.time_s[found.start], capture.time_s[found.stop]
    assert OPENED_S - 5 * PERIOD_S <= first <= OPENED_S < last <= OPENED_S + 4 * PERIOD_S
    assert len(pieces([capture])) == 2


def test_an_opening_is_found_in_noise_beside_an_offset_and_without_a_motion() -> None:
    assert len(openings(logged(run(), "zero", loud=12.0))) == 1
    assert len(openings(logged(run(), "zero", offset_a=0.15))) == 1
    whole = logged(run(), "zero")
    without = {n: c for n, c in whole.channels.items() if n != SPEED}
    assert len(openings(Capture(whole.ticks, whole.clock_hz, without))) == 1


LOOSE_S, DRIVEN_S = 0.3, 0.45  # of a motor that had run up: .13 A of 3.3 A flow


@cache
def run_up(after: Callable[[float], float | None]) -> Trace:
    """What comes ``after`` it, and a reversal."""

    def drive(t: float, w: float) -> float | None:
        if t < LOOSE_S:
            return 6.0 if t > 0.03 else 0.0
        return after(t - LOOSE_S) if t < DRIVEN_S else -4.0

    return turn(MOTOR, drive, 0.6)


def twelve_bits(true: Trace, kick: float | None = None, counts: int = 0) -> Capture:
    """A log by converters of 12 bits.

    ``kick``: V that diodes show at one reading as the current runs out; ``counts``: of an encoder,
    in the place of a speed.
    """
    stamps, rng = np.arange(0.4e-3, 0.599, PERIOD_S), np.random.default_rng(3)
    volts, current, speed, angle = (
        true.at(y, stamps) for y in (true.volts, true.current, true.speed, true.angle)
    )
    if kick is not None:
        volts[np.searchsorted(stamps, LOOSE_S)] = kick
    columns = [
        (VOLTAGE, "V", volts + 0.01 * rng.standard_normal(len(stamps)), 32.0 / 4096),
        (CURRENT, "A", current + 3e-3 * rng.standard_normal(len(stamps)), 20.0 / 4096),
        (POSITION, "rad", angle, 2.0 * np.pi / counts) if counts else
        (SPEED, "rad/s", speed + 0.1 * rng.standard_normal(len(stamps)), 0.1),
    ]  # fmt: skip
    channels = {
        name: Channel(name, unit, step * np.floor(y / step + 0.5), resolution=step)
        for name, unit, y, step in columns
    }
    return Capture(np.rint(stamps * 1e6).astype(np.int64), 1e6, channels)


def opened(_: float) -> None:
    """Nothing drives the motor."""


def down(volts: float, per_s: float = 0.0) -> Callable[[float], float]:
    """To a lower voltage, and further down."""
    return lambda since_s: volts - per_s * since_s


DRIVEN = {
    "a ramp": down(5.87, 2.0),
    "a faster ramp": down(5.87, 10.0),
    "a step to the back-EMF": down(5.74),
    "a step": down(3.0),
}


@pytest.mark.parametrize("kick", [-0.7, 12.7, None])
@pytest.mark.parametrize("counts", [0, 60, 2000])
def test_a_bridge_that_opens_at_a_small_current_is_told_by_what_ends(
    kick: float | None, counts: int
) -> None:
    """One reading of the voltage is clamped, to either side, or none was taken then. The others
    show the back-EMF: the end of the current alone is left out.
    """
    capture = twelve_bits(run_up(opened), kick, counts)
    (found,) = openings(capture)
    time = capture.ticks / capture.clock_hz
    assert LOOSE_S - 3 * PERIOD_S <= time[found.start] <= LOOSE_S
    assert LOOSE_S + PERIOD_S <= time[found.stop] <= LOOSE_S + 3 * PERIOD_S
    driven = [len(piece) for piece in pieces([capture])]
    assert driven == [found.start, len(capture) - found.stop]


@pytest.mark.parametrize("counts", [0, 60])
@pytest.mark.parametrize("after", DRIVEN)
def test_a_ramp_or_a_step_to_a_small_current_opens_nothing(after: str, counts: int) -> None:
    """The motor slows down with a small current, as it does with none behind an open bridge."""
    assert openings(twelve_bits(run_up(DRIVEN[after]), counts=counts)) == []


def test_a_ramp_about_as_fast_as_it_slows_by_itself_loses_a_few_samples() -> None:
    """.05 A drive it still: that looks like none, and all of the ramp stays."""
    found = openings(twelve_bits(run_up(down(5.87, 4.0))))
    assert sum(one.stop - one.start for one in found) <= 5


@pytest.mark.slow
@pytest.mark.parametrize("drive", [steps, closed_loop])
def test_a_motor_that_is_driven_throughout_has_none(drive: Callable[[], Drive]) -> None:
    true = trace(drive, 0.0, 0.0)
    capture = logged(true)
    assert openings(capture) == []
    assert pieces([capture]) == [capture]
    assert left_out([capture]) == []


@pytest.mark.slow
@pytest.mark.parametrize("late", [-12, 12])
def test_a_current_that_comes_late_is_no_open_bridge(late: int) -> None:
    capture = logged(trace(steps, 0.0, 0.0))
    current = capture.channels[CURRENT]
    moved = replace(current, raw=np.roll(current.raw, late))
    assert openings(replace(capture, channels={**capture.channels, CURRENT: moved})) == []


@pytest.mark.slow
@pytest.mark.parametrize("shown", ["emf", "zero", "supply"])
def test_the_fit_leaves_an_open_bridge_out_and_says_so(shown: str) -> None:
    found = fit([logged(run(), shown, 0.0 if shown == "emf" else 4e-3)])
    said = [d.message for d in found.diagnostics if d.code == "bridge_open"]
    assert len(said) == 1
    assert "left out" in said[0]
    assert "0.1" in said[0]
    for name in ("R", "L", "K", "J"):
        p, true = found.parameters[name], getattr(MOTOR, name)
        assert p.status == "estimated"
        assert p.value == pytest.approx(true, abs=4.0 * p.total)
        assert p.value == pytest.approx(true, rel=0.05)


def test_a_bridge_that_opens_too_often_is_said_to() -> None:
    def chopped(t: float, w: float) -> float | None:
        return 6.0 if t % 0.03 < 0.012 else None

    true = turn(MOTOR, chopped, 0.4)
    stamps = np.arange(0.4e-3, 0.4, PERIOD_S)
    is_open = stamps % 0.03 >= 0.012
    channels = {
        VOLTAGE: Channel(VOLTAGE, "V", np.where(is_open, 0.0, 6.0)),
        CURRENT: Channel(CURRENT, "A", np.where(is_open, 0.0, true.at(true.current, stamps))),
        SPEED: Channel(SPEED, "rad/s", true.at(true.speed, stamps)),
    }
    capture = Capture(np.rint(stamps * 1e6).astype(np.int64), 1e6, channels)
    assert pieces([capture]) == [capture]
    (said,) = left_out([capture])
    assert said.severity == "warning"
    assert "opens so often" in said.message
