"""A small cogging torque by the motor's linear equations, against the response that has it."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.effects.rotor.torque_wave import Run
from motorid.motor.reading import Output, Quantity
from motorid.motor.wide import AT_REST, START, WideResponse
from tests.estimate.logs_with_effects import LEVELS, TRUTH, VOLTS, motor_with, run

PERIOD_S, COUNT = 1e-4, 300
PARTS = np.repeat(LEVELS[:3], COUNT) * VOLTS  # from rest, and two reversals
SIZE = 1e-3  # of the friction


@pytest.mark.parametrize("order", [4, 12, 30])
@pytest.mark.parametrize(("part", "phase"), [("real", 0.0), ("imag", -np.pi / 2)])
def test_what_it_does_is_what_the_response_shows(order: int, part: str, phase: float) -> None:
    """From rest, through reversals and at speed; its phase is that of a cosine and of a sine."""
    plain = motor_with({})
    steady = run(plain, PARTS, PERIOD_S)
    size = SIZE * TRUTH["T0"]
    response = WideResponse(PERIOD_S, PARTS, [Output(q) for q in Quantity])
    initial = list(AT_REST)
    initial[START.index("cogging_phase")] = phase - np.pi / 2  # less a sine is a cosine
    cogged = motor_with({"cogging": size, "cogging_per_turn": order})
    response.angle = np.ascontiguousarray(steady[2])
    response.plan(cogged, initial)
    moved = response(cogged, initial)
    response.plan(plain, AT_REST)
    shown = (moved - response(plain, AT_REST)) / size
    waves = Run(plain[:6], PERIOD_S, *steady).waves([order])
    for true, wave in zip(shown, waves, strict=True):
        told = getattr(wave[0], part)
        assert np.linalg.norm(told - true) < 0.05 * np.linalg.norm(true)


def test_a_rotor_that_stands_shows_none() -> None:
    still = np.full(50, 0.3 * TRUTH["T0"] / TRUTH["K"])
    waves = Run(motor_with({})[:6], PERIOD_S, still, 0.0 * still, 0.0 * still).waves([7])
    assert not any(np.any(wave) for wave in waves)
