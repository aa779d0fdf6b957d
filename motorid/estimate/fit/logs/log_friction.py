"""How a log without a motion shares its friction between B and T0.

One level hardly separates the two. But a T0 near nothing lets noise of the voltage turn a resting
motor in the model. What that explains of the current's noise by chance makes a narrow valley, whose
lowest point may be the lowest of all. Its curvature says nothing of the wide one beside it, so
valleys are compared by all that lies in them: by the mass of the posterior about each, with T0 held
where the wide one would be. What a search does not leave for it is a rival of the answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.estimate.effects import scales
from motorid.estimate.fit.alternating_fit import ROUGH, again
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import Rival
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution, bounded_inverse
from motorid.estimate.solver.search_coordinates import LOG_REACH

SHARES = (0.2, 0.8)  # of the friction at the highest speed, that is Coulomb's
SURELY = 0.5  # of chi-square: less is no better
APART = 3.0  # times the fall that a parabola promises: less is the same valley
TINY = 1e-300  # for a variance that is none
FALLEN = 16.0  # of chi-square, from which a valley holds nothing


def shared(
    records: Sequence[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
) -> Solution:
    """This solution, or one of another valley of friction where more of the posterior lies there;
    else with that for a rival.
    """
    if not {"B", "T0"} <= set(free):
        return solution
    most = _most(records, merged(start, solution))
    rivals: list[Rival] = []
    for share in SHARES if all(most.values()) else ():
        dry = share * most["T0"]
        held = _with_dry(records, solution, (1.0 - share) * most["B"], dry)
        if held.objective - solution.objective > FALLEN:
            continue
        # where T0 is at its bound, derivatives of a rough end say nothing of how narrow it is
        finer = again(records, free, start, solution)
        solution = finer if finer.objective < solution.objective else solution
        fallen = max(held.objective - solution.objective, 1.0)
        if _promised(solution, dry) <= APART**2 * fallen:
            continue
        trial = again(records, free, start, held)
        behind = min(_weight(held, most), _weight(trial, most)) - _weight(solution, most)
        if _weight(trial, most) < _weight(solution, most) - SURELY:
            solution, rivals = trial, []
        else:
            rivals.append(Rival(held.values, behind, friction=True))
    records[0].rivals = (*records[0].rivals, *rivals)
    return solution


def _most(records: Sequence[MotorRecord], found: Mapping[str, float]) -> dict[str, float]:
    """Of B and T0, each if it were all the friction at the speed of the highest voltage."""
    top = max(scales.volts(record) for record in records) / found["K"]
    torque = found["B"] * top + found["T0"]
    return {"B": torque / top, "T0": torque}


def _with_dry(
    records: Sequence[MotorRecord], solution: Solution, viscous: float, dry: float
) -> Solution:
    """Everything else as it is the most likely with so much of T0 (N·m); B is begun with."""
    values = {**merged({}, solution), "B": viscous, "T0": dry}
    unknowns = [replace(u, start=values[u.name]) for u in solution.unknowns]
    held = [replace(u, lower=dry, upper=dry) if u.name == "T0" else u for u in unknowns]
    return maximise(held, records, enough=ROUGH, before=solution)


def _promised(solution: Solution, dry: float) -> float:
    """What a parabola about the solution has F rise by to so much of T0 (N·m)."""
    k = [u.name for u in solution.unknowns].index("T0")
    others = solution.at_bound.copy()
    others[k] = False
    variance = float(bounded_inverse(solution.information, others)[k, k])
    return float((dry - solution.values[k]) ** 2 / max(variance, TINY))


def _weight(solution: Solution, most: Mapping[str, float]) -> float:
    """Minus twice the logarithm of the posterior's mass about a solution, but for a constant: by
    Laplace's approximation, no wider than ``most`` (SI) of a parameter or the search reaches.
    """
    widest = [LOG_REACH if u.log else most.get(u.name, np.inf) for u in solution.unknowns]
    known = np.diag(np.array(widest) ** -2.0)
    return solution.objective + float(np.linalg.slogdet(solution.information + known)[1])
