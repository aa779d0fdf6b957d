"""What slowly wandering residuals are worth, against series whose worth is known."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.model.effective_sample_size import excess


def white(seed: int, stretches: int, length: int) -> list[np.ndarray]:
    return list(np.random.default_rng(seed).standard_normal((stretches, length)))


def test_white_noise_is_worth_what_it_counts() -> None:
    found = [excess(white(s, 4, 800), [np.ones(800)] * 4) for s in range(200)]
    assert np.mean(np.array(found) == 1.0) > 0.98


def test_a_slow_wander_counts_for_its_variance_at_low_frequency() -> None:
    """White noise plus a level of each batch: variance 1 + 100 s² of sums over 100 samples."""
    rng = np.random.default_rng(1)
    levels = np.repeat(0.5 * rng.standard_normal((40, 8)), 100, axis=1)
    pieces = [a + b for a, b in zip(white(2, 40, 800), levels, strict=True)]
    assert excess(pieces, [np.ones(800)] * 40) == pytest.approx((1 + 100 * 0.25) / 1.25, rel=0.15)


def test_a_count_that_stays_is_one_reading_not_a_wander() -> None:
    rng = np.random.default_rng(3)
    held = np.repeat(rng.standard_normal((8, 40)), 20, axis=1)  # one error for 20 samples
    roots = np.full(800, 20.0**-0.5)
    assert excess([row * roots for row in held], [roots] * 8) == 1.0


def test_too_few_samples_show_nothing() -> None:
    assert excess([np.ones(50)], [np.ones(50)]) == 1.0
