"""Runs of blocks too short to be judged, and whose they become."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.segment import classify
from motorid.segment.blocks import Signal
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


@pytest.mark.parametrize(
    ("sigma", "final", "settled"),
    [
        (0.0, 10.0, 4),  # within a twentieth of the final level
        (0.0, -10.0, 4),
        (2.0, 10.0, 2),  # or within half of its noise
    ],
)
def test_a_drive_is_settled_near_its_final_level(sigma: float, final: float, settled: int) -> None:
    above = final * np.array([2.0, 1.5, 1.1, 1.06, 1.04, *[1.0] * 15])
    drive = Signal(above, sigma, sigma, abs(final))
    assert classify._drive_settled(drive, above, 0, len(above)) == settled
    late = final * np.array([2.0] * 15 + [1.2] + [1.0] * 4)
    assert classify._drive_settled(drive, late, 0, len(late)) == 0  # too late to wait for
