"""A log's voltage freed of noise, which would drive the model, but not of its jumps and bends.

About each reading the widest window is sought in which the readings leave a parabola by no more
than they scatter; the parabola of its inner half, which bends a sixteenth as much, takes the
reading's place. Beside a jump no window about a reading is wide. There it is taken from one that
lies to its side and agrees with it: what follows a jump tells the inductance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.voltage_jumps import jumps, scatter

Floats = NDArray[np.float64]
Places = NDArray[np.intp]

HALF_WINDOWS = (4, 8, 16, 32, 64, 128)  # samples
BY_CHANCE = 3.0  # standard deviations of noise's variance about a parabola: more is a bend
STRAIGHT = 1.5  # of that variance: no more about one that a reading lies to the side of
WORTH = 0.5  # of a reading's variance: a window to its side must leave less


@dataclass(frozen=True)
class Windows:
    """Of each reading (n,): ``half`` so many are on either side of the middle of its parabola, 0:
    it stays as it is; the middle lies ``ahead`` of it by so many.
    """

    half: Places
    ahead: Places


def calm_windows(volts: Floats) -> Windows:
    """Windows of readings (n,) in which they follow a parabola."""
    deviation, count = scatter(volts), len(volts)
    halves = [half for half in HALF_WINDOWS if deviation and 2 * half < count]
    spread = {half: _spread(volts, half) for half in halves}
    found = Windows(np.zeros(count, dtype=np.intp), np.zeros(count, dtype=np.intp))
    left = np.ones(count)  # of each reading's variance
    for half in halves:  # the widest has the last word
        calm = _calm(spread[half], half, deviation)
        found.half[calm] = half // 2
        left[calm] = _share(half // 2, 0)
    room = _room(volts)
    for half in halves:
        ahead, inside = _beside(_calm(spread[half], half, deviation, STRAIGHT), half)
        share = _share(half // 2, ahead)
        take = np.flatnonzero(inside & (room < half) & (share < WORTH * left))
        off = volts[take] - _at(volts, half // 2, take, ahead[take])
        take = take[np.abs(off) < BY_CHANCE * deviation * np.sqrt(1.0 + share[take])]
        found.half[take], found.ahead[take], left[take] = half // 2, ahead[take], share[take]
    return found


def smoothed(volts: Floats, windows: Windows) -> Floats:
    """Readings (n,) by the parabola of each one's window."""
    out = volts.copy()
    for half in np.unique(windows.half[windows.half > 0]).tolist():
        here = np.flatnonzero(windows.half == half)
        out[here] = _at(volts, half, here, windows.ahead[here])
    return out


def _at(volts: Floats, half: int, here: Places, ahead: Places) -> Floats:
    """What parabolas say of readings (k,) whose middles lie so many ahead of them."""
    each = np.array(_parabolas(volts, half))[:, here + ahead - half]
    return np.asarray(each[0] - each[1] * ahead + each[2] * ahead**2)


def _calm(spread: Floats, half: int, deviation: float, most: float = math.inf) -> NDArray[np.bool_]:
    """Readings (n,) about which so many on either side leave a parabola by no more than noise, and
    no more than ``most`` times its variance; ``spread`` (n - 2 half,): what they leave.
    """
    most = min(most, 1.0 + BY_CHANCE / math.sqrt(half - 1))
    return np.pad(spread <= most * deviation**2, half)


def _room(volts: Floats) -> Places:
    """How many readings lie between each (n,) and the next jump on either side."""
    at, edges = np.arange(len(volts)), np.r_[-len(volts), jumps(volts), 2 * len(volts)]
    after = np.searchsorted(edges, at, side="right")
    return np.asarray(np.minimum(at - edges[after - 1], edges[after] - 1 - at), dtype=np.intp)


def _beside(calm: NDArray[np.bool_], half: int) -> tuple[Places, NDArray[np.bool_]]:
    """Of readings (n,): by how much the middle of half the nearest calm window lies ahead, where
    that is moved towards it as far as the window reaches; and whether it is in the window.
    """
    at, middles = np.arange(len(calm)), np.flatnonzero(calm)
    if not len(middles):
        return np.zeros(len(calm), dtype=np.intp), calm
    after = np.searchsorted(middles, at)
    before = middles[np.maximum(after - 1, 0)]
    after = middles[np.minimum(after, len(middles) - 1)]
    far = np.where(np.abs(before - at) <= np.abs(after - at), before, after) - at
    ahead = np.sign(far) * np.maximum(np.abs(far) - half // 2, 0)
    return ahead.astype(np.intp), np.abs(far) <= half


def _share(half: int, ahead: Places | int) -> Floats:
    """Of a reading's variance, that of the parabola's value so far from its middle."""
    place, bend = _basis(half)
    at = np.asarray(ahead, dtype=np.float64)
    slopes, bends = at**2 / (place @ place), (at**2 + bend[half]) ** 2 / (bend @ bend)
    return np.asarray(1.0 / len(place) + slopes + bends)


def _parabolas(volts: Floats, half: int) -> tuple[Floats, Floats, Floats]:
    """Through every window of 2·half + 1 readings a parabola: its value, slope and bend in the
    middle.
    """
    place, bend = _basis(half)
    mean = float(volts.mean())
    level = mean + np.correlate(volts - mean, np.full(len(place), 1.0 / len(place)))
    slopes = np.correlate(volts - mean, place) / (place @ place)
    bends = np.correlate(volts - mean, bend) / (bend @ bend)
    return level + bends * bend[half], slopes, bends


def _spread(volts: Floats, half: int) -> Floats:
    """Variance (n - 2 half,) that a parabola leaves of each window of 2·half + 1 readings."""
    place, bend = _basis(half)
    off, each = volts - volts.mean(), np.ones(len(place))
    left = np.correlate(off**2, each) - np.correlate(off, each) ** 2 / len(place)
    for basis in (place, bend):
        left -= np.correlate(off, basis) ** 2 / (basis @ basis)
    return np.asarray(left / (len(place) - 3))


def _basis(half: int) -> tuple[Floats, Floats]:
    """A slope and a bend over 2·half + 1 readings, which are in no way alike."""
    place = np.arange(-half, half + 1.0)
    return place, place**2 - (place**2).mean()
