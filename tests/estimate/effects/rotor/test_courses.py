"""What ripple, cogging and an encoder's error do to the readings, against phasors by hand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, Capture
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.rotor.encoder_error import ENCODER_ERROR
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.r_ripple import R_RIPPLE
from motorid.estimate.effects.rotor.repeating import of_order
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.repeating_response import RepeatingResponse
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.measurements import EMF
from tests.exact_capture import FAULHABER, Plan, clean_capture

PLAN = Plan(volts=(6.0,), count=4000, aperture_s=0.0, delay_s=0.0)
PERIODS = 7
STEADY = slice(1300, 1790)  # samples of the drive that are near its end


def fine(capture: Capture) -> Capture:
    """With an encoder of many counts."""
    position = replace(capture.channels[POSITION], resolution=1e-4)
    return replace(capture, channels={**capture.channels, POSITION: position})


@cache
def response() -> RepeatingResponse:
    record = MotorRecord(fine(clean_capture(FAULHABER, PLAN)), PARAMETERS, {})
    own = np.array([u.start for u in record.unknowns])
    return RepeatingResponse(record, np.array(list(FAULHABER.values())), own)


@cache
def phasor(quantity: InfluenceQuantity, block: str, quarter: int) -> complex:
    """The block's course over the steady turns, as amplitude and phase of e^(i order angle)."""
    at = response()
    course = at.slopes(PERIODS)[of_order(quantity, PERIODS)[quarter]][block]
    m = at.record.block(block)
    assert m is not None
    inside = (m.keep >= STEADY.start) & (m.keep < STEADY.stop)
    wave = np.exp(1j * PERIODS * at.angle[m.keep])
    since = (m.keep - STEADY.start) * PLAN.period_s
    settling = np.exp(
        -since * (FAULHABER["K"] ** 2 / FAULHABER["R"] + FAULHABER["B"]) / FAULHABER["J"]
    )
    table = np.column_stack([wave.real, -wave.imag, np.ones(len(wave)), since, settling])
    real, imaginary, *_ = np.linalg.lstsq(table[inside], course[inside], rcond=None)[0]
    return complex(real, imaginary)


def by_hand(volts: complex, torque: complex) -> tuple[complex, complex]:
    """Current and speed that a voltage and a torque of the ripple's frequency give."""
    at = response()
    R, L, K, B, J, _ = FAULHABER.values()
    speed = float(np.gradient(at.angle)[STEADY].mean()) / PLAN.period_s
    s = 1j * PERIODS * speed
    current, speed_ = np.linalg.solve([[R + s * L, K], [-K, B + s * J]], [volts, torque])
    return current, speed_


def steady() -> tuple[float, float]:
    """Current (A) and speed (rad/s) at the end of the drive."""
    at = response()
    current = at.record.block(CURRENT)
    assert current is not None
    speed = np.gradient(at.angle)[STEADY].mean() / PLAN.period_s
    return float(current.values[STEADY].mean()), float(speed)


@pytest.mark.parametrize("quarter", [0, 1])
@pytest.mark.parametrize("quantity", [K_RIPPLE, R_RIPPLE, COGGING], ids=lambda q: q.name)
def test_a_steady_drive_answers_as_two_linear_equations_do(
    quantity: InfluenceQuantity, quarter: int
) -> None:
    current, speed = steady()
    K, R = FAULHABER["K"], FAULHABER["R"]
    forces = {
        K_RIPPLE: (-K * speed, K * current),
        R_RIPPLE: (-R * current, 0.0),
        COGGING: (0.0, 1.0),
    }
    turned = (1.0, 1.0j)[quarter]
    amperes, rate = (turned * x for x in by_hand(*forces[quantity]))
    angle = rate / (1j * PERIODS * speed)
    assert phasor(quantity, CURRENT, quarter) == pytest.approx(amperes, rel=0.02)
    assert phasor(quantity, POSITION, quarter) == pytest.approx(angle, rel=0.03)


def test_an_open_bridge_shows_the_ripple_of_k_at_once() -> None:
    at = response()
    one = of_order(K_RIPPLE, PERIODS)[0]
    course, m = at.slopes(PERIODS)[one][EMF], at.record.block(EMF)
    assert m is not None
    turning = np.abs(m.values) > 0.5 * np.abs(m.values).max()
    before = np.cos(PERIODS * (at.angle[m.keep] - 0.5 * np.gradient(at.angle)[m.keep]))
    # a mean over the sample period: a little less than at its middle
    assert course[turning] == pytest.approx(m.values[turning] * before[turning], abs=0.15)


def test_an_encoder_shows_its_error_and_the_motor_does_not() -> None:
    at = response()
    cosine, sine = of_order(ENCODER_ERROR, 1)
    error, m = at.encoder_error(1), at.record.block(POSITION)
    assert m is not None
    assert set(error[cosine]) == {POSITION}
    assert error[cosine][POSITION] == pytest.approx(np.cos(at.angle[m.keep]))
    assert error[sine][POSITION] == pytest.approx(-np.sin(at.angle[m.keep]))


def test_what_bends_grows_with_the_square() -> None:
    at = response()
    slopes = at.slopes(PERIODS)
    sizes = dict.fromkeys(slopes, 0.0) | {of_order(K_RIPPLE, PERIODS)[0]: 0.02}
    small = at.bend(PERIODS, slopes, sizes)[CURRENT][STEADY]
    twice = {one: 2.0 * size for one, size in sizes.items()}
    large = at.bend(PERIODS, slopes, twice)[CURRENT][STEADY]
    assert large.mean() == pytest.approx(4.0 * small.mean(), rel=0.1)
    assert (
        np.abs(small).max()
        < 0.05 * 0.02 * np.abs(slopes[of_order(K_RIPPLE, PERIODS)[0]][CURRENT]).max()
    )


@pytest.mark.parametrize("gear", [1.0, 5.0, 0.5])
@pytest.mark.parametrize("name", [POSITION, SPEED])
def test_an_encoder_behind_a_gear_errs_by_its_own_turn(name: str, gear: float) -> None:
    """Its reading, times the gear, errs by gear e cos(n angle/gear)."""
    period_s, rate = 1e-3, 40.0
    angle = rate * period_s * np.arange(2000)
    motion = SimpleNamespace(block=SimpleNamespace(name=name), keep=np.arange(0, 2000, 2))
    named = {name: motion}
    record = SimpleNamespace(
        block=named.get, gear=gear, timeline=SimpleNamespace(period_s=period_s)
    )
    at = object.__new__(RepeatingResponse)
    at.record, at.angle = record, angle  # type: ignore[assignment]
    cosine, sine = of_order(ENCODER_ERROR, 2)
    found = at.encoder_error(2)
    turned = 2.0 * angle[motion.keep] / gear
    if name == POSITION:
        assert found[cosine][name] == pytest.approx(gear * np.cos(turned))
        assert found[sine][name] == pytest.approx(-gear * np.sin(turned))
    else:  # its derivative in time
        assert found[cosine][name] == pytest.approx(-2.0 * rate * np.sin(turned))
        assert found[sine][name] == pytest.approx(-2.0 * rate * np.cos(turned))
    named.clear()
    assert at.encoder_error(2) == {}
