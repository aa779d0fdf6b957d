"""Speeds at the start of a step that no motor has are left out, and said."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel
from motorid.estimate.partial import mechanical_fit, step_response
from motorid.estimate.partial.levels.stray_readings import at_start

TAU_S, TOP, ONSET_S = 0.08, 100.0, 0.31
TIME = np.arange(0.0, 1.6, 0.02)
FIRST = int(np.searchsorted(TIME, ONSET_S))


def risen(*first: float) -> np.ndarray:
    speed = TOP * (1.0 - np.exp(-np.maximum(TIME - ONSET_S, 0.0) / TAU_S))
    speed += 0.3 * np.random.default_rng(6).standard_normal(len(TIME))
    speed[FIRST : FIRST + len(first)] = first
    return speed


@pytest.mark.parametrize(
    ("first", "count"),
    [
        ((), 0),
        ((145.0,), 1),  # a count from before
        ((145.0, 150.0), 2),
        ((145.0, 100.0), 2),  # it fell back from both
        ((-35.0, -40.0, 0.0), 2),  # backward first; a rest is none
        ((5.0, 10.0, 15.0, 20.0), 0),  # slow, but it rises
    ],
)
def test_what_falls_back_or_runs_backward_is_stray(first: tuple[float, ...], count: int) -> None:
    for way in (1.0, -1.0):
        found = at_start(TIME, way * risen(*first), ONSET_S, 0.0)
        assert np.flatnonzero(found).tolist() == list(range(FIRST, FIRST + count))


def test_few_readings_show_no_strays() -> None:
    assert not at_start(TIME[: FIRST + 10], risen(145.0)[: FIRST + 10], ONSET_S, 0.0).any()


def log(speed: np.ndarray, drive: np.ndarray) -> Capture:
    channels = {
        "command": Channel("command", "1", drive),
        "speed": Channel("speed", "rad/s", speed),
    }
    return Capture(np.rint(TIME * 1e9).astype(np.int64), 1e9, channels)


ON = np.where(np.arange(len(TIME)) >= FIRST, 255.0, 0.0)


def test_a_step_is_fitted_without_its_strays() -> None:
    """They were the rise: a time constant of a thirtieth of a sample, ± 8 %."""
    found = mechanical_fit.fit([log(risen(145.0, 150.0), ON)])
    low, high = found.combinations["JR/(K²+RB)"].interval_95
    assert low < TAU_S < high
    assert "145, 150 rad/s" in {d.code: d.message for d in found.diagnostics}["stray_readings"]


def test_rows_after_the_drive_went_off_are_not_the_step() -> None:
    off = ON.copy()
    off[-2:] = 0.0
    steps = step_response.steps([log(risen(), off)])
    assert steps is not None
    assert (steps[0].after, len(steps[0].record.time_s)) == (2, len(TIME) - 2)
    codes = {d.code for d in mechanical_fit.fit([log(risen(), off)]).diagnostics}
    assert "after_the_step" in codes


def test_a_rise_between_two_readings_shows_no_time_constant() -> None:
    sudden = np.where(ON > 0.0, TOP, 0.0) + 0.3 * np.random.default_rng(8).standard_normal(len(ON))
    found = mechanical_fit.fit([log(sudden, ON)])
    assert found.combinations["JR/(K²+RB)"].value is None
    assert "below 20 ms" in {d.code: d.message for d in found.diagnostics}["few_samples"]
