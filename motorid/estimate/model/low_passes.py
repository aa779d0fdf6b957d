"""Low-passes in a log's channels, declared or found by a search: of first order, and of second."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.action import Setup
from motorid.estimate.signals.measurements import Measured, second_order
from motorid.estimate.signals.second_order_filter import SecondOrder
from motorid.motor.reading import Output

Floats = NDArray[np.float64]

LEAST_DAMPED = 0.3  # a first coefficient in roots of the second: less rings
SHORTEST = 0.02  # of a tick of the fit: a shorter one does nothing


def declared(measured: Sequence[Measured], period_s: float) -> dict[int, SecondOrder]:
    """Of second order, by row of the response."""
    rows = (m for m in measured if second_order(m.channel, m.block.name))
    return {m.row: SecondOrder.of(m.channel, period_s) for m in rows}


def low_passes(
    measured: Sequence[Measured], outputs: Sequence[Output], setup: Setup, period_s: float
) -> dict[int, SecondOrder]:
    """By row of the response, each with what its channel's low-pass has of first order."""
    found = {}
    for m in measured:
        size_s = setup.second_s.get(m.block.name, 0.0)
        if size_s:
            size_s = max(size_s, SHORTEST * period_s)
            first_s = outputs[m.row].filter_s + setup.filter_s.get(m.block.name, 0.0)
            first_s = max(first_s, LEAST_DAMPED * size_s)
            found[m.row] = SecondOrder.by_coefficients(first_s, size_s**2, period_s)
    return found


def behind(passes: Mapping[int, SecondOrder], readings: Floats) -> Floats:
    """Readings (outputs, count), those of some rows behind a low-pass; changed in place."""
    for row, low_pass in passes.items():
        readings[row] = low_pass(readings[row])
    return readings


def first_orders(
    measured: Sequence[Measured], outputs: Sequence[Output], setup: Setup
) -> dict[str, float]:
    """s by block, that its low-pass of first order is longer than declared.

    It is none where it is part of one of second order.
    """
    return {
        m.block.name: -outputs[m.row].filter_s
        if m.block.name in setup.second_s
        else setup.filter_s.get(m.block.name, 0.0)
        for m in measured
    }
