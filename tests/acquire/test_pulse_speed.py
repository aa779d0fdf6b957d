"""The speed at the end of the first pulse, by which a rig's facts are judged."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.acquire import pulse

PERIOD_S = 1e-3


@pytest.mark.parametrize("sign", [1, -1])
def test_it_is_that_of_the_last_quarter_of_the_drive(sign: int) -> None:
    """Rest, a slow start, and 7 counts a sample in the end; what follows is not of the drive."""
    steps = np.concatenate([np.zeros(10), np.full(30, 2), np.full(10, 7), np.full(10, 50)])
    counts = (sign * np.cumsum(steps)).astype(np.int32)
    driven = np.zeros(60, dtype=bool)
    driven[10:50] = True
    assert pulse._speed(counts, driven, PERIOD_S) == pytest.approx(sign * 7 / PERIOD_S)


def test_it_is_unknown_of_too_few_samples_or_without_an_encoder() -> None:
    counts = np.arange(2 * pulse.FEWEST)
    driven = counts < pulse.FEWEST
    assert pulse._speed(counts, driven, PERIOD_S) == pytest.approx(1 / PERIOD_S)
    assert pulse._speed(counts, counts < pulse.FEWEST - 1, PERIOD_S) is None
    assert pulse._speed(None, driven, PERIOD_S) is None
