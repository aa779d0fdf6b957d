"""Runs of blocks too short to be judged, and whose they become."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.segment import classify
from motorid.segment.blocks import Blocks, Signal
from motorid.segment.classify import ACCELERATION, BRAKE, COAST, REST, SHORT, STEADY, Course

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


def single_samples(speed: np.ndarray, still: float = 0.0, sigma: float = 0.0) -> Blocks:
    """A block a sample, a millisecond each, without a drive."""
    start = np.arange(len(speed))
    return Blocks(
        start=start,
        stop=start + 1,
        time_s=start * 1e-3,
        joined=np.ones(len(speed) - 1, dtype=bool),
        speed=Signal(speed, sigma, sigma, float(np.max(np.abs(speed)))),
        still=still,
        drive=None,
        drive_zero=None,
        speed_samples=speed,
        drive_samples=None,
    )


@pytest.mark.parametrize(
    ("slope", "length_s", "transient"),
    [
        (2.0, 5.0, False),  # a drift: a fiftieth of the steepest slope, a tenth of the speed
        (8.0, 1.25, True),  # as much of the speed, less gently
        (2.0, 20.0, True),  # as gently, for a large part of the speed
        (8.0, 0.25, False),  # too little of the speed
    ],
)
def test_a_gentle_run_is_wander_beside_a_steep_one(
    slope: float, length_s: float, transient: bool
) -> None:
    going = Course(np.array([100.0, 0.0, slope]), np.full(3, 1e-3), np.array([1.0, 1.0, length_s]))
    blocks = single_samples(np.array([0.0, 100.0]))
    found = classify._transient(blocks, going, np.zeros(3, dtype=bool))
    assert found.tolist() == [True, False, transient]


@pytest.mark.parametrize(("level", "kind"), [(0.5, R), (-0.5, R), (0.6, S), (0.0, R)])
def test_what_settles_at_no_more_than_the_speed_of_rest_rests(level: float, kind: int) -> None:
    speed = np.concatenate((np.linspace(10.0, level, 10), np.full(30, level)))
    names = np.array([B] * 10 + [S] * 30)
    found = classify._settle(
        single_samples(speed, still=0.5), names, [speed], 0.0, np.zeros(40, dtype=bool)
    )
    assert found[-1] == kind


@pytest.mark.parametrize(
    ("other", "commonest"),
    [(3.0, 1.2), (4.5, 50.0)],  # one level within four standard deviations of a block, else two
)
def test_the_commonest_level_lasts_longest(other: float, commonest: float) -> None:
    levels, weights = np.array([0.0, other, 50.0]), np.array([6, 4, 7])
    assert classify._commonest(levels, weights, 1.0) == pytest.approx(commonest)


@pytest.mark.parametrize(
    ("gap", "ends_slowing"),
    [(None, True), ("before", False), ("within", False), ("after", False)],
)
def test_a_creep_between_slowing_down_and_rest_ends_it_unless_a_gap_is_there(
    gap: str | None, ends_slowing: bool
) -> None:
    names = np.array([B] * 10 + [S] * 10 + [R] * 10)
    joined = np.ones(len(names) - 1, dtype=bool)
    if gap:
        joined[{"before": 9, "within": 14, "after": 19}[gap]] = False
    found = classify._stop_without_pause(names.copy(), joined)
    becomes = [B] * 20 + [R] * 10 if ends_slowing else names.tolist()
    assert found.tolist() == becomes


def test_a_line_through_zero_is_a_brake_and_then_an_acceleration() -> None:
    speed = np.repeat([-10.0, 10.0], 30)
    speed = np.concatenate((speed[:30], np.linspace(-10.0, 10.0, 20), speed[30:]))
    blocks = single_samples(speed, sigma=0.01)
    found = classify.name_blocks(blocks, classify.fit_pieces(blocks))
    assert found[31:39].tolist() == [B] * 8
    assert found[41:48].tolist() == [A] * 7
