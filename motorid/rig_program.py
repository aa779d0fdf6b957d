"""The program of a rig file that names none, and the times that its nameplate explains."""

from __future__ import annotations

import math

from motorid.errors import RigError
from motorid.program import Program, Step, StepKind, climbs
from motorid.rig_model import Nameplate

DEFAULT_CLIMBS = ((0.3, 0.5, 0.75), (1.0,))  # fractions of the nameplate's voltage
SETTLING = 8  # mechanical time constants of a level


def default_program(nameplate: Nameplate) -> Program:
    """Levels up to the nameplate's voltage, each long enough to settle; climbs that coast to rest.

    The first climb brakes for a time constant before it coasts: driving and coasting alone cannot
    tell friction that follows the current from a larger inertia and friction. A brake gives its
    energy to the winding; a step down would give it to the supply.

    Raises RigError when the nameplate names no voltage.
    """
    if nameplate.voltage_v is None:
        raise RigError("a rig without [program] needs nameplate.voltage_v to derive one from")
    coast_s, drive_s = coasting_s(nameplate), settling_s(nameplate)
    plain = climbs(
        [[share * nameplate.voltage_v for share in climb] for climb in DEFAULT_CLIMBS],
        kind=StepKind.DRIVE_VOLTS,
        drive_s=drive_s,
        coast_s=[round(coast_s * climb[-1], 4) for climb in DEFAULT_CLIMBS],
    )
    first = 1 + len(DEFAULT_CLIMBS[0])
    brake = Step(StepKind.BRAKE, round(drive_s / SETTLING, 4))
    return Program((*plain.steps[:first], brake, *plain.steps[first:]))


def settling_s(plate: Nameplate) -> float:
    """Eight mechanical time constants RJ/K² in seconds, or a long guess where they are unknown."""
    R, J, K = plate.resistance_ohm, plate.inertia_kg_m2, plate.torque_constant_nm_a
    if R is None or J is None or K is None:
        return 0.5
    return round(min(max(SETTLING * R * J / K**2, 0.06), 2.0), 4)


def coasting_s(plate: Nameplate) -> float:
    """Seconds in which a motor surely stops: 1.7 times what a constant no-load torque would take.

    Where only a share s of that torque is dry friction, it takes -ln(s)/(1-s) times: 1.7 at 30 %.
    """
    J, K, V = plate.inertia_kg_m2, plate.torque_constant_nm_a, plate.voltage_v
    if J is None or K is None or V is None or plate.no_load_current_a is None:
        return 1.5
    return round(min(max(1.7 * J * (V / K) / (K * plate.no_load_current_a), 0.1), 4.0), 4)


def turning_s(plate: Nameplate, volts: float, turns: float, name: str) -> float:
    """Seconds in which a motor surely turns so often from rest, at half the speed that the plate
    lets expect. Raises RigError where the plate knows too little, or the motor may not turn.
    """
    R, K, idle = plate.resistance_ohm, plate.torque_constant_nm_a, plate.no_load_current_a
    if R is None or K is None or idle is None:
        raise RigError(
            f"{name} needs duration_s, or resistance_ohm, torque_constant_nm_a and "
            "no_load_current_a of the nameplate"
        )
    left = volts - R * idle
    if not left > 0.0:
        raise RigError(
            f"{name}: {volts:g} V may not turn the motor, whose no-load current alone takes "
            f"{R * idle:.3g} V: raise volts, or give duration_s"
        )
    return round(2.0 * turns * 2.0 * math.pi * K / left + settling_s(plate), 4)
