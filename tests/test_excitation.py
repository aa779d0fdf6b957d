"""Signals of many steps: a PRBS of maximal length, a multisine that stays within its peak."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.errors import UsageError
from motorid.excitation import TAPS, Levels, chips, multisine, prbs, slow_turn
from motorid.program import Decay, StepKind

LEVELS = Levels(StepKind.DRIVE_DUTY, 0.1, 0.3)


@pytest.mark.parametrize("bits", TAPS)
def test_a_prbs_is_of_maximal_length(bits: int) -> None:
    """Its circular autocorrelation is that of no shorter sequence (Golomb's third postulate)."""
    sequence = np.array(chips(bits))
    assert len(sequence) == 2**bits - 1
    assert sequence.sum() == 1
    others = [int(sequence @ np.roll(sequence, lag)) for lag in range(1, len(sequence))]
    assert set(others) == {-1}


@pytest.mark.parametrize("bits", TAPS)
def test_it_takes_a_step_for_each_run_of_chips(bits: int) -> None:
    steps = prbs(LEVELS, bits, 0.05)
    assert len(steps) == 2 ** (bits - 1)
    assert sum(step.duration_s for step in steps) == pytest.approx(0.05)
    assert {round(step.level, 12) for step in steps} == {0.4, -0.2}
    assert {step.decay for step in steps} == {Decay.SYNCHRONOUS_SLOW}


def test_a_multisine_has_its_tones_and_no_others() -> None:
    steps = multisine(LEVELS, tones=5, points=64, duration_s=0.05)
    levels = np.array([step.level for step in steps])
    assert len(levels) == 64
    assert np.abs(levels - 0.1).max() <= 0.3
    assert np.abs(levels - 0.1).max() > 0.25
    lines = np.abs(np.fft.rfft(levels - 0.1))
    assert np.flatnonzero(lines > 1e-9).tolist() == [1, 2, 4, 8, 16]
    np.testing.assert_allclose(lines[[1, 2, 4, 8, 16]], lines[1], rtol=1e-9)


def test_more_tones_than_points_show_are_refused() -> None:
    with pytest.raises(UsageError, match="5 tones need 20 points or more, not 16"):
        multisine(LEVELS, tones=5, points=16, duration_s=0.05)


def test_a_slow_turn_goes_both_ways() -> None:
    kinds = [
        (step.kind, step.level) for step in slow_turn(Levels(StepKind.DRIVE_VOLTS, 0, 1.5), 2.0)
    ]
    drive, brake = StepKind.DRIVE_VOLTS, (StepKind.BRAKE, 0.0)
    assert kinds == [(drive, 1.5), brake, (drive, -1.5), brake]
