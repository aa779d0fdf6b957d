"""An uncertain answer that was made by hand: six parameters, their covariance, and causes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motorid.estimate.solver.problem import Solution, Unknown
from motorid.estimate.uncertainty.covariance import Statistical
from motorid.estimate.uncertainty.intervals import Findings

VALUES = {"R": 2.0, "L": 3e-3, "K": 0.05, "B": 4e-5, "J": 2e-5, "T0": 6e-3}
LOG = ("R", "L", "K", "J")
RELATIVE = {"R": 0.01, "L": 0.04, "K": 0.005, "B": 0.1, "J": 0.02, "T0": 0.05}


def search_sd(name: str, relative: float) -> float:
    """In search coordinates: a logarithm of those that are positive."""
    return relative if name in LOG else relative * VALUES[name]


def findings(
    relative: Mapping[str, float] = RELATIVE,
    causes: Mapping[str, Mapping[str, float]] | None = None,
    freedom: float = np.inf,
    bound: tuple[str, ...] = (),
    fixed: Mapping[str, float] | None = None,
    without: tuple[str, ...] = (),
    correlation: Mapping[tuple[str, str], float] | None = None,
) -> Findings:
    """Every parameter that is not fixed is free, with a relative deviation by noise."""
    names = [n for n in VALUES if n not in {**(fixed or {}), **dict.fromkeys(without)}]
    deviations = np.array([search_sd(n, relative[n]) for n in names])
    covariance = np.diag(deviations**2)
    for (a, b), rho in (correlation or {}).items():
        i, j = names.index(a), names.index(b)
        covariance[i, j] = covariance[j, i] = rho * deviations[i] * deviations[j]
    solution = Solution(
        unknowns=tuple(
            Unknown(n, VALUES[n], log=n in LOG, scale=VALUES[n], lower=-np.inf if n in LOG else 0.0)
            for n in names
        ),
        values=np.array([0.0 if n in bound else VALUES[n] for n in names]),
        own=(), own_covariance=(), information=np.linalg.inv(covariance),
        at_bound=np.array([n in bound for n in names]), linearise=tuple, objective=0.0,
        evaluations=1, converged=True,
    )  # fmt: skip
    shifts = {
        cause: np.array([search_sd(n, sizes.get(n, 0.0)) for n in names])
        for cause, sizes in (causes or {}).items()
    }
    known = Statistical(
        covariance, np.full(len(names), freedom), 1.0, False, {"noise": np.diag(covariance)}
    )
    return Findings(solution, known, shifts, dict(fixed or {}), without)
