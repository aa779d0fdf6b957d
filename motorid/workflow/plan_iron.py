"""A rig and wants of its motor's iron -> the PRBS for a held rotor, and the rig file for it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motorid.errors import RigError, UsageError

if TYPE_CHECKING:
    from motorid.plan.iron import IronPlan
    from motorid.plan.wants import Want
    from motorid.rig import Rig

OWN = ("L_1kHz", "L_rated", "L_pwm")  # wants that only a held rotor's run meets
USUAL = ("R=1%", "L=2%", "L_1kHz=3%")
WANT = re.compile(r"(?P<name>\w+)=(?P<percent>\d+(\.\d+)?)%")
ENERGY_J = 10.0  # where nobody states a bound
TOLERANCE = 1.3  # factor that a label's resistance may be wrong by


def asks_for_iron(wants: Sequence[str]) -> bool:
    """Whether a want is one that only a held rotor's run meets."""
    return any(text.strip().partition("=")[0] in OWN for text in wants)


def plan_iron(rig: Rig, wants: Sequence[str], energy_j: float | None = None) -> IronPlan:
    """The shortest PRBS for a held rotor that reaches ``wants`` on this rig, in ``energy_j``.

    Raises RigError, LinkError or UsageError.
    """
    from motorid.motor.parameters import Motor
    from motorid.plan.iron import propose_iron
    from motorid.plan.motors import SHORT_S
    from motorid.workflow import plan

    wanted = _wanted(wants or USUAL, rig)
    ohms, rail = _needed(rig)
    board = plan.ask(rig)
    bench = plan.benches_of(rig, board, plan.templates_of(rig, board))[0]
    top_v = plan.ROOM * min(rig.limits.current_a * ohms / TOLERANCE, rail)
    motor = Motor(ohms, rig.nameplate.inductance_h or SHORT_S * ohms, 1.0, 0.0, 1.0, 0.0)
    return propose_iron(
        bench, motor, top_v / rail, ohms / TOLERANCE, energy_j or ENERGY_J, plan.decay_of(board),
        wanted, lambda program: plan.allows(rig, program, board, bench.period_ticks),
        rig.nameplate.rated_current_a,
    )  # fmt: skip


def _needed(rig: Rig) -> tuple[float, float]:
    """The plate's resistance and the supply's voltage. Raises RigError without them."""
    from motorid.capture.model import CURRENT, VOLTAGE

    for name in (CURRENT, VOLTAGE):
        if name not in rig.sampling.channels:
            raise RigError(f"sampling.channels lacks {name}, which the run of a held rotor needs")
    ohms, rail = rig.nameplate.resistance_ohm, rig.supply_voltage_v
    if ohms is None:
        raise RigError("the rig's nameplate lacks resistance_ohm: give it, roughly")
    if rail is None:
        raise RigError("the rig lacks wiring.supply_voltage_v, of which a duty is a share: give it")
    return ohms, rail


def _wanted(texts: Sequence[str], rig: Rig) -> tuple[Want, ...]:
    from motorid.plan.iron import WANTED
    from motorid.plan.wants import Want

    found = {}
    for text in texts:
        match = WANT.fullmatch(text.strip())
        name = match["name"] if match else ""
        if match is None or name not in WANTED or not 0.0 < float(match["percent"]) < 100.0:
            raise UsageError(
                f"--want {text[:60]!r}: for the iron it is NAME=NUMBER%, with NAME one of "
                f"{', '.join(WANTED)}, such as L_1kHz=3%; K, B, J and T0 need a rotor that turns"
            )
        if name == "L_rated" and rig.nameplate.rated_current_a is None:
            raise RigError("L_rated needs nameplate.rated_current_a in the rig file")
        found[name] = Want(name, float(match["percent"]) / 100.0)
    return tuple(found.values())


def rig_text(rig: Rig, source: Path, plan: IronPlan, target: Path) -> str:
    """The rig's file for ``target``, with the planned signals in place of its program.

    Raises UsageError where the file is written in a way that this cannot edit.
    """
    from motorid.workflow.plan_file import checked, with_block

    by = f"# by `motorid plan --iron --rig {source.name}`"
    text = with_block(rig.text, [by, *_block(plan)])
    return checked(text, rig, source, target, plan.program, plan.bench)


def _block(plan: IronPlan) -> list[str]:
    program = plan.program
    lines = ["[program]", f'rotor = "{program.rotor.value}"', f"energy_j = {program.energy_j!r}"]
    rest = program.steps[0]
    lines += ["[[program.steps]]", 'kind = "coast"', f"duration_s = {rest.duration_s!r}"]
    for signal in plan.signals:
        lines += [
            "[[program.steps]]", 'kind = "prbs"', f"amplitude_duty = {signal.amplitude!r}",
            f"bits = {signal.bits}", f"duration_s = {signal.seconds!r}",
        ]  # fmt: skip
        if signal.decay.name != "SYNCHRONOUS_SLOW":
            lines.append(f'decay = "{signal.decay.name.lower()}"')
    return lines
