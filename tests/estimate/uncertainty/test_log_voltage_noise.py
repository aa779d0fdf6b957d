"""Noise of a log's voltage, against fits of logs that really had more of it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.fit.multistart import settled
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.voltage_jumps import scatter
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import log_voltage_noise
from motorid.estimate.uncertainty.errors_in_variables import hidden, with_errors
from tests.estimate.effects.benches import measured

Floats = NDArray[np.float64]

R, L, K, B, J, T0 = 2.0, 1e-3, 0.02, 1e-6, 1e-5, 1e-3
PERIOD_S, COUNT, FINE = 2e-4, 3000, 20
NOISE_V = 0.1
TRUE = dict(zip(PARAMETERS, (R, L, K, B, J, T0), strict=True))


def turned() -> tuple[Floats, Floats, Floats]:
    """Volts, amperes and rad/s (COUNT,) of a motor under a sine, by small steps of Euler's."""
    h = PERIOD_S / FINE
    volts = 6.0 * np.sin(2.0 * np.pi * 8.0 * h * np.arange(COUNT * FINE))
    out, i, w = np.empty((2, COUNT)), 0.0, 0.0
    for n, v in enumerate(volts.tolist()):
        if n % FINE == 0:
            out[:, n // FINE] = i, w
        torque = K * i
        dry = T0 * np.sign(w) if w else max(-T0, min(T0, torque))
        i, before = i + h * (v - R * i - K * w) / L, w
        w += h * (torque - B * w - dry) / J
        w = 0.0 if w * before < 0.0 and abs(torque) < T0 else w
    return volts[::FINE], out[0], out[1]


@cache
def log(noise_v: float) -> Capture:
    """What a logger keeps of it, the voltage with that much noise."""
    rng = np.random.default_rng(7)
    columns = (VOLTAGE, "V", noise_v), (CURRENT, "A", 0.01), (SPEED, "rad/s", 0.2)
    channels = {
        name: Channel(name, unit, values + sd * rng.standard_normal(COUNT))
        for (name, unit, sd), values in zip(columns, turned(), strict=True)
    }
    return Capture(np.arange(COUNT) * 200, 1e6, channels)


def fitted(capture: Capture) -> tuple[MotorRecord, Solution]:
    record = MotorRecord(capture, PARAMETERS, {})
    return record, settled([record], PARAMETERS, TRUE)


def shaken(capture: Capture, seed: int) -> Capture:
    """With as much noise of the voltage once more."""
    volts = capture.channels[VOLTAGE]
    noise = scatter(volts.values) * np.random.default_rng(seed).standard_normal(len(volts.raw))
    return replace(
        capture, channels={**capture.channels, VOLTAGE: replace(volts, raw=volts.raw + noise)}
    )


def deviations(said: list[log_voltage_noise.Step]) -> Floats:
    return np.asarray(np.sqrt(np.sum([one.shared**2 for one in said], axis=0)))


def test_steps_are_as_large_as_those_of_fits_with_more_noise() -> None:
    """Under one sine L and a lag are nearly one: what seems to tell them apart is the noise."""
    capture = log(NOISE_V)
    record, usual = fitted(capture)
    said = deviations(list(log_voltage_noise.steps(0, record, usual)))
    others = [fitted(shaken(capture, seed))[1] for seed in range(8)]
    moved = np.array([(o.values - usual.values) / usual.slopes for o in others])
    found = np.sqrt(np.mean(moved**2, axis=0))
    noise = np.sqrt(np.diag(usual.covariance))
    assert (found / noise)[:2].min() > 5.0  # far beyond what residuals tell of R and L
    ratio = (said / found)[:2]  # of eight draws each, whose searches end in several valleys
    assert ratio.min() > 0.2
    assert ratio.max() < 5.0
    assert (said / noise)[:2].min() > 5.0
    away = (np.array(list(TRUE.values())) / usual.values)[:2]
    assert (np.abs(np.log(away)) < 3.0 * said[:2]).all()  # the truth is within their reach


def test_what_they_do_stands_in_the_budget_and_in_the_lags() -> None:
    record, usual = fitted(log(NOISE_V))
    errors = hidden(usual, [record])
    assert len(errors) == log_voltage_noise.DRAWS
    place = [one.name for one in record.instances].index("voltage late")
    before, after = (s.own_covariance[0][place, place] for s in (usual, with_errors(usual, errors)))
    assert after == pytest.approx(before + sum(one.own[place] ** 2 for one in errors))
    assert after > 9.0 * before
    assert abs(usual.own[0][place]) < 3.0 * np.sqrt(after)  # it has none


def test_a_quiet_voltage_moves_nothing() -> None:
    record, usual = fitted(log(0.0))
    moved = deviations(list(log_voltage_noise.steps(0, record, usual)))
    assert (moved < 0.3 * np.sqrt(np.diag(usual.covariance))).all()


def test_a_record_with_a_program_has_none() -> None:
    record = MotorRecord(measured(), PARAMETERS, {})
    solution = settled([record], PARAMETERS, TRUE)
    assert list(log_voltage_noise.steps(0, record, solution)) == []


def test_information_that_is_all_noise_leaves_a_tenth() -> None:
    """Of two directions, one that noise tells nothing of, and one that it tells all of."""
    rows = np.eye(4)[:, :2] * [2.0, 3.0]
    usual = SimpleNamespace(orthogonal=rows, sigmas=np.ones(1))
    more = np.eye(4)[:, 2:] * [0.0, 30.0]
    line = SimpleNamespace(
        orthogonal=(rows + more) / 2.0, sigmas=np.full(1, 2.0), slices=(slice(0, 4),)
    )
    given: Any = usual, [line, line]
    inverse = log_voltage_noise._without_what_noise_tells(rows.T @ rows, *given)
    np.testing.assert_allclose(inverse, np.diag([1.0 / 4.0, 10.0 / 9.0]), atol=1e-12)
