"""Bridge, diodes and supply against closed forms."""

from __future__ import annotations

from math import exp, log
from typing import Any

import pytest

R, L, V, T = 2.0, 400e-6, 12.0, 50e-6
TAU = L / R
DIODE = 0.7


@pytest.mark.parametrize("duty", [0.1, 0.5, 0.93, -0.4])
def test_mean_current_of_a_locked_motor_is_duty_times_supply_over_resistance(
    make: Any, duty: float
) -> None:
    plant = make()
    plant.lock()
    plant.drive(duty)
    plant.advance(40 * TAU)
    plant.clear()
    plant.advance(10 * T)
    assert plant.c.i_dt / (10 * T) == pytest.approx(duty * V / R, rel=1e-7)
    assert plant.c.v_dt / (10 * T) == pytest.approx(duty * V, rel=1e-12)


def test_ripple_of_a_locked_motor_is_the_closed_form(make: Any) -> None:
    plant = make()
    plant.lock()
    plant.drive(0.3)
    plant.advance(800 * T)
    low = plant.c.current
    plant.advance(0.3 * T)
    rise, fall, whole = (exp(-share * T / TAU) for share in (0.3, 0.7, 1.0))
    ripple = V / R * (1 - rise) * (1 - fall) / (1 - whole)
    assert plant.c.current - low == pytest.approx(ripple, rel=1e-6)


def test_coasting_current_dies_in_the_diodes_at_the_exact_time(make: Any) -> None:
    plant = make(diode_drop=DIODE, inertia=1e3)
    plant.drive(1.0)
    plant.advance(T * 20)
    start = plant.c.current
    against = V + 2 * DIODE
    dies = TAU * log(1 + start * R / against)
    charge = TAU * (start + against / R) * (1 - exp(-dies / TAU)) - against / R * dies
    plant.coast()
    plant.clear()
    plant.advance(0.999 * dies)
    assert plant.c.current > 0
    plant.advance(0.002 * dies)
    assert plant.c.current == 0.0
    assert plant.c.i_dt == pytest.approx(charge, rel=1e-6)
    assert plant.c.terminal == pytest.approx(0.01 * plant.c.speed, abs=1e-12)


@pytest.mark.parametrize("duty", [0.05, 0.2, -0.2])
def test_discontinuous_conduction_is_the_closed_form(make: Any, duty: float) -> None:
    plant = make(diode_drop=DIODE)
    plant.lock()
    plant.drive(duty, decay=2)
    plant.advance(3 * T)
    plant.clear()
    plant.advance(7 * T)
    against, on = V + 2 * DIODE, abs(duty) * T
    peak = V / R * (1 - exp(-on / TAU))
    dies = TAU * log(1 + peak * R / against)
    assert on + dies < T, "the case must be discontinuous"
    up = V / R * (on - TAU * (1 - exp(-on / TAU)))
    down = TAU * (peak + against / R) * (1 - exp(-dies / TAU)) - against / R * dies
    sign = 1 if duty > 0 else -1
    assert plant.c.i_dt / 7 == pytest.approx(sign * (up + down), rel=1e-6)
    mean_v = (V * on - against * dies) / T
    assert plant.c.v_dt / (7 * T) == pytest.approx(sign * mean_v, rel=1e-6)


def test_fast_decay_reverses_the_bridge_and_keeps_the_mean(make: Any) -> None:
    plant = make()
    plant.lock()
    plant.drive(0.25, decay=3)
    plant.advance(400 * T)
    plant.clear()
    plant.advance(4 * T)
    assert plant.c.v_dt / (4 * T) == pytest.approx(0.25 * V, rel=1e-9)
    plant.advance(0.7 * T)
    assert plant.c.terminal == pytest.approx(-V)


def test_dead_time_takes_its_share_of_the_voltage(make: Any) -> None:
    dead = 1e-6
    plant = make(dead_time=dead, diode_drop=DIODE)
    plant.lock()
    plant.drive(0.5)
    plant.advance(100 * T)
    plant.clear()
    plant.advance(10 * T)
    expected = (0.5 - dead / T) * V - 2 * dead / T * DIODE
    assert plant.c.v_dt / (10 * T) == pytest.approx(expected, rel=1e-9)


def test_switches_leads_and_supply_share_the_voltage(make: Any) -> None:
    plant = make(switch_resistance=0.1, lead_resistance=0.2, supply_resistance=0.3)
    plant.lock()
    plant.drive(1.0)
    plant.advance(50 * TAU)
    current = V / (R + 2 * 0.1 + 0.2 + 0.3)
    assert plant.c.current == pytest.approx(current, rel=1e-9)
    assert plant.c.bus == pytest.approx(V - 0.3 * current, rel=1e-9)
    assert plant.c.terminal == pytest.approx(R * current, rel=1e-9)


def test_a_supply_with_capacitance_sags_to_the_same_voltage(make: Any) -> None:
    plant = make(supply_resistance=0.3, supply_capacitance=1e-3)
    plant.lock()
    plant.drive(1.0)
    plant.advance(0.05)
    assert plant.c.current == pytest.approx(V / (R + 0.3), rel=1e-8)


def test_a_supply_in_current_limit_gives_its_limit(make: Any) -> None:
    plant = make(supply_resistance=0.1, supply_capacitance=1e-3, supply_limit=2.0)
    plant.lock()
    plant.drive(1.0)
    plant.advance(0.1)
    assert plant.c.current == pytest.approx(2.0, rel=1e-6)
    assert plant.c.bus == pytest.approx(2.0 * R, rel=1e-6)


def test_a_supply_that_cannot_sink_is_pumped_up_by_braking_regeneration(make: Any) -> None:
    plant = make(
        supply_resistance=0.1, supply_capacitance=1e-3, supply_sinks=0, inertia=1e-5, dead_time=0.0
    )
    plant.drive(0.9)
    plant.advance(1.0)
    plant.drive(0.4)
    plant.advance(0.05)
    assert plant.c.bus > V + 1.0


def test_brush_drop_adds_to_the_ohmic_drop(make: Any) -> None:
    plant = make(brush_drop=0.5, brush_current=0.05)
    plant.lock()
    plant.drive(0.5)
    plant.advance(0.05)
    plant.clear()
    plant.advance(10 * T)
    current = plant.c.i_dt / (10 * T)
    assert plant.c.v_dt / (10 * T) == pytest.approx(R * current + 0.5, abs=2e-3)


def test_brake_shorts_the_terminals(make: Any) -> None:
    plant = make(switch_resistance=0.1, inertia=1e3)
    plant.c.speed = 300.0
    plant.c.direction = 1
    plant.brake()
    plant.advance(50 * TAU)
    current = -0.01 * plant.c.speed / (R + 0.2)
    assert plant.c.current == pytest.approx(current, rel=1e-6)
    assert plant.c.terminal == pytest.approx(-0.2 * current, rel=1e-6)
