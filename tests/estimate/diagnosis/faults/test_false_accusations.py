"""Good captures that look a little like a fault, and must not be accused of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture, Gap, Phase
from motorid.estimate.diagnosis.data_remarks import of_capture
from motorid.estimate.diagnosis.faults.current_limited_supply import suspects as limits
from motorid.estimate.diagnosis.faults.lost_samples import short_of_program
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.program import Decay, Program, Step, StepKind, whole_ticks
from tests.exact_capture import FAULHABER, Plan, clean_capture

CLOCK_HZ, PERIOD = 16_000_000, 16_000


def run_of(durations: tuple[float, ...], missing: int = 0) -> Capture:
    """A run of steps whose lengths are no whole samples, as a board rounds and samples it."""
    steps = tuple(Step(StepKind.DRIVE_VOLTS, s, 3.0, Decay.SYNCHRONOUS_SLOW) for s in durations)
    whole = [whole_ticks(s, CLOCK_HZ, PERIOD) for s in durations]
    samples = sum(whole) // PERIOD - missing
    starts = np.concatenate([[0], np.cumsum(whole)])
    return Capture(
        ticks=PERIOD * np.arange(samples, dtype=np.int64),
        clock_hz=CLOCK_HZ * 1.0001,  # calibrated: the board counts by its nominal clock
        channels={},
        program=Program(steps),
        phases=tuple(Phase(k, int(t)) for k, t in enumerate(starts[:-1])),
        provenance={
            "identity": {"clock_hz": CLOCK_HZ, "min_sample_period_ticks": PERIOD},
            "configuration": {"sample_period_ticks": PERIOD},
        },
    )


@pytest.mark.parametrize("each", [0.10045, 0.1003, 0.10051, 0.0004])
def test_steps_of_no_whole_samples_are_not_short(each: float) -> None:
    assert short_of_program(run_of((each,) * 9)) == 0


def test_a_sample_that_is_missing_is_counted() -> None:
    assert short_of_program(run_of((0.10045,) * 9, missing=3)) == 3


def with_supply_of(ohms: float) -> Capture:
    """A run whose terminal voltage sags by so many ohms times the current."""
    capture = clean_capture(FAULHABER, Plan(volts=(6.0, 3.0)))
    volts = capture.channels["terminal_voltage"]
    current = capture.channels[CURRENT].values
    sagging = replace(volts, raw=volts.values - ohms * np.abs(current) * np.sign(volts.values))
    return replace(capture, channels={**capture.channels, volts.name: sagging})


def test_a_supply_with_a_resistance_is_not_called_limited() -> None:
    assert limits(MotorRecord(with_supply_of(2.0), PARAMETERS, {})) == []


def log_of(steps: list[int]) -> MotorRecord:
    """A log with these steps between its stamps (µs), and what an import calls its gaps."""
    base = clean_capture(FAULHABER, Plan(count=800))
    keep = np.concatenate([[0], np.cumsum(np.array(steps) // 100)])
    channels = {n: replace(c, raw=np.asarray(c.raw)[keep]) for n, c in base.channels.items()}
    gaps = tuple(Gap(k + 1, s // 100 - 1, "pause") for k, s in enumerate(steps) if s > 250)
    ticks = base.ticks[keep]
    log = replace(base, ticks=ticks, channels=channels, gaps=gaps, program=None, phases=())
    return MotorRecord(log, PARAMETERS, {})


def lost(steps: list[int]) -> list[str]:
    return [d.message for d in of_capture(log_of(steps), "") if d.code == "lost_samples"]


def test_a_logger_that_slows_down_has_lost_nothing() -> None:
    assert lost([100] * 400 + [500] * 60) == []


def test_a_log_without_a_pause_has_none() -> None:
    assert lost([100] * 400) == []


def test_a_pause_in_a_log_is_a_loss() -> None:
    (said,) = lost([100] * 400 + [500] + [100] * 200)
    assert said.startswith("4 of ")
