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


@pytest.mark.parametrize(("length", "worth"), [(127, 1.0), (128, 16.0)])
def test_stretches_of_some_length_alone_show_a_wander(length: int, worth: float) -> None:
    """All readings off by as much: an eighth of them count as one."""
    assert excess([np.ones(length)], [np.ones(length)]) == pytest.approx(worth)
    assert excess([np.ones(127), np.ones(128)], [np.ones(127), np.ones(128)]) == pytest.approx(16.0)


def test_a_wander_stands_out_of_the_scatter_of_its_batches() -> None:
    """Three deviations of eight squares: 1 + 3 √(2/8). Batches of 16, whose sums are given."""
    level = np.repeat(np.array([1.0, -1.0] * 4), 16)
    noise = np.tile([1.0, -1.0], 64)
    for share, stands in ((0.15, False), (0.16, True)):  # of the variance, in the level
        mixed = np.sqrt(share) * level + np.sqrt(1.0 - share) * noise
        found = excess([mixed], [np.ones(128)])
        assert (found > 1.0) is stands
        assert found == (pytest.approx(16.0 * share) if stands else 1.0)


def test_nothing_left_is_worth_all() -> None:
    assert excess([np.zeros(200)], [np.ones(200)]) == 1.0
    assert excess([], []) == 1.0


def test_readings_without_weight_say_nothing() -> None:
    """Of a stretch of which only a half counts: batches of that half."""
    roots = np.where(np.arange(256) < 128, 1.0, 0.0)
    half = excess([roots], [roots])
    assert half == pytest.approx((4 * 32.0 / 8.0) / 1.0)
