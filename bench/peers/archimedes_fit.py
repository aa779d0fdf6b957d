"""The same fit by archimedes' prediction-error method; runs in an environment of its own.

Usage: python archimedes_fit.py DATA.npz, prints one JSON line {seconds, parameters}.
"""

from __future__ import annotations

import json
import sys
import time

import archimedes as arc
import numpy as np
from archimedes.observers import ExtendedKalmanFilter
from archimedes.sysid import Timeseries, pem
from problem import NAMES, PERIOD_S, SIGMA_I, SIGMA_W, start


def main() -> None:
    """Fit once, time the call (its compilation included, as a user pays it), print."""
    file = np.load(sys.argv[1])
    guess = start()

    @arc.discretize(dt=PERIOD_S, method="rk4", n_steps=2)
    def dynamics(t, x, u, params):
        p = {name: guess[name] * params[name] for name in NAMES}
        torque = p["K"] * x[0] - p["B"] * x[1] - p["T0"] * np.tanh(x[1] / 0.1)
        return np.hstack([(u[0] - p["R"] * x[0] - p["K"] * x[1]) / p["L"], torque / p["J"]])

    def observe(t, x, u, params):
        return x / np.array([SIGMA_I, SIGMA_W])

    # Next to no process noise: the prediction error is then the output error that the others fit.
    filter_ = ExtendedKalmanFilter(dyn=dynamics, obs=observe, Q=1e-16 * np.eye(2), R=np.eye(2))
    n = len(file["v"])
    v, y = file["v"], np.vstack([file["i"] / SIGMA_I, file["w"] / SIGMA_W])
    # Its predictor steps with u[k], then compares with y[k]: the same convention as the data's.
    data = Timeseries(ts=np.arange(n) * PERIOD_S, us=v[None, :], ys=y)
    ones = {name: np.float64(1.0) for name in NAMES}
    bounds = (dict.fromkeys(NAMES, 0.001), dict.fromkeys(NAMES, 1000.0))
    x0 = np.array([0.0, 0.0])
    began = time.perf_counter()
    result = pem(
        filter_,
        data,
        ones,
        x0=x0,
        P0=1e-12 * np.eye(2),
        bounds=bounds,
        method="lm",
    )
    seconds = time.perf_counter() - began
    fitted = result.p
    print(
        json.dumps(
            {
                "seconds": seconds,
                "evaluations": int(result.nfev),
                "parameters": {name: float(guess[name] * fitted[name]) for name in NAMES},
            }
        )
    )


main()
