"""The line with uncertainty in both directions, against published figures and another library."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from motorid.calibration.line import fit_line
from motorid.errors import DataError

# Pearson's data with York's weights, and the answer that York et al. (2004) publish in table II.
X = [0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4]
Y = [5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5]
WEIGHT_X = np.array([1000, 1000, 500, 800, 200, 80, 60, 20, 1.8, 1.0])
WEIGHT_Y = np.array([1.0, 1.8, 4.0, 8.0, 20, 20, 70, 70, 100, 500])


def test_it_gives_the_published_line() -> None:
    line = fit_line(X, Y, WEIGHT_X**-0.5, WEIGHT_Y**-0.5)
    assert line.slope == pytest.approx(-0.480533407, abs=1e-9)
    assert line.intercept == pytest.approx(5.47991022, abs=1e-8)
    assert line.chi_square == pytest.approx(11.8663532, rel=1e-6)
    assert line.slope_uncertainty == pytest.approx(0.0579, abs=3e-4)
    assert line.intercept_uncertainty == pytest.approx(0.2949, abs=1e-3)


def test_it_agrees_with_orthogonal_distance_regression() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        from scipy import odr

        data = odr.RealData(X, Y, sx=WEIGHT_X**-0.5, sy=WEIGHT_Y**-0.5)
        peer = odr.ODR(data, odr.unilinear, beta0=[-0.5, 5.5]).run()
    line = fit_line(X, Y, WEIGHT_X**-0.5, WEIGHT_Y**-0.5)
    assert line.slope == pytest.approx(peer.beta[0], rel=1e-5)
    assert line.intercept == pytest.approx(peer.beta[1], rel=1e-5)


@pytest.mark.slow
def test_its_uncertainty_covers_repeated_draws() -> None:
    rng = np.random.default_rng(5)
    true_x = np.array([-2.0, -1.0, 1.0, 2.0])
    u_x, u_y = np.array([0.02, 0.01, 0.01, 0.03]), np.full(4, 0.015)
    scores = []
    for _ in range(2000):
        x = true_x + u_x * rng.standard_normal(4)
        y = 0.1 + 1.05 * true_x + u_y * rng.standard_normal(4)
        line = fit_line(x, y, u_x, u_y)
        scores.append(
            [
                (line.slope - 1.05) / line.slope_uncertainty,
                (line.intercept - 0.1) / line.intercept_uncertainty,
            ]
        )
    assert np.std(scores, axis=0) == pytest.approx([1, 1], abs=0.05)
    assert np.mean(scores, axis=0) == pytest.approx([0, 0], abs=0.08)


def test_one_level_is_no_line() -> None:
    with pytest.raises(DataError, match="two different levels"):
        fit_line([1.0, 1.0], [1.0, 1.1], [0.1, 0.1], [0.1, 0.1])
    with pytest.raises(DataError, match="without any uncertainty"):
        fit_line([1.0, 2.0], [1.0, 2.1], [0.0, 0.1], [0.0, 0.1])
