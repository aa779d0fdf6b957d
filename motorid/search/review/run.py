"""One task of a table: one row, one noise, one seed; and what many of them say together."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motorid.errors import DataError
from motorid.estimate.results.estimate import Floats
from motorid.motor.batch import FRICTION, LINEAR, Record
from motorid.search import closed_forms
from motorid.search.problem import Problem, Solution, solve
from motorid.search.review.as_capture import default
from motorid.search.review.experiment import Experiment, Row

DEFAULT = "ml"
CLOSED_FORMS: Mapping[str, Callable[[Record], dict[str, float]]] = {
    "acceleration": closed_forms.acceleration,
    "steady-state+coast-down": closed_forms.least_squares,
}


def run(experiment: Experiment, row: Row, noise: float, seed: int) -> Solution:
    """Solve one task. A method that finds no answer gives one without values, and its reason."""
    problem = experiment.problem(noise, seed)
    try:
        if row.method == DEFAULT and experiment.model in (LINEAR, FRICTION):
            return default(problem.step, experiment.model, seed)
        if row.method in CLOSED_FORMS:
            return _closed_form(problem, row.method, seed)
        return solve(problem, row.method, budget=row.budget, seed=seed, n=row.n, rule=row.rule)
    except DataError as error:
        return Solution(row.method, {}, np.inf, 0, 0.0, str(error), seed, np.empty((0, 2)))


def _closed_form(problem: Problem, method: str, seed: int) -> Solution:
    begin = time.perf_counter()
    values = CLOSED_FORMS[method](problem.step)
    seconds = time.perf_counter() - begin
    return Solution(method, values, np.nan, 1, seconds, "closed form", seed, np.empty((0, 2)))


def relative_to_nominal(estimate: Floats, nominal: Floats) -> Floats:
    """100 |x - x0| / x0: the convention of Tables 3 to 6, in percent."""
    return np.asarray(100.0 * np.abs(estimate - nominal) / np.abs(nominal))


def relative_to_estimate(estimate: Floats, nominal: Floats) -> Floats:
    """100 |x - x0| / x: the convention that Tables 8 and 9 turn out to use, in percent."""
    return np.asarray(100.0 * np.abs(estimate - nominal) / np.abs(estimate))


@dataclass(frozen=True)
class Quartiles:
    """Of a percent error over the seeds."""

    low: float
    median: float
    high: float

    @classmethod
    def of(cls, values: Floats) -> Quartiles:
        """Quartiles of values (seeds,)."""
        low, median, high = np.quantile(values, (0.25, 0.5, 0.75))
        return cls(float(low), float(median), float(high))


@dataclass(frozen=True)
class Summary:
    """What a row came to over its seeds; errors in percent by parameter, both conventions."""

    experiment: str
    noise: float
    label: str
    method: str
    seeds: int
    failed: int
    to_nominal: Mapping[str, Quartiles]
    to_estimate: Mapping[str, Quartiles]
    rms: Mapping[str, float]  # to nominal, over the seeds
    cost: Quartiles | None
    evaluations: float
    seconds: float


def figures_found(experiment: Experiment, solutions: Sequence[Solution]) -> dict[str, Floats]:
    """What each solution says of each figure, (solutions,); NaN where it says nothing."""
    said = [experiment.figures(s.values) if s.values else {} for s in solutions]
    return {
        name: np.array([figures.get(name, np.nan) for figures in said])
        for name in experiment.figures(experiment.truth)
    }


def summarise(
    experiment: Experiment, row: Row, noise: float, solutions: Sequence[Solution]
) -> Summary:
    """Medians, quartiles and rms over the seeds that gave an answer."""
    good = [solution for solution in solutions if solution.values]
    truth = experiment.figures(experiment.truth)
    nominal, estimate, rms = {}, {}, {}
    for name, found in figures_found(experiment, good).items():
        values = found[~np.isnan(found)]
        if len(values):
            misses = relative_to_nominal(values, np.array(truth[name]))
            nominal[name] = Quartiles.of(misses)
            estimate[name] = Quartiles.of(relative_to_estimate(values, np.array(truth[name])))
            rms[name] = float(np.sqrt(np.mean(misses**2)))
    costs = np.array([s.cost for s in good if np.isfinite(s.cost)])
    return Summary(
        experiment.key,
        noise,
        row.label,
        row.method,
        len(solutions),
        len(solutions) - len(good),
        nominal,
        estimate,
        rms,
        Quartiles.of(costs) if len(costs) else None,
        float(np.mean([s.evaluations for s in good])) if good else 0.0,
        float(np.median([s.seconds for s in good])) if good else 0.0,
    )
