"""mealpy's PSO on the bench's motor; runs in an environment of its own.

Usage: python mealpy_pso.py DATA.npz OBJECTIVE POPULATION EPOCHS, prints one JSON line
{seconds, evaluations, cost}. OBJECTIVE "solve_ivp": as a user of mealpy writes it; "compiled":
motorid's own compiled response, one candidate at a time (PYTHONPATH must hold motorid).
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

import numpy as np
from mealpy import PSO, FloatVar

Cost = Callable[[np.ndarray], float]


def by_solve_ivp(data: dict[str, np.ndarray]) -> Cost:
    """LSODA over the record at its usual tolerance, cost of equation 31 by peaks."""
    from scipy.integrate import solve_ivp

    i, w, volts = data["current"], data["speed"], float(data["volts"])
    times = np.arange(len(i)) * float(data["period_s"])

    def cost(values: np.ndarray) -> float:
        R, L, K, B, J = values

        def rates(t: float, x: np.ndarray) -> list[float]:
            return [(volts - R * x[0] - K * x[1]) / L, (K * x[0] - B * x[1]) / J]

        y = solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], method="LSODA", t_eval=times).y
        both = np.concatenate([(y[0] - i) / i.max(), (y[1] - w) / w.max()])
        return float(np.sqrt(np.mean(both**2)))

    return cost


def by_compiled(data: dict[str, np.ndarray]) -> Cost:
    """motorid's objective, asked for one candidate at a time."""
    from motorid.motor.batch import LINEAR, Record
    from motorid.search.bounds import Box
    from motorid.search.objective import Objective, peaks

    record = Record(
        float(data["period_s"]),
        np.full(len(data["current"]), float(data["volts"])),
        {"current": data["current"], "speed": data["speed"]},
    )
    box = Box(LINEAR.parameters, data["low"], data["high"])
    objective = Objective(LINEAR, (record,), box, peaks([record]))
    return lambda values: float(objective(box.unit(values)[None])[0])


def main() -> None:
    """Search once and print."""
    data = dict(np.load(sys.argv[1]))
    cost = {"solve_ivp": by_solve_ivp, "compiled": by_compiled}[sys.argv[2]](data)
    population, epochs = int(sys.argv[3]), int(sys.argv[4])
    evaluations = 0

    def counted(values: np.ndarray) -> float:
        nonlocal evaluations
        evaluations += 1
        return cost(values)

    problem = {
        "bounds": FloatVar(lb=data["low"].tolist(), ub=data["high"].tolist()),
        "obj_func": counted,
        "minmax": "min",
        "log_to": None,
    }
    counted(np.sqrt(data["low"] * data["high"]))  # imports and compilations are not timed
    evaluations = 0
    begin = time.perf_counter()
    best = PSO.OriginalPSO(epoch=epochs, pop_size=population).solve(problem, seed=1)
    seconds = time.perf_counter() - begin
    print(json.dumps({"seconds": seconds, "evaluations": evaluations, "cost": best.target.fitness}))


main()
