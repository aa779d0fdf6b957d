"""What the source of a part does beyond its line: a curve that is smooth after the head."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.solver.dense_products import dot, square

Floats = NDArray[np.float64]

ODD_HEAD = 2.5  # variance of the few samples after a step, over the noise's: still called noise
BLOCKS, SLOW = 8, 28.0  # stretches of a part, and chi-square of their means: 1 in 2,000 by noise
ODD_SAMPLE = 3.5  # standard deviations from the line of one of them
ALWAYS = 3  # first samples that depart even where noise hides it: what L is told by lies there
NEAR = 32  # samples that tell where the source was just before them
WINDOWS = (64, 32, 16, 8, 4)  # half-widths in samples
LINE, AS_READ = 0, -1  # in place of one: no curve, and no smoothing


@dataclass(frozen=True)
class Form:
    """What is decided of a part's source: ``half``, the half-width (samples) of the window of its
    curve, LINE without one or AS_READ; and ``head``, how many first samples depart from that.
    """

    half: int = LINE
    head: int = 0

    @property
    def quiet(self) -> bool:
        """Free of the readings' noise after the head."""
        return self.half != AS_READ


PLAIN = Form()


def trend_of(
    left: Floats, noise: float, allowed: float, declared: float = 0.0, form: Form | None = None
) -> tuple[Floats, Form]:
    """What the source does beyond its line, (n,), and its form: as given, or as the data ask for.

    It is as read when no window leaves only noise behind: its head is then judged by the
    ``declared`` variance of a reading, as what comes and goes is no noise.
    """
    late = left[HEAD:]
    half = form.half if form is not None else _half(late, noise, allowed)
    trend = np.zeros_like(left)
    if half != LINE:
        trend[HEAD:] = late if half == AS_READ else smoothed(late, half)
        trend[:HEAD] = _carried_back(late)
    if form is None:
        scatter = min(noise, declared or noise) if half == AS_READ else noise
        form = Form(half, _head(left[:HEAD] - trend[:HEAD], scatter))
    return trend, form


def _half(late: Floats, noise: float, allowed: float) -> int:
    """The smoothest that leaves only noise."""
    if square(late) / len(late) <= allowed and _slow(late) <= SLOW * noise:
        return LINE
    for half in WINDOWS:
        if 4 * half <= len(late) and square(late - smoothed(late, half)) / len(late) <= allowed:
            return half
    return AS_READ


def _head(odd: Floats, noise: float) -> int:
    out = np.flatnonzero(np.abs(odd) > ODD_SAMPLE * np.sqrt(noise))
    head = max(int(out[-1]) + 1 if len(out) else 0, ALWAYS)
    return HEAD if square(odd[head:]) > ODD_HEAD * noise * len(odd) else head


def _slow(late: Floats) -> float:
    """Sum of squares of the means of BLOCKS stretches, times their length: noise alone has BLOCKS
    times its variance.
    """
    length = len(late) // BLOCKS
    sums: Floats = late[: BLOCKS * length].reshape(BLOCKS, length) @ np.ones(length)
    return square(sums) / max(length, 1)


def _carried_back(late: Floats) -> Floats:
    """The head (HEAD,) on the straight line through the samples that follow it."""
    near = late[:NEAR]
    place: Floats = np.arange(len(near), dtype=np.float64) - (len(near) - 1) / 2
    slope = dot(place, near) / square(place)
    return np.asarray(near.mean() + slope * (np.arange(-HEAD, 0) - (len(near) - 1) / 2))


def smoothed(values: Floats, half: int) -> Floats:
    """Mean over ``half`` samples on either side, fewer at the ends."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    place = np.arange(len(values))
    low, high = np.maximum(place - half, 0), np.minimum(place + half + 1, len(values))
    return np.asarray((total[high] - total[low]) / (high - low))
