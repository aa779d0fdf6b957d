"""Defects of the simulated motor, below the wire."""

from __future__ import annotations

import math
from typing import Any

import pytest
from motorid.sim._plant import ffi, lib

from motorid.errors import UsageError
from motorid.sim import truth
from motorid.sim.bench import plant_params
from motorid.sim.chain import draw_chain
from motorid.sim.options import parse_url


def plant(url: str) -> Any:
    options = parse_url(url)
    p = ffi.new("plant *")
    lib.plant_init(p, plant_params(options, draw_chain(options)))
    return p


def test_factors_are_in_the_truth() -> None:
    plain = truth("sim://")
    wound = truth("sim://?winding=1.1&magnet=0.9&friction=2&copper=1.05")
    assert wound["R"] == pytest.approx(plain["R"] * 1.1**2 * 1.05)
    assert wound["L"] == pytest.approx(plain["L"] * 1.1**2)
    assert wound["K"] == pytest.approx(plain["K"] * 1.1 * 0.9)
    assert wound["T0"] == pytest.approx(2 * plain["T0"])
    assert truth("sim://?shorted_turn=0.1")["B"] > plain["B"]


def test_a_loose_load_follows_by_its_torque() -> None:
    p = plant("sim://?load_inertia=1e-6&coupling=1e-3&heating=0&friction=0&bridge_resistance=0")
    lib.plant_command(p, lib.PLANT_DRIVE, 1.0, 1)
    lib.plant_advance(p, 0.01)
    assert p.speed > 10 * p.load_speed  # the rotor runs ahead, the load gets the slip torque
    assert p.load_speed == pytest.approx(1e-3 / 1e-6 * 0.01, rel=0.03)
    lib.plant_advance(p, 3.0)
    assert p.load_speed == pytest.approx(p.speed, rel=1e-3)


def test_the_balance_of_energy_holds_while_slipping() -> None:
    p = plant(
        "sim://?load_inertia=1e-6&coupling=1e-3&unbalance=2e-4&brush_bounce=0.5&decay_modes=fast"
    )
    lib.plant_command(p, lib.PLANT_DRIVE, 1.0, 1)
    lib.plant_advance(p, 0.1)
    lifted = 2e-4 * (1 - math.cos(p.angle))
    spent = lib.plant_stored_energy(p) + p.heat_energy + p.friction_energy + lifted
    assert p.friction_energy > 0.1 * p.electric_energy
    assert p.electric_energy == pytest.approx(spent, rel=2e-3)


def test_a_huge_unbalance_holds_the_rotor_in_its_well() -> None:
    p = plant("sim://?unbalance=0.1")
    lib.plant_command(p, lib.PLANT_DRIVE, 1.0, 1)
    lib.plant_advance(p, 1.0)
    assert 0 < p.angle < math.pi / 2
    assert abs(p.speed) < 1.0


def test_a_coupling_needs_a_load() -> None:
    with pytest.raises(UsageError, match="load_inertia"):
        parse_url("sim://?coupling=1e-3")
