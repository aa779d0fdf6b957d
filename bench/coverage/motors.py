"""Random motors from half a watt to half a kilowatt, by the scaling laws of real ones.

The laws are straight lines, on logarithms over the rated power, through the catalogue motors of
``motorid/sim/presets.toml``; every figure scatters about its line as those motors do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from motorid.sim.motor import Motor

LEAST_W, MOST_W = 0.5, 500.0  # three decades
VOLTAGES = (3.0, 4.5, 6.0, 9.0, 12.0, 18.0, 24.0, 36.0, 48.0)
GRAPHITE_FROM_W = 3.0  # below it brushes are of precious metal


@dataclass(frozen=True)
class Drawn:
    """A motor, its rated power, and what no data sheet names: effects of brushes, slots, friction.

    Torques in N·m, ``brush_drop_v`` over both brushes, ``ripple`` relative.
    """

    motor: Motor
    power_w: float
    has_iron: bool
    cogging_nm: float
    brush_drop_v: float
    brush_current_a: float  # at which the drop has risen to 0.71 of that
    ripple: float
    stiction: float
    stribeck_rad_s: float
    load_inertia: float


def draw_motor(rng: np.random.Generator) -> Drawn:
    """One motor; the same generator state gives the same motor."""
    power = float(10 ** rng.uniform(math.log10(LEAST_W), math.log10(MOST_W)))

    def law(at_1_w: float, exponent: float, scatter: float) -> float:
        """``at_1_w`` at 1 W, growing with a power of the rating; ``scatter`` of the logarithm."""
        return float(at_1_w * power**exponent * math.exp(scatter * rng.standard_normal()))

    iron = bool(rng.random() < 0.5)
    volts = _voltage(rng, power)
    R = volts**2 / law(5.0, 1.15, 0.3)  # V²/R: electrical power at stall
    K = volts / law(1100.0, -0.2, 0.3)  # V/K: no-load speed, rad/s
    J = law(0.025, -0.33, 0.3) * K**2 / R  # mechanical time constant
    L = (law(6e-4, 0.15, 0.35) if iron else law(6e-5, 0.25, 0.35)) * R  # electrical one
    idle = law(0.05, -0.45, 0.3) * volts / R  # no-load current over stall current
    dry = float(rng.uniform(0.4, 0.85))  # Coulomb's share of friction
    winding = law(8.0, -0.28, 0.25)
    motor = Motor(
        title=f"drawn motor of {power:.3g} W",
        source="drawn by the scaling laws of the coverage study",
        friction=f"{dry:.0%} Coulomb",
        thermal="drawn",
        voltage_v=volts,
        resistance_ohm=R,
        inductance_h=L,
        torque_constant_nm_a=K,
        inertia_kg_m2=J,
        viscous_nm_s=(1 - dry) * K * idle / (volts / K),
        coulomb_nm=dry * K * idle,
        commutator_segments=int(rng.choice((3, 5, 7, 9, 11, 12, 13, 16, 22))),
        winding_k_w=winding,
        winding_s=law(6.0, 0.5, 0.3),
        housing_k_w=winding * float(rng.uniform(1.0, 4.0)),
        housing_s=law(250.0, 0.25, 0.3),
        supply_v=volts,
        switch_resistance_ohm=0.01 * R,
        supply_resistance_ohm=0.01 * R,
        supply_capacitance_f=0.0,
    )
    graphite = power > GRAPHITE_FROM_W and rng.random() < 0.6
    loaded = rng.random() < 0.5
    return Drawn(
        motor=motor,
        power_w=power,
        has_iron=iron,
        cogging_nm=motor.coulomb_nm * float(rng.uniform(0.1, 0.6) if iron else 0.0),
        brush_drop_v=volts * float(rng.uniform(0.005, 0.02) if graphite else rng.uniform(0, 0.004)),
        brush_current_a=0.05 * volts / R * math.exp(0.5 * rng.standard_normal()),
        ripple=float(rng.uniform(0.002, 0.015)),
        stiction=float(rng.uniform(1.0, 1.4)),
        stribeck_rad_s=float(10 ** rng.uniform(-0.3, 1.0)),
        load_inertia=J * float(rng.uniform(0.2, 4.0)) if loaded else 0.0,
    )


def _voltage(rng: np.random.Generator, power_w: float) -> float:
    """A usual nominal voltage near 5 V at 1 W and 36 V at 500 W."""
    wish = math.log(5.0 * power_w**0.32) + 0.35 * rng.standard_normal()
    return min(VOLTAGES, key=lambda v: abs(math.log(v) - wish))
