"""Irregular stamps beside a winding that is quick for the fit's grid."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.mistakes.plant import Motor
from bench.stranger import chain
from bench.stranger.chain import Floats
from bench.stranger.plant import Source, turn
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.logs import log_grid
from motorid.estimate.signals.time_grid import FINER_GRID, lay
from tests.six_parameters import fit

RATE = 2500.0
MOTOR = Motor(0.5, 0.5 * 0.16 / RATE, 0.038, 7e-5, 4e-5, 14e-3, 12.0)  # L/R of .16 samples
CLOCK_HZ, TICKS = 1e9, 60


@cache
def logged(jitter: float, late: float = 0.0, motor: Motor = MOTOR) -> Capture:
    """A log by converters of 16 bits, by a simulator that shares nothing with the fit.

    ``jitter``: of a period, by which its stamps are off a grid, each as it is logged; ``late``: of
    a period, by which the voltage jumps before the reading that shows it.
    """
    rng = np.random.default_rng(5)
    volts = chain.wave("steps", motor.volts, motor.tau_s, RATE, rng)
    dt = 1.0 / RATE / TICKS
    true = turn(motor, np.repeat(volts, TICKS), dt, Source())
    places = np.arange(1, len(volts)) + late
    stamps = (places + jitter * rng.uniform(-1.0, 1.0, len(volts) - 1)) / RATE
    spans = {"v": 1.25 * motor.volts, "i": 1.3 * motor.stall_a, "w": 1.3 * motor.top_rad_s}
    series = {"v": true.terminal, "i": true.current, "w": true.speed}

    def shown(column: str) -> Floats:
        read = chain.instants(series[column], dt, stamps, column == "v")
        return chain.converted(read, spans[column], 16, 2.0, rng)

    channels = {
        name: Channel(name, unit, shown(column))
        for name, column, unit in ((VOLTAGE, "v", "V"), (CURRENT, "i", "A"), (SPEED, "w", "rad/s"))
    }
    return Capture(np.rint(stamps * CLOCK_HZ).astype(np.int64), CLOCK_HZ, channels)


@pytest.mark.slow
def test_a_finer_grid_lays_its_ticks_closer_and_no_closer_than_is_allowed() -> None:
    capture = logged(0.15)
    finer = replace(capture, provenance={FINER_GRID: 2})
    finest = replace(capture, provenance={FINER_GRID: 10**6})
    assert lay(finer).period_s == pytest.approx(lay(capture).period_s / 2)
    assert lay(finest).count <= 101 * len(capture)


@pytest.mark.slow
def test_a_quick_winding_is_fitted_on_a_finer_grid() -> None:
    """On the usual grid L was off by 91 %, and R by .27 %."""
    _, solution = solved([logged(0.15)], {}, ())
    found = dict(zip((u.name for u in solution.unknowns), solution.values, strict=True))
    assert found["L"] == pytest.approx(MOTOR.L, rel=0.05)
    assert found["R"] == pytest.approx(MOTOR.R, rel=5e-4)
    assert found["K"] == pytest.approx(MOTOR.K, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("jitter", "finer"), [(0.15, True), (0.0, False)])
def test_only_readings_between_ticks_ask_for_it(jitter: float, finer: bool) -> None:
    """Four times as many ticks are tried then; these readings do not tell the two apart."""
    records, _ = solved([logged(jitter)], {}, ())
    assert (records[0].between_ticks is not None) is finer


@pytest.mark.slow
@pytest.mark.parametrize(
    "late",
    [0.1, pytest.param(0.45, marks=pytest.mark.study), pytest.param(0.7, marks=pytest.mark.study)],
)
def test_a_voltage_that_jumps_between_two_readings_moves_no_parameter(late: float) -> None:
    """With four ticks a sample R was off by 6 standard uncertainties at .1, J by 8, unnamed."""
    motor = replace(MOTOR, L=0.4 * MOTOR.R / RATE)
    found = fit([logged(0.0, late, motor)])
    for name in ("R", "L", "K", "J"):
        p, true = found.parameters[name], getattr(motor, name)
        assert p.value is not None
        assert p.total
        assert abs(p.value - true) < 4.0 * p.total
        assert p.value == pytest.approx(true, rel=0.02 if name == "L" else 2e-4)
    assert not [one.code for one in found.suspects if one.strength == "named"]


@pytest.mark.slow
def test_a_search_that_goes_astray_leaves_the_coarse_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(log_grid, "WORSE", -np.inf)
    records, _ = solved([logged(0.15)], {}, ())
    assert FINER_GRID not in records[0].capture.provenance
