"""The same fit as a user of SciPy would write it: LSODA inside least_squares, in log parameters.

Usage: python lsoda_fit.py DATA.npz RTOL, prints one JSON line {seconds, parameters}.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np
from problem import NAMES, SIGMA_I, SIGMA_W, simulate, start
from scipy.optimize import least_squares


def main() -> None:
    """Fit once and print."""
    data = dict(np.load(sys.argv[1]))
    rtol = float(sys.argv[2])
    guess = start()
    evaluations = 0

    def residuals(logs: np.ndarray) -> np.ndarray:
        nonlocal evaluations
        evaluations += 1
        p = {name: guess[name] * float(np.exp(x)) for name, x in zip(NAMES, logs, strict=True)}
        y = simulate(data["v"], p, rtol)
        return np.r_[(data["i"] - y[0]) / SIGMA_I, (data["w"] - y[1]) / SIGMA_W]

    began = time.perf_counter()
    # The difference step must clear the integrator's own noise, hence its tie to rtol.
    fit = least_squares(residuals, np.zeros(len(NAMES)), diff_step=rtol**0.5, xtol=1e-9, ftol=1e-9)
    seconds = time.perf_counter() - began
    fitted = {name: guess[name] * float(np.exp(x)) for name, x in zip(NAMES, fit.x, strict=True)}
    print(json.dumps({"seconds": seconds, "evaluations": evaluations, "parameters": fitted}))


main()
