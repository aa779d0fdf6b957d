"""What a plan promises, held against fits of captures that another integrator made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Wiring
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.uncertainty.intervals import POSITIVE
from motorid.motor.parameters import Motor
from motorid.plan.predict import foresee, predict
from motorid.plan.skeleton import Bench, skeleton
from motorid.program import Program, Step, StepKind
from tests.exact_capture import CLOCK_HZ, FAULHABER, clean_capture
from tests.six_parameters import fit

NOISE = {CURRENT: 0.01, POSITION: 2e-3, VOLTAGE: 0.02}
MOTOR = Motor.of(FAULHABER)


def declared(capture: Capture, **gains: float) -> Capture:
    """With the noise and the gains that its channels have said of them."""
    channels = {
        name: replace(c, noise=NOISE[name], gain_uncertainty=gains.get(name, 0.0))
        for name, c in capture.channels.items()
    }
    known = Wiring(bridge_resistance_ohm=1e-6, bridge_resistance_uncertainty_ohm=1e-6)
    return replace(capture, channels=channels, wiring=known)


def noisy(capture: Capture, seed: int) -> Capture:
    """White noise as declared on every reading, the driving voltage's too."""
    rng = np.random.default_rng(seed)
    channels = {
        name: replace(c, raw=c.raw + c.noise * rng.standard_normal(len(capture)))
        for name, c in capture.channels.items()
    }
    return replace(capture, channels=channels)


def bench_of(capture: Capture) -> Bench:
    return Bench(capture.channels, CLOCK_HZ, round(capture.period_s * CLOCK_HZ), capture.wiring)


def program_of(capture: Capture) -> Program:
    """The capture's own, its last step cut to what is there."""
    assert capture.program is not None
    *steps, last = capture.program.steps
    whole = len(capture) * capture.period_s
    left = whole - sum(step.duration_s for step in steps)
    return Program((*steps, Step(last.kind, round(left, 9))))


@pytest.mark.slow
def test_the_errors_of_fits_are_as_large_as_predicted() -> None:
    """RMS over 24 captures, integrated by SciPy: within chi-square's 99 % range of all six."""
    runs = 24
    clean = declared(clean_capture(FAULHABER))
    foreseen = foresee(bench_of(clean), program_of(clean), MOTOR)
    assert foreseen is not None
    promised = foreseen.bare()  # the motor has none of the effects that a fit may not find
    errors: dict[str, list[float]] = {name: [] for name in PARAMETERS}
    for seed in range(runs):
        found = fit([noisy(clean, seed)]).parameters
        for name in PARAMETERS:
            unit = FAULHABER[name] if name in POSITIVE else 1.0
            errors[name].append((float(found[name].value or 0) - FAULHABER[name]) / unit)
    low, high = np.sqrt(chi2.ppf([0.005 / 6, 1 - 0.005 / 6], runs) / runs)
    for name in PARAMETERS:
        rms = float(np.sqrt(np.mean(np.square(errors[name]))))
        assert low < rms / promised.statistical[name] < high, name


def test_a_gain_reaches_the_parameters_as_algebra_says() -> None:
    """A current read high by u: R, L and K low by u where voltage and speed are right.

    v = R i + K ω keeps K; R i is fixed, so R falls by u; K i = J ω' then makes J rise by u.
    """
    capture = declared(clean_capture(FAULHABER), **{CURRENT: 0.01})
    promised = predict(bench_of(capture), program_of(capture), MOTOR)
    assert promised is not None
    by = promised.causes["current gain"]
    assert by["R"] == pytest.approx(0.01, rel=0.02)
    assert by["J"] == pytest.approx(0.01, rel=0.02)
    assert by["K"] < 1e-4
    assert promised.largest_cause("R") == "current gain"


def test_runs_lessen_noise_and_not_the_instruments() -> None:
    capture = declared(clean_capture(FAULHABER), **{CURRENT: 0.01})
    promised = predict(bench_of(capture), program_of(capture), MOTOR)
    assert promised is not None
    assert promised.reach("R", np.inf) == pytest.approx(1.96 * promised.instrument("R"), rel=1e-3)
    assert promised.runs_for("R", 0.05, 0.5) < promised.runs_for("R", 0.03, 0.5)
    needed = promised.runs_for("L", 0.03, 0.5)
    assert promised.reach("L", needed) == pytest.approx(0.03, rel=1e-6)


def test_a_skeleton_reads_as_the_other_integrator_does() -> None:
    clean = clean_capture(FAULHABER)
    quiet = skeleton(bench_of(clean), program_of(clean), MOTOR)
    for name in (CURRENT, POSITION):
        a, b = clean.channels[name].values, quiet.channels[name].values
        assert np.abs(a - b).max() < 1e-6 * np.ptp(a), name


def test_a_program_that_tells_nothing_promises_nothing() -> None:
    clean = clean_capture(FAULHABER)
    short = Program((Step(StepKind.COAST, 5e-4),))
    assert predict(bench_of(clean), short, MOTOR) is None
