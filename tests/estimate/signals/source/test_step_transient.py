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


def test_a_share_is_of_what_changed_since_the_command() -> None:
    """The current was .5 A; one that hardly changed by then tells nothing, and has all of it."""
    mean, current = np.zeros(20), np.zeros(20)
    mean[3:5] = 9.0, 0.5
    current[5:13] = 0.5 + np.array([4.0, 2.0, -1.0, 0.09, 0.07, -0.07, 1.0, 1.0])
    mean[5:13] = 0.5 + np.array([3.0, 2.5, -0.5, 0.045, 0.9, 0.9, -1.0, 9.0])
    found = shares(current, mean, KNOWN, Part(5, 20))
    assert found == pytest.approx([0.75, 1.25, 0.5, 0.5, 1.0, 1.0, 0.0, 1.5])


def test_a_first_reading_that_is_missing_is_the_next_ones() -> None:
    current, mean = np.full(20, 2.0), np.full(20, 1.0)
    current[:1], mean[:1] = np.nan, np.nan
    found = shares(current, mean, KNOWN[1:], Part(0, 20))
    assert found == pytest.approx([0.0] + [0.5] * 7)
