"""A tachogenerator that keeps a fixed voltage: what it shows, and a fit that names and finds it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import POSITION, SPEED, Capture, Channel
from motorid.estimate.effects.reading.speed_dead_band import SPEED_DEAD_BAND, swallowed
from motorid.estimate.results.status import Status
from tests.estimate.effects.benches import moved, record, usual
from tests.exact_capture import FAULHABER, Plan, clean_capture, ended, noisy
from tests.six_parameters import fit

PLAN = Plan(volts=(6.0, -4.0, 2.0))
NOISE = 0.3  # rad/s


def beside_a_tacho(band: float) -> Capture:
    """Whose speed reads nearer to zero by so many rad/s."""
    capture = noisy(ended(clean_capture(FAULHABER, PLAN)), 1, 1e-3, 0.0)
    clean = clean_capture(FAULHABER, PLAN).channels[POSITION].values
    speed = np.gradient(clean, capture.period_s)
    scatter = NOISE * np.random.default_rng(2).standard_normal(len(speed))
    shown = np.where(np.abs(speed) > band, speed - np.sign(speed) * band, 0.0) + scatter
    kept = {n: c for n, c in capture.channels.items() if n != POSITION}
    tacho = Channel(SPEED, "rad/s", shown, noise=NOISE, gain_uncertainty=1e-3)
    return replace(capture, channels={**kept, SPEED: tacho})


def test_it_shows_less_of_either_sign_and_nothing_within() -> None:
    shown = swallowed(np.array([-5.0, -0.5, 0.0, 0.9, 3.0]), 1.0)
    assert shown == pytest.approx([-4.0, 0.0, 0.0, 0.0, 2.0])


def test_its_tangent_is_one_against_the_motion() -> None:
    change, speed = moved("moving", SPEED_DEAD_BAND)[SPEED], usual("moving")[SPEED]
    fast = np.abs(speed) > 1.0
    assert change[fast] == pytest.approx(-np.sign(speed[fast]))
    assert SPEED_DEAD_BAND.prior(record("moving"), 0) is None  # no fit has it by itself


@pytest.mark.slow
def test_a_fit_names_it_and_estimates_it_with_the_motor() -> None:
    top = 0.01 * 6.0 / FAULHABER["K"]
    found = fit([beside_a_tacho(top)])
    (said,) = [s for s in found.suspects if s.strength == "named"]
    assert (said.code, said.allowed) == ("speed_dead_band", True)
    size = found.nuisance[SPEED_DEAD_BAND.name]
    assert size.value == pytest.approx(top, abs=4.0 * size.total)
    for name, truth in FAULHABER.items():
        p = found.parameters[name]
        assert p.status is Status.ESTIMATED
        assert p.value == pytest.approx(truth, abs=4.0 * p.total)


@pytest.mark.slow
def test_a_tacho_without_one_is_not_accused() -> None:
    assert [s.code for s in fit([beside_a_tacho(0.0)]).suspects if s.strength == "named"] == []
