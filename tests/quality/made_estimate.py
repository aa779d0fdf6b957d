"""An answer of a fit that was made by hand: round figures, and nothing that a run would need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motorid.estimate.results.estimate import UNITS, Curve, Estimate, Parameter
from motorid.estimate.results.status import Status

VALUES = {"R": 2.0, "L": 2e-4, "K": 0.01, "B": 1e-6, "J": 4e-7, "T0": 5e-4}


def parameter(
    name: str,
    value: float | None,
    total: float | None = None,
    status: Status = Status.ESTIMATED,
    note: str = "",
    statistical: float | None = None,
) -> Parameter:
    """Half a percent, unless it says otherwise."""
    own = 0.005 * value if total is None and value is not None else total
    return Parameter(name, UNITS.get(name, "1"), value, statistical, None, own, None, status, note)


def estimate(**changes: object) -> Estimate:
    """The six parameters alone; ``changes`` replace fields."""
    base = Estimate(
        model="linear friction",
        method="ml",
        parameters={name: parameter(name, value) for name, value in VALUES.items()},
        combinations={}, derived={}, nuisance={}, free=tuple(VALUES), correlation=np.eye(6),
        chi_square=100.0, degrees_of_freedom=100, evaluations=1, diagnostics=(),
        inputs=({"ambient_c": 20.0, "ambient_uncertainty_c": 0.3},),
    )  # fmt: skip
    return replace(base, **changes)  # type: ignore[arg-type]


def curve(
    channel: str, measured: Sequence[float] | np.ndarray, fitted: Sequence[float] | np.ndarray,
    capture: int = 0, step_s: float = 1e-3,
) -> Curve:  # fmt: skip
    """Readings a millisecond apart."""
    read, shown = np.asarray(measured, float), np.asarray(fitted, float)
    time_s = np.arange(len(read)) * step_s
    unit = {"current": "A", "position": "rad"}[channel]
    return Curve(capture, channel, unit, time_s, read, shown, 0.01)
