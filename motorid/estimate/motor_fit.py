"""The joint output-error maximum-likelihood fit of captures of one driven motor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motorid.capture.model import Capture
from motorid.estimate import closed_form, unseen_inductance, unseen_motion
from motorid.estimate.loss import lossless
from motorid.estimate.motor_results import report
from motorid.estimate.record import MotorRecord
from motorid.estimate.settling import settled, whitened
from motorid.estimate.solution import Solution
from motorid.estimate.suspects import signs
from motorid.estimate.types import PARAMETERS, Estimate
from motorid.estimate.unknowns import held_values, merged
from motorid.estimate.waveform import SHAPES, Rival


def fit(
    captures: Sequence[Capture],
    fix: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
) -> Estimate:
    """The six parameters from captures with a voltage and a current or a motion.

    ``fix`` holds parameters at SI values; ``without`` takes L, B or T0 out of the model. Raises
    DataError where the captures cannot be fitted at all.
    """
    records, solution = solved(captures, fix or {}, without)
    return report(captures, records, solution, fix or {}, without)


def solved(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str]
) -> tuple[list[MotorRecord], Solution]:
    """The captures as the likelihood sees them, and their most likely parameters; as ``fit``."""
    fixed = held_values(fix, without)
    free = [name for name in PARAMETERS if name not in fixed]
    if fixed.get("L") == 0.0:  # the rise of the current would be taken for a drop
        captures = [lossless(capture) for capture in captures]
    records = [MotorRecord(capture, free, fixed) for capture in captures]
    signs.insist(records)
    begin = unseen_motion if unseen_motion.suits(records, fixed) else closed_form
    start = begin.start_values(records, fixed)
    solution = settled(records, free, start)
    if any(record.sensed.waveform for record in records):
        records, solution = _best_shaped(records, solution, free, start, fixed)
    solution = whitened(records, free, merged(start, solution), solution)
    known = merged(start, solution)
    return unseen_inductance.told(records, free, fixed, known, solution) or (records, solution)


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
