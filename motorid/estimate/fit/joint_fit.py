"""The joint output-error maximum-likelihood fit of captures of one driven motor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motorid.capture.model import Capture
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.fit import (
    sign_check,
    start_values,
    start_values_without_motion,
    subsample_inductance,
)
from motorid.estimate.fit.multistart import settled, whitened
from motorid.estimate.fit.parameter_bounds import held_values, merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.signals.intersample_voltage import SHAPES, Rival
from motorid.estimate.solver.problem import Solution


def solved(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str]
) -> tuple[list[MotorRecord], Solution]:
    """The captures as the likelihood sees them, and their most likely parameters; as ``fit``."""
    fixed = held_values(fix, without)
    free = [name for name in PARAMETERS if name not in fixed]
    if fixed.get("L") == 0.0:  # the rise of the current would be taken for a drop
        captures = [lossless(capture) for capture in captures]
    records = [MotorRecord(capture, free, fixed) for capture in captures]
    sign_check.insist(records)
    begin = (
        start_values_without_motion
        if start_values_without_motion.suits(records, fixed)
        else start_values
    )
    start = begin.start_values(records, fixed)
    solution = settled(records, free, start)
    if any(record.sensed.waveform for record in records):
        records, solution = _best_shaped(records, solution, free, start, fixed)
    solution = whitened(records, free, merged(start, solution), solution)
    known = merged(start, solution)
    return subsample_inductance.told(records, free, fixed, known, solution) or (records, solution)


def _best_shaped(
    records: list[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
    fixed: Mapping[str, float],
) -> tuple[list[MotorRecord], Solution]:
    """Of the shapes that a log's voltage may have had between readings, the most likely.

    A voltage that jumps makes bad ground for a search, so each begins where the smoothest ended.
    """
    near = merged(start, solution)
    found = [(records, solution)]
    for shape in SHAPES[1:]:
        others = [MotorRecord(record.capture, free, fixed, shape) for record in records]
        found.append((others, settled(others, free, near)))
    records, solution = best = min(found, key=lambda one: one[1].objective)
    for record in records:
        record.rivals = tuple(
            Rival(other.values, other.objective - solution.objective)
            for _, other in found
            if other is not solution
        )
    return best
