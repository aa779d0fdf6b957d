"""What measuring chains do to a quantity, on the fine grid of a trace. Shapes (n,)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Floats = NDArray[np.float64]


def low_pass(values: Floats, step_s: float, tau_s: float, order: int = 1) -> Floats:
    """So many equal first-order filters, one after the other; from rest at the first value."""
    keep = np.exp(-step_s / tau_s)
    for _ in range(order):
        values, _ = lfilter([1 - keep], [1, -keep], values, zi=[keep * values[0]])
    return np.asarray(values)


def late(values: Floats, step_s: float, delay_s: float) -> Floats:
    """What comes so much later."""
    at = np.arange(len(values)) * step_s
    return np.interp(at - delay_s, at, values)


def mean(values: Floats, step_s: float, aperture_s: float, where: str = "before") -> Floats:
    """The mean over a window before, around or after each tick."""
    window = max(round(aperture_s / step_s), 1)
    total = np.concatenate([[0.0], np.cumsum(values)])
    ahead = {"before": 0, "around": window // 2, "after": window}[where]
    end = np.clip(np.arange(len(values)) + ahead, 0, len(values))
    begin = np.clip(end - window, 0, len(values))
    return np.asarray((total[end] - total[begin]) / np.maximum(end - begin, 1))


def rounded(values: Floats, step: float) -> Floats:
    """To whole steps of a converter."""
    return np.round(values / step) * step
