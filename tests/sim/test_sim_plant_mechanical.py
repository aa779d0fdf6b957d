"""Motion, friction and heat against closed forms and an independent integrator."""

from __future__ import annotations

from math import exp, log, tau
from typing import Any

import numpy as np
import pytest
from motorid.sim._plant import ffi, lib
from scipy.integrate import solve_ivp


def test_a_full_duty_start_agrees_with_lsoda(make: Any) -> None:
    R, L, K, J, B, T0, V = 2.0, 400e-6, 0.01, 1e-6, 2e-7, 1e-3, 12.0
    plant = make(viscous=B, coulomb=T0)
    plant.drive(1.0)

    def motion(_t: float, y: np.ndarray) -> list[float]:
        i, w, _angle = y
        moving = w > 0 or K * i > T0
        pull = (K * i - B * w - T0) / J if moving else 0.0
        return [(V - R * i - K * w) / L, pull, w]

    breaks = -L / R * log(1 - T0 / K * R / V)  # locked until the torque exceeds friction
    first = [T0 / K, 0.0, 0.0]
    times = np.linspace(breaks, 0.05, 40)
    reference = solve_ivp(
        motion, (breaks, 0.05), first, method="LSODA", t_eval=times, rtol=1e-11, atol=1e-13
    )
    plant.advance(breaks)
    for n, _time in enumerate(times):
        if n:
            plant.advance(float(times[n] - times[n - 1]))
        state = plant.c.current, plant.c.speed, plant.c.angle
        assert state == pytest.approx(tuple(reference.y[:, n]), rel=2e-6, abs=2e-6)


def test_coast_down_is_exponential_with_an_exact_stop(make: Any) -> None:
    J, B, T0, w0 = 1e-6, 5e-7, 2e-4, 400.0
    plant = make(inertia=J, viscous=B, coulomb=T0)
    plant.c.speed = w0
    plant.c.direction = 1
    plant.coast()
    at = 0.3
    plant.advance(at)
    assert plant.c.speed == pytest.approx((w0 + T0 / B) * exp(-B * at / J) - T0 / B, rel=1e-8)
    stops = J / B * log(1 + w0 * B / T0)
    plant.advance(stops - at + 0.1)
    assert plant.c.speed == 0.0
    assert plant.c.direction == 0
    turned = (w0 + T0 / B) * J / B * (1 - exp(-B * stops / J)) - T0 / B * stops
    assert plant.c.angle == pytest.approx(turned, rel=1e-8)


def test_it_sticks_below_breakaway_and_slides_above(make: Any) -> None:
    below, above = (
        make(coulomb=1e-3, stiction=3e-3, stribeck_speed=1.0, supply_voltage=volts)
        for volts in (0.59, 0.61)  # K V / R = 2.95 and 3.05 mN·m
    )
    for plant in (below, above):
        plant.drive(1.0)
        plant.advance(0.02)
    assert below.c.speed == 0.0
    assert below.c.angle == 0.0
    assert above.c.speed > 1.0


def test_a_small_reversal_is_held_by_friction(make: Any) -> None:
    plant = make(coulomb=1e-3)
    plant.drive(1.0)
    plant.advance(0.01)
    plant.coast()
    plant.advance(1.0)
    assert plant.c.speed == 0.0
    rest = plant.c.angle
    plant.drive(-0.01)
    plant.advance(0.1)
    assert plant.c.angle == rest


@pytest.mark.slow
def test_cogging_holds_a_detent(make: Any) -> None:
    plant = make(cogging=1e-3, cogging_per_turn=12, viscous=2e-6)
    plant.c.angle = 0.05
    plant.coast()
    plant.advance(5.0)
    assert plant.c.angle == pytest.approx(0.0, abs=1e-3)
    lib.plant_init(plant.c, plant.par)
    plant.c.angle = 0.6 * tau / 12  # past the hill: falls into the next detent
    plant.coast()
    plant.advance(5.0)
    assert plant.c.angle == pytest.approx(tau / 12, abs=1e-3)


def test_energy_balances_with_every_effect_on(make: Any) -> None:
    A, n = 2e-4, 14
    plant = make(
        cogging=A,
        cogging_per_turn=n,
        coulomb=1e-3,
        stiction=1.3e-3,
        stribeck_speed=2.0,
        viscous=2e-7,
        brush_drop=0.3,
        brush_current=0.1,
        k_ripple=0.03,
        r_ripple=0.03,
        ripple_per_turn=14,
        dead_time=300e-9,
        diode_drop=0.7,
        diode_resistance=0.05,
        switch_resistance=0.1,
        supply_resistance=0.05,
        supply_capacitance=1e-3,
        winding_resistance=5.0,
        winding_capacity=2.0,
        housing_resistance=20.0,
        housing_capacity=20.0,
        copper_coefficient=0.0039,
        magnet_coefficient=-0.0011,
        max_step=2e-6,
    )
    for duty, decay, time in ((0.8, 1, 0.1), (-0.5, 2, 0.05), (0.3, 3, 0.05)):
        plant.drive(duty, decay)
        plant.advance(time)
    plant.coast()
    plant.advance(0.02)
    c = plant.c
    cogging = A / n * (1 - np.cos(n * c.angle))
    spent = c.heat_energy + c.friction_energy + plant.stored + cogging
    assert c.electric_energy == pytest.approx(spent, rel=1e-6)
    assert c.supply_energy > c.electric_energy


@pytest.mark.slow
def test_winding_heats_as_two_bodies_do(make: Any) -> None:
    R, V = 2.0, 2.0
    c1, c2, r1, r2, copper = 1.5, 10.0, 6.0, 20.0, 0.0039
    plant = make(
        supply_voltage=V,
        winding_resistance=r1,
        winding_capacity=c1,
        housing_resistance=r2,
        housing_capacity=c2,
        copper_coefficient=copper,
    )
    plant.lock()
    plant.drive(1.0)
    plant.advance(8.0)

    def warm(_t: float, y: np.ndarray) -> list[float]:
        power = V**2 / (R * (1 + copper * y[0]))
        flow = (y[0] - y[1]) / r1
        return [(power - flow) / c1, (flow - y[1] / r2) / c2]

    end = solve_ivp(warm, (0, 8.0), [0.0, 0.0], rtol=1e-9, atol=1e-9).y[:, -1]
    assert plant.c.winding - 25 == pytest.approx(end[0], rel=1e-3)
    assert plant.c.housing - 25 == pytest.approx(end[1], rel=1e-3)
    assert plant.c.current == pytest.approx(V / (R * (1 + copper * end[0])), rel=1e-4)


def test_a_plant_is_copied_by_assignment(make: Any) -> None:
    plant = make(coulomb=1e-3, diode_drop=0.7)
    plant.drive(0.4, decay=2)
    plant.advance(0.013)
    twin = ffi.new("plant *", plant.c[0])
    plant.advance(0.01)
    lib.plant_advance(twin, 0.01)
    assert twin.speed == plant.c.speed
    assert twin.current == plant.c.current
