"""How well the columns of a log follow the two laws of a motor, by two cheap regressions.

Of means over blocks, with no coefficient below zero,

    V = R i + K w + L di/dt        i = J/K dw/dt + B/K w + T0/K sign(w)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Shares = tuple[float, float]  # of the squares that each law leaves
Columns = tuple[Floats, Floats, Floats]  # voltage, current and speed, (n,) each

BLOCKS, SHORTEST, FEWEST = 400, 3, 40  # of a log; rows of a block; blocks
SLOW = 0.02  # of the highest speed, below which friction has no sign
QUANTITIES = (VOLTAGE, CURRENT, SPEED)
GOOD = 0.05  # share that both laws together leave of the squares: a motor's current
BETTER = 5.0  # times less than the logged current leaves


def columns(capture: Capture) -> Columns | None:
    """Voltage, current and speed of a log, (n,) each, in shares of their largest; None: none."""
    channels = [capture.get(name) for name in QUANTITIES]
    if capture.program is not None or any(c is None or c.unsigned for c in channels):
        return None
    table = np.array([c.values for c in channels if c is not None])
    table = table[:, np.isfinite(table).all(axis=0)]
    if table.shape[1] < FEWEST * SHORTEST or (np.ptp(table, axis=1) == 0.0).any():
        return None
    volts, current, speed = table / np.abs(table).max(axis=1, keepdims=True)
    return volts, current, speed


def left(
    volts: Floats,
    current: Floats,
    speed: Floats,
    rows: Bools | None = None,
    blocks: int = BLOCKS,
) -> Shares:
    """Share of the squares that each law leaves of columns (n,), in blocks that are all ``rows``.

    Of at most so many ``blocks``. 1 where fewer than FEWEST blocks remain.
    """
    width = max(len(volts) // blocks, SHORTEST)
    used = np.ones(len(volts)) if rows is None else rows.astype(np.float64)
    whole = _means(used, width) == 1.0
    if whole.sum() < FEWEST:
        return 1.0, 1.0
    sign = np.where(np.abs(speed) > SLOW * np.abs(speed).max(), np.sign(speed), 0.0)
    electrical = [_means(current, width), _means(speed, width), _rises(current, width)]
    mechanical = [_rises(speed, width), _means(speed, width), _means(sign, width)]
    return (
        non_negative([x[whole] for x in electrical], _means(volts, width)[whole])[1],
        non_negative([x[whole] for x in mechanical], _means(current, width)[whole])[1],
    )


def convinces(mended: Shares, logged: Shares) -> bool:
    """A current as it is mended follows both laws, each better, and together far better.

    Readings of a coarse speed follow the second law badly whatever the current is; one that is
    bent until it follows them leaves the first.
    """
    each = all(now < before for now, before in zip(mended, logged, strict=True))
    return each and sum(mended) < min(GOOD, sum(logged) / BETTER)


def _means(values: Floats, width: int) -> Floats:
    count = (len(values) - 1) // width
    means: Floats = values[: count * width].reshape(count, width).mean(axis=1)
    return means


def _rises(values: Floats, width: int) -> Floats:
    """Mean change a row within each block."""
    count = (len(values) - 1) // width
    edges = values[: count * width + 1 : width]
    return np.asarray(np.diff(edges) / width)


def non_negative(regressors: list[Floats], target: Floats) -> tuple[list[float], float]:
    """Coefficients, none below zero, and the share of the squares of (n,) that they leave."""
    from scipy.optimize import nnls

    total = float(target @ target)
    if total <= 0.0:
        return [0.0] * len(regressors), 1.0
    scales = [float(np.sqrt(x @ x)) or 1.0 for x in regressors]
    found, rest = nnls(
        np.column_stack([x / s for x, s in zip(regressors, scales, strict=True)]), target
    )
    return [float(c / s) for c, s in zip(found, scales, strict=True)], float(rest) ** 2 / total
