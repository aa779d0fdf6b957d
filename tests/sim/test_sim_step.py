"""Halving the longest step moves no sample by a tenth of an ADC step: every preset, all effects."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from motorid.sim._plant import ffi, lib

from motorid.sim.bench import plant_params
from motorid.sim.chain import draw_chain
from motorid.sim.motor import motors
from motorid.sim.options import parse_url

SAMPLE = 100e-6
EFFECTS = "cogging={cogging}&brush_drop=0.3&ripple=0.03&stiction=1.4&supply_limit={limit}"


def program() -> list[tuple[int, float, int, int]]:
    """Mode, duty, decay, samples."""
    drive, coast, brake = lib.PLANT_DRIVE, lib.PLANT_COAST, lib.PLANT_BRAKE
    return [
        (drive, 0.02, 1, 100),
        (drive, 0.7, 1, 400),
        (coast, 0.0, 0, 200),
        (drive, 0.3, 2, 300),
        (drive, -0.4, 3, 300),
        (brake, 0.0, 0, 200),
        (drive, 0.05, 2, 300),
        (drive, 1.0, 1, 200),
        (coast, 0.0, 0, 600),
    ]


def samples(par: Any, step: float) -> np.ndarray:
    """Mean current and voltage, and angle, of each sample, (n, 3)."""
    plant = ffi.new("plant *")
    par.max_step = step
    lib.plant_init(plant, par)
    rows = []
    for mode, duty, decay, count in program():
        lib.plant_command(plant, mode, duty, decay)
        for _ in range(count):
            plant.i_dt = plant.v_dt = 0.0
            lib.plant_advance(plant, SAMPLE)
            lib.plant_new_period(plant)
            rows.append((plant.i_dt / SAMPLE, plant.v_dt / SAMPLE, plant.angle))
    return np.array(rows)


IRON = "&reaction=0.08&saturation=0.5&eddy=0.4&eddy_time=50e-6&load_friction=0.04"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "more"), [*((name, "") for name in motors()), ("faulhaber-2338s006s", IRON)]
)
def test_halving_the_step_moves_no_sample(name: str, more: str) -> None:
    motor = motors()[name]
    effects = EFFECTS.format(cogging=0.3 * motor.coulomb_nm, limit=1.2 * motor.stall_current_a)
    effects += more
    options = parse_url(f"sim://?motor={name}&clock_ppm=0&{effects}")
    chain = draw_chain(options)
    par = plant_params(options, chain)
    plant = ffi.new("plant *")
    lib.plant_init(plant, par)
    coarse, fine = (samples(par, plant.step / share) for share in (1, 2))
    lsb = [chain.current.scale, chain.voltage.scale, 2 * np.pi / options.counts_per_turn]
    worst = np.abs(coarse - fine).max(axis=0) / lsb
    assert np.all(worst < 0.1), worst
    assert np.ptp(coarse[:, 2]) > 1.0, "the motor must have turned"
