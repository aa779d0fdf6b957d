"""A motor's two laws in the units of a file: R, K and J/K by two cheap regressions.

Integrated over blocks of rows, which differentiates nothing,

    V = R i + K w + L di/dt        i = J/K dw/dt + B/K w + T0/K sign(w)
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis.facts.motor_laws import SLOW, non_negative

Floats = NDArray[np.float64]
BLOCKS, FEWEST = 400, 24
HOLDS = 0.1  # share of the squares that a law leaves where columns follow it
HIGH = 99.0  # percentile that counts as the highest voltage


@dataclass(frozen=True)
class Found:
    """In the file's own units. ``left``: shares of the squares that the laws leave.

    ``J_over_K`` None: no acceleration shows it. ``signs`` of the current and of the speed.
    """

    top_v: float
    R: float
    K: float
    J_over_K: float | None
    left: tuple[float, float]
    signs: tuple[float, float] = (1.0, 1.0)

    @property
    def holds(self) -> bool:
        """Whether the columns are a motor's as far as the voltage shows."""
        return self.left[0] < HOLDS and self.R > 0.0 and self.K > 0.0


def found(time: Floats, volts: Floats, current: Floats, speed: Floats) -> Found | None:
    """The laws in columns (rows,) of a file; None: too little of it to say.

    A column that was wired the other way round is tried with the other sign.
    """
    table = np.array([time, volts, current, speed])
    table = table[:, np.isfinite(table).all(axis=0)]
    if table.shape[1] < 3 * FEWEST or (np.ptp(table, axis=1) == 0.0).any():
        return None
    if not (np.diff(table[0]) >= 0.0).all():
        return None
    blocks = _Blocks(*table)
    tried = {(a, b): blocks.laws((a, b)) for a, b in product((1.0, -1.0), repeat=2)}
    straight = tried[1.0, 1.0]
    best = min(tried.values(), key=lambda one: sum(one.left))
    return straight if straight.holds or sum(best.left) > 0.5 * sum(straight.left) else best


class _Blocks:
    """Means over blocks of rows, by the trapezoid rule."""

    def __init__(self, time: Floats, volts: Floats, current: Floats, speed: Floats) -> None:
        self.top_v = float(np.percentile(np.abs(volts), HIGH))
        count = min(BLOCKS, (len(time) - 1) // 3)
        edges = np.linspace(0, len(time) - 1, count + 1).astype(np.intp)
        whole = np.diff(time[edges]) > 0.0
        sign = np.where(np.abs(speed) > SLOW * np.abs(speed).max(), np.sign(speed), 0.0)
        span = np.diff(time[edges])[whole]

        def mean(values: Floats) -> Floats:
            area = np.r_[0.0, np.cumsum(np.diff(time) * (values[1:] + values[:-1]) / 2.0)]
            return np.asarray(np.diff(area[edges])[whole] / span)

        def slope(values: Floats) -> Floats:
            return np.asarray(np.diff(values[edges])[whole] / span)

        self.volts, self.current, self.speed, self.sign = map(mean, (volts, current, speed, sign))
        self.current_slope, self.speed_slope = slope(current), slope(speed)

    def laws(self, signs: tuple[float, float]) -> Found:
        a, b = signs
        electrical, left_e = _fit(
            [a * self.current, b * self.speed, a * self.current_slope], self.volts
        )
        mechanical, left_m = _fit(
            [b * self.speed_slope, b * self.speed, b * self.sign], a * self.current
        )
        accelerates = left_m < 0.5 and mechanical[0] > 0.0
        return Found(
            self.top_v, electrical[0], electrical[1], mechanical[0] if accelerates else None,
            (left_e, left_m), signs,
        )  # fmt: skip


def _fit(regressors: list[Floats], target: Floats) -> tuple[list[float], float]:
    few = len(target) < FEWEST
    return ([0.0] * len(regressors), 1.0) if few else non_negative(regressors, target)


def resistance(volts: Floats, current: Floats) -> tuple[float, float] | None:
    """Highest voltage and about the resistance, of a file without motion; None: it does not show.

    While the motor is driven V >= R i, nearest at the largest current.
    """
    known = np.isfinite(volts) & np.isfinite(current)
    volts, current = np.abs(volts[known]), np.abs(current[known])
    if len(volts) < FEWEST or not current.max() > 0.0 or not volts.max() > 0.0:
        return None
    driven = (current > 0.5 * current.max()) & (volts > 0.2 * volts.max())
    if not driven.any():
        return None
    ratio = float(np.percentile(volts[driven] / current[driven], 5.0))
    return (float(np.percentile(volts, HIGH)), ratio) if ratio > 0.0 else None
