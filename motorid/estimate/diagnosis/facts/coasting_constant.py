"""The back-EMF constant of coasts alone, against that of the whole fit.

While the bridge is open the terminals show K w, whatever brushes, iron and source do when current
flows. A fit hardly heeds a small departure that lasts: it takes it for noise that wanders. So the
slope of what the fit leaves over what it foretells is asked for by itself, as of any readings whose
neighbours agree.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.coloured_mean import variance_growth

Floats = NDArray[np.float64]

SURE = 4.0  # standard uncertainties of a difference
HARM = 0.005  # of K: less is worth no remark
FEWEST = 32  # readings of a coast
TORQUES = ("K", "B", "J", "T0")  # which a torque, and so K, is the measure of


@dataclass(frozen=True)
class Share:
    """By how much of it K is larger in coasts than in the fit, with its standard uncertainty."""

    size: float
    u: float


def findings(
    solution: Solution, records: Sequence[MotorRecord], parameters: Mapping[str, Parameter]
) -> Iterator[Diagnostic]:
    """A remark where coasts contradict the K of the fit."""
    K = parameters["K"]
    share = pooled([
        one
        for record, own in zip(records, solution.own, strict=True)
        if (one := of_coasts(record, solution.values, own)) is not None
    ])  # fmt: skip
    if share is None or not K.value or K.statistical is None:
        return
    times = abs(share.size) / float(np.hypot(share.u, K.statistical / K.value))
    if times <= SURE or abs(share.size) <= HARM:
        return
    values = {n: p.value for n in TORQUES if (p := parameters[n]).value is not None}
    moves = {name: abs(share.size * value) for name, value in values.items()}
    below = share.size < 0.0
    shown = K.value * (1.0 + share.size)
    yield Diagnostic(
        "coasting_constant", "warning",
        f"while coasting the terminals show K of {shown:.4g} {K.unit}, the fit finds {K.value:.4g} "
        f"{K.unit}, {times:.2g} standard uncertainties apart: while current flows the motor or its "
        "voltage is not what the model says; compare runs at other levels and another decay",
        moves, {name: (move, 0.0) if below else (0.0, move) for name, move in moves.items()},
    )  # fmt: skip


def of_coasts(record: MotorRecord, shared: Floats, own: Floats) -> Share | None:
    """By the coasts of one capture; None without enough of them."""
    blocks = zip(record.measured, record.departures(shared, own), strict=True)
    for m, left in blocks:
        if m.block.name == EMF and len(left) >= FEWEST and not m.unsigned:
            return slope(m.values - left, left, m.block.floor)
    return None


def slope(foretold: Floats, left: Floats, floor: float) -> Share | None:
    """Of what is left over what was foretold, beside an offset; ``floor``: the least scatter."""
    x = foretold - foretold.mean()
    extent = float(x @ x)
    if not extent > len(x) * floor**2:
        return None
    size = float(x @ left) / extent
    about = left - left.mean() - size * x
    scatter = max(float(np.sqrt(np.mean(about**2))), floor)
    return Share(size, scatter * float(np.sqrt(variance_growth(about) / extent)))


def pooled(shares: Sequence[Share]) -> Share | None:
    """Of several captures; less sure where they differ by more than their uncertainties."""
    if not shares:
        return None
    sizes, weights = np.array([s.size for s in shares]), np.array([s.u**-2 for s in shares])
    size = float(sizes @ weights / weights.sum())
    spread = float(weights @ (sizes - size) ** 2) / max(len(shares) - 1, 1)
    return Share(size, float(np.sqrt(max(spread, 1.0) / weights.sum())))
