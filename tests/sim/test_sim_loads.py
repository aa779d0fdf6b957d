"""Quadratic friction, friction by direction and a flexible shaft, against closed forms."""

from __future__ import annotations

from math import cos, exp, sqrt
from typing import Any

import pytest


def test_quadratic_friction_slows_a_coast_as_a_hyperbola(make: Any) -> None:
    J, C, w0 = 1e-6, 2e-9, 400.0
    plant = make(inertia=J, quadratic=C)
    plant.c.speed, plant.c.direction = w0, 1
    plant.coast()
    plant.advance(0.5)
    assert plant.c.speed == pytest.approx(w0 / (1 + C * w0 * 0.5 / J), rel=1e-8)


@pytest.mark.parametrize("sign", [1, -1])
def test_friction_by_direction_stops_a_coast_sooner_one_way(make: Any, sign: int) -> None:
    J, T0, d, w0 = 1e-6, 1e-3, 0.25, 100.0
    plant = make(inertia=J, coulomb=T0, asymmetry=d)
    plant.c.speed, plant.c.direction = sign * w0, sign
    plant.coast()
    plant.advance(0.05)
    assert plant.c.speed == pytest.approx(sign * (w0 - T0 * (1 + sign * d) * 0.05 / J), rel=1e-8)


@pytest.mark.parametrize("sign", [1, -1])
def test_fresh_friction_falls_while_the_motor_turns(make: Any, sign: int) -> None:
    """dw/dt = −(T0/J)(1 + f exp(−t/time)): in closed form. While it stands nothing falls."""
    J, T0, fresh, time, w0, t = 1e-6, 1e-3, 0.5, 0.02, 100.0, 0.05
    plant = make(inertia=J, coulomb=T0, fresh_friction=fresh, fresh_time=time, max_step=2e-6)
    plant.coast()
    plant.advance(t)
    assert plant.c.fresh == 1.0
    plant.c.speed, plant.c.direction = sign * w0, sign
    plant.coast()
    plant.advance(t)
    lost = T0 / J * (t + fresh * time * (1 - exp(-t / time)))
    assert plant.c.speed == pytest.approx(sign * (w0 - lost), rel=1e-4)
    assert plant.c.fresh == pytest.approx(exp(-t / time), rel=1e-9)


def test_two_masses_swing_at_their_resonance_and_keep_their_energy(make: Any) -> None:
    J, load, stiffness = 1e-6, 3e-6, 0.02
    plant = make(inertia=J, load_inertia=load, shaft_stiffness=stiffness)
    plant.c.speed, plant.c.direction = 10.0, 1  # the load rests
    plant.coast()
    energy, mean = plant.stored, 10.0 * J / (J + load)
    resonance = sqrt(stiffness * (1 / J + 1 / load))
    for k in range(1, 6):
        plant.advance(1e-3)
        swing = (10.0 - mean) * cos(resonance * k * 1e-3)
        assert plant.c.speed == pytest.approx(mean + swing, rel=1e-6, abs=1e-6)
    assert plant.stored == pytest.approx(energy, rel=1e-8)


def test_a_damped_shaft_turns_its_swing_into_heat(make: Any) -> None:
    plant = make(load_inertia=2e-6, shaft_stiffness=0.02, shaft_damping=1e-4)
    plant.c.speed, plant.c.direction = 10.0, 1
    plant.coast()
    before = plant.stored
    plant.advance(0.5)
    assert plant.c.speed == pytest.approx(10.0 / 3, rel=1e-6)
    assert plant.c.friction_energy == pytest.approx(before - plant.stored, rel=1e-6)
