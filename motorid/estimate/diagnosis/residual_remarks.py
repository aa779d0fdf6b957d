"""What the residuals say: how many times the declared noise they are, and their correlation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis.localise import place
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic
from motorid.estimate.signals.measurements import EMF, Measured
from motorid.estimate.solver.autoregression import autocovariance
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution
from motorid.segment import Segment

Floats = NDArray[np.float64]

LACK_OF_FIT = 1.5  # residuals in units of the declared noise
WORDS = {EMF: "back-EMF while coasting"}


def declared_noise(m: Measured) -> float:
    """Standard deviation that the channel declares for a reading, quantisation included; 0: none.

    A declared noise is that of a reading as it comes, with the quantisation in it.
    """
    step = m.channel.resolution / np.sqrt(12.0)
    return float(max(m.channel.noise, step)) if m.channel.noise > 0 else 0.0


def rms(m: Measured, residual: Floats) -> float:
    """Of a channel's residuals (n,), in its unit."""
    return float(np.sqrt(square(residual) / m.block.count))


def chi_square(solution: Solution, records: Sequence[MotorRecord]) -> tuple[float, int]:
    """Squared residuals over the declared noise, or over the noise found where none is declared.

    With it its degrees of freedom: the same readings, each in full, less all unknowns.
    """
    total = count = 0.0
    for record, own in zip(records, solution.own, strict=True):
        left = record.weighed(record.departures(solution.values, own), filtered=False)
        for m, r in zip(record.measured, left, strict=True):
            noise = declared_noise(m)
            total += square(r) / noise**2 if noise else m.block.count
            count += m.block.count
    return total, round(count) - solution.unknown_count


def lack_of_fit(
    record: MotorRecord, m: Measured, residual: Floats, segments: Sequence[Segment], where: str
) -> list[Diagnostic]:
    """A channel whose residuals are more than its declared noise, and where most of it lies."""
    out = []
    name = WORDS.get(m.block.name, m.block.name)
    sigma = rms(m, residual)
    noise, unit = declared_noise(m), m.channel.unit
    if noise and sigma > LACK_OF_FIT * noise:
        mostly = place(record, m, residual, segments)
        out.append(
            Diagnostic(
                "lack_of_fit", "warning",
                f"the residual of the {name} is {sigma:.3g} {unit} rms{where}, "
                f"{sigma / noise:.1f} times its declared noise"
                f"{f', {mostly}' if mostly else ''}: the model lacks an effect",
            )
        )  # fmt: skip
    return out


def neighbour_correlation(residual: Floats) -> list[float]:
    """The correlation of neighbours, where it stands out."""
    lags = autocovariance(residual, 1)
    rho = float(lags[1] / lags[0]) if lags[0] > 0 else 0.0
    return [rho] if abs(rho) > max(0.1, 4.0 / np.sqrt(len(residual))) else []


def coloured(name: str, rhos: Sequence[float]) -> Diagnostic:
    """One sentence for all runs."""
    size = f"{rhos[0]:+.2f}" if len(rhos) == 1 else f"{min(rhos):+.2f} to {max(rhos):+.2f}"
    runs = f" in {len(rhos)} runs" if len(rhos) > 1 else ""
    return Diagnostic(
        "coloured_residuals", "info",
        f"neighbouring residuals of the {WORDS.get(name, name)} are correlated ({size}){runs}; "
        "the intervals allow for it",
    )  # fmt: skip
