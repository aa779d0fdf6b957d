"""Steiglitz and McBride's iteration (1965) for the linear motor: voltage to current and speed.

Both responses share the poles. Each pass is a linear least squares on data filtered by the
denominator of the pass before; the discrete system that results is taken back to R, L, K, B, J
through its Markov parameters and a matrix logarithm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorid.errors import DataError
from motorid.estimate.results.estimate import Floats
from motorid.motor.batch import Record

PASSES = 20
SETTLED = 1e-12  # largest change of a coefficient of A between passes


@dataclass(frozen=True)
class SteiglitzMcBride:
    """``values`` in SI; ``denominator`` (3,) of current and speed alike."""

    values: dict[str, float]
    denominator: Floats
    passes: int
    settled: bool


def steiglitz_mcbride(record: Record, passes: int = PASSES) -> SteiglitzMcBride:
    """Fit A(q) y = B(q) v with common A of order 2, the motor at rest before the record.

    Raises DataError if a channel is missing, a reading is missing, or the system that comes out
    is no motor (no real logarithm, or a parameter that is not positive).
    """
    if not {"current", "speed"} <= set(record.channels):
        raise DataError("Steiglitz-McBride needs a current and a speed channel")
    outputs = np.array([record.measured["current"], record.measured["speed"]])
    if not np.isfinite(outputs).all():
        raise DataError("Steiglitz-McBride needs every reading: this record has missing ones")
    a, b = np.array([1.0, 0.0, 0.0]), np.zeros((2, 2))
    settled, done = False, 0
    while done < passes and not settled:
        previous = a
        a, b = _pass(record.input, outputs, a)
        a, done = _stable(a), done + 1
        settled = bool(np.max(np.abs(a - previous)) < SETTLED)
    return SteiglitzMcBride(motor_of(a, b, record.period_s), a, done, settled)


def _pass(u: Floats, outputs: Floats, denominator: Floats) -> tuple[Floats, Floats]:
    """One least squares: filtered data, each equation divided by its output's deviation."""
    from scipy.signal import lfilter

    uf = lfilter([1.0], denominator, u)
    rows, right = [], []
    for channel, y in enumerate(outputs):
        yf = lfilter([1.0], denominator, y)
        block = np.zeros((len(y), 6))  # a1, a2, and two taps for each channel
        block[:, 0], block[:, 1] = -_delayed(yf, 1), -_delayed(yf, 2)
        block[:, 2 + 2 * channel], block[:, 3 + 2 * channel] = _delayed(uf, 1), _delayed(uf, 2)
        deviation = float(np.std(y)) or 1.0
        rows.append(block / deviation)
        right.append(yf / deviation)
    stacked = np.vstack(rows)
    size = np.linalg.norm(stacked, axis=0)
    size[size == 0.0] = 1.0
    solution = np.linalg.lstsq(stacked / size, np.concatenate(right), rcond=None)[0] / size
    return np.array([1.0, *solution[:2]]), solution[2:].reshape(2, 2)


def _delayed(x: Floats, by: int) -> Floats:
    return np.concatenate([np.zeros(by), x[:-by]])


def _stable(a: Floats) -> Floats:
    """The polynomial with roots outside the unit circle reflected into it."""
    roots = np.roots(a)
    outside = np.abs(roots) > 1.0
    roots[outside] = 1.0 / np.conj(roots[outside])
    return np.asarray(np.real(np.poly(roots)))


def motor_of(a: Floats, b: Floats, period_s: float) -> dict[str, float]:
    """R, L, K, B, J of the discrete system. Raises DataError if it is no motor's."""
    from scipy.linalg import logm

    h1 = b[:, 0]  # Markov parameters of (current, speed): h_k = Ad^(k-1) Bd
    h2 = b[:, 1] - a[1] * h1
    h3 = -a[1] * h2 - a[2] * h1
    augmented = np.eye(3)
    try:
        augmented[:2, :2] = np.column_stack([h2, h3]) @ np.linalg.inv(np.column_stack([h1, h2]))
        augmented[:2, 2] = h1
        continuous = np.asarray(logm(augmented)) / period_s
    except np.linalg.LinAlgError as error:
        raise DataError("Steiglitz-McBride: current and speed do not make a state") from error
    if np.abs(continuous.imag).max() > 1e-6 * np.abs(continuous.real).max():
        raise DataError("Steiglitz-McBride found a system that no motor has: sample faster")
    (a11, a12, b1), (a21, a22, _), _ = continuous.real.tolist()
    L = 1.0 / b1
    K = -a12 * L
    J = K / a21
    values = {"R": -a11 * L, "L": L, "K": K, "B": -a22 * J, "J": J}
    wrong = [name for name, value in values.items() if not value > 0]
    if wrong:
        raise DataError(
            f"Steiglitz-McBride found {wrong[0]} = {values[wrong[0]]:.3g}, which no motor has: its "
            "model lacks Coulomb friction, delays and noise of the voltage; use the method ml"
        )
    return values
