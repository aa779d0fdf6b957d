"""A bare plant for tests of the physics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest
from motorid.sim._plant import ffi, lib

IDEAL = {
    "resistance": 2.0,
    "inductance": 400e-6,
    "torque_constant": 0.01,
    "inertia": 1e-6,
    "pwm_period": 50e-6,
    "supply_voltage": 12.0,
    "supply_sinks": 1,
    "ambient": 25.0,
}


@dataclass
class Plant:
    """A C plant and the parameters that it was made of."""

    c: Any
    par: Any

    def command(self, mode: int, duty: float = 0.0, decay: int = 1) -> None:
        lib.plant_command(self.c, mode, duty, decay)

    def drive(self, duty: float, decay: int = 1) -> None:
        self.command(lib.PLANT_DRIVE, duty, decay)

    def coast(self) -> None:
        self.command(lib.PLANT_COAST)

    def brake(self) -> None:
        self.command(lib.PLANT_BRAKE)

    def advance(self, seconds: float) -> None:
        lib.plant_advance(self.c, seconds)

    def clear(self) -> None:
        """Set the integrals to zero."""
        self.c.i_dt = self.c.v_dt = self.c.supply_dt = 0.0

    def lock(self) -> None:
        lib.plant_lock(self.c, 1)

    @property
    def stored(self) -> float:
        return float(lib.plant_stored_energy(self.c))


def make_plant(**par: float) -> Plant:
    """An ideal plant at rest, with these parameters changed."""
    p = ffi.new("plant_params *", IDEAL | par)
    plant = ffi.new("plant *")
    lib.plant_init(plant, p)
    return Plant(plant, p)


@pytest.fixture
def make() -> Any:
    """``make_plant``."""
    return make_plant
