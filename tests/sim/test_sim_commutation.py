"""R that rises with speed in the simulated motor, against an independent integrator."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from motorid.sim._plant import ffi, lib
from scipy.integrate import solve_ivp

from motorid.errors import UsageError
from motorid.sim.bench import plant_params
from motorid.sim.chain import draw_chain
from motorid.sim.options import parse_url

R, L, K, J, B, V = 2.0, 400e-6, 0.01, 1e-6, 2e-7, 12.0  # of conftest's plant
RISE, FROM = 1e-3, 200.0


def integrated(volts: float, first: tuple[float, float], times: np.ndarray) -> np.ndarray:
    """Current and speed at these times, (2, n)."""

    def rates(_t: float, y: np.ndarray) -> list[float]:
        i, w = y
        ohms = R + RISE * max(abs(w) - FROM, 0.0)
        return [(volts - ohms * i - K * w) / L, (K * i - B * w) / J]

    span = (times[0], times[-1])
    return np.asarray(solve_ivp(rates, span, first, "LSODA", times, rtol=1e-9, atol=1e-11).y)


@pytest.mark.parametrize("volts", [V, -V])
def test_the_current_at_speed_agrees_with_lsoda(make: Any, volts: float) -> None:
    plant = make(viscous=B, commutation=RISE, commutation_speed=FROM, max_step=2e-6)
    plant.c.current, plant.c.speed, plant.c.direction = 1.0, -300.0, -1
    plant.drive(volts / V)
    times = np.linspace(0.0, 2e-3, 5)
    reference = integrated(volts, (1.0, -300.0), times)
    for n, time in enumerate(times):
        plant.advance(float(time - times[n - 1]) if n else 0.0)
        found = plant.c.current, plant.c.speed
        assert found == pytest.approx(tuple(reference[:, n]), rel=1e-5, abs=1e-5)


def test_what_commutation_adds_becomes_heat(make: Any) -> None:
    plant = make(viscous=B, commutation=RISE, commutation_speed=FROM, max_step=1e-6)
    plant.drive(0.8)
    plant.advance(0.02)
    spent = plant.c.heat_energy + plant.c.friction_energy + plant.stored
    assert plant.c.speed > 2 * FROM
    assert plant.c.electric_energy == pytest.approx(spent, rel=1e-6)


def test_the_option_is_a_share_of_r_at_the_speed_of_the_voltage() -> None:
    options = parse_url("sim://?commutation=0.06&commutation_speed=300&winding=1.1")
    p, motor = plant_params(options, draw_chain(options)), options.specimen
    top = motor.voltage_v / motor.torque_constant_nm_a
    assert p.commutation * (top - 300.0) == pytest.approx(0.06 * motor.resistance_ohm)
    assert p.commutation_speed == 300.0
    with pytest.raises(UsageError, match="commutation_speed must lie below"):
        parse_url("sim://?commutation=0.06&commutation_speed=1e4")


def test_a_speed_without_a_rise_moves_no_bit() -> None:
    ends = []
    for more in ("", "commutation_speed=100"):
        options = parse_url(f"sim://?{more}")
        plant = ffi.new("plant *")
        lib.plant_init(plant, plant_params(options, draw_chain(options)))
        lib.plant_command(plant, lib.PLANT_DRIVE, 0.6, 1)
        lib.plant_advance(plant, 0.01)
        ends.append((plant.current, plant.speed, plant.heat_energy, plant.terminal))
    assert ends[0] == ends[1]
