"""How much more means scatter, against the variance of many drawn ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from motorid.estimate.uncertainty.coloured_mean import COLOUR, variance_growth


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_means_of_an_autoregression_scatter_so_much_more(rho: float) -> None:
    draws = np.random.default_rng(4).standard_normal((400, 2000))
    many = lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], draws, axis=1)
    seen = float(np.var(many.mean(axis=1)) * many.shape[1])
    growths = [variance_growth(one - one.mean()) for one in many]
    assert np.median(growths) == pytest.approx(seen, rel=0.2)


def test_neighbours_that_alternate_or_are_nothing_count_as_white() -> None:
    assert variance_growth(np.tile([1.0, -1.0], 50)) == 1.0
    assert variance_growth(np.zeros(20)) == 1.0


def test_no_more_is_believed_than_a_bound() -> None:
    slow = np.sin(2.0 * np.pi * np.arange(5000) / 5000)
    assert variance_growth(slow) == pytest.approx((1.0 + COLOUR) / (1.0 - COLOUR))
