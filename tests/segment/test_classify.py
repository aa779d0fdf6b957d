"""Runs of blocks too short to be judged, and whose they become."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.segment import classify
from motorid.segment.classify import ACCELERATION, BRAKE, COAST, REST, SHORT, STEADY

A, B, C, R, S = ACCELERATION, BRAKE, COAST, REST, STEADY
LONG = 20


@pytest.mark.parametrize(
    ("before", "short", "after", "becomes"),
    [
        (B, A, B, B),  # a misnamed block amid a brake
        (B, A, S, A),  # between unlike neighbours it may be what it says
        (B, S, A, A),  # the foot of a transient
        (A, C, S, S),
        (B, S, R, B),  # the tail of a stop
        (B, C, R, B),
    ],
)
def test_a_short_run_belongs_to_its_neighbours(
    before: int, short: int, after: int, becomes: int
) -> None:
    names = np.array([R] * LONG + [before] * LONG + [short] + [after] * LONG)
    at = 2 * LONG
    joined, clear = np.ones(len(names) - 1, dtype=bool), np.zeros(len(names), dtype=bool)
    found = classify._absorb_short(names.copy(), joined, clear, clear)
    assert found[at] == becomes
    np.testing.assert_array_equal(np.delete(found, at), np.delete(names, at))


def test_what_stays_however_short() -> None:
    """A jump, a run beside a gap, and a run that is just long enough."""
    names = np.array([R] * LONG + [B] * LONG + [A] + [B] * LONG)
    joined, clear = np.ones(len(names) - 1, dtype=bool), np.zeros(len(names), dtype=bool)
    jump, gap = clear.copy(), joined.copy()
    jump[2 * LONG] = True
    gap[2 * LONG] = False
    for now in ((joined, jump, clear), (gap, clear, clear)):
        np.testing.assert_array_equal(classify._absorb_short(names.copy(), *now), names)
    enough = np.array([R] * LONG + [B] * LONG + [A] * SHORT + [B] * LONG)
    joined, clear = np.ones(len(enough) - 1, dtype=bool), np.zeros(len(enough), dtype=bool)
    np.testing.assert_array_equal(
        classify._absorb_short(enough.copy(), joined, clear, clear), enough
    )
