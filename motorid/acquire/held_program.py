"""A program for a rotor that is held: who says that it is, and what heat it gives the winding."""

from __future__ import annotations

from motorid.errors import RigError, UsageError
from motorid.program import Program, Rotor


def insist_on_rotor(program: Program) -> None:
    """Raises UsageError where nobody has said that the rotor is held."""
    if program.rotor is Rotor.ASK:
        raise UsageError(
            "the program is for a rotor that is held, and nobody said that it is: clamp it and "
            'give --clamped, or set program.rotor = "clamped" (or "braked") in the rig file'
        )


def refuse_held(program: Program, who: str) -> None:
    """Raises UsageError for what has no board's limit on a rotor that moves."""
    if program.held:
        raise UsageError(
            f"the program is for a rotor that is held, and {who} does not stop one that moves: use "
            "`motorid capture` with a board"
        )


def check_heat(program: Program, volts: list[float | None], resistance_ohm: float) -> None:
    """Raises RigError where a run could give the winding more heat than its program allows.

    The current of a rotor at rest follows its voltage through R and L alone, so that the integral
    of i² R is at most that of v²/R, at whatever L.
    """
    most = program.energy_j
    heat = heat_j(program, volts, resistance_ohm)
    if most is not None and heat > most:
        raise RigError(
            f"the program could give the winding {heat:.3g} J through {resistance_ohm:.3g} ohm, "
            f"and program.energy_j is {most:g}: lower the levels, shorten it, or raise the bound"
        )


def heat_j(program: Program, volts: list[float | None], resistance_ohm: float) -> float:
    """J of I²R heat at most while the rotor stands; ``volts`` of each step."""
    steps = zip(program.steps, volts, strict=True)
    return sum((value or 0.0) ** 2 * step.duration_s for step, value in steps) / resistance_ohm
