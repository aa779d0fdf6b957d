"""Readings of a voltage freed of noise, as a log's waveform is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.voltage_smoothing import calm_windows, smoothed


def quiet(volts: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) V over the windows that the readings themselves ask for."""
    return smoothed(volts, calm_windows(volts))
