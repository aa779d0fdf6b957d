"""Start values without any from the user: linear least squares on integrals of the equations.

    integral of v = R integral of i + L change of i + K change of angle
    K integral of i = J change of w + B change of angle + T0 time of motion

Windows at steady state make these the steady-state equations over all levels; windows of a coast
are the integrated coast-down, which gives B/J and T0/J; windows after a step give L and J. No
derivative of a noisy signal is taken, and parts that a capture lacks leave no hole.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED
from motorid.errors import DataError
from motorid.estimate.fit import lagging_start
from motorid.estimate.fit.lagging_start import Doubt
from motorid.estimate.fit.start_signals import Signals, signals
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.dense_products import dot

Floats = NDArray[np.float64]

WINDOWS = 24  # mechanical windows in each part
SHORTEST = 6  # samples of a mechanical window
COUNTED = 100  # steps of an encoder in one at the top speed: half a per cent of that is their error
FEWEST = 4  # marks that a wide window leaves in a part
HIDDEN = 0.02  # share of the voltage of a back-EMF that noise gave the wrong sign
STALLED = 1e-3  # of the largest speed, below which friction may hold


def start_values(records: Sequence[MotorRecord], fixed: Mapping[str, float]) -> dict[str, float]:
    """``begun``, whether or not it is a guess."""
    return begun(records, fixed)[0]


def begun(
    records: Sequence[MotorRecord], fixed: Mapping[str, float]
) -> tuple[dict[str, float], Doubt | None]:
    """R, L, K, B, J, T0 (SI) near the answer, and why they are a guess; None: they are not.

    Records without a motion have no say where others have one. Raises DataError where a signal is
    missing, or turned round.
    """
    moving = [record for record in records if shows_motion(record)]
    told = moving or records
    data = [signals(record, told) for record in told]
    R, L, K = _electrical(data, fixed)
    doubt = None
    try:
        B, J, T0 = mechanical(data, K, fixed)
    except DataError as error:
        (B, J, T0), doubt = lagging_start.mechanics(data, R, K, fixed, balanced, error)
    return {"R": R, "L": L, "K": K, "B": B, "J": J, "T0": T0} | dict(fixed), doubt


def shows_motion(record: MotorRecord) -> bool:
    """Position or speed is measured."""
    return any(m.block.name in (POSITION, SPEED) for m in record.measured)


def _electrical(data: Sequence[Signals], fixed: Mapping[str, float]) -> tuple[float, float, float]:
    rows = np.array([row for s in data for row in _voltage_windows(s)])
    if not len(rows) or not np.abs(rows[:, 0]).max() > 0:
        raise DataError("the motor was never driven in these captures: capture a run with a step")
    known = {j: fixed[n] for j, n in enumerate(("R", "L", "K")) if n in fixed}
    found = dict(known)
    left = rows[:, 0] - sum((known[j] * rows[:, 1 + j] for j in known), np.zeros(len(rows)))
    free = [j for j in range(3) if j not in known]
    if free:
        columns = rows[:, [1 + j for j in free]]
        scale = np.sqrt((columns**2).sum(axis=0)) + 1e-300
        solved = np.linalg.lstsq(columns / scale, left, rcond=1e-9)[0] / scale
        found |= dict(zip(free, solved, strict=True))
    R, L, K = (float(found[j]) for j in range(3))
    if K <= 0 and "K" not in fixed:
        K = _unseen_constant(rows)
    peak = max(float(np.abs(s.current).max()) for s in data)
    volts = max(float(np.abs(s.volts).max()) for s in data)
    if R <= 0:
        R = 0.5 * volts / peak
    period = min(s.period_s for s in data)
    if L <= 0 and fixed.get("L") != 0.0:
        L = 0.3 * R * period
    return R, L, K


def _unseen_constant(rows: Floats) -> float:
    """A start for a K whose back-EMF noise hides. Raises DataError where the motion is reversed."""
    flux, angle = rows[:, 0], rows[:, 3]
    if not dot(flux, angle) > 0:
        raise DataError(
            "the motor turns against its voltage in these captures: "
            "reverse the encoder (or the motor's leads) in the rig"
        )
    return HIDDEN * dot(flux, flux) / dot(flux, angle)


def _voltage_windows(s: Signals) -> Iterator[Floats]:
    """Rows (∫v, ∫i, Δi, Δangle) over windows that double in length after every step."""
    charge, flux = np.cumsum(s.current) * s.period_s, np.cumsum(s.volts) * s.period_s
    for k, opened in enumerate(s.open):
        a, stop, width = max(s.edges[k] - 1, 0), s.edges[k + 1] - 1, 1
        while not opened and a < stop:
            b = min(a + width, stop)
            q = charge[b] - charge[a]
            row = np.array(
                [
                    flux[b] - flux[a] - s.series_ohm * q,
                    q,
                    s.current[b] - s.current[a],
                    s.angle[b] - s.angle[a],
                ]
            )
            yield row / np.sqrt((b - a) * s.period_s)
            a, width = b, min(2 * width, max(1, (stop - s.edges[k]) // 4))


def mechanical(
    data: Sequence[Signals], K: float, fixed: Mapping[str, float]
) -> tuple[float, float, float]:
    """B, J and T0 from windows of the torque. Raises DataError where these show no inertia."""
    return balanced(data, K, fixed)[0]


def balanced(
    data: Sequence[Signals], K: float, fixed: Mapping[str, float]
) -> tuple[tuple[float, float, float], float]:
    """``mechanical``, and how much of the torque's squares it explains."""
    rows = np.array([row for s in data for row in _torque_windows(s, K)])
    names = ("J", "B", "T0")
    if not len(rows):
        raise DataError("the motor did not move in these captures: raise the level of the steps")
    known = {j: fixed[n] for j, n in enumerate(names) if n in fixed}
    left = rows[:, 0] - sum((known[j] * rows[:, 1 + j] for j in known), np.zeros(len(rows)))
    free = [j for j in range(3) if j not in known]
    found = dict(known) | dict(zip(free, _non_negative(rows[:, [1 + j for j in free]], left),
                                   strict=True))  # fmt: skip
    J, B, T0 = (float(found[j]) for j in range(3))
    if J <= 0:
        raise DataError(
            "the speed does not follow the current in these captures: check the sign and the "
            "unit of the current and of the motion"
        )
    rest = rows[:, 0] - rows[:, 1:] @ np.array([J, B, T0])
    return (B, J, T0), dot(rows[:, 0], rows[:, 0]) - dot(rest, rest)


def _torque_windows(s: Signals, K: float) -> Iterator[Floats]:
    """Rows (K ∫i, Δw, Δangle, time of motion with its sign)."""
    charge = np.cumsum(s.current) * s.period_s
    top = _top_speed(s)
    if not top > 0:
        return
    for first, end in zip(s.edges[:-1], s.edges[1:], strict=True):
        first, end = max(first - 1, 0), end - 1
        width = _width(s, end - first, top)
        marks = range(first + width // 2, end - width // 2, width)
        speeds = [_speed_at(s, m, width) for m in marks]
        for (a, wa), (b, wb) in zip(
            zip(marks[:-1], speeds[:-1], strict=True), zip(marks[1:], speeds[1:], strict=True),
            strict=True,
        ):  # fmt: skip
            if wa * wb <= 0 or min(abs(wa), abs(wb)) < STALLED * top:
                continue
            time = (b - a) * s.period_s
            yield np.array(
                [
                    K * (charge[b] - charge[a]),
                    wb - wa,
                    s.angle[b] - s.angle[a],
                    time if wa > 0 else -time,
                ]
            ) / np.sqrt(time)


def _width(s: Signals, samples: int, top: float) -> int:
    """Samples of a mechanical window in a part of so many.

    The speed is a column, and noise of a column makes its coefficient small: at a high rate the
    steps of a position would hide the inertia.
    """
    counted = int(COUNTED * s.step_rad / (top * s.period_s))
    return max(SHORTEST, samples // WINDOWS, min(counted, samples // FEWEST))


def _top_speed(s: Signals) -> float:
    width = max(2, SHORTEST, len(s.angle) // 200)
    if len(s.angle) <= width:
        return 0.0
    return float(np.abs(s.angle[width:] - s.angle[:-width]).max()) / (width * s.period_s)


def _speed_at(s: Signals, n: int, width: int) -> float:
    half = max(width // 2, 1)
    if s.speed is not None:
        quarter = max(half // 2, 1)
        return float(s.speed[n - quarter : n + quarter + 1].mean())
    return float(s.angle[n + half] - s.angle[n - half]) / (2 * half * s.period_s)


def _non_negative(columns: Floats, target: Floats) -> Floats:
    """Least squares over the best set of columns whose coefficients come out positive."""
    n = columns.shape[1]
    best, smallest = np.zeros(n), float(target @ target)
    for size in range(1, n + 1):
        for chosen in combinations(range(n), size):
            part = columns[:, chosen]
            scale = np.sqrt((part**2).sum(axis=0)) + 1e-300
            solved = np.linalg.lstsq(part / scale, target, rcond=None)[0] / scale
            left = target - part @ solved
            if (solved >= 0).all() and float(left @ left) < smallest:
                smallest = float(left @ left)
                best = np.zeros(n)
                best[list(chosen)] = solved
    return best
