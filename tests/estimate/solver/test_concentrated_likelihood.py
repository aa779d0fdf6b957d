"""Twice the negative log-likelihood of Gaussian readings whose noise is unknown, written out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from motorid.estimate.solver.concentrated_likelihood import Concentrated
from motorid.estimate.solver.problem import Block, Unknown


class Straight:
    """y = a x + c, c its own, with what was known of c before."""

    def __init__(self, n: int, seed: int, group: str, prior_sd: float = np.inf) -> None:
        self.x = np.linspace(-1.0, 2.0, n)
        self.y = 2.0 * self.x + 0.3 + np.random.default_rng(seed).normal(0.0, 0.1, n)
        self.unknowns = (Unknown("c", 0.0, prior_sd=prior_sd),)
        self.blocks = (Block("y", 1e-9, n, group),)

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        return [self.y - shared[0] * self.x - own[0]]


A = (Unknown("a", 1.0),)


def minus_twice_log(residual: np.ndarray) -> float:
    """Of independent Gaussian residuals at their most likely deviation, less n ln 2π."""
    sd = float(np.sqrt(np.mean(residual**2)))
    whole = -2.0 * float(norm.logpdf(residual, 0.0, sd).sum())
    return whole - len(residual) * float(np.log(2 * np.pi))


@pytest.mark.parametrize(("a", "c"), [(1.0, 0.0), (2.0, 0.3), (-1.0, 5.0)])
def test_each_kind_of_reading_has_its_own_noise(a: float, c: float) -> None:
    records = [Straight(40, 1, ""), Straight(60, 2, "")]
    at = Concentrated(A, records).point(np.array([a]), [np.array([c])] * 2)
    expected = sum(minus_twice_log(r.y - a * r.x - c) for r in records)
    assert at.objective == pytest.approx(expected, rel=1e-9)


def test_one_group_has_one_noise() -> None:
    records = [Straight(40, 1, "y"), Straight(60, 2, "y")]
    at = Concentrated(A, records).point(np.array([1.5]), [np.array([0.1])] * 2)
    together = np.concatenate([r.y - 1.5 * r.x - 0.1 for r in records])
    assert at.objective == pytest.approx(minus_twice_log(together), rel=1e-9)


def test_what_was_known_before_adds_its_chi_square() -> None:
    vague, known = Straight(40, 1, ""), Straight(40, 1, "", prior_sd=0.2)
    points = [
        Concentrated(A, [one]).point(np.array([1.0]), [np.array([0.5])]) for one in (vague, known)
    ]
    assert points[1].objective - points[0].objective == pytest.approx((0.5 / 0.2) ** 2)
    assert points[1].prior == pytest.approx((0.5 / 0.2) ** 2)


def test_derivatives_of_a_straight_line_are_its_columns() -> None:
    one = Straight(40, 1, "")
    engine = Concentrated(A, [one])
    found = engine.derivatives(engine.start)
    assert np.abs(found.shared[0][0]) == pytest.approx(np.abs(one.x), abs=1e-6)
    assert np.abs(found.own_slopes[0][0]) == pytest.approx(np.ones(40), abs=1e-6)
    assert np.sign(found.shared[0][0][0]) == np.sign(-found.own_slopes[0][0][0])
