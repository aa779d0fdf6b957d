"""An opened bridge's voltage counts as back-EMF once the diodes carry no current."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel
from motorid.estimate.signals.opened_voltage import LONG, SAMPLES, emf_shows
from motorid.estimate.signals.time_grid import lay
from motorid.motor.reading import Stretch
from tests.estimate.signals.test_time_grid import COAST, capture, drive
from tests.motor_reference import Reference

Floats = NDArray[np.float64]
OPENED, COUNT = 40, 200  # samples of 100 us


def shown_from(run: Capture) -> int:
    """Samples after the opening whose voltage is taken."""
    timeline = lay(run)
    shows = emf_shows(run, timeline, run.channels[VOLTAGE])
    start = next(part.start for part in timeline.parts if part.open)
    assert not shows[:start].any()
    return int(np.flatnonzero(shows)[0]) - start


def first_of(
    flows: int, late: int = 0, count: int = COUNT, noise_a: float = 1e-3, **facts: float
) -> int:
    """The same, of a current that falls for ``flows`` samples."""
    rng = np.random.default_rng(5)
    after = np.arange(count) - OPENED - late
    amps = np.where(after < 0, 1.0, np.clip(1.0 - after / max(flows, 1), 0.0, 1.0))
    amps += rng.normal(0.05, noise_a, count)  # its zero is nobody's
    volts = np.where(after < 0, 6.0, np.where(after < flows, -7.4, 3.0))
    run = capture(
        100 * np.arange(count), drive(0.5), COAST, starts=(0, 100 * OPENED), current=amps,
        terminal_voltage=volts,
    )  # fmt: skip
    channels = dict(run.channels)
    channels[CURRENT] = replace(channels[CURRENT], delay_s=1e-4 * late)
    channels[VOLTAGE] = replace(channels[VOLTAGE], delay_s=1e-4 * late, **facts)
    return shown_from(replace(run, channels=channels))


def test_a_current_that_stops_at_once_leaves_three_samples() -> None:
    assert first_of(0) in (SAMPLES, SAMPLES + 1)


@pytest.mark.parametrize("flows", [12, 50])
@pytest.mark.parametrize("late", [0, 2])
def test_a_current_that_flows_on_is_waited_for(flows: int, late: int) -> None:
    begins = first_of(flows, late)
    assert flows + late - 1 <= begins <= flows + late + 2


@pytest.mark.parametrize("noise_a", [0.01, 0.03])
def test_a_current_that_noise_hides_is_waited_for_too(noise_a: float) -> None:
    assert 49 <= first_of(50, noise_a=noise_a) <= 50 + 5 * 50 * 2 * noise_a


def test_a_filter_of_the_voltage_empties_first() -> None:
    plain, slow = first_of(12), first_of(12, filter_s=1e-3)
    assert slow - plain == pytest.approx(70, abs=1)  # 7 time constants


def test_a_filter_empties_also_where_a_current_stops_at_once() -> None:
    """Down to a tenth of the noise: of 7.4 V to 1 mV in 8.9 time constants, or in seven."""
    assert first_of(0, filter_s=1e-3) - first_of(0) == pytest.approx(70, abs=1)
    noisy = first_of(12, filter_s=1e-3, noise=1e-2)
    assert noisy - first_of(12) == pytest.approx(10 * np.log(13.4 / 1e-3), abs=1)


def test_a_short_part_tells_no_zero_of_the_current() -> None:
    assert first_of(12, count=OPENED + LONG - 1) == SAMPLES


def test_a_current_without_readings_tells_no_end() -> None:
    volts = np.where(np.arange(COUNT) < OPENED, 6.0, 3.0)
    amps = np.where(np.arange(COUNT) < OPENED, 1.0, np.nan)
    run = capture(
        100 * np.arange(COUNT), drive(0.5), COAST, starts=(0, 100 * OPENED), current=amps,
        terminal_voltage=volts,
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert shown_from(run) == SAMPLES


# a sampled wave: 20 kHz, readings of three periods

PERIOD_S, FINE, DRIVEN, ALL = 50e-6, 50, 400, 700
APERTURE_S, DELAY_S, CLAMP_V = 3 * PERIOD_S, 43e-6, 15.4
MOTOR = (0.253, 0.4e-3, 0.0306, 1.2e-5, 2.6e-5, 1.1e-2)
STEP_A, STEP_V = 5e-3, 1.5e-3  # noise of a reading


@cache
def wave(volts: float) -> tuple[Floats, Floats, Floats]:
    """Current, speed and terminal voltage at instants 1 us apart, up to each end of one."""
    reference = Reference(MOTOR)
    driven = np.full(ALL, volts)
    reference.run(PERIOD_S, driven, [Stretch(1), Stretch(DRIVEN, open=True, clamp_v=CLAMP_V)])
    times = PERIOD_S / FINE * (np.arange((ALL - 1) * FINE) + 0.5)
    current, speed = reference.states(times)[:2]
    flows = np.abs(current) > 1e-9
    opened = np.where(flows, -np.sign(current) * CLAMP_V, MOTOR[2] * speed)
    return current, speed, np.where(times < (DRIVEN - 1) * PERIOD_S, volts, opened)


def reading(fine: Floats, filter_s: float) -> Floats:
    """Means (samples,) of a window behind a filter of first order."""
    if filter_s:
        kept = np.exp(-PERIOD_S / FINE / filter_s)
        fine = lfilter([1.0 - kept], [1.0, -kept], fine)
    total = np.concatenate([[0.0], np.cumsum(fine)])
    end = np.maximum(np.arange(ALL) * FINE - round(DELAY_S / PERIOD_S * FINE), 0)
    wide = round(APERTURE_S / PERIOD_S * FINE)
    return np.asarray((total[end] - total[np.maximum(end - wide, 0)]) / wide)


@pytest.mark.parametrize("volts", [4.0, -4.0, 0.5])
@pytest.mark.parametrize("filter_s", [0.0, 12.5e-6, 200e-6])
def test_the_first_reading_of_a_wave_shows_the_back_emf_alone(
    volts: float, filter_s: float
) -> None:
    rng = np.random.default_rng(3)
    current, speed, terminals = wave(volts)
    emf, shown = MOTOR[2] * reading(speed, filter_s), reading(terminals, filter_s)
    amps = reading(current, 0.0) + rng.normal(0.0, STEP_A, ALL)
    channels = [
        Channel(name, unit, raw, kind="mean", aperture_s=APERTURE_S, delay_s=late, filter_s=tau)
        for name, unit, raw, late, tau in (
            (CURRENT, "A", amps, DELAY_S, 0.0),
            (VOLTAGE, "V", shown, DELAY_S + filter_s, filter_s),
        )
    ]
    run = capture(
        round(1e6 * PERIOD_S) * np.arange(ALL), drive(np.sign(volts) * 0.5), COAST,
        starts=(0, round(1e6 * PERIOD_S) * (DRIVEN - 1)), **{c.name: c for c in channels},
    )  # fmt: skip
    off = np.abs(shown - emf)[DRIVEN:]
    begins = shown_from(run)
    clean = int(np.flatnonzero(off > STEP_V)[-1]) + 1
    widest = 4 + round(2 * filter_s / PERIOD_S)  # later than need be
    assert clean <= begins <= clean + widest
    assert off[begins:].max() < CLAMP_V / 1000
