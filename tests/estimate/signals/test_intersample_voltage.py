"""A log whose voltage readings are means since the one before, against the exact solution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from tests.six_parameters import fit

TRUE = {"R": 2.6, "L": 400e-6, "K": 7.68e-3, "B": 4.0e-7, "J": 6.0e-7, "T0": 1.5e-4}
PERIOD_S = 1e-4  # L/R is one and a half of it
LEVELS = (3.0, 6.0, 4.5, 2.0, 5.0)
EACH = 701


def log(share: float, jitter: float = 0.0) -> Capture:
    """Steps at stamps; the voltage a mean over the last ``share`` of the time between them."""
    R, L, K, B, J, T0 = TRUE.values()
    rng = np.random.default_rng(1)
    n = EACH * len(LEVELS)
    volts = np.repeat(LEVELS, EACH)
    steps = PERIOD_S * (1.0 + jitter * rng.uniform(-1, 1, n))
    system = np.zeros((4, 4))  # current, speed; held voltage, Coulomb torque
    system[0] = [-R / L, -K / L, 1 / L, 0.0]
    system[1] = [K / J, -B / J, 0.0, -1 / J]
    i0 = (B * LEVELS[0] + K * T0) / (R * B + K * K)
    state = np.array([i0, (LEVELS[0] - R * i0) / K])  # steady
    out = np.empty((2, n))
    usual = expm(system * PERIOD_S)[:2]
    for k in range(n):
        step = usual if not jitter else expm(system * steps[k])[:2]
        out[:, k] = state = step @ [*state, volts[k], T0]
    current = out[0] + 3e-3 * rng.standard_normal(n)
    speed = out[1] + 1.5 * rng.standard_normal(n)
    clock_hz = 1e9
    return Capture(
        ticks=np.rint(np.cumsum(steps) * clock_hz).astype(np.int64),
        clock_hz=clock_hz,
        channels={
            VOLTAGE: Channel(
                VOLTAGE, "V", volts, kind="mean", aperture_s=share * PERIOD_S, sense="terminals"
            ),
            CURRENT: Channel(CURRENT, "A", current),
            SPEED: Channel(SPEED, "rad/s", speed),
        },
    )


@pytest.mark.slow
@pytest.mark.parametrize(("share", "jitter"), [(1.0, 0.0), (0.9, 0.0), (1.0, 0.3)])
def test_the_inductance_holds(share: float, jitter: float) -> None:
    """Readings leave 2 % of any value open; what is usual of a fan leaves more of friction."""
    found = fit([log(share, jitter)])
    for name, true in TRUE.items():
        p, fan = found.parameters[name], found.budget[name].get("quadratic load", 0.0)
        assert abs(p.value - true) < 3.0 * p.total, name
        assert p.total**2 - fan**2 < (0.02 * true) ** 2, name
        assert name in ("B", "T0") or fan < 0.02 * true
