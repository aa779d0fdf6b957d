"""How much less residuals tell that follow each other, against the theory of such noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from motorid.estimate.partial.exponential_fit import _correlated


@pytest.mark.parametrize("rho", [0.5, 0.9])
def test_the_variance_of_a_mean_grows_as_of_an_autoregression(rho: float) -> None:
    noise = lfilter([1.0], [1.0, -rho], np.random.default_rng(2).standard_normal(40_000))
    assert _correlated(noise) == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.1)


def test_white_residuals_tell_all_and_none_tell_no_less() -> None:
    assert _correlated(np.random.default_rng(2).standard_normal(2000)) == 1.0
    assert _correlated(np.zeros(50)) == 1.0
