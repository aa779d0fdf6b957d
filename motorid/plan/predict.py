"""How well a program would tell a motor's parameters: the fit's linearisation, before any run.

A skeleton of the capture goes through the fit's own record, search and budget, started at the
motor itself. Its information matrix holds noise, rounding, apertures, delays and the offsets'
priors, and what a fit leaves open of effects that it does not find counts with them; the
instruments' part follows from the gains that the channels declare.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError
from motorid.estimate.fit.multistart import with_promoted
from motorid.estimate.fit.parameter_bounds import unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import budget
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.estimate.uncertainty.intervals import NORMAL_95, POSITIVE
from motorid.estimate.uncertainty.undetected import UNTOLD, undetected
from motorid.motor.parameters import Motor, no_load_speed
from motorid.plan.skeleton import Bench, skeleton
from motorid.program import Program

Floats = NDArray[np.float64]

NEARLY = 1.2  # times what may stay open of an effect that a fit counts: chance may decide it
ROUGH = 1.0  # change of chi-square at which the search about the true motor ends


@dataclass(frozen=True)
class Prediction:
    """Standard uncertainties of one run: relative for R, L, K and J, in SI units for B and T0.

    ``statistical`` by parameter; ``causes`` by instrument cause, then by parameter.
    """

    motor: Motor
    statistical: Mapping[str, float]
    causes: Mapping[str, Mapping[str, float]]

    def instrument(self, name: str) -> float:
        """The instruments' part, which no repetition lessens."""
        return float(np.sqrt(sum(by[name] ** 2 for by in self.causes.values())))

    def reach(self, name: str, runs: float = 1.0) -> float:
        """Half the width of the 95 % interval after so many runs."""
        part = self.statistical[name] ** 2 / runs
        return NORMAL_95 * float(np.sqrt(part + self.instrument(name) ** 2))

    def runs_for(self, name: str, reach: float, least: float) -> float:
        """Runs after which the 95 % interval is ``reach`` wide to either side.

        Where the instruments alone take more than that, runs until noise takes ``least`` of it.
        """
        allowed = (reach / NORMAL_95) ** 2
        left = max(allowed - self.instrument(name) ** 2, least**2 * allowed)
        return self.statistical[name] ** 2 / left

    def largest_cause(self, name: str) -> str:
        """The instrument cause that takes the largest share; empty where none is declared."""
        by = {cause: shares[name] for cause, shares in self.causes.items()}
        return max(by, key=lambda cause: by[cause], default="")

    def scale(self, name: str) -> float:
        """What the parts are multiplied with for SI units."""
        return float(getattr(self.motor, name)) if name in POSITIVE else 1.0


@dataclass(frozen=True)
class Foreseen:
    """The fit of one run, which ends at the motor itself."""

    motor: Motor
    record: MotorRecord
    solution: Solution

    def bare(self) -> Prediction:
        """Without what effects leave open that a fit does not find: no uncertainty is less."""
        return self._with(self._white)

    def whole(self) -> Prediction:
        """The uncertainties with those, which take longer to foresee than all others."""
        return self._with(self._white + _of_effects(self.solution, self.record))

    @cached_property
    def _white(self) -> Floats:
        return np.diag(covariance_of(self.solution.information))

    def _with(self, variances: Floats) -> Prediction:
        return Prediction(self.motor, self._by_name(np.sqrt(variances)), self._causes)

    def _by_name(self, values: Floats) -> dict[str, float]:
        each = zip(self.solution.unknowns, map(float, values), strict=True)
        return {unknown.name: value for unknown, value in each}

    @cached_property
    def _causes(self) -> Mapping[str, Mapping[str, float]]:
        found = budget.propagated(self.solution, [self.record])
        return {cause: self._by_name(np.abs(shift)) for cause, shift in found.items()}


def predict(bench: Bench, program: Program, motor: Motor, seed: int = 0) -> Prediction | None:
    """The uncertainties of one run of ``program``; None where it could not be fitted at all."""
    found = foresee(bench, program, motor, seed)
    return found.whole() if found is not None else None


def foresee(bench: Bench, program: Program, motor: Motor, seed: int = 0) -> Foreseen | None:
    """The fit of one run of ``program``; None where it could not be fitted at all."""
    if not any(no_load_speed(motor, bench.volts(step)) > 0 for step in program.steps):
        return None  # it would stand still
    try:
        record = MotorRecord(skeleton(bench, program, motor, seed), PARAMETERS, {})
    except DataError:
        return None
    start = dict(zip(PARAMETERS, motor.values, strict=True))
    own = np.array([u.start for u in record.unknowns])
    # what brushes might take follows the motor's current
    record.retake_sources(np.array(motor.values), own)
    solution = maximise(unknowns_of([record], PARAMETERS, start), [record], enough=ROUGH)
    return Foreseen(motor, record, with_promoted([record], PARAMETERS, start, solution))


def _of_effects(solution: Solution, record: MotorRecord) -> Floats:
    """Variances (p,) by effects that a fit does not find and that its budget has or may have.

    It counts what the readings tell. Where more stays open than that, but not much more, noise
    decides whether it counts. More runs lessen such a variance as they lessen that of noise.
    """
    shifts = [
        effect.shift * min(1.0, UNTOLD / effect.open)
        for effect in undetected(solution, [record])
        if effect.open < NEARLY * UNTOLD
    ]
    return np.sum(np.square(shifts), axis=0) if shifts else np.zeros(len(solution.values))
