"""What the residuals say: how many times the declared noise they are, and their correlation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION
from motorid.estimate.diagnosis.localise import place
from motorid.estimate.effects.reading.smoothing import hidden_noise
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic
from motorid.estimate.signals.measurements import EMF, Measured
from motorid.estimate.signals.neighbour_noise import counting_noise, neighbour_noise
from motorid.estimate.signals.time_grid import IRREGULAR
from motorid.estimate.solver.autoregression import autocovariance
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution
from motorid.segment import Segment

Floats = NDArray[np.float64]

LACK_OF_FIT = 1.5  # residuals in units of the declared noise
OF_NEIGHBOURS = 4.0  # the same of what neighbours differ by, where none is declared
ORDER = 2  # of the differences that show it
ASTRAY = 5e-3  # of a board's position's span: what no ripple, cogging or noise adds up to
VISIBLE = 1e-3  # of a channel's span: residuals that are less lack nothing that matters
WORDS = {EMF: "back-EMF while coasting"}


def declared_noise(m: Measured) -> float:
    """Standard deviation that the channel declares for a reading, quantisation included; 0: none.

    A declared noise is that of a reading as it comes, with the quantisation in it.
    """
    step = m.resolution / np.sqrt(12.0)
    return float(max(m.noise, step)) if m.noise > 0 else 0.0


def lacking(record: MotorRecord, m: Measured, residual: Floats, driven: float = 0.0) -> float:
    """How many times the noise the residuals are, where they are more than they should be; else 0.

    A log declares none: there it is what neighbouring residuals differ by, and what noise of its
    voltage leaves, of variance ``driven`` (SI). A board's position adds up whatever a motor does
    besides: there it is the encoder's step, where the residuals are a share of all that it turned.
    """
    sigma, noise = rms(m, residual), declared_noise(m)
    if noise:
        return sigma / noise if sigma > LACK_OF_FIT * noise else 0.0
    if record.sensed.waveform is None and m.block.name == POSITION and m.resolution > 0.0:
        far = sigma > max(ASTRAY * float(np.ptp(m.values)), OF_NEIGHBOURS * m.resolution)
        return float(sigma / (m.resolution / np.sqrt(12.0))) if far else 0.0
    if record.sensed.waveform is None or record.timeline.jitter > IRREGULAR:
        return 0.0
    hidden = np.sqrt(hidden_noise(record.instances, record.unknowns, m.block.name, ORDER))
    rounded = max(m.resolution / np.sqrt(12.0), counting_noise(m.values))
    between = max(neighbour_noise(residual, ORDER) * hidden, rounded)
    between = np.hypot(between, np.sqrt(driven))
    least = max(OF_NEIGHBOURS * between, VISIBLE * float(np.ptp(m.values)))
    return float(sigma / between) if between > 0.0 and sigma > least else 0.0


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
    record: MotorRecord, m: Measured, residual: Floats, segments: Sequence[Segment], where: str,
    driven: float = 0.0,
) -> list[Diagnostic]:  # fmt: skip
    """A channel whose residuals are more than its noise (see ``lacking``), and where most of it
    lies.
    """
    times = lacking(record, m, residual, driven)
    if not times:
        return []
    name = WORDS.get(m.block.name, m.block.name)
    of = "its declared noise" if declared_noise(m) else "what neighbours differ by"
    if m.block.name == POSITION and record.sensed.waveform is None:
        of = "what the encoder's step leaves open"
    mostly = place(record, m, residual, segments)
    return [
        Diagnostic(
            "lack_of_fit", "warning",
            f"the residual of the {name} is {rms(m, residual):.3g} {m.channel.unit} rms{where}, "
            f"{times:.1f} times {of}{f', {mostly}' if mostly else ''}: the model lacks an effect",
        )
    ]  # fmt: skip


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
