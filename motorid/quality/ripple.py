"""What repeats with the rotor's angle: commutation ripple, segments, friction over a turn.

Everything is found in what the smooth model leaves of current and position while the motor runs
steadily: a fit's residuals, and what the fit itself gives to the rotor's angle. Angles count from
where the run began. Ripple is given as the relative ripple of the voltage that would cause it,
amplitude x R / V. Torque over a turn follows from current and motion together:
T_k = K I_k + J (k w)² Θ_k for order k of a turn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION
from motorid.estimate.results.estimate import Curve, Estimate

Floats = NDArray[np.float64]
TURN_ORDERS = (1, 2, 3, 4)
FRICTION_ORDERS = (1, 2)
LEAST_TURNS = 2.0
LEAST_SAMPLES = 64
STEP_SHARE = 0.05  # of the largest current, between samples: a step of the program
STEP_REACH = 5  # samples to each side of one that are left out
NEAR = 0.05  # of the speed that a stretch ends with
OPEN_SHARE = 1e-3  # of the largest current: less than this is an open bridge
SLOW = 31  # samples over which a mean is slow
BUSY = 0.2  # of the largest current: where a brush has current to interrupt


@dataclass(frozen=True)
class Window:
    """A stretch of steady running. ``current`` and ``position``: less the smooth model's, (n,)."""

    angle: Floats  # rad
    current: Floats  # A
    position: Floats  # rad
    level: float  # V
    mean_current: float  # A
    speed: float  # rad/s, signed


@dataclass(frozen=True)
class Harmonics:
    """Complex amplitudes by order, of residual current (A) and position (rad), with deviations."""

    current: Mapping[int, complex]
    position: Mapping[int, complex]
    current_sd: float
    position_sd: float
    rest: Floats  # of the current, when the orders are taken out


def windows(estimate: Estimate) -> tuple[Window, ...]:
    """The steady stretches that have current and position and turn often enough.

    Steady is: one voltage, by the fit's R i + K w, and a speed near the one it ends with.
    """
    curves = {(c.capture, c.channel): c for c in estimate.curves}
    R, K = (estimate.parameters[n].value for n in ("R", "K"))
    found: list[Window] = []
    for run in range(len(estimate.inputs)):
        current, position = (curves.get((run, n)) for n in (CURRENT, POSITION))
        if current is not None and position is not None and R is not None and K is not None:
            found += _of_run(current, position, R, K)
    return tuple(found)


def _of_run(current: Curve, position: Curve, R: float, K: float) -> list[Window]:
    time = current.time_s
    angle = np.interp(time, position.time_s, position.measured)
    left = np.interp(time, position.time_s, position.measured - position.smooth)
    speed = np.gradient(np.interp(time, position.time_s, position.smooth), time)
    amps = current.smooth - _open_current(current)
    volts = R * amps + K * speed
    largest = float(np.abs(volts).max())
    driven = np.abs(amps) > OPEN_SHARE * float(np.abs(amps).max())
    breaks = np.abs(np.diff(volts)) > STEP_SHARE * largest
    breaks |= driven[1:] != driven[:-1]
    edges = [0, *(np.flatnonzero(breaks) + 1), len(time)]
    found = []
    for start, stop in pairwise(edges):
        if stop - start < LEAST_SAMPLES or not driven[start:stop].all():
            continue
        end = speed[stop - 2]
        near = np.abs(speed[start:stop] - end) < NEAR * abs(end)
        first = start + int(np.flatnonzero(~near)[-1] + 1 if not near.all() else 0)
        part = slice(max(first, start + STEP_REACH), stop - 1)
        enough = part.stop - part.start >= LEAST_SAMPLES
        if not enough or abs(np.ptp(angle[part])) < LEAST_TURNS * 2 * np.pi:
            continue
        found.append(
            Window(
                angle[part], (current.measured - current.smooth)[part], left[part],
                float(np.median(volts[part])), float(amps[part].mean()),
                float(speed[part].mean()),
            )
        )  # fmt: skip
    return found


def _open_current(current: Curve) -> float:
    """What the fit reads with the bridge open: the offset, the value it takes most often."""
    values, counts = np.unique(np.round(current.smooth, 9), return_counts=True)
    often = int(np.argmax(counts))
    return float(values[often]) if counts[often] >= STEP_REACH else 0.0


def harmonics(window: Window, orders: Sequence[int]) -> Harmonics:
    """Least squares of both residuals on the orders, beside a cubic of time: what the model
    leaves is slower than a turn, and no noise.
    """
    n = len(window.angle)
    drift = np.linspace(-1.0, 1.0, n)
    waves = [f(k * window.angle) for k in orders for f in (np.cos, np.sin)]
    design = np.column_stack([np.ones(n), drift, drift**2, drift**3, *waves])
    both = np.column_stack([window.current, window.position])
    found = np.linalg.solve(design.T @ design, design.T @ both)  # orthogonal enough, and quick
    rest = both - design @ found
    freedom = max(n - design.shape[1], 1)
    deviations = np.sqrt((rest**2).sum(axis=0) / freedom * 2.0 / n)  # of an amplitude

    def amplitudes(column: int) -> dict[int, complex]:
        pairs = found[4:, column].reshape(-1, 2)
        return {k: complex(a, -b) for k, (a, b) in zip(orders, pairs, strict=True)}

    return Harmonics(
        amplitudes(0), amplitudes(1), float(deviations[0]), float(deviations[1]), rest[:, 0]
    )


def relative_ripple(
    found: Sequence[Window], resistance: float, orders: Sequence[int], among: Sequence[int]
) -> tuple[float, float, int]:
    """The largest amplitude among ``among``, its deviation, and its order.

    Mean over the windows of each amplitude; all ``orders`` are fitted.
    """
    amplitudes = np.zeros(len(among))
    variance = 0.0
    for window in found:
        h, scale = harmonics(window, orders), resistance / abs(window.level)
        amplitudes += [abs(h.current[k]) * scale / len(found) for k in among]
        variance += (h.current_sd * scale / len(found)) ** 2
    worst = int(np.argmax(amplitudes))
    return float(amplitudes[worst]), float(np.sqrt(variance)), among[worst]


def segment_ripple(
    found: Sequence[Window], resistance: float, segments: int
) -> tuple[float, float, int]:
    """The segment that departs most from the others: relative ripple, deviation, its number from 0.

    Means of the current over each segment's angle, against the motion: more current is positive.
    """
    total, count = np.zeros(segments), np.zeros(segments)
    spread = 0.0
    for window in found:
        scale = resistance / window.level
        own = (window.current - window.current.mean()) * scale
        place = np.floor(window.angle * segments / (2 * np.pi)).astype(np.int64) % segments
        total += np.bincount(place, own, segments)
        count += np.bincount(place, minlength=segments)
        spread += float((own**2).sum())
    means = total / np.maximum(count, 1)
    typical = np.median(means)
    worst = int(np.argmax(np.abs(means - typical)))
    noise = np.sqrt(spread / count.sum() / max(count[worst], 1))
    return float(abs(means[worst] - typical)), float(noise), worst


@dataclass(frozen=True)
class TurnTorque:
    """Torque over a turn, N·m: peak to peak of its variation, and what both directions share."""

    peak_to_peak: float
    peak_to_peak_sd: float
    unbalance: float
    unbalance_sd: float


def turn_torque(found: Sequence[Window], constant: float, inertia: float) -> TurnTorque:
    """Torque variation by ``FRICTION_ORDERS``; order 1 that keeps its sign is an unbalance."""
    grid = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)
    widest = widest_sd = 0.0
    once: list[complex] = []
    variances: list[float] = []
    for window in found:
        h = harmonics(window, TURN_ORDERS)
        stiffness = {k: inertia * (k * window.speed) ** 2 for k in FRICTION_ORDERS}
        torque = {k: constant * h.current[k] + stiffness[k] * h.position[k] for k in stiffness}
        wave = sum(np.real(t * np.exp(1j * k * grid)) for k, t in torque.items())
        noise = [np.hypot(constant * h.current_sd, s * h.position_sd) for s in stiffness.values()]
        span = float(np.ptp(np.asarray(wave)))
        if span > widest:
            widest, widest_sd = span, 2.0 * float(np.hypot(*noise))
        once.append(torque[1])
        variances.append(float(noise[0]) ** 2)
    weights = 1.0 / np.maximum(np.array(variances), 1e-30)
    shared = abs((np.array(once) * weights).sum() / weights.sum())
    return TurnTorque(widest, widest_sd, float(shared), float(1.0 / np.sqrt(weights.sum())))


def brush_noise(curve: Curve) -> tuple[float, float]:
    """Scatter of the current where much flows, relative to that current; its deviation.

    Rms of what is quicker than ``SLOW`` samples in the residual, so that the model's own slow
    errors do not count; steps of the program are left out.
    """
    if len(curve.fitted) < LEAST_SAMPLES:
        return float("nan"), float("nan")
    largest = float(np.abs(curve.fitted).max())
    jumps = np.abs(np.diff(curve.fitted, prepend=curve.fitted[0])) > STEP_SHARE * largest
    near = np.convolve(jumps, np.ones(2 * STEP_REACH + 1), mode="same") > 0
    use = (np.abs(curve.fitted) > BUSY * largest) & ~near
    box = np.ones(SLOW)
    residual = np.where(use, curve.measured - curve.fitted, 0.0)
    around = np.convolve(use, box, mode="same")
    slow = np.convolve(residual, box, mode="same") / np.maximum(around, 1.0)
    use &= around > 0.5 * SLOW
    n = int(use.sum())
    if n < LEAST_SAMPLES:
        return float("nan"), float("nan")
    rms = float(np.sqrt((((residual - slow)[use] / curve.fitted[use]) ** 2).mean()))
    return rms, rms / float(np.sqrt(n))
