"""Effects that these data say less of than what is usual, as suspects that are not excluded."""

from __future__ import annotations

from collections.abc import Sequence

from motorid.estimate.results.estimate import PARAMETERS, Suspect
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.undetected import Undetected

WORTH_SAYING = 1e-3  # relative change of a parameter
PLACES = 3  # a percentage with one decimal


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
            name = one.quantity.name
            evidence = (
                f"these data cannot reveal {name}: its usual size would change "
                f"{', '.join(said)}, and the intervals do not include that"
            )
            code = name.replace(" ", "_")
            out.append(Suspect(code, name, evidence, one.quantity.remedy, "not excluded"))
    return tuple(out)
