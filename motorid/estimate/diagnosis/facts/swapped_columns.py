"""Two columns of a log under each other's names.

Of means over blocks, with no coefficient below zero,

    V = R i + K w + L di/dt        i = J/K dw/dt + B/K w + T0/K sign(w)

hold in one arrangement of a motor's columns. The second law tells a speed, which changes slowly,
from a voltage; the signs tell a voltage from a current.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic

Floats = NDArray[np.float64]

BLOCKS, SHORTEST, FEWEST = 400, 3, 40  # of a log; rows of a block; blocks
GOOD = 0.1  # share that both laws together leave of the squares: a motor's columns
BETTER = 5.0  # times less than as stated
SLOW = 0.02  # of the highest speed, below which friction has no sign
QUANTITIES = (VOLTAGE, CURRENT, SPEED)


def findings(capture: Capture, where: str = "") -> Iterator[Diagnostic]:
    """Columns that fit a motor in another arrangement only. ``where``: " in run 2", or nothing."""
    found = find(capture)
    if found is None:
        return
    names = {q: q.replace("terminal_", "") for q in QUANTITIES}
    moved = [(names[q], names[of]) for q, of in zip(QUANTITIES, found, strict=True) if q != of]
    kind = f"{moved[0][0]} and {moved[0][1]} are swapped" if len(moved) == 2 else (
        "the columns have changed places")  # fmt: skip
    reads = ", ".join(f"the one called {called} reads as the {truly}" for truly, called in moved)
    yield Diagnostic(
        "columns_swapped", "error",
        f"{kind}{where}: {reads}; in that arrangement the readings follow a motor's laws, as "
        "stated they do not. Import again with the names exchanged",
        dict.fromkeys(PARAMETERS, math.inf),
    )  # fmt: skip


def find(capture: Capture) -> tuple[str, ...] | None:
    """Which channel holds the voltage, the current and the speed; None: as stated, or unclear."""
    columns = _columns(capture)
    if columns is None:
        return None
    signs = product((1.0, -1.0), repeat=2)  # a reversed column is another mistake
    volts, current, speed = columns
    stated = min(left(volts, a * current, b * speed) for a, b in signs)
    if stated < GOOD:
        return None
    tried = {order: left(*(columns[k] for k in order)) for order in permutations(range(3))}
    best = min(tried, key=lambda order: tried[order])
    if tried[best] > min(GOOD, stated / BETTER):
        return None
    return tuple(QUANTITIES[k] for k in best)


def left(volts: Floats, current: Floats, speed: Floats) -> float:
    """Share of the squares that both laws leave of columns (n,)."""
    width = max(len(volts) // BLOCKS, SHORTEST)
    sign = np.where(np.abs(speed) > SLOW * np.abs(speed).max(), np.sign(speed), 0.0)
    electrical = [_means(current, width), _means(speed, width), _rises(current, width)]
    mechanical = [_rises(speed, width), _means(speed, width), _means(sign, width)]
    return _share(electrical, _means(volts, width)) + _share(mechanical, _means(current, width))


def _columns(capture: Capture) -> tuple[Floats, Floats, Floats] | None:
    channels = [capture.get(name) for name in QUANTITIES]
    if capture.program is not None or any(c is None or c.unsigned for c in channels):
        return None
    table = np.array([c.values for c in channels if c is not None])
    table = table[:, np.isfinite(table).all(axis=0)]
    if table.shape[1] < FEWEST * SHORTEST or (np.ptp(table, axis=1) == 0.0).any():
        return None
    volts, current, speed = table / np.abs(table).max(axis=1, keepdims=True)
    return volts, current, speed


def _means(values: Floats, width: int) -> Floats:
    count = (len(values) - 1) // width
    means: Floats = values[: count * width].reshape(count, width).mean(axis=1)
    return means


def _rises(values: Floats, width: int) -> Floats:
    """Mean change a row within each block."""
    count = (len(values) - 1) // width
    edges = values[: count * width + 1 : width]
    return np.asarray(np.diff(edges) / width)


def _share(regressors: list[Floats], target: Floats) -> float:
    from scipy.optimize import nnls

    total = float(target @ target)
    scales = [float(np.sqrt(x @ x)) or 1.0 for x in regressors]
    _, rest = nnls(
        np.column_stack([x / s for x, s in zip(regressors, scales, strict=True)]), target
    )
    return float(rest) ** 2 / total if total > 0.0 else 1.0
