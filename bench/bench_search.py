"""Speed of the batch response and of a swarm, against scipy's filter and mealpy, in one run.

python bench/bench_search.py [--mealpy VENV]
(the environment is made by bench/peers_search/setup_mealpy.sh VENV)
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lfilter

from motorid.motor.batch import FRICTION, LINEAR, Record, blank
from motorid.search import Problem, solve
from motorid.search.bounds import Box
from motorid.search.objective import peaks

HERE = Path(__file__).parent
MOTOR = {"R": 3.1363, "L": 0.01307, "K": 0.048774, "B": 1.69e-4, "J": 9e-6}  # Table 7 of the review
SAMPLES, CANDIDATES = 5000, 100
PERIOD_S, VOLTS = 1e-4, 8.0
POPULATION, GENERATIONS = 30, 100
LIMIT_MS, LIMIT_FILTERS = 4.0, 70.0
LIMIT_IVP, LIMIT_COMPILED = 100.0, 2.0


def record() -> Record:
    """The motor's step response with 1 % noise."""
    volts = np.full(SAMPLES, VOLTS)
    silent = Record(PERIOD_S, volts, blank(volts, ("current", "speed")))
    clean = LINEAR.outputs(np.array([list(MOTOR.values())]), silent)[0]
    noise = np.random.default_rng(1).standard_normal(clean.shape)
    noisy = clean + 0.01 * np.abs(clean).max(axis=1, keepdims=True) * noise
    return Record(PERIOD_S, volts, {"current": noisy[0], "speed": noisy[1]})


def fastest(call: Callable[[], Any], repeats: int = 30) -> float:
    """Seconds of the fastest call: what the code costs when nothing else runs."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


def responses(data: Record) -> bool:
    """The batch of candidates against one filter pass; True if within the limits."""
    rng = np.random.default_rng(0)
    motors = np.array(list(MOTOR.values())) * rng.uniform(0.3, 3.0, (CANDIDATES, 5))
    signal = rng.standard_normal(10_000)
    one_pass = fastest(lambda: lfilter([0.1, 0.2, 0.1], [1.0, -0.5, 0.1], signal), 200)
    batch = fastest(lambda: LINEAR.squares(motors, data))
    with_friction = np.column_stack([motors, np.full(CANDIDATES, 1e-4)])
    friction = fastest(lambda: FRICTION.squares(with_friction, data))
    print(f"one lfilter pass, second order, 10,000 samples   {1e3 * one_pass:8.3f} ms")
    for name, seconds in (("linear", batch), ("with friction", friction)):
        print(
            f"{CANDIDATES} candidates x {SAMPLES} samples, {name:<14}     {1e3 * seconds:8.3f} ms"
            f"   = {seconds / one_pass:5.1f} passes"
        )
    good = 1e3 * batch <= LIMIT_MS and batch <= LIMIT_FILTERS * one_pass
    print(f"   wanted: {LIMIT_MS:g} ms, {LIMIT_FILTERS:g} passes: {'yes' if good else 'NO'}")
    return good


def peer(venv: str, path: str, objective: str) -> dict[str, Any]:
    """mealpy's swarm in its own environment: {seconds, evaluations, cost}."""
    python = Path(venv) / ("Scripts" if os.name == "nt" else "bin") / "python"
    script = HERE / "peers_search" / "mealpy_pso.py"
    run = subprocess.run(
        [str(python), str(script), path, objective, str(POPULATION), str(GENERATIONS)],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(HERE.parent)},
    )
    return json.loads(run.stdout.strip().splitlines()[-1])


def swarms(data: Record, venv: str | None) -> bool:
    """A swarm of 30 x 100 against mealpy's; True if faster by the factors wanted."""
    box = Box.around(MOTOR, 0.3, 3.0)
    problem = Problem(LINEAR, (data,), box, peaks([data]))
    budget = POPULATION * (1 + GENERATIONS)
    ours = fastest(lambda: solve(problem, "pso-inertia", budget=budget, seed=1), 7)
    cost = solve(problem, "pso-inertia", budget=budget, seed=1).cost
    print(f"PSO {POPULATION} x {GENERATIONS}, {SAMPLES} samples, motorid             "
          f"{1e3 * ours:8.1f} ms   cost {cost:.5f}")  # fmt: skip
    if venv is None:
        return True
    good = True
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "problem.npz")
        np.savez(path, period_s=PERIOD_S, volts=VOLTS, low=box.low, high=box.high, **data.measured)
        for objective, wanted in (("compiled", LIMIT_COMPILED), ("solve_ivp", LIMIT_IVP)):
            theirs = peer(venv, path, objective)
            ratio = theirs["seconds"] / ours
            good = good and ratio >= wanted
            print(
                f"   mealpy's, {objective:<10} objective                 "
                f"{1e3 * theirs['seconds']:8.1f} ms   cost {theirs['cost']:.5f}   = {ratio:.1f} x"
                f"   wanted {wanted:g} x: {'yes' if ratio >= wanted else 'NO'}"
            )
    return good


def main() -> None:
    """Print the table; exit 1 where a figure is missed."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--mealpy", help="virtual environment that holds mealpy")
    options = parser.parse_args()
    data = record()
    good = responses(data)
    good = swarms(data, options.mealpy) and good
    raise SystemExit(0 if good else 1)


if __name__ == "__main__":
    main()
