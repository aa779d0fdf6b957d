"""The share of a reading's departure that its interval has, in cases that can be told by hand."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.signals.source.step_transient import (
    DOUBT,
    HEAD,
    MOST_SHARE,
    head_errors,
    shares,
)
from motorid.estimate.signals.time_grid import Part

KNOWN = np.arange(HEAD + 4)


def test_a_window_that_sees_the_whole_interval_has_all_of_it() -> None:
    current = np.linspace(1.0, 2.0, 20)
    assert shares(current, current, KNOWN, Part(0, 20)) == pytest.approx(np.ones(HEAD))


def test_the_first_interval_has_the_share_that_flowed() -> None:
    """A current that rises in a line from nothing: its mean is half of what its end shows."""
    end = np.zeros(20)
    end[0] = 1.0
    end[1:] = 1.0
    mean = end.copy()
    mean[0] = 0.5
    found = shares(end, mean, KNOWN, Part(0, 20))
    assert found[0] == pytest.approx(0.5)
    assert found[1:] == pytest.approx(1.0)


def test_no_share_is_negative_or_beyond_the_most() -> None:
    rng = np.random.default_rng(2)
    found = shares(rng.normal(size=20), rng.normal(size=20), KNOWN, Part(0, 20))
    assert ((found >= 0.0) & (found <= MOST_SHARE)).all()


def test_each_readings_noise_and_one_doubt() -> None:
    share = np.array([0.5, 1.0, 1.0])
    departure = np.array([0.2, 0.1, 0.0])
    *own, doubt = head_errors(np.arange(5), share, departure, 0.01)
    assert doubt == pytest.approx(DOUBT * (share - 1.0) * departure)
    # every reading is known by itself: together their noise is that of each interval's own
    assert np.sqrt(np.sum(np.square(own), axis=0)) == pytest.approx(0.01 * share)
