"""The times of a capture, from its ticks."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture import store
from motorid.capture.model import Capture, Channel
from motorid.errors import DataError


def of(ticks: list[int]) -> Capture:
    values = np.zeros(len(ticks))
    return Capture(np.array(ticks, np.int64), 1e6, {"current": Channel("current", "A", values)})


@pytest.mark.parametrize("ticks", [[], [5]])
def test_fewer_than_two_samples_have_no_period(ticks: list[int]) -> None:
    capture = of(ticks)
    assert capture.time_s.tolist() == [0.0] * len(ticks)
    with pytest.raises(DataError, match="fewer than two samples"):
        _ = capture.period_s


def test_the_period_is_the_usual_one_though_samples_are_missing() -> None:
    capture = of([500, 1500, 2500, 9500, 10_500])
    assert capture.period_s == pytest.approx(1e-3)
    assert capture.time_s == pytest.approx([0.0, 1e-3, 2e-3, 9e-3, 10e-3])


@pytest.mark.parametrize(("ticks", "seconds"), [([], 0.0), ([7], 0.0), ([7, 1007, 4007], 4e-3)])
def test_what_is_cited_of_a_capture_lasts_from_its_first_sample_to_its_last(
    ticks: list[int], seconds: float
) -> None:
    cited = store.describe(of(ticks))
    assert (cited["samples"], cited["duration_s"]) == (len(ticks), pytest.approx(seconds))
