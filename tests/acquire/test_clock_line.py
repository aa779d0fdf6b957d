"""A line through ticks and times: its slope, its uncertainty, and what stands against it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motorid.acquire.clock import Clock, Pair, clock_of, with_stated
from motorid.acquire.clock_check import in_force, measured, of_identity
from motorid.errors import DataError

HZ = 1000.0


def exact(times: list[float], rate: float = 1.0, trip_s: float = 0.0) -> list[Pair]:
    """Questions about these moments, of a clock of that rate; each trip takes so long."""
    return [Pair(round(HZ * rate * t), t - trip_s / 2, t + trip_s / 2) for t in times]


TEN = [float(t) for t in range(10)]


def test_a_clock_needs_ten_pairs() -> None:
    found = clock_of(exact(TEN, 1.25), HZ, 0.0)
    assert (found.rate, found.pairs, found.span_s) == (pytest.approx(1.25), 10, pytest.approx(9.0))
    assert found.uncertainty == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(DataError, match="needs 10 pairs"):
        clock_of(exact(TEN[:9]), HZ, 0.0)


def test_the_computer_s_own_clock_counts() -> None:
    assert clock_of(exact(TEN), HZ, 3e-4).uncertainty == pytest.approx(3e-4)


@pytest.mark.parametrize("pairs", [exact([5.0] * 10), [Pair(7, t, t) for t in TEN]])
def test_a_clock_that_stands_is_none(pairs: list[Pair]) -> None:
    with pytest.raises(DataError, match="do not increase"):
        clock_of(pairs, HZ, 0.0)


def test_the_quicker_half_of_the_trips_is_used() -> None:
    slow = [Pair(0, t, t + 9.0) for t in np.arange(10) + 0.5]  # whose ticks are nonsense
    found = clock_of([*exact(TEN, 1.0, 0.01), *slow], HZ, 0.0)
    assert found.pairs == 10
    assert found.rate == pytest.approx(1.0)
    # of eleven quick ones and nine slow ones ten and all that are as quick
    found = clock_of([*exact([*TEN, 10.0], 1.0, 0.01), *slow[:9]], HZ, 0.0)
    assert found.pairs == 11


def test_uneven_trips_bound_the_slope() -> None:
    pairs = exact(TEN)
    pairs[3] = Pair(3000, 2.85, 3.15)  # longer by .3 s than the shortest, about the same middle
    uneven = 0.3 / 2 * math.sqrt(2 / 3) / 9.0
    assert clock_of(pairs, HZ, 0.0).uncertainty == pytest.approx(uneven)


def test_the_scatter_of_ticks_about_the_line_counts() -> None:
    off = 1e-3 * np.array([20, -30, 10, 0, 40, -10, -20, 30, -50, 10])
    pairs = [Pair(round(HZ * (t + d)), t, t) for t, d in zip(TEN, off, strict=True)]
    slope, covariance = np.polyfit(TEN, TEN + off, 1, cov=True)
    found = clock_of(pairs, HZ, 0.0)
    assert found.rate == pytest.approx(slope[0])
    assert found.uncertainty == pytest.approx(math.sqrt(covariance[0, 0]))


@pytest.mark.parametrize("wraps", [0, 1, 2])
def test_a_counter_s_wraps_are_told_by_the_time(wraps: int) -> None:
    ticks = [(2**32 - 5000 + 1000 * n + (wraps * 2**32 if n > 6 else 0)) for n in range(10)]
    times = [(tick - ticks[0]) / HZ for tick in ticks]
    pairs = [Pair(tick % 2**32, t, t) for tick, t in zip(ticks, times, strict=True)]
    assert clock_of(pairs, HZ, 0.0).rate == pytest.approx(1.0)


def test_two_statements_are_weighed_by_their_uncertainty() -> None:
    found = with_stated(Clock(1.02, 0.01, 5.0, 10), 0.02, 0.97)
    assert found.rate == pytest.approx((1.02 * 4 + 0.97) / 5)
    assert found.uncertainty == pytest.approx(0.01 * math.sqrt(0.8))
    assert (found.span_s, found.pairs) == (5.0, 10)
    alone = with_stated(Clock(1.02, 0.01, 5.0, 10), 0.0)
    assert (alone.rate, alone.uncertainty) == (pytest.approx(1.02), pytest.approx(0.01))
    assert with_stated(Clock(1.02, 0.01, 5.0, 10), 0.01).rate == pytest.approx(1.01)


def test_the_last_questions_before_a_run_and_the_first_after_it_count() -> None:
    wrong = [Pair(0, -9.0, -9.0)]
    before, after = exact([0.0, 1.0, 2.0, 3.0, 4.0]), exact([95.0, 96.0, 97.0, 98.0, 99.0])
    late = [Pair(5, 200.0, 200.0)]
    found = measured([*wrong, *before], [*after, *late], HZ, 0.5)
    assert found is not None
    assert (found.rate, found.span_s, found.pairs) == (pytest.approx(1.0), 99.0, 10)
    host = 1e-4 / math.sqrt(3)
    assert found.uncertainty == pytest.approx(math.hypot(host, 0.5 / math.sqrt(6) / 99.0))


@pytest.mark.parametrize(
    ("seen", "rate", "remark"),
    [
        (1.0299, 1.0299, "fast"),
        (0.9701, 0.9701, "slow"),
        (1.0301, 1.0, "times as fast as it states"),
        (0.9699, 1.0, "times as fast as it states"),
    ],
)
def test_beyond_three_in_a_hundred_it_is_another_crystal(
    seen: float, rate: float, remark: str
) -> None:
    found, _, said = in_force(1.0, 1e-5, Clock(seen, 1e-5, 5.0, 10))
    assert found == rate
    assert remark in said


@pytest.mark.parametrize(
    ("seen", "contradicts"), [(1.0056, False), (1.0058, True), (0.9944, False), (0.9942, True)]
)
def test_what_is_stated_is_contradicted_beyond_its_limit_and_four_deviations(
    seen: float, contradicts: bool
) -> None:
    stated = 1e-3  # a limit of 1.732e-3, and four times 1e-3
    found = in_force(1.0, stated, Clock(seen, 1e-3, 5.0, 10))
    assert bool(found[2]) is contradicts
    assert found[:2] == ((seen, 1e-3) if contradicts else (1.0, stated))


def test_a_clock_as_uncertain_as_the_statement_adds_nothing() -> None:
    assert in_force(1.0, 1e-3, Clock(1.001, 1e-3, 5.0, 10)) == (1.0, 1e-3, "")
    rate, _, said = in_force(1.0, 1e-3, Clock(1.001, 0.99e-3, 5.0, 10))
    assert rate == pytest.approx(1.0005, abs=1e-5)
    assert said == ""


def test_the_board_s_clock_in_ticks_a_second() -> None:
    identity = {"clock_hz": 16e6, "clock_uncertainty_ppm": 50}
    hz, known, said = of_identity(identity)
    assert (hz, known, said) == (16e6, pytest.approx(50e-6 / math.sqrt(3)), "")
    assert of_identity(identity, 1.001, 1e-6)[:2] == (pytest.approx(16.016e6), 1e-6)
    seen = Clock(1.01, 1e-5, 5.0, 10)
    assert of_identity(identity, found=seen)[:2] == (pytest.approx(16.16e6), 1e-5)
