"""A record of the review as a capture, so that the default estimator can stand in its tables."""

from __future__ import annotations

import time
from itertools import pairwise

import numpy as np

from motorid.capture.model import (
    CURRENT,
    QUANTITIES,
    SPEED,
    VOLTAGE,
    Capture,
    Channel,
    Phase,
    Wiring,
)
from motorid.estimate.assembly.assemble import fit
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.results.estimate import Floats
from motorid.motor.batch import FRICTION, Model, Record
from motorid.program import Decay, Program, Step, StepKind
from motorid.search.problem import Solution

REST = 16  # samples of standstill before the record: every method of a table knows that it rests
AT_ONCE_V = 1e6  # of a supply so high that the batch's open bridge ends the current at once
KNOWN = 1e-9  # of a current's peak: its offset is known to be nothing, as the other methods take it


def capture_of(record: Record) -> Capture:
    """Current and speed as instants, the held input as what the supply gave over each sample.

    A batch input is held from sample n to n + 1; a capture's voltage at n is the mean before n.
    """
    period = record.period_s
    current, speed = (_after_rest(record.measured[name]) for name in ("current", "speed"))
    held = np.concatenate([np.zeros(REST + 1), record.input[:-1]])
    exact = KNOWN * float(np.abs(current).max())
    channels = {
        VOLTAGE: Channel(
            VOLTAGE, QUANTITIES[VOLTAGE], held, kind="mean", aperture_s=period, sense="supply"
        ),
        CURRENT: Channel(CURRENT, QUANTITIES[CURRENT], current, offset_uncertainty=exact),
        SPEED: Channel(SPEED, QUANTITIES[SPEED], speed),
    }
    steps, phases = _program(record)
    capture = Capture(
        ticks=np.arange(len(held), dtype=np.int64),
        clock_hz=1.0 / period,
        channels=channels,
        wiring=Wiring(supply_voltage_v=AT_ONCE_V),
        program=Program(steps),
        phases=phases,
    )
    return lossless(capture)  # as the review's motors are


def _after_rest(y: Floats) -> Floats:
    return np.concatenate([np.zeros(REST), y])


def _program(record: Record) -> tuple[tuple[Step, ...], tuple[Phase, ...]]:
    """Rest, then one step for each stretch of constant input."""
    volts = record.input
    is_open = np.zeros(len(volts), dtype=bool) if record.open is None else record.open
    changes = np.flatnonzero((np.diff(volts) != 0.0) | np.diff(is_open)) + 1
    steps, phases = [Step(StepKind.COAST, REST * record.period_s)], [Phase(0, 0)]
    for index, (a, b) in enumerate(pairwise([0, *changes.tolist(), len(volts)])):
        duration = (b - a) * record.period_s
        if is_open[a]:
            steps.append(Step(StepKind.COAST, duration))
        else:
            level = float(volts[a])
            steps.append(Step(StepKind.DRIVE_VOLTS, duration, level, Decay.SYNCHRONOUS_SLOW))
        phases.append(Phase(index + 1, REST + a))
    return tuple(steps), tuple(phases)


def default(record: Record, model: Model, seed: int) -> Solution:
    """The default estimator on the record, without Coulomb friction where the model has none."""
    begin = time.perf_counter()
    without = () if model is FRICTION else ("T0",)
    estimate = fit([capture_of(record)], without=without)
    seconds = time.perf_counter() - begin
    values = {
        name: p.value
        for name, p in estimate.parameters.items()
        if name in model.parameters and p.value is not None
    }
    settled = "settled" if not any(d.code == "not_converged" for d in estimate.diagnostics) else ""
    nothing = np.empty((0, 2))
    return Solution(
        "ml", values, np.nan, estimate.evaluations, seconds, settled or "unsettled", seed, nothing
    )
