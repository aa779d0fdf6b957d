"""Sums of products against numpy's own."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.solver.dense_products import (
    MISFIT,
    SMALL_PRODUCT,
    dot,
    gram,
    misfits,
    project,
    square,
)

RNG = np.random.default_rng(5)


@pytest.mark.parametrize("n", [1, 7, SMALL_PRODUCT // 6, SMALL_PRODUCT // 6 + 1, 100_003])
def test_they_are_matrix_products(n: int) -> None:
    """Also where the work is split, and where the last piece is short."""
    a, b = RNG.normal(size=(2, n)), RNG.normal(size=(3, n))
    assert gram(a, b) == pytest.approx(a @ b.T, rel=1e-9, abs=1e-9)
    assert project(b, a[0]) == pytest.approx(b @ a[0], rel=1e-9, abs=1e-9)
    assert dot(a[0], a[1]) == pytest.approx(float(np.dot(a[0], a[1])), rel=1e-9, abs=1e-9)
    assert square(a[0]) == pytest.approx(float(np.linalg.norm(a[0]) ** 2))


def test_nothing_times_nothing() -> None:
    assert gram(np.zeros((0, 5)), np.zeros((2, 5))).shape == (0, 2)
    assert gram(np.zeros((1, 0)), np.zeros((1, 0))).tolist() == [[0.0]]


def test_noise_is_no_misfit_and_a_bow_is() -> None:
    noise = RNG.normal(size=2000)
    bow = 10.0 * np.sin(np.linspace(0.0, np.pi, 2000))
    assert not misfits(noise, 0.0)
    assert misfits(noise + bow, 0.0)
    assert misfits(noise + bow, 5.0)
    assert not misfits(noise + bow, 20.0)  # less than what counts at all


@pytest.mark.parametrize("scale", [1.0, 3.0])
@pytest.mark.parametrize(("times", "said"), [(0.9, False), (1.1, True)])
def test_a_misfit_begins_at_its_multiple_of_the_scatter(
    times: float, said: bool, scale: float
) -> None:
    """An offset adds nothing between neighbours: with it the rms is that multiple."""
    noise = np.tile([1.0, -1.0], 1000) / np.sqrt(2.0)  # sqrt(half the mean square step) is 1
    assert misfits(scale * (noise + np.sqrt((times * MISFIT) ** 2 - 0.5)), 0.0) == said
