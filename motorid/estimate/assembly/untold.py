"""Effects that these data say less of than what is usual, as suspects that are not excluded.

So is a resistor across the motor, behind the current's sensor, which leaves no trace at all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.effects.bridge.terminal_load import TERMINAL_LOAD
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Use
from motorid.estimate.effects.loaded_motor import loaded
from motorid.estimate.effects.registry import used
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS, Parameter, Suspect
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.undetected import Undetected

WORTH_SAYING = 1e-3  # relative change of a parameter
PLACES = 3  # a percentage with one decimal
USUAL_OHM = 1e4  # across a motor: dividers of a board, a lamp
LOADED = ("R", "K", "B")


def suspects(undetected: Sequence[Undetected], solution: Solution) -> tuple[Suspect, ...]:
    """One for each that would change a parameter and that these data leave to its prior; no
    interval holds it.
    """
    out = []
    for one in undetected:
        if not one.untold:
            continue
        moves = one.moves(solution)
        worth = [n for n in PARAMETERS if abs(moves.get(n, 0.0)) > WORTH_SAYING]
        worth.sort(key=lambda name: -abs(round(moves[name], PLACES)))  # as they are printed
        said = [f"{name} by {moves[name]:+.1%}" for name in worth]
        if said:
            name, code = one.quantity.name, _code(one.quantity)
            evidence = (
                f"these data cannot reveal {name}: its usual size would change "
                f"{', '.join(said)}, and the intervals do not include that"
            )
            out.append(Suspect(code, name, evidence, one.quantity.remedy, "not excluded"))
    return tuple(out)


def beside(found: Sequence[Suspect], terms: Sequence[str]) -> tuple[Suspect, ...]:
    """Those of ``found`` that no model with these terms shows."""
    shown = {_code(q) for q in used(Use.UNDETECTED) if q.term in terms}
    return tuple(s for s in found if s.code not in shown or s.strength != "not excluded")


def _code(quantity: InfluenceQuantity) -> str:
    return quantity.name.replace(" ", "_")


def terminal_load(
    records: Sequence[MotorRecord], parameters: Mapping[str, Parameter]
) -> tuple[Suspect, ...]:
    """A resistor across the motor that no rig declares: one, where a usual one would move a
    parameter by its standard uncertainty and by what is worth saying.
    """
    known = [parameters[name].value for name in PARAMETERS if name in parameters]
    stated = any(r.capture.wiring.terminal_load_ohm or r.block(CURRENT) is None for r in records)
    if stated or len(known) < len(PARAMETERS) or any(value is None for value in known):
        return ()
    motor = np.array([float(value or 0.0) for value in known])
    moved = loaded(motor, PARAMETERS, 1.0 / USUAL_OHM) - motor
    said = []
    for name in LOADED:
        p, by = parameters[name], -float(moved[PARAMETERS.index(name)])
        worth = p.status.measured and p.value and abs(by) > WORTH_SAYING * p.value
        if worth and abs(by) > (p.total or 0.0):
            said.append(f"{name} by {by / (p.value or 1.0):+.1%}")
    if not said:
        return ()
    evidence = (
        "these data cannot reveal a resistor across the motor, behind the current's sensor, of "
        f"which no rig says anything: {1e-3 * USUAL_OHM:.0f} kohm would change {', '.join(said)}"
    )
    code = TERMINAL_LOAD.name.replace(" ", "_")
    action = (
        "measure across the motor's wires with the motor unplugged, and declare what is there "
        "(terminal_load_ohm of the rig)"
    )
    return (Suspect(code, "motor terminals", evidence, action, "not excluded"),)
