"""The rotor's angle by its encoder, and an open bridge's ripple, against an integral by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import POSITION
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.rotor_angle import measured_angle, rippled
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.measurements import EMF
from motorid.motor.reading import Output, Quantity
from tests.exact_capture import FAULHABER, Plan, clean_capture

PLAN = Plan(volts=(6.0,), count=1500)
PERIOD_S, RATE, K = 1e-3, 40.0, 0.02  # s, rad/s, V·s/rad
WAVE = (7.0, 0.4)  # periods a turn, rad


def record(step_rad: float = 1e-4) -> MotorRecord:
    """Of a run whose encoder has such steps."""
    capture = clean_capture(FAULHABER, PLAN)
    position = replace(capture.channels[POSITION], resolution=step_rad)
    channels = {**capture.channels, POSITION: position}
    return MotorRecord(replace(capture, channels=channels), PARAMETERS, {})


def shown(aperture_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Ripple of a rotor that turns evenly, and the ends (s) of its readings."""
    run = record()
    m = run.block(EMF)
    assert m is not None
    angle = RATE * PERIOD_S * np.arange(run.timeline.count)
    volts = np.full(len(m.keep), K * RATE)
    output = Output(Quantity.SPEED, aperture_s)
    past = m.keep if m.past is None else m.keep + m.past
    return rippled(m, output, volts, K, WAVE, angle, PERIOD_S), past * PERIOD_S


@pytest.mark.slow
def test_a_reading_at_an_instant_shows_the_ripple_there() -> None:
    ripple, at = shown(0.0)
    expected = K * RATE * np.cos(WAVE[0] * RATE * at + WAVE[1])
    assert ripple == pytest.approx(expected, abs=1e-9)


def test_a_mean_shows_the_mean_of_the_ripple() -> None:
    aperture = 5e-3
    ripple, at = shown(aperture)
    fine = (np.arange(2000) + 0.5) / 2000 * aperture
    each = np.cos(WAVE[0] * RATE * (at[:, None] - fine) + WAVE[1])
    inside = at > aperture
    assert ripple[inside] == pytest.approx(K * RATE * each.mean(axis=1)[inside], abs=1e-6)


def test_an_encoder_shows_the_angle_from_the_first_reading_on() -> None:
    run = record()
    own = np.array([u.start for u in run.unknowns])
    angle = measured_angle(run, run.fitted(np.array(list(FAULHABER.values())), own))
    assert angle is not None
    assert len(angle) == run.timeline.count
    assert abs(angle[0]) < 0.01
    m = run.block(POSITION)
    assert m is not None
    assert np.ptp(angle) == pytest.approx(np.ptp(m.values), rel=0.01)


def test_a_coarse_encoder_shows_no_ripple() -> None:
    run = record(step_rad=0.1)
    own = np.array([u.start for u in run.unknowns])
    assert measured_angle(run, run.fitted(np.array(list(FAULHABER.values())), own)) is None
