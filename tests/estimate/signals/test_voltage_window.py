"""What a slow terminal filter does to the first readings after a command, and to L."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from motorid.sim._plant import ffi, lib
from scipy.signal import lfilter

import motorid
from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Channel, Phase, Wiring
from motorid.estimate.signals.time_grid import lay
from motorid.estimate.signals.voltage_window import Window
from motorid.motor.reading import Output, Quantity
from motorid.program import Decay, Program, Step, StepKind
from motorid.sim.bench import plant_params
from motorid.sim.chain import draw_chain
from motorid.sim.options import parse_url

H, FINE, TAU, LATE = 250e-6, 5e-6, 58.75e-6, 236e-6
EACH = round(H / FINE)
PHASES = (0, 200, 1000)  # samples at which rest, drive and coast begin
COUNT, DUTY = 1800, 0.9


def test_a_filter_s_remnant_of_the_command_before_is_taken_out() -> None:
    """A step from 3 V to 20 V, from which a line falls, by an exact filter on a fine grid."""
    n = 40
    at = (np.arange(n * EACH) + 0.5) * FINE
    volts = np.where(at < 20 * H, 3.0, 20.0 - 400.0 * (at - 20 * H))
    keep = np.exp(-FINE / TAU)
    seen = lfilter([1 - keep], [1, -keep], volts, zi=[keep * 3.0])[0]
    total = np.concatenate([[0.0], np.cumsum(seen)]) * FINE
    ends = np.arange(n) * H - LATE
    grid = np.interp(ends, np.arange(len(total)) * FINE, total)
    grid = (grid - np.interp(ends - H, np.arange(len(total)) * FINE, total)) / H
    line = lay(_capture(n, {VOLTAGE: Channel(VOLTAGE, "V", grid)}, (0, 20)))
    window = Window(H, H, LATE + TAU, TAU)
    found = window.readings(grid, line)
    assert window.lag == 1
    first = line.parts[1].start
    assert list(np.flatnonzero(np.isnan(found[:-1]))) == [0, first - 1, first]
    # a line is delayed by a filter's time constant, whatever the window's width
    k = np.arange(first + 1, n - 1)
    middle = (k - 20) * H - (LATE + TAU - window.lag * H) - H / 2
    left_over = 400.0 * TAU * np.exp(-(middle - H / 2 + TAU) / TAU)  # of the corner of that line
    assert np.abs(found[k] - (20.0 - 400.0 * middle)).max() < left_over[0] + 1e-3
    plain = Window(H, H, LATE + TAU).readings(grid, line)
    assert plain[first + 1] < found[first + 1] - 0.04  # the remnant of 17 V


@pytest.fixture(scope="module")
def sensed() -> tuple[Capture, float]:
    """The simulator's plant behind such a filter, and its true inductance."""
    options = parse_url("sim://?motor=maxon-re35&heating=0&ambient=25&cogging=0&ripple=0")
    params = plant_params(options, draw_chain(options))
    params.dead_time = 0.0
    plant = ffi.new("plant *")
    lib.plant_init(plant, params)
    rows = np.zeros((COUNT * EACH, 3))
    for n in range(len(rows)):
        if n % EACH == 0 and n // EACH in PHASES:
            mode = lib.PLANT_DRIVE if n // EACH == PHASES[1] else lib.PLANT_COAST
            driven = mode == lib.PLANT_DRIVE
            lib.plant_command(plant, mode, DUTY if driven else 0.0, lib.PLANT_SYNCHRONOUS_SLOW)
        plant.i_dt = plant.v_dt = 0.0
        lib.plant_advance(plant, FINE)
        rows[n] = plant.i_dt / FINE, plant.v_dt / FINE, plant.angle
    keep = np.exp(-FINE / TAU)
    # the mean over a short stretch of what an exact filter says, to first order
    filtered = lfilter([1 - keep], [1, -keep], rows[:, 1])
    filtered = (filtered + np.concatenate([[0.0], filtered[:-1]])) / 2
    place = np.arange(len(rows) + 1) * FINE
    ends = np.arange(COUNT) * H - LATE

    def means(values: np.ndarray) -> np.ndarray:
        total = np.concatenate([[0.0], np.cumsum(values)]) * FINE
        return (np.interp(ends, place, total) - np.interp(ends - H, place, total)) / H

    rng = np.random.default_rng(5)
    angle = np.concatenate([[0.0], rows[:, 2]])[np.arange(COUNT) * EACH]
    current = means(rows[:, 0]) + 0.004 * rng.standard_normal(COUNT)
    volts = means(filtered) + 0.005 * rng.standard_normal(COUNT)
    mean = {"kind": "mean", "aperture_s": H}
    channels = {
        CURRENT: Channel(CURRENT, "A", current, delay_s=LATE, **mean),
        POSITION: Channel(POSITION, "rad", angle + 1e-3 * rng.standard_normal(COUNT)),
        VOLTAGE: Channel(
            VOLTAGE, "V", volts, delay_s=LATE + TAU, filter_s=TAU, sense="terminals", **mean
        ),
    }
    return _capture(COUNT, channels, PHASES), params.inductance


def _capture(count: int, channels: dict[str, Channel], phases: Sequence[int]) -> Capture:
    steps = [Step(StepKind.COAST, H)] * len(phases)
    steps[1] = Step(StepKind.DRIVE_DUTY, H, DUTY, Decay.SYNCHRONOUS_SLOW)
    return Capture(
        ticks=np.arange(count, dtype=np.int64) * round(H * 1e6),
        clock_hz=1e6,
        channels=channels,
        wiring=Wiring(0.04, 0.004, pwm_hz=20e3, supply_voltage_v=34.0, brush_drop_v=0.0),
        program=Program(tuple(steps)),
        phases=tuple(Phase(k, round(n * H * 1e6)) for k, n in enumerate(phases)),
    )


def error_of_l(sensed: tuple[Capture, float], filter_s: float) -> float:
    """Relative, with that filter declared."""
    capture, inductance = sensed
    told = replace(capture.channels[VOLTAGE], filter_s=filter_s)
    capture = replace(capture, channels={**capture.channels, VOLTAGE: told})
    return motorid.fit(capture).parameters["L"].value / inductance - 1


@pytest.mark.slow
def test_l_is_right_behind_a_slow_terminal_filter(sensed: tuple[Capture, float]) -> None:
    told, as_delay = error_of_l(sensed, TAU), error_of_l(sensed, 0.0)
    # what a supply's capacitor leaves of it is 0.0015; the first interval is not only late, and a
    # filter declared as a delay leaves 0.0033
    assert abs(told) < 0.0025
    assert abs(told) < abs(as_delay)


SLOW_V, SLOW_OHM = (2.0, 9.0, -6.0, 4.0), 0.5  # a source in four steps, and what is before it
EACH_STEP, FINER = 80, 200  # intervals, and places in one


@pytest.mark.parametrize("samples", [0.6, 3.0, 5.0, 10.0])
@pytest.mark.parametrize("aperture_s", [0.0, H / 2])
def test_a_source_behind_a_slow_filter_is_the_same_all_through_its_step(
    samples: float, aperture_s: float
) -> None:
    """Its voltage v0 - r i, with a current that follows each step, by an exact filter."""
    tau, rise_s, late_s = samples * H, 2.5 * H, 0.1 * H
    step = H / FINER
    source = np.repeat(SLOW_V, EACH_STEP * FINER)
    current = lfilter([-np.expm1(-step / rise_s)], [1, -np.exp(-step / rise_s)], source)
    window = Window(H, aperture_s, late_s + tau, tau)
    line = lay(_capture(len(SLOW_V) * EACH_STEP, {}, range(0, len(SLOW_V) * EACH_STEP, EACH_STEP)))

    def read(fine: np.ndarray) -> np.ndarray:
        """As the converter does at every tick."""
        seen = lfilter([-np.expm1(-step / tau)], [1, -np.exp(-step / tau)], fine)
        total = np.concatenate([[0.0], np.cumsum(seen)]) * step
        ends, wide = H * np.arange(line.count) - late_s, aperture_s or step
        place = np.arange(len(total)) * step
        return (np.interp(ends, place, total) - np.interp(ends - wide, place, total)) / wide

    volts = window.readings(read(source - SLOW_OHM * current), line)
    amperes = window.current(read(current)[None, :], np.zeros(line.count), line)
    found = volts + SLOW_OHM * amperes
    assert window.foresees == window.lag
    for part, level in zip(line.parts[1:-1], SLOW_V[1:-1], strict=True):
        shown = found[part.slice]
        assert np.isnan(shown[len(shown) - window.foresees :]).all()
        assert np.isfinite(shown).sum() > EACH_STEP / 4
        assert np.nanmax(np.abs(shown - level)) < 0.01 * abs(level)


def test_a_current_is_seen_through_the_same_window() -> None:
    window = Window(H, H, LATE + TAU, TAU)
    assert window.outputs == [Output(Quantity.CURRENT, H, LATE, filter_s=TAU)]
