"""One fitting problem for every peer: the exact model, known input, noisy current and speed.

Drive only, one direction, so that a peer without stiction or coasting can state it too.
"""

from __future__ import annotations

import numpy as np

TRUTH = {"R": 2.6, "L": 400e-6, "K": 7.68e-3, "B": 4.0e-7, "J": 6.0e-7, "T0": 1.5e-4}
START_FACTOR = {"R": 1.4, "L": 0.6, "K": 0.8, "B": 1.6, "J": 1.5, "T0": 0.6}
NAMES = tuple(TRUTH)
PERIOD_S = 1e-4
SIGMA_I, SIGMA_W = 3e-3, 1.5


def rhs(x: np.ndarray, v: float, p: dict[str, float]) -> np.ndarray:
    """Time derivative of (current, speed); sticks at standstill."""
    i, w = x
    torque = p["K"] * i
    friction = p["T0"] if w > 0 else min(max(torque, 0.0), p["T0"])
    di = (v - p["R"] * i - p["K"] * w) / p["L"]
    return np.array([di, (torque - p["B"] * w - friction) / p["J"]])


def voltage(n: int = 10_000) -> np.ndarray:
    """A hundredth at rest, then 3, 6, 4.5, 2 V in equal parts of n samples, held between them."""
    rest = n // 100
    return np.concatenate([np.zeros(rest), np.repeat([3.0, 6.0, 4.5, 2.0], (n - rest) // 4)])


def simulate(v: np.ndarray, p: dict[str, float], rtol: float = 1e-10) -> np.ndarray:
    """Current and speed at each sample, shape (2, n): LSODA, restarted at each step of v."""
    from scipy.integrate import solve_ivp

    edges = np.flatnonzero(np.diff(v)) + 1
    out = np.zeros((2, len(v)))
    x = np.zeros(2)
    for a, b in zip(np.r_[0, edges], np.r_[edges, len(v)], strict=True):
        t = np.arange(b - a + 1) * PERIOD_S
        level = float(v[a])
        sol = solve_ivp(
            lambda _, x, level=level: rhs(x, level, p),
            (0, t[-1]),
            x,
            method="LSODA",
            t_eval=t,
            rtol=rtol,
            atol=[rtol * 1, rtol * 100],
        )
        out[:, a:b] = sol.y[:, 1:]
        x = sol.y[:, -1]
    return out


def make(seed: int = 1) -> dict[str, np.ndarray]:
    """The data: v (n,) V, held over the interval before its sample, i (n,) A, w (n,) rad/s."""
    v = voltage()
    y = simulate(v, TRUTH)
    rng = np.random.default_rng(seed)
    return {
        "v": v,
        "i": y[0] + SIGMA_I * rng.standard_normal(len(v)),
        "w": y[1] + SIGMA_W * rng.standard_normal(len(v)),
    }


def start() -> dict[str, float]:
    """Where every peer starts."""
    return {name: TRUTH[name] * START_FACTOR[name] for name in NAMES}


def chi_square(p: dict[str, float], data: dict[str, np.ndarray]) -> float:
    """Sum of squared residuals over their variances, at p, by the reference integrator."""
    y = simulate(data["v"], p)
    return float(
        np.sum(((data["i"] - y[0]) / SIGMA_I) ** 2) + np.sum(((data["w"] - y[1]) / SIGMA_W) ** 2)
    )
