"""The board's clock by this computer's, in a run: what is believed, and what a person is told."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire.clock import Clock, Pair
from motorid.acquire.clock_check import in_force, measured
from motorid.capture import store
from tests.acquire.rigs import run, sim_rig

HZ = 1e6
STATED = 5e-3 / math.sqrt(3)  # of a ceramic resonator of 0.5 %


def pairs(rate: float, at_s: float, trip_s: float = 1e-3, ticks: int = 0) -> Sequence[Pair]:
    """Five questions from ``at_s`` on to a board whose clock has that rate, and its replies."""
    begins = [at_s + k * 2e-3 for k in range(5)]
    count = [round(HZ * rate * (t + trip_s / 2)) + ticks for t in begins]
    return [Pair(c % (1 << 32), t, t + trip_s) for c, t in zip(count, begins, strict=True)]


@pytest.mark.parametrize("rate", [1.0, 1.01, 0.997])
def test_the_rate_is_that_of_the_ticks_between_both_groups(rate: float) -> None:
    found = measured(pairs(rate, 3.0), pairs(rate, 8.0), HZ, 0.0)
    assert found is not None
    assert found.rate == pytest.approx(rate, abs=1e-6)
    assert found.uncertainty == pytest.approx(1e-4 / math.sqrt(3), rel=0.01)  # the computer's


def test_a_counter_that_wrapped_twice_meanwhile_misleads_nobody() -> None:
    found = measured(pairs(1.002, 0.0), pairs(1.002, 9000.0), HZ, 0.0)  # 4295 s a turn
    assert found is not None
    assert found.rate == pytest.approx(1.002, abs=1e-6)


def test_a_clock_of_coarse_steps_tells_less() -> None:
    found = measured(pairs(1.0, 3.0), pairs(1.0, 8.0), HZ, 0.0156)
    assert found is not None
    assert found.uncertainty > 0.0156 / math.sqrt(6) / 5.1


def test_later_replies_tell_less() -> None:
    quick, slow = (measured(pairs(1.0, 3.0), pairs(1.0, 8.0, s), HZ, 0.0) for s in (1e-3, 11e-3))
    assert quick is not None
    assert slow is not None
    assert slow.uncertainty > quick.uncertainty + 0.01 / 2 / 5.1 / 2  # half of 10 ms over 5 s


@pytest.mark.parametrize("lacking", [0, 1])
def test_a_board_that_answered_at_one_end_alone_tells_nothing(lacking: int) -> None:
    both = [pairs(1.0, 3.0), pairs(1.0, 8.0)]
    both[lacking] = []
    assert measured(both[0], both[1], HZ, 0.0) is None


def shown(rate: float, uncertainty: float) -> Clock:
    """What a run showed."""
    return Clock(rate, uncertainty, 5.0, 10)


def test_a_run_without_such_questions_goes_by_what_is_stated() -> None:
    assert in_force(1.0, STATED, None) == (1.0, STATED, "")


def test_what_knows_less_than_the_board_changes_nothing() -> None:
    assert in_force(1.0, 3e-5, shown(1.0002, 1e-4)) == (1.0, 3e-5, "")


def test_what_knows_more_than_the_board_is_weighed_in() -> None:
    rate, uncertainty, said = in_force(1.0, STATED, shown(1.002, 1e-3))
    share = STATED**2 / (STATED**2 + 1e-3**2)
    assert rate == pytest.approx(1 + 0.002 * share, rel=1e-12)
    assert uncertainty == pytest.approx(1e-3 * math.sqrt(share), rel=1e-12)
    assert said == ""


@pytest.mark.parametrize(("rate", "word"), [(1.01, "fast"), (0.99, "slow")])
def test_what_contradicts_the_board_is_believed_and_said(rate: float, word: str) -> None:
    found = in_force(1.0, 3e-5, shown(rate, 1e-4))
    assert found[:2] == (rate, 1e-4)
    assert f"the board's is 1 % {word} (± 0.02 %)" in found[2]
    assert "states 0.005 % at most" in found[2]


def test_a_board_within_its_own_limit_is_no_contradiction() -> None:
    assert in_force(1.0, STATED, shown(1.0049, 1e-4))[2] == ""
    assert in_force(1.0, STATED, shown(1.0056, 1e-4))[2] != ""


@pytest.mark.parametrize("rate", [0.31, 0.96, 2.0])
def test_a_board_in_another_time_keeps_its_own_and_it_is_said(rate: float) -> None:
    found = in_force(1.0, 3e-5, shown(rate, 1e-4))
    assert found[:2] == (1.0, 3e-5)
    assert f"goes {rate:.3g} times as fast as it states" in found[2]


def test_a_badly_measured_clock_contradicts_nobody() -> None:
    assert in_force(1.0, 3e-5, shown(1.05, 0.02)) == (1.0, 3e-5, "")


@pytest.mark.slow
def test_a_run_finds_its_boards_wrong_clock_by_itself(tmp_path: Path) -> None:
    capture = store.load(run("clock_ppm=10000", tmp_path / "run.h5"))
    nominal = capture.provenance["identity"]["clock_hz"]
    assert capture.clock_hz / nominal == pytest.approx(1.01, abs=4 * capture.clock_uncertainty)
    assert capture.clock_uncertainty < 3e-4
    (note,) = capture.provenance["notes"]
    assert "times are by this computer's" in note


@pytest.mark.slow
def test_a_rig_whose_clock_was_calibrated_contradicts_nobody(tmp_path: Path) -> None:
    from motorid.acquire import record

    rig = sim_rig("clock_ppm=10000")
    rig = replace(rig, clock_rate=1.01, clock_uncertainty=2e-6)
    capture = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    nominal = capture.provenance["identity"]["clock_hz"]
    assert capture.clock_hz == pytest.approx(1.01 * nominal, rel=1e-12)
    assert "notes" not in capture.provenance
