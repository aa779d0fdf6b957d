"""The search and what drives the motor in turn, until neither changes the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.estimate.fit.parameter_bounds import merged, unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.thevenin_source import Source
from motorid.estimate.solver.levenberg_marquardt import ENOUGH, maximise
from motorid.estimate.solver.problem import Solution, Unknown

SOURCE_PASSES = 3  # at most, of fit and source lines in turn
LOSS_PASSES = 7  # the same while what brushes take follows a current that still moves
ROUGH = 1.0  # change of chi-square that is near enough while sources and noise are unsettled


def with_sources(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    held_h: float = 0.0,
) -> Solution:
    """The fit and what drives the motor in turn, until that stays; ``held_h``: an inductance that
    is not searched, 0: it is.
    """
    first = _held(unknowns_of(records, free, start), held_h)
    solution = maximise(first, records, enough=ROUGH)
    settled = True
    for n in range(1, LOSS_PASSES):
        if settled and n >= SOURCE_PASSES:
            break
        before = [record.sources for record in records]
        for record, own in zip(records, solution.own, strict=True):
            record.retake_sources(solution.values, own)
        after = [record.sources for record in records]
        settled = all(record.driving.settled for record in records)
        if settled and all(_same(a, b) for old, new in zip(before, after, strict=True)
               for a, b in zip(old, new, strict=True)):  # fmt: skip
            break
        solution = again(records, free, start, solution, ROUGH, held_h)
    return solution


def again(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    before: Solution,
    enough: float = ENOUGH,
    held_h: float = 0.0,
) -> Solution:
    """The search goes on from a solution, with what has changed in the records."""
    known = _held(unknowns_of(records, free, merged(start, before)), held_h)
    return maximise(known, records, enough=enough, before=before)


def judge_at(records: Sequence[MotorRecord], solution: Solution, inductance_h: float) -> None:
    """What drives the motor, and what is lost, if that were its inductance.

    Ripple and pulses follow it, and what brushes take of them: judged by none, it stays none.
    """
    values = np.array([
        inductance_h if unknown.name == "L" else value
        for unknown, value in zip(solution.unknowns, solution.values, strict=True)
    ])  # fmt: skip
    for record, own in zip(records, solution.own, strict=True):
        record.retake_sources(values, own)


def with_inductance(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    known: Mapping[str, float],
    near: Solution,
    inductance_h: float,
) -> Solution:
    """``with_sources`` from ``known`` values with an inductance that is held, and what drives the
    motor judged by it from the start; ``near`` is a solution to judge that with.
    """
    judge_at(records, near, inductance_h)
    return with_sources(records, free, {**known, "L": inductance_h}, inductance_h)


def _held(unknowns: list[Unknown], held_h: float) -> list[Unknown]:
    if not held_h:
        return unknowns
    return [
        replace(u, start=held_h, lower=held_h, upper=held_h) if u.name == "L" else u
        for u in unknowns
    ]


def _same(a: Source | None, b: Source | None) -> bool:
    return a is b if a is None or b is None else a.near(b)
