"""How much there is to explain: residuals against the noise that their own neighbours show."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.reading.smoothing import smoothed_by
from motorid.estimate.effects.reading.smoothing_kernels import hidden
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import Measured
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution

Floats = NDArray[np.float64]


def residuals(records: Sequence[MotorRecord], solution: Solution) -> list[list[Floats]]:
    """Every record's residuals as the likelihood counts them, not whitened; SI units."""
    return [
        record.weighed(record.departures(solution.values, own), filtered=False)
        for record, own in zip(records, solution.own, strict=True)
    ]


def noise_variance(m: Measured, residual: Floats) -> float:
    """Of a reading: by what neighbours differ, and not below the floor that its block declares."""
    between = np.diff(residual)
    usual = float(np.median(np.abs(between))) / 0.6745 if len(between) else 0.0
    return max(usual**2 / 2.0, m.block.floor**2 * _weight(m))


def _smoothed(record: MotorRecord, m: Measured, usual: float) -> float:
    """The same of readings that an unknown smoothed: neighbours hide some of it, and what the
    channel declares was smoothed with them.
    """
    kernel = smoothed_by(record.instances, record.unknowns, m.block.name)
    if kernel is None:
        return usual
    declared = (m.noise**2 * square(kernel) + m.block.floor**2) * _weight(m)
    return max(usual * hidden(kernel, 1), declared)


def _weight(m: Measured) -> float:
    return 1.0 if m.root_weights is None else float(np.mean(m.root_weights**2))


def of_fit(records: Sequence[MotorRecord], solution: Solution) -> float:
    """``excess`` of a fit's residuals."""
    return excess(records, residuals(records, solution))


def excess(
    records: Sequence[MotorRecord],
    left: Sequence[Sequence[Floats]],
    more: Sequence[Sequence[float]] = (),
) -> float:
    """Fall of F, for each reading, if the residuals were but noise; about 0 when they are.

    No hypothesis can explain more than this. ``more``: variance (SI) by record and channel, which
    noise has besides.
    """
    total = count = 0.0
    for k, (record, blocks) in enumerate(zip(records, left, strict=True)):
        for j, (m, r) in enumerate(zip(record.measured, blocks, strict=True)):
            noise = _smoothed(record, m, noise_variance(m, r)) + (more[k][j] if more else 0.0)
            ratio = square(r) / max(len(r), 1) / max(noise, 1e-300)
            total += m.block.count * max(float(np.log(max(ratio, 1e-300))), 0.0)
            count += m.block.count
    return total / max(count, 1.0)
