"""The residuals' memory, taken into the records' weights: filters for short, thinning for long."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.effective_sample_size import excess
from motorid.estimate.model.program_parts import part_rows
from motorid.estimate.signals.measurements import Measured
from motorid.estimate.solver.autoregression import whitener
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution

Floats = NDArray[np.float64]


def whiten(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """Every kind of reading through the filter that whitens what is left; whether any needs one."""
    kinds: dict[str, list[Floats]] = {}  # one process for all readings of one kind
    floors: dict[str, float] = {}
    for record, own in zip(records, solution.own, strict=True):
        left = record.weighed(record.departures(solution.values, own), filtered=False)
        for m, r in zip(record.measured, left, strict=True):
            kinds.setdefault(m.block.group, []).append(r)
            floors[m.block.group] = max(m.block.floor, floors.get(m.block.group, 0.0))
    filters = {
        group: whitener(*left) if _noisy(left, floors[group]) else None
        for group, left in kinds.items()
    }
    for record in records:
        record.whiten([filters[m.block.group] for m in record.measured])
    return any(f is not None for f in filters.values())


def _noisy(residuals: Sequence[Floats], floor: float) -> bool:
    """Above the least that their converter shows: what rounding leaves has no colour to model."""
    return sum(square(r) for r in residuals) > floor**2 * sum(len(r) for r in residuals)


def thin(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """Every kind of reading to the worth that its slow residuals leave it; whether any has them.

    Driven and open stretches apart: what makes a position wander is mostly the voltage.
    """
    found: dict[tuple[str, bool], list[tuple[Floats, Floats]]] = {}
    for record, own in zip(records, solution.own, strict=True):
        left = record.weighed(record.departures(solution.values, own))
        for m, r in zip(record.measured, left, strict=True):
            for k, rows in part_rows(record.timeline, m, len(r)):
                key = (m.block.group, record.timeline.parts[k].open)
                roots = np.ones(len(r)) if m.root_weights is None else m.root_weights[-len(r) :]
                found.setdefault(key, []).append((r[rows], roots[rows]))
    factors = {key: excess(*zip(*pieces, strict=True)) for key, pieces in found.items()}
    for record in records:
        record.thin([_roots(record, m, factors) for m in record.measured])
    return any(f > 1.0 for f in factors.values())


def _roots(
    record: MotorRecord, m: Measured, factors: dict[tuple[str, bool], float]
) -> Floats | None:
    roots = np.ones(len(m.keep))
    for k, rows in part_rows(record.timeline, m, len(m.keep)):
        roots[rows] = factors.get((m.block.group, record.timeline.parts[k].open), 1.0) ** -0.5
    return roots if roots.min(initial=1.0) < 1.0 else None
