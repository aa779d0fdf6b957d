"""How the current runs within the first intervals of a part, where it changes much in each.

What bends with the current (a brush's drop, a dead time's loss) takes more at the end of such an
interval than at its beginning. From one command to the next the current is nearly an exponential
of L/R, so that its mean over an interval and its end tell all of it. The fit is given one voltage
an interval: the one that moves the current's own reading as what is lost does, and that has half
forgotten what was lost long before.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.estimate.signals.source.pwm_bridge import ripple
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay

Floats = NDArray[np.float64]

QUICKEST, SLOWEST = 0.01, 1e6  # L/R in intervals: as good as none, and as a straight rise
PLACES = (np.arange(16) + 0.5) / 16  # of an interval


@dataclass(frozen=True)
class Rise:
    """The current (k, 16), in A, at PLACES of the first k intervals of ``part``.

    ``weights`` (16,): how much each place is worth to a reading of the current.
    """

    part: Part
    amperes: Floats
    weights: Floats

    @property
    def where(self) -> slice:
        """Its intervals."""
        return slice(self.part.start, self.part.start + len(self.amperes))

    def at(self, places: Floats) -> Floats:
        """The current (k, m) at other places (m,) of the same intervals."""
        return np.array([np.interp(places, PLACES, one) for one in self.amperes])

    def mean(self, lost: Floats) -> Floats:
        """Of what is lost at all the places, (k * 16,), that of every interval, (k,)."""
        return np.asarray(lost.reshape(self.amperes.shape) @ self.weights)


def rises(
    capture: Capture,
    parts: Sequence[Part],
    mean: Floats,
    end: Floats,
    inductance_h: float,
    resistance_ohm: float,
) -> Iterator[Rise]:
    """Those of all parts but the first, of a current whose ``mean`` over every interval and whose
    ``end`` there, (count,), are known but for the ripple.

    A command changes the ripple but not the current, so that it changes the mean: by the difference
    of how far below it a period begins, which is forgotten like any other current.
    """
    if not inductance_h > 0.0 or not resistance_ohm > 0.0:
        return
    tau = inductance_h / resistance_ohm / capture.period_s
    tau = min(max(tau, QUICKEST), SLOWEST)
    rest, last = np.exp(-PLACES / tau), np.exp(-1.0 / tau)
    shape = (rest - last) / (rest.mean() - last)
    weights = _worth(capture, tau)
    since = np.arange(HEAD)[:, None] + PLACES
    for earlier, part in pairwise(parts):
        here = slice(part.start, min(part.start + HEAD, part.stop))
        amperes = end[here, None] + (mean - end)[here, None] * shape
        if not part.open:
            jump = swing_at_start(capture, part, inductance_h, resistance_ohm)
            jump -= swing_at_start(capture, earlier, inductance_h, resistance_ohm)
            amperes += jump * np.exp(-since[: len(amperes)] / tau)
        yield Rise(part, amperes, weights)


def moving(mean: Floats, risen: Sequence[Rise]) -> Floats:
    """The ``mean`` current (count,) over intervals, of ``risen`` ones as it moves a reading."""
    moved = mean.copy()
    for rise in risen:
        moved[rise.where] = rise.mean(rise.amperes.ravel())
    return moved


def swing_at_start(
    capture: Capture, part: Part, inductance_h: float, resistance_ohm: float
) -> float:
    """A that the current is below its mean where the PWM periods of a part begin."""
    if part.discontinuous:
        return 0.0
    below, above = ripple(capture, part, inductance_h, resistance_ohm)
    if part.level > 0:
        return below
    return above if part.decay == Decay.FAST else -below


def _worth(capture: Capture, tau: float) -> Floats:
    """Of the places, (16,), to a reading of the current in the same interval; their sum is 1."""
    channel = capture.get(CURRENT)
    late_s, wide_s = (0.0, 0.0) if channel is None else (channel.delay_s, channel.window_s)
    read = (1.0 - (late_s + wide_s * PLACES) / capture.period_s) % 1.0
    since = read[:, None] - PLACES
    worth = np.where(since > 0.0, np.exp(-np.maximum(since, 0.0) / tau), 0.0).sum(axis=0)
    return np.asarray(worth / worth.sum() if worth.sum() else np.full(len(PLACES), 1 / len(PLACES)))
