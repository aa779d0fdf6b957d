"""Iron and load-dependent friction against an independent integrator, closed forms and energy."""

from __future__ import annotations

from math import atan, exp, hypot
from typing import Any

import numpy as np
import pytest
from motorid.sim._plant import ffi, lib
from scipy.integrate import solve_ivp

from motorid.errors import UsageError
from motorid.sim import truth
from motorid.sim.bench import plant_params
from motorid.sim.chain import draw_chain
from motorid.sim.options import parse_url

R, L, K, J, B, T0, V = 2.0, 400e-6, 0.01, 1e-6, 2e-7, 1e-3, 12.0  # of conftest's plant
REACTION, REACTION_A, BEND = 0.08, 6.0, 0.4
DEPTH, HALF = 0.6, 3.0
SHARE, EDDY = 0.4, 1.6
LOADED = 0.04
FRICTION = {"viscous": B, "coulomb": T0, "load_friction": LOADED}
IRON = {
    "reaction": REACTION,
    "reaction_current": REACTION_A,
    "reaction_bend": BEND,
    "saturation": DEPTH,
    "saturation_current": HALF,
    "eddy_share": SHARE,
    "eddy_resistance": EDDY,
}


def constant(i: float) -> float:
    return K * (1 - REACTION * (hypot(i, BEND) - BEND) / REACTION_A)


def flux(i: float) -> float:
    return L * (i - DEPTH * (i - HALF * atan(i / HALF)))


def slope(i: float) -> float:
    near = 1e-5 * (1 + abs(i))
    return (flux(i + near) - flux(i - near)) / (2 * near)


def motion(volts: float) -> Any:
    """i, i_e, speed of a motor that turns forwards at that voltage."""

    def rates(_t: float, y: np.ndarray) -> list[float]:
        i, i_e, w = y
        eddy, torque = EDDY * (i - i_e), constant(i) * i
        return [
            (volts - R * i - constant(i) * w - eddy) / ((1 - SHARE) * slope(i)),
            eddy / (SHARE * slope(i_e)),
            (torque - T0 - B * w - LOADED * abs(torque)) / J,
        ]

    return rates


def integrated(volts: float, first: tuple[float, ...], times: np.ndarray) -> np.ndarray:
    """States at these times, (3, n)."""
    span = (times[0], times[-1])
    found = solve_ivp(
        motion(volts), span, first, method="LSODA", t_eval=times, rtol=1e-9, atol=1e-11
    )
    return np.asarray(found.y)


@pytest.mark.parametrize("volts", [V, 0.0, -V])
def test_drive_brake_and_reversal_agree_with_lsoda(make: Any, volts: float) -> None:
    plant = make(**FRICTION, **IRON, max_step=2e-6)
    plant.c.current, plant.c.eddy_current, plant.c.speed, plant.c.direction = 1.0, 0.5, 300.0, 1
    plant.drive(volts / V)
    times = np.linspace(0.0, 2e-3, 9)
    reference = integrated(volts, (1.0, 0.5, 300.0), times)
    for n, time in enumerate(times):
        plant.advance(float(time - times[n - 1]) if n else 0.0)
        state = plant.c.current, plant.c.eddy_current, plant.c.speed
        assert state == pytest.approx(tuple(reference[:, n]), rel=1e-5, abs=1e-5)
    assert abs(plant.c.speed - 300.0) > 5.0


def test_energy_balances_with_iron_and_loaded_friction_on(make: Any) -> None:
    plant = make(
        **FRICTION,
        **IRON,
        dead_time=300e-9,
        diode_drop=0.7,
        diode_resistance=0.05,
        switch_resistance=0.1,
        supply_resistance=0.05,
        supply_capacitance=1e-3,
        max_step=1e-6,
    )
    for duty, decay, time in ((0.8, 1, 0.02), (-0.5, 2, 0.01), (0.3, 3, 0.01)):
        plant.drive(duty, decay)
        plant.advance(time)
    plant.coast()
    plant.advance(0.002)
    c = plant.c
    spent = c.heat_energy + c.friction_energy + plant.stored
    assert c.electric_energy == pytest.approx(spent, rel=1e-6)


def test_a_saturated_winding_holds_less_energy_than_its_inductance_says(make: Any) -> None:
    i = 5.0
    plant = make(saturation=DEPTH, saturation_current=HALF)
    plant.c.current = i
    grid = np.linspace(0.0, i, 20_001)
    links = np.array([flux(x) for x in grid])
    assert plant.stored == pytest.approx(float(np.trapezoid(grid, links)), rel=1e-6)
    assert plant.stored < 0.8 * 0.5 * L * i**2


def test_open_terminals_show_what_eddy_currents_leave(make: Any) -> None:
    plant = make(eddy_share=SHARE, eddy_resistance=EDDY, inertia=1e3, diode_drop=0.7)
    plant.lock()
    plant.drive(1.0)
    plant.advance(20 * L / R)
    plant.coast()
    while plant.c.current > 0.0:
        plant.advance(1e-6)
    first, tau = plant.c.terminal, SHARE * L / EDDY
    assert first == pytest.approx(-EDDY * plant.c.eddy_current)
    assert first < -0.5
    plant.advance(tau)
    assert plant.c.current == 0.0
    assert plant.c.terminal == pytest.approx(first * exp(-1), rel=1e-6)


@pytest.mark.parametrize(("share", "moves"), [(0.2, True), (0.4, False)])
def test_loaded_friction_is_in_the_breakaway(make: Any, share: float, moves: bool) -> None:
    volts = 1e-3 / K * R / 0.7  # the torque is 1/0.7 of Coulomb's
    plant = make(coulomb=T0, load_friction=share, supply_voltage=volts)
    plant.drive(1.0)
    plant.advance(0.02)
    assert (plant.c.speed > 0.1) == moves


def test_options_are_shares_at_the_stall_current() -> None:
    url = "sim://?reaction=0.06&saturation=0.5&eddy=0.4&eddy_time=1e-4&winding=1.1"
    options, known = parse_url(url), truth(url)
    p = plant_params(options, draw_chain(options))
    stall = options.specimen.stall_current_a
    reaction = p.reaction * (hypot(stall, p.reaction_bend) - p.reaction_bend) / p.reaction_current
    assert reaction == pytest.approx(0.06)
    assert p.saturation_current == pytest.approx(stall / 2)
    assert p.saturation / (1 + (p.saturation_current / stall) ** 2) == pytest.approx(0.5)
    assert p.eddy_share * p.inductance / p.eddy_resistance == pytest.approx(1e-4)
    assert known["K_stall"] == pytest.approx(0.94 * known["K"])
    assert known["L_stall"] == pytest.approx(0.5 * known["L"])
    at_1_khz = 1 - 0.4 * (1 - 1 / (1 + (2 * np.pi * 1e3 * 1e-4) ** 2))
    assert known["L_1kHz"] == pytest.approx(at_1_khz * known["L"])


def test_a_saturation_that_leaves_no_inductance_is_refused() -> None:
    with pytest.raises(UsageError, match="saturation_current"):
        parse_url("sim://?saturation=0.9&saturation_current=5")


def test_what_is_absent_moves_no_bit() -> None:
    """Every shape of an effect whose size is zero, against the plant without it."""
    shapes = "reaction_bend=1&saturation_current=0.5&eddy_time=1e-5"
    ends = []
    for more in ("", shapes):
        options = parse_url(f"sim://?{more}")
        plant = plant_of(options)
        lib.plant_command(plant, lib.PLANT_DRIVE, 0.6, 1)
        lib.plant_advance(plant, 0.01)
        ends.append((plant.current, plant.speed, plant.angle, plant.heat_energy, plant.terminal))
    assert ends[0] == ends[1]


def plant_of(options: Any) -> Any:
    plant = ffi.new("plant *")
    lib.plant_init(plant, plant_params(options, draw_chain(options)))
    return plant
