"""By how much more a mean scatters where neighbours agree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

COLOUR = 0.98  # largest correlation of neighbours that is believed


def variance_growth(about: NDArray[np.float64]) -> float:
    """Variance of a mean of residuals (n,), whose own mean is 0, over that of white ones.

    As of an autoregression of first order: (1 + ρ)/(1 - ρ). Neighbours that alternate are white.
    """
    rho = float(np.clip((about[1:] * about[:-1]).sum() / max((about**2).sum(), 1e-300), 0, COLOUR))
    return (1.0 + rho) / (1.0 - rho)
