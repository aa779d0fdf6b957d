"""Shapiro and Wilk's test against scipy's, and without the package that is slow to import."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import kurtosis, shapiro, skew

from motorid.quality.pearson_curve import curve_of
from motorid.quality.shapiro_wilk import shapiro_wilk
from motorid.quality.skewed import normality

SIZES = (3, 4, 5, 6, 7, 11, 12, 30, 500, 5000)


@pytest.mark.parametrize("count", SIZES)
@pytest.mark.parametrize("law", ["normal", "exponential", "uniform"])
def test_it_is_scipys(count: int, law: str) -> None:
    rng = np.random.default_rng([2031, count])
    values = 20.0 + 3.0 * getattr(rng, law)(size=count)
    assert shapiro_wilk(values) == pytest.approx(shapiro(values).pvalue, rel=1e-5, abs=1e-12)


def test_rounded_readings_and_equal_ones() -> None:
    rounded = np.round(np.random.default_rng(7).normal(2.6, 0.01, 200), 2)
    assert shapiro_wilk(rounded) == pytest.approx(shapiro(rounded).pvalue, rel=1e-5)
    assert shapiro_wilk(np.full(9, 2.6)) == 1.0
    assert shapiro_wilk(np.array([0.0] * 10 + [1.0])) < 1e-6


def test_many_readings_are_thinned() -> None:
    values = np.random.default_rng(8).normal(size=12_000)
    assert normality(values) == pytest.approx(shapiro(values[::3]).pvalue, rel=1e-4)


@pytest.mark.slow
def test_a_trend_of_normal_readings_needs_no_scipy_stats() -> None:
    code = (
        "import sys, numpy as np\n"
        "from motorid.quality.trend import trend\n"
        "values = np.random.default_rng(9).normal(size=100)\n"
        "trend(values, np.arange(100.0), lower=-9.0, upper=9.0)\n"
        "print('scipy.stats' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize("count", [3, 4, 9, 2000])
def test_the_moments_of_a_curve_are_scipys(count: int) -> None:
    values = 0.01 * np.random.default_rng(count).exponential(size=count) + 2.6
    curve = curve_of(values)
    assert curve.skewness[0] == pytest.approx(skew(values, bias=False), rel=1e-9)
    assert curve.kurtosis[0] == pytest.approx(kurtosis(values, bias=False), rel=1e-9)
