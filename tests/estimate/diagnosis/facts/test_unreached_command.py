"""A supply that gives less than the command, where no voltage was measured."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from motorid.capture.model import VOLTAGE, Capture
from motorid.estimate.diagnosis.facts.unreached_command import findings
from motorid.program import Decay, Program, Step, StepKind
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy


@cache
def given(*volts: float) -> Capture:
    """What a motor does at these volts, with some noise."""
    return noisy(clean_capture(FAULHABER, Plan(volts, 2400)), 1, 2e-3, 1e-3)


def said(capture: Capture) -> list[tuple[str, str]]:
    """Code and message of all findings."""
    return [(one.code, one.message) for one in findings(capture)]


def commanding(capture: Capture, *levels: float) -> Capture:
    """Without its voltage, under a program that commanded these levels."""
    assert capture.program is not None
    volts = iter(levels)
    steps = [replace(s, level=next(volts)) if s.level else s for s in capture.program.steps]
    kept = {n: c for n, c in capture.channels.items() if n != VOLTAGE}
    return replace(capture, program=Program(tuple(steps)), channels=kept)


@pytest.mark.slow
def test_a_level_that_the_motor_does_not_get_is_named_with_its_time_and_share() -> None:
    real = given(6.0, -6.0, 3.0, 4.5, -3.0, 5.0)
    ((code, words),) = said(commanding(real, 6.0, -6.0, 3.0, 6.0, -3.0, 5.0))
    assert code == "supply_limited"
    assert "25% less" in words
    begins = real.phases[4].tick / real.clock_hz
    assert begins <= float(words.split()[1]) <= begins + 4e-3


@pytest.mark.slow
@pytest.mark.parametrize("real", [5.9, 6.0])
def test_a_supply_that_gives_the_command_is_not_accused(real: float) -> None:
    """A hundredth less is what switches and dead time take."""
    ((code, words),) = said(commanding(given(6.0, -6.0, real, 3.0), 6.0, -6.0, 6.0, 3.0))
    assert code == "volts_commanded"
    assert "no smaller sag" in words


@pytest.mark.slow
def test_a_voltage_that_was_measured_speaks_for_itself() -> None:
    assert not said(given(6.0, -6.0, 4.5, 3.0))


def test_duties_of_a_supply_that_nobody_measured_are_no_volts() -> None:
    capture = commanding(given(6.0, -6.0, 4.5, 3.0), 6.0, -6.0, 6.0, 3.0)
    assert capture.program is not None
    steps = tuple(
        Step(StepKind.DRIVE_DUTY, s.duration_s, s.level / 8.0, Decay.SYNCHRONOUS_SLOW)
        if s.level
        else s
        for s in capture.program.steps
    )
    assert not said(replace(capture, program=Program(steps)))
