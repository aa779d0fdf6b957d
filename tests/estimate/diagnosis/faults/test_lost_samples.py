"""Jumps of a position, and runs that are shorter than their program, on records made by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import POSITION, Capture, Channel, Gap, Phase
from motorid.estimate.diagnosis.faults import lost_samples as module
from motorid.program import Decay, Program, Step, StepKind

COUNT, RESOLUTION, PER_SAMPLE = 400, 0.01, 40  # counts a sample
PERIOD_TICKS, CLOCK_HZ = 100, 1e5


def capture(counts: NDArray[Any], **more: Any) -> Capture:
    ticks = PERIOD_TICKS * np.arange(len(counts))
    position = Channel(POSITION, "rad", counts, scale=RESOLUTION, resolution=RESOLUTION)
    return Capture(ticks, CLOCK_HZ, {POSITION: position}, **more)


def timeline(index: NDArray[Any] | None = None) -> Any:
    return SimpleNamespace(index=np.arange(COUNT) if index is None else index)


def turned(jumps: dict[int, float], per_sample: float = PER_SAMPLE) -> NDArray[Any]:
    """Counts at each sample; before sample k the rotor moves so much more than usual."""
    steps = np.full(COUNT, float(per_sample))
    steps[0] = 0.0
    for k, more in jumps.items():
        steps[k] += more
    return np.cumsum(steps)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("missing", [1, 3])
def test_whole_steps_at_once_are_samples_that_are_missing(missing: int, side: float) -> None:
    more = {100: missing * side * PER_SAMPLE, 250: missing * side * PER_SAMPLE}
    found = module.find(capture(turned(more, side * PER_SAMPLE)), timeline())
    assert found is not None
    assert found.places.tolist() == [100, 250]
    assert found.counts == pytest.approx([missing * PER_SAMPLE] * 2)
    assert found.missing.tolist() == [missing, missing]
    assert found.nearly == pytest.approx([missing, missing])
    assert (found.dropped, found.lost) == (2 * missing, 0.0)
    (said,) = module.suspects(capture(turned(more, side * PER_SAMPLE)), timeline())
    assert (said.code, said.where) == ("samples_dropped", "time")
    assert "by whole steps 2 times" in said.evidence


def test_counts_that_fall_short_are_lost() -> None:
    short = turned({100: -7.0, 250: -5.0})
    found = module.find(capture(short), timeline())
    assert found is not None
    assert found.counts == pytest.approx([-7.0, -5.0])
    assert (found.dropped, found.lost) == (0, 12.0)
    (said,) = module.suspects(capture(short), timeline())
    assert (said.code, said.where) == ("encoder_loses_counts", "position")
    assert "short by 12 counts in 2 jumps, first at 0.1 s" in said.evidence


@pytest.mark.parametrize(
    ("more", "whole"), [(0.85, True), (0.75, False), (1.25, False), (1.15, True)]
)
def test_a_jump_that_is_no_whole_step_is_no_sample(more: float, whole: bool) -> None:
    found = module.find(capture(turned({100: more * PER_SAMPLE})), timeline())
    assert found is not None
    assert found.missing.tolist() == [float(whole)]
    assert found.nearly == pytest.approx([more])


@pytest.mark.parametrize(("more", "seen"), [(3.4, False), (3.6, True)])
def test_few_counts_are_rounding(more: float, seen: bool) -> None:
    found = module.find(capture(turned({100: more})), timeline())
    assert found is not None
    assert (len(found.places) == 1) is seen


def test_a_gap_that_is_known_is_no_jump() -> None:
    index = np.arange(COUNT)
    index[100:] += 1
    found = module.find(capture(turned({100: PER_SAMPLE})), timeline(index))
    assert found is not None
    assert not len(found.places)


def test_jumps_stand_out_of_what_steps_scatter_by() -> None:
    rng = np.random.default_rng(2)
    counts = np.rint(turned({100: PER_SAMPLE}) + 6.0 * rng.standard_normal(COUNT))
    found = module.find(capture(counts), timeline())
    assert found is not None
    assert not len(found.places)


def test_a_motor_that_is_up_to_speed_within_a_few_samples_loses_no_counts() -> None:
    """One of the packaged rigs at 1 kHz: its mechanical time constant is 7 samples."""
    rise = [1, 10, 21, 34, 47, 58, 69, 79, 86, 94, 98, 104, 107, 111, 113]
    steps = np.r_[np.zeros(COUNT // 2), rise, np.full(COUNT // 2 - len(rise), 115)]
    found = module.find(capture(np.cumsum(steps)), timeline())
    assert found is not None
    assert not len(found.places)


@pytest.mark.parametrize("k", [1, 2, COUNT - 1])
def test_ends_have_no_neighbours_to_judge_by(k: int) -> None:
    found = module.find(capture(turned({k: PER_SAMPLE})), timeline())
    assert found is not None
    assert not len(found.places)


@pytest.mark.parametrize(("k", "seen"), [(5, 0), (6, 1), (COUNT - 6, 1), (COUNT - 5, 0)])
def test_five_increments_on_either_side_show_what_is_usual(k: int, seen: int) -> None:
    found = module.find(capture(turned({k: PER_SAMPLE})), timeline())
    assert found is not None
    assert len(found.places) == seen


def test_without_steps_of_a_position_nothing_is_told() -> None:
    smooth = capture(turned({100: PER_SAMPLE}))
    channel = replace(smooth.channels[POSITION], resolution=0.0)
    assert module.find(replace(smooth, channels={POSITION: channel}), timeline()) is None
    assert module.find(replace(smooth, channels={}), timeline()) is None
    assert module.suspects(replace(smooth, channels={}), timeline()) == []


def test_the_usual_increment_is_a_mean_of_those_that_are_alike() -> None:
    assert module._usual(np.array([40.0, 41.0, 42.0, 400.0, 40.0])) == pytest.approx(40.75)
    assert module._usual(np.array([100.0, 129.0, 131.0, 100.0, 100.0])) == pytest.approx(107.25)
    assert module._usual(np.array([1.0, 4.0, 1.0, 1.0, -3.0])) == pytest.approx(1.75)
    assert module._usual(np.array([0.0, 0.0, 200.0, 200.0])) == 100.0  # none is like the median


def programmed(present: int, **more: Any) -> Capture:
    """A run of 300 sample periods by its program, its first phase two periods after it began."""
    steps = (
        Step(StepKind.DRIVE_VOLTS, 0.2, 6.0, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.COAST, 0.1),
    )
    phases = (Phase(0, 2 * PERIOD_TICKS), Phase(1, 202 * PERIOD_TICKS))
    known: dict[str, Any] = {"program": Program(steps), "phases": phases, **more}
    return capture(PER_SAMPLE * np.arange(float(present)), **known)


@pytest.mark.parametrize(("present", "short"), [(302, 0), (310, 0), (301, 1), (250, 52)])
def test_a_run_that_is_shorter_than_its_program_says_by_how_much(present: int, short: int) -> None:
    assert module.short_of_program(programmed(present)) == short
    gaps = (Gap(3, 1, "lost"), Gap(9, 4, "lost"))
    assert module.short_of_program(programmed(present, gaps=gaps)) == max(short - 5, 0)


def test_a_run_that_was_stopped_or_has_no_program_is_not_short() -> None:
    assert module.short_of_program(programmed(250, end_reason="stopped")) == 0
    assert module.short_of_program(programmed(250, program=None)) == 0
    assert module.short_of_program(programmed(250, phases=())) == 0
    assert module.short_of_program(programmed(250, phases=(Phase(1, 0),))) == 0


def test_a_short_run_is_said_with_the_jumps_that_show_it() -> None:
    whole = programmed(301)
    index: Any = SimpleNamespace(index=np.arange(301))
    (said,) = module.suspects(whole, index)
    assert said.evidence.startswith("the run is 1 samples shorter than its program")
    counts = turned({100: PER_SAMPLE})[:301]
    position = replace(whole.channels[POSITION], raw=counts)
    (said,) = module.suspects(replace(whole, channels={POSITION: position}), index)
    assert "; 1 of them show as jumps of the position" in said.evidence


def test_steps_last_whole_periods_of_the_board() -> None:
    """1.2 and 2.4 periods of 100 ticks; a board that streams no faster than 250 makes them one."""
    steps = (
        Step(StepKind.DRIVE_VOLTS, 1.2e-3, 6.0, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.COAST, 2.4e-3),
    )
    run = programmed(302, program=Program(steps))
    assert module._planned_ticks(run, PERIOD_TICKS) == 100 + 200
    slow = {"identity": {"min_sample_period_ticks": 250}}
    assert module._planned_ticks(replace(run, provenance=slow), PERIOD_TICKS) == 250 + 250
    known = {"identity": {"clock_hz": 2e5}, "configuration": {"sample_period_ticks": 80}}
    assert module._planned_ticks(replace(run, provenance=known), PERIOD_TICKS) == 240 + 480
