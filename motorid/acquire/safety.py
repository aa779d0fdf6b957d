"""What a rig refuses to drive, reasoned before anything turns."""

from __future__ import annotations

import math

from motorid.acquire.held_program import check_heat, insist_on_rotor
from motorid.errors import RigError
from motorid.program import Program, StepKind
from motorid.rig import Rig, settling_s

PULSE_MARGIN = 1.5  # a check pulse may see up to this many times the resistance: the motor moves


def check_program(
    rig: Rig,
    program: Program,
    *,
    resistance_ohm: float | None = None,
    supply_v: float | None = None,
) -> None:
    """Raises RigError for a program that could pass a limit of the rig.

    ``resistance_ohm`` stands in where the nameplate names none, ``supply_v`` is measured. Without
    any resistance the currents are left for later: the caller comes back with a measured one.
    """
    insist_on_rotor(program)
    limits = rig.limits
    if program.duration_s > limits.run_time_s:
        raise RigError(
            f"the program takes {program.duration_s:.2f} s, and limits.run_time_s is "
            f"{limits.run_time_s:g}: shorten it or raise the limit"
        )
    volts = [_volts(rig, step.kind, step.level, supply_v) for step in program.steps]
    _check_supply(rig, program, volts)
    _check_voltage(rig, volts)
    if program.held:
        _check_held(rig, program, volts, resistance_ohm)
        return
    _check_speed(rig, volts)
    resistance = rig.nameplate.resistance_ohm or resistance_ohm
    if resistance is not None:
        _check_current(rig, program, volts, resistance)


def pulse_resistance(volts: float, peak_a: float) -> float:
    """A resistance that the motor surely has, from a check pulse's volts and peak current.

    The back-EMF makes the ratio look larger than the resistance, so it is taken smaller.
    """
    return abs(volts / peak_a) / PULSE_MARGIN


def program_volts(rig: Rig, program: Program, supply_v: float | None = None) -> list[float]:
    """V that each driven step puts on the motor, without its sign."""
    volts = (_volts(rig, step.kind, step.level, supply_v) for step in program.steps)
    return [abs(value) for value in volts if value]


def _volts(rig: Rig, kind: StepKind, level: float, supply_v: float | None) -> float | None:
    """What a step puts on the motor, at most; None where the bridge is open."""
    match kind:
        case StepKind.COAST:
            return None
        case StepKind.BRAKE:
            return 0.0
        case StepKind.DRIVE_VOLTS:
            return level
    return level * (supply_v or rig.supply_voltage_v or rig.limits.supply_max_v)


def _check_held(
    rig: Rig, program: Program, volts: list[float | None], resistance_ohm: float | None
) -> None:
    """Current and heat of a rotor that stands: v/R in every step, whatever came before it.

    The smaller of the nameplate's resistance and the measured one counts.
    """
    known = [ohm for ohm in (rig.nameplate.resistance_ohm, resistance_ohm) if ohm is not None]
    if not known:
        return
    for number, value in enumerate(volts):
        peak = abs(value or 0.0) / min(known)
        if peak > rig.limits.current_a:
            raise RigError(
                f"step {number} of the program ({value:g} V) could draw {peak:.3g} A through "
                f"{min(known):.3g} ohm, and limits.current_a is {rig.limits.current_a:g}: lower "
                "the level, or raise the limit"
            )
    check_heat(program, volts, min(known))


def _check_supply(rig: Rig, program: Program, volts: list[float | None]) -> None:
    ceiling = rig.supply_voltage_v or rig.limits.supply_max_v
    for number, (step, value) in enumerate(zip(program.steps, volts, strict=True)):
        if step.kind is StepKind.DRIVE_VOLTS and value is not None and abs(value) > ceiling:
            raise RigError(
                f"step {number} of the program asks for {value:g} V, and the supply has "
                f"{ceiling:g} V: lower it"
            )


def _check_voltage(rig: Rig, volts: list[float | None]) -> None:
    most = rig.limits.voltage_v
    for number, value in enumerate(volts):
        if most is not None and value is not None and abs(value) > most:
            raise RigError(
                f"step {number} of the program puts {abs(value):g} V on the motor, and "
                f"limits.voltage_v is {most:g}: lower the level, or raise the limit"
            )


def _check_speed(rig: Rig, volts: list[float | None]) -> None:
    constant = rig.nameplate.torque_constant_nm_a
    top = max((abs(value) for value in volts if value is not None), default=0.0)
    if constant is not None and top / constant > rig.limits.speed_rad_s:
        raise RigError(
            f"{top:g} V can turn this motor at {top / constant:.0f} rad/s, and "
            f"limits.speed_rad_s is {rig.limits.speed_rad_s:g}: lower the level or raise the limit"
        )


def _check_current(
    rig: Rig, program: Program, volts: list[float | None], resistance: float
) -> None:
    """The worst current of each step: its volts against the back-EMF that may stand by then.

    ``low`` to ``high`` is where the back-EMF can be. From rest that is V/R, as if locked. A step
    pulls it towards its own volts with the mechanical time constant, where the nameplate knows it.
    """
    tau_s = settling_s(rig.nameplate) / 8 if _knows_tau(rig) else math.inf
    low = high = 0.0
    for number, (step, value) in enumerate(zip(program.steps, volts, strict=True)):
        if value is None:
            continue  # a coast slows the motor, but who knows how soon
        peak = max(abs(value - low), abs(value - high), abs(value)) / resistance
        if peak > rig.limits.current_a:
            raise RigError(
                f"step {number} of the program ({value:g} V) could draw {peak:.3g} A through "
                f"{resistance:.3g} ohm, and limits.current_a is {rig.limits.current_a:g}: lower "
                "the level, let the motor settle before it, or raise the limit"
            )
        left = math.exp(-step.duration_s / tau_s)
        low = min(0.0, value + (low - value) * left, value)
        high = max(0.0, value + (high - value) * left, value)


def _knows_tau(rig: Rig) -> bool:
    plate = rig.nameplate
    return None not in (plate.resistance_ohm, plate.inertia_kg_m2, plate.torque_constant_nm_a)
