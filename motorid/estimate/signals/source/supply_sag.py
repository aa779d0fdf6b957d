"""A supply that gives way: behind a resistance, with a capacitor that answers first.

The current that the bridge draws pulls the supply down by Rs of it, and the capacitor Cs lets that
come late by Rs Cs. After a command the current changes much within a few samples, so that the
source's voltage is another in each, while readings of it are noisy, and the first shows the command
before. Rs and Rs Cs are one for all parts of a capture: what the readings after every command do
beyond a line in the current tells them, and they tell the voltage of every interval.

A board that makes volts takes its duty from what the supply showed a sample ago. There a sag comes
through until the next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.source.current_transient import PLACES, Rise
from motorid.estimate.signals.source.pwm_bridge import signed_duty
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.time_grid import Part
from motorid.estimate.signals.voltage_window import Window
from motorid.estimate.solver.dense_products import dot, square
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]

LATENESS = tuple(0.1 * 1.8**k for k in range(11))  # Rs Cs in intervals that are tried, to 36
TELLING = 120  # intervals of a part that may tell; a later current has settled
SHORTEST = 24  # intervals of a part that tells
FORGOTTEN = 20.0  # times its lateness, after which a supply knows nothing of a current
CLEAR = 25.0  # chi-square by which a supply must explain the readings better


@dataclass(frozen=True)
class Sag:
    """V (n,) that a supply adds to the source of a part: over readings' windows and intervals.

    ``late``: intervals of the supply's lag.
    """

    shown: Floats
    taken: Floats
    late: float = 0.0


NO_SAG, NO_SAGS = Sag(np.zeros(1), np.zeros(1)), MappingProxyType[int, Sag]({})


@dataclass(frozen=True)
class Draw:
    """What a part draws from the supply, its ``share`` of the motor's current: A ``before`` the
    command, (8 * 16,) in its first intervals, and (TELLING - 8,) in those after.

    ``follows``: by how much of the supply's change its duty makes up, a sample later.
    """

    share: float
    follows: float
    before: float
    first: Floats
    after: Floats

    @classmethod
    def of(
        cls, part: Part, earlier: Part, rise: Rise, mean: Floats, rail: float | None
    ) -> Draw | None:
        """None where nothing tells it, or the current stops in every period."""
        share = _share(part, rail)
        if not share or part.discontinuous or part.stop - part.start < SHORTEST:
            return None
        follows = 0.0
        if part.kind == StepKind.DRIVE_VOLTS:
            follows = abs(signed_duty(part, rail)) * (2.0 if part.decay == Decay.DIODE else 1.0)
            follows = float(np.copysign(follows, part.level))
        before = 0.0 if earlier.open else _share(earlier, rail) * float(mean[part.start - 1])
        after = share * mean[part.start + HEAD : min(part.start + TELLING, part.stop)]
        after = np.pad(after, (0, TELLING - HEAD - len(after)), mode="edge")
        return cls(share, follows, before, share * rise.amperes.ravel(), after)

    def whole(
        self, rows: tuple[Floats, Floats], mean: Floats, late: float, window: Window
    ) -> tuple[Floats, Floats]:
        """V (n,) of a part for an ohm of a supply ``late`` by so many intervals, over the readings'
        windows and over the intervals, from ``rows`` of its first intervals (TELLING,) and the
        ``mean`` current (n,): commutation ripple draws as long as the motor turns.
        """
        drawn = self.share * mean
        forgets = np.exp(-np.arange(int(FORGOTTEN * late) + 2) / late)
        follows = np.convolve(drawn - self.before, forgets * (1.0 - np.exp(-1.0 / late)))
        begin = self.before + np.concatenate([[0.0], follows[: len(mean) - 1]])
        shown = _mean(drawn, begin, late, *_reach(window))
        given = self.follows * np.concatenate([[self.before], shown[:-1]])
        whole = given - self.share * shown, given - self.share * _mean(drawn, begin, late)
        for later, row in zip(whole, rows, strict=True):
            later[:TELLING] = row[: len(later)]
        return whole


def _share(part: Part, rail: float | None) -> float:
    """Of the motor's current, signed, that a part's command draws from the supply in the mean, and
    of the supply's voltage that the motor gets.
    """
    duty = signed_duty(part, rail)
    if part.decay == Decay.DIODE and duty:  # it flows back through the diodes for the rest
        return float(np.copysign(2.0 * abs(duty) - 1.0, duty))
    return duty


class Draws:
    """Those of several parts, and what a supply makes of them."""

    def __init__(self, draws: Sequence[Draw], window: Window, weights: Floats) -> None:
        self.window, self.weights = window, weights
        self.share = np.array([[draw.share] for draw in draws])
        self.follows = np.array([[draw.follows] for draw in draws])
        self.before = np.array([[draw.before] for draw in draws])
        self.first = np.array([draw.first for draw in draws])
        self.after = np.array([draw.after for draw in draws])

    def sags(self, late: float) -> tuple[Floats, Floats]:
        """V (parts, TELLING) for an ohm of a supply that comes ``late`` by so many intervals: over
        the readings' windows, and over the intervals as they move a reading of the current.
        """
        grid = len(PLACES)
        fine = np.hstack([self.before, self.first]) @ _behind(HEAD * grid, late * grid)
        first = _mean(self.first, fine[:, :-1], late * grid).reshape(-1, HEAD, grid)
        begin = np.hstack([fine[:, -1:], self.after]) @ _behind(TELLING - HEAD, late)
        start, stop = _reach(self.window)
        over = np.hstack([first @ self.weights, _mean(self.after, begin[:, :-1], late)])
        after = _mean(self.after, begin[:, :-1], late, start, stop)
        shown = np.hstack([first @ seen(self.window), after])
        given = self.follows * np.hstack([self.before, shown[:, :-1]])
        return given - self.share * shown, given - self.share * over


@lru_cache(maxsize=64)
def _behind(steps: int, late: float) -> Floats:
    """What follows a current by a lateness of so many steps: (1 + steps, 1 + steps), from where it
    is at the beginning and the current in each to where it is at the beginning of each and the end.
    """
    rest = np.exp(-1.0 / late)
    ago = np.arange(steps + 1)[None, :] - np.arange(steps + 1)[:, None]
    follows = np.where(ago >= 0, rest ** np.maximum(ago, 0), 0.0)
    follows[1:] *= 1.0 - rest
    return np.asarray(follows)


def _mean(
    current: Floats, begin: Floats, late: float, start: float = 0.0, stop: float = 1.0
) -> Floats:
    """Of what follows it, from ``start`` to ``stop`` of every step."""
    if stop <= start:
        return np.asarray(current + (begin - current) * np.exp(-stop / late))
    left = late * (np.exp(-start / late) - np.exp(-stop / late)) / (stop - start)
    return np.asarray(current + (begin - current) * left)


def _reach(window: Window) -> tuple[float, float]:
    """From where to where in its interval a reading sees."""
    stop = 1.0 - window.late_s / window.period_s
    return max(stop - window.aperture_s / window.period_s, 0.0), stop


def seen(window: Window) -> Floats:
    """The share (16,) of a reading that each of the places of its interval has."""
    start, stop = _reach(window)
    start = min(start, stop - 1e-3)
    inside = np.clip(np.linspace(0.0, 1.0, len(PLACES) + 1), start, stop)
    return np.asarray(np.diff(inside) / (stop - start))


def sags(
    window: Window,
    parts: Sequence[Part],
    open_circuit: Floats,
    shown: Floats,
    known: NDArray[np.bool_],
    mean: Floats,
    rises: Sequence[Rise],
    rail: float | None,
    before: Mapping[int, Sag] | None = None,
) -> Mapping[int, Sag]:
    """What the supply adds to the source of each part, by its place; none where no reading tells.

    ``before``: sags whose lag is kept, None: the readings decide.

    ``open_circuit`` (count,) is what the readings show of the source, ``known`` which are any,
    ``shown`` (count,) the current that they saw, ``mean`` that over the intervals.
    """
    by_start = {rise.part.start: rise for rise in rises}
    drawn = {
        k: draw
        for k in range(1, len(parts))
        if parts[k].start in by_start
        and (draw := Draw.of(parts[k], parts[k - 1], by_start[parts[k].start], mean, rail))
    }
    if window.lag or not drawn or (before is not None and not before):
        return NO_SAGS
    draws = Draws(tuple(drawn.values()), window, rises[0].weights)
    told = [_Told.of(open_circuit, shown, known, parts[k]) for k in drawn]
    variance = float(np.mean(np.concatenate([np.diff(t.left) ** 2 for t in told]))) / 2.0
    best = (CLEAR * variance if before is None else 0.0), 0.0, 0.0
    for late in LATENESS if before is None else (next(iter(before.values())).late,):
        tried = draws.sags(late)[0]
        sums = np.array([t.against(row) for t, row in zip(told, tried, strict=True)])
        weight, cross = sums.sum(axis=0)
        if cross > 0.0 and cross**2 / weight > best[0]:
            best = cross**2 / weight, cross / weight, late
    _, ohms, late = best
    if not ohms:
        return NO_SAGS
    found = {}
    for (k, draw), a, b in zip(drawn.items(), *draws.sags(late), strict=True):
        seen_v, taken_v = draw.whole((a, b), mean[parts[k].slice], late, window)
        found[k] = Sag(ohms * seen_v, ohms * taken_v, late)
    return found


@dataclass(frozen=True)
class _Told:
    """The first readings of a part, beyond their line in the current: what is ``left`` (m,), an
    orthonormal ``basis`` (m, 2) of lines, and which readings (n,) they are.
    """

    left: Floats
    basis: Floats
    kept: NDArray[np.bool_]

    @classmethod
    def of(cls, open_circuit: Floats, shown: Floats, known: NDArray[np.bool_], part: Part) -> _Told:
        """Of the intervals that may tell."""
        here = slice(part.start, min(part.start + TELLING, part.stop))
        kept = known[here] & np.isfinite(shown[here]) & np.isfinite(open_circuit[here])
        basis, _ = np.linalg.qr(np.vander(shown[here][kept], 2))
        volts = open_circuit[here][kept]
        return cls(volts - basis @ (basis.T @ volts), basis, kept)

    def against(self, row: Floats) -> tuple[float, float]:
        """A supply's V (TELLING,) squared beyond their own line, and times what is left."""
        volts = row[: len(self.kept)][self.kept]
        volts = volts - self.basis @ (self.basis.T @ volts)
        return square(volts), dot(volts, self.left)
