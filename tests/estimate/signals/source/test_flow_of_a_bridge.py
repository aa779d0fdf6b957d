"""A flow as it is made for a bridge: what bends with it against a current in fine steps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import Capture, Wiring
from motorid.estimate.signals.source.current_transient import Rise
from motorid.estimate.signals.source.ripple_average import Flow, Pulses, Swing
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]
OHM, HENRY, PWM_HZ, RAIL, BEND, COUNT = 2.0, 2e-4, 10e3, 12.0, 0.3, 30
TAU = HENRY / OHM * PWM_HZ  # of a PWM period
EVEN = np.full(16, 1.0 / 16.0)


def capture() -> Capture:
    return Capture(
        100 * np.arange(COUNT), 1e6, {}, wiring=Wiring(pwm_hz=PWM_HZ, supply_voltage_v=RAIL)
    )


def part(start: int, level: float, decay: Decay = Decay.SYNCHRONOUS_SLOW) -> Part:
    return Part(start, start + 10, StepKind.DRIVE_DUTY, level, decay)


def bent(current: Floats) -> Floats:
    return np.asarray(current / np.hypot(current, BEND))


def swing(duty: float) -> Floats:
    """A current less its mean, that rises towards RAIL / OHM for a share of the period, and falls
    towards nothing."""
    t = (np.arange(20_000) + 0.5) / 20_000
    high, keep = RAIL / OHM, math.exp(-1.0 / TAU)
    least = high * (math.exp(duty / TAU) - 1.0) * keep / (1.0 - keep)
    most = high + (least - high) * math.exp(-duty / TAU)
    on = high + (least - high) * np.exp(-t / TAU)
    whole = np.where(t < duty, on, most * np.exp(-(t - duty) / TAU))
    return np.asarray(whole - whole.mean())


def test_each_part_swings_by_its_duty_and_one_without_a_switch_does_not() -> None:
    mean = np.linspace(-0.5, 2.0, COUNT)
    rise = Rise(part(10, -0.7), np.zeros((2, 16)), EVEN)
    parts = [part(0, 0.25), part(10, -0.7), Part(20, COUNT, StepKind.COAST)]
    flow = Flow.of(capture(), parts, mean, HENRY, OHM, [rise])
    assert flow.rises == (rise,)
    assert [one.part for one in flow.swings] == parts[:2]
    share, _ = Flow.of(capture(), parts, mean, HENRY, OHM).saturation(BEND)
    wanted = [float(bent(i + swing(0.25)).mean()) for i in mean[:10]]
    wanted += [float(bent(i - swing(0.7)).mean()) for i in mean[10:20]]
    assert share == pytest.approx([*wanted, *bent(mean[20:])], abs=5e-4)


def test_a_rise_swings_about_its_own_course() -> None:
    """The mean over places of the mean over the PWM period."""
    mean, course = np.full(COUNT, 0.2), np.linspace(-0.4, 0.8, 32).reshape(2, 16)
    rises = [Rise(part(10, 0.25), course, EVEN), Rise(Part(20, COUNT), course, np.eye(16)[3])]
    flow = Flow.of(capture(), [part(0, 0.5), part(10, 0.25)], mean, HENRY, OHM, rises)
    share, _ = flow.saturation(BEND)
    about = np.array([float(bent(i + swing(0.25)).mean()) for i in course.ravel()])
    assert share[10:12] == pytest.approx(about.reshape(2, 16).mean(axis=1), abs=5e-4)
    assert share[12:20] == pytest.approx(float(bent(0.2 + swing(0.25)).mean()), abs=5e-4)
    assert share[20:22] == pytest.approx(bent(course)[:, 3])
    assert share[22:] == pytest.approx(bent(mean)[22:])


def test_pulses_stand_where_a_diodes_current_stops() -> None:
    """Against the back-EMF of each interval; where it flows on, the ripple of a flow stands."""
    emf = np.linspace(0.0, 4.0, COUNT)
    one = part(5, 0.3, Decay.DIODE)
    flow = Flow.of(capture(), [one], np.zeros(COUNT), HENRY, OHM, emf=emf)
    (found,) = flow.swings
    floor = (RAIL + 1.4 + emf[5:15]) / OHM
    pulses = Pulses(1.0, 0.3, 1.0 / TAU, floor)
    assert found.pulses is not None
    assert found.pulses.floor == pytest.approx(floor)
    mean = np.linspace(0.01, 8.0, 10)
    stops, pulsed, bending = pulses.saturation(mean, BEND)
    assert stops[0]
    assert not stops[-1]
    plain = Swing(one, found.deviations, found.weights).saturation(mean, BEND)
    share, bend = found.saturation(mean, BEND)
    assert share == pytest.approx(np.where(stops, pulsed, plain[0]))
    assert bend == pytest.approx(np.where(stops, bending, plain[1]))


def test_without_a_back_emf_a_part_has_none() -> None:
    one = part(5, 0.3, Decay.DIODE)
    (found,) = Flow.of(capture(), [one], np.zeros(COUNT), HENRY, OHM).swings
    assert found.pulses is not None
    assert found.pulses.floor == pytest.approx(np.full(10, (RAIL + 1.4) / OHM))


def test_the_beginning_of_a_part_falls_as_its_first_interval() -> None:
    pulses = Pulses(1.0, 0.3, 1.0, np.array([5.0, 9.0, 9.0]))
    first = Pulses(1.0, 0.3, 1.0, np.array([5.0, 5.0]))
    mean = np.array([0.1, 0.3])
    for found, wanted in zip(
        pulses.saturation(mean, BEND), first.saturation(mean, BEND), strict=True
    ):
        assert found.tolist() == wanted.tolist()
