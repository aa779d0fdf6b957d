"""A rough search: near the truth from a start beside it, and what is held stays held."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.fit.rough_fit import departures
from tests.exact_capture import FAULHABER, Plan, clean_capture


def share(start: dict[str, float], fix: dict[str, float]) -> np.ndarray:
    """What is left of each channel, in shares of its own range."""
    capture = clean_capture(FAULHABER, Plan())
    left = departures([capture], start, fix, ())
    ranges = [float(np.ptp(c.values)) for c in capture.channels.values() if c.name != "voltage"]
    return np.array([float(np.abs(a).max()) for a in left]) / np.array(ranges)


def test_from_beside_the_truth_it_finds_the_truth() -> None:
    start = {name: 1.1 * value for name, value in FAULHABER.items()}
    assert share(start, {}).max() < 1e-3


def test_values_that_are_not_known_are_found() -> None:
    start = {name: value for name, value in FAULHABER.items() if name in ("R", "K", "J")}
    assert share(start, {}).max() < 1e-3


@pytest.mark.parametrize("name", ["K", "J"])
def test_what_is_held_wrong_leaves_more(name: str) -> None:
    wrong = {name: 1.1 * FAULHABER[name]}
    assert share({**FAULHABER, **wrong}, wrong).max() > 1e-2
