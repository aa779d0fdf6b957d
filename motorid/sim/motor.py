"""Motors of ``presets.toml``."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

from motorid.sim.nearest import pick


@dataclass(frozen=True)
class Motor:
    """A motor at 25 °C, and a bench that suits it; where the figures come from is in the texts."""

    title: str
    source: str
    friction: str
    thermal: str
    voltage_v: float
    resistance_ohm: float
    inductance_h: float
    torque_constant_nm_a: float
    inertia_kg_m2: float
    viscous_nm_s: float
    coulomb_nm: float
    commutator_segments: int
    winding_k_w: float
    winding_s: float
    housing_k_w: float
    housing_s: float
    supply_v: float
    switch_resistance_ohm: float
    supply_resistance_ohm: float
    supply_capacitance_f: float

    @property
    def stall_current_a(self) -> float:
        """At the nominal voltage, cold."""
        return self.voltage_v / self.resistance_ohm

    @property
    def ripple_per_turn(self) -> int:
        """Commutations a turn: an odd number of segments commutates twice for each."""
        return self.commutator_segments * (2 if self.commutator_segments % 2 else 1)


@lru_cache(maxsize=1)
def motors() -> dict[str, Motor]:
    """Every preset by name."""
    text = files("motorid.sim").joinpath("presets.toml").read_text(encoding="utf-8")
    return {name: Motor(**table) for name, table in tomllib.loads(text).items()}


def find_motor(name: str) -> tuple[str, Motor]:
    """The preset of that name, or of the only name that begins with it. Raises UsageError."""
    full = pick(name, motors(), "motor")
    return full, motors()[full]
