"""The momentum balance of a motion, weighted by smooth bumps: linear rows without a derivative.

While the motor turns one way (s = ±1), drive = a dω/dt + b ω + c s + d. Multiplied by a bump φ(t)
and integrated by parts,

    ∫ φ drive dt = a ([φ ω] − ∫ φ' ω dt) + b ∫ φ ω dt + c s ∫ φ dt + d ∫ φ dt,

which is linear in a, b, c, d and differentiates no measurement (modulating functions; M. Shinbrot,
Trans. ASME 79, 1957). The drive (current, torque, volts) is noisy and stands alone on the left, so
that its noise does not bias the coefficients; the noise of the speed is averaged over the bump. One
that acts later by τ than its readings say has −τ ∫ φ' drive dt besides: a column for that delay.
Bumps are raised cosines a half-width apart, whole ones only: [φ ω] is then what little of a bump
lies between its end and the nearest sample.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.partial.mechanical_signals import Motion, Stretch

Floats = NDArray[np.float64]

COLUMNS = ("inertia", "viscous", "coulomb", "offset")
SQUARED = "friction that grows with the square of speed"
COASTING_PWM = ", or a PWM that lets the motor coast between its pulses"  # bends a speed as much
SQUARE, LATE = "square", "late"
TERMS = (SQUARE, LATE)  # that a balance may have beside: ω |ω| over the top speed, a delay in s
FEWEST_SAMPLES = 4  # that a bump must cover


@dataclass(frozen=True)
class Rows:
    """Rows of a linear regression, each divided by (∫φ² dt)½, so that white noise weighs all alike.

    ``shapes`` are further regressors, tried on residuals: the same bumps over functions of ω.
    ``late`` is what a second would add by which the drive acts later than it was taken to.
    """

    matrix: Floats  # (n, 4): by COLUMNS
    drive: Floats  # (n,)
    weight: Floats  # (n,): ∫φ dt / (∫φ² dt)½; drive / weight is a mean
    time_s: Floats  # (n,): centre of the bump
    stretch: NDArray[np.int64]  # (n,): which stretch of motion the row is from
    capture: NDArray[np.int64]  # (n,)
    shapes: Floats  # (n, len(SHAPES))
    late: Floats  # (n,)

    def __len__(self) -> int:
        return len(self.drive)

    def only(self, keep: NDArray[np.bool_]) -> Rows:
        """Those rows."""
        return Rows(*(getattr(self, name)[keep] for name in self.__dataclass_fields__))

    def beside(self, *terms: str) -> Rows:
        """With columns for TERMS behind those of COLUMNS."""
        if not terms:
            return self
        known = {SQUARE: self.shapes[:, 0], LATE: self.late}
        more = [known[term] for term in terms]
        return replace(self, matrix=np.column_stack([self.matrix, *more]))


SHAPES = (
    SQUARED,
    "viscous friction that differs with direction",
    "friction that is higher at low speed (Stribeck)",
)


def _shapes(speed: Floats, top: float) -> Floats:
    """Functions of ω in the units of ω, shape (3, n)."""
    slow = np.sign(speed) * np.exp(-np.abs(speed) / (0.05 * top))
    return np.stack([speed * np.abs(speed) / top, np.abs(speed), top * slow])


def build(motions: Sequence[Motion], half_width_s: float) -> Rows:
    """Rows of all stretches of all captures, for bumps of about that half-width."""
    found: list[Rows] = []
    number = 0
    for index, motion in enumerate(motions):
        speed = motion.speed(half_width_s)
        for stretch in motion.stretches(half_width_s):
            rows = _of_stretch(motion, stretch, speed, half_width_s, number, index)
            if len(rows):
                found.append(rows)
                number += 1
    if not found:
        none, no_number = np.zeros(0), np.zeros(0, dtype=np.int64)
        shapes = np.zeros((0, len(SHAPES)))
        return Rows(np.zeros((0, 4)), none, none, none, no_number, no_number, shapes, none)
    names = Rows.__dataclass_fields__
    return Rows(*(np.concatenate([getattr(rows, name) for rows in found]) for name in names))


def _of_stretch(
    motion: Motion, stretch: Stretch, speed: Floats, half_width_s: float, number: int, index: int
) -> Rows:
    time = motion.time_s[stretch.slice]
    length = float(time[-1] - time[0])
    bumps = max(round(length / half_width_s), 1)
    half = length / bumps
    lines = []
    for k in range(1, bumps):
        centre = time[0] + k * half
        line = _line(motion, stretch, speed, centre, half)
        if line is not None:
            lines.append((centre, *line))
    n = len(lines)
    return Rows(
        np.array([line[1] for line in lines]).reshape(n, 4),
        np.array([line[2] for line in lines]),
        np.array([line[3] for line in lines]),
        np.array([line[0] for line in lines]),
        np.full(n, number, dtype=np.int64),
        np.full(n, index, dtype=np.int64),
        np.array([line[4] for line in lines]).reshape(n, len(SHAPES)),
        np.array([line[5] for line in lines]),
    )


def _line(
    motion: Motion, stretch: Stretch, speed: Floats, centre: float, half: float
) -> tuple[Floats, float, float, Floats, float] | None:
    """One row: its regressors, drive, weight, shapes and what a later drive would add; None where a
    bump covers too little.
    """
    time = motion.time_s
    ends = np.searchsorted(time, [centre - half, centre + half + 1e-12])
    a, b = max(int(ends[0]), stretch.start), min(int(ends[1]), stretch.stop)
    if b - a < FEWEST_SAMPLES:
        return None
    at, middle, step = time[a:b], motion.middle_s[a : b - 1], np.diff(time[a:b])
    phi = 0.5 * (1 + np.cos(np.pi * (at - centre) / half))
    phi_mid = 0.5 * (1 + np.cos(np.pi * (middle - centre) / half))
    slope_mid = -0.5 * np.pi / half * np.sin(np.pi * (middle - centre) / half)
    turned = motion.turned[a : b - 1]
    driven = _driven(motion, a, b, centre, half)
    if driven is None:
        return None
    area = float(step @ (phi[1:] + phi[:-1])) / 2
    scale = float(np.sqrt(step @ phi_mid**2))
    ends_term = phi[-1] * speed[b - 1] - phi[0] * speed[a]
    shapes = _shapes(speed[a:b], motion.top_speed) * phi
    regressors = np.array(
        [ends_term - slope_mid @ turned, phi_mid @ turned, stretch.sign * area, area]
    )
    return (
        regressors / scale,
        driven[0] / scale,
        area / scale,
        (shapes[:, 1:] + shapes[:, :-1]) @ step / 2 / scale,
        driven[1] / scale,
    )


def _driven(
    motion: Motion, a: int, b: int, centre: float, half: float
) -> tuple[float, float] | None:
    """∫ φ drive dt and −∫ φ' drive dt: over the samples ``a`` to ``b`` of a bump or, where the
    drive acts later or earlier, over those that then lie in it. None where some of these lack.
    """
    time, late = motion.time_s, motion.drive_late_s
    if late:
        begin, end = centre - half - late, centre + half - late
        slack = motion.period_s
        if begin < time[0] - slack or end > time[-1] + slack:
            return None
        a, b = map(int, np.searchsorted(time, [begin, end + 1e-12]))
        if b - a < FEWEST_SAMPLES or motion.broken[a : b - 1].any():
            return None
    at, step = time[a:b] + late, np.diff(time[a:b])
    phase = np.pi * (at - centre) / half
    bump = 0.5 * (1 + np.cos(phase)) * motion.drive[a:b]
    later = 0.5 * np.pi / half * np.sin(phase) * motion.drive[a:b]
    return float(step @ (bump[1:] + bump[:-1])) / 2, float(step @ (later[1:] + later[:-1])) / 2
