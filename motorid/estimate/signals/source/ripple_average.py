"""How the motor's current runs within intervals and PWM periods, and what bends with it.

A brush's drop at the mean current is not the mean of the drop: the current swings within every PWM
period, rises within the first intervals of a part, and with diode decay flows in pulses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.signals.source.current_transient import Rise
from motorid.estimate.signals.source.pwm_bridge import DIODE_DROPS_V, STRAIGHT, driven_share, ripple
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay

Floats = NDArray[np.float64]

_NODES, _WORTH = np.polynomial.legendre.leggauss(16)
PLACES, WEIGHTS = (_NODES + 1.0) / 2.0, _WORTH / 2.0  # of a mean from 0 to 1
STEPS = 5  # of Newton's method
TINY_A = 1e-12


@dataclass(frozen=True)
class Flow:
    """The current: its mean (count,) over every interval, how it swings within PWM periods, and how
    it rises within the first intervals of a part.
    """

    mean: Floats
    swings: tuple[Swing, ...] = ()
    rises: tuple[Rise, ...] = ()

    @classmethod
    def of(
        cls,
        capture: Capture,
        parts: Sequence[Part],
        mean: Floats,
        inductance_h: float,
        resistance_ohm: float,
        rises: Sequence[Rise] = (),
        emf: Floats | None = None,
    ) -> Flow:
        """That of a motor whose mean current is known, and its back-EMF (count,), None: little."""
        found = []
        for part in parts:
            against = np.zeros(part.stop - part.start) if emf is None else emf[part.slice]
            found.append(Swing.of(capture, part, inductance_h, resistance_ohm, against))
        return cls(mean, tuple(swing for swing in found if swing is not None), tuple(rises))

    def saturation(self, bend: float) -> tuple[Floats, Floats]:
        """Means (count,) over an interval of s = i/hypot(i, ``bend``) and of ds/d ln bend."""
        share, bending = _saturation(self.mean, bend)
        swings = {swing.part.start: swing for swing in self.swings}
        for swing in self.swings:
            here = swing.part.slice
            share[here], bending[here] = swing.saturation(self.mean[here], bend)
        for rise in self.rises:
            shown, own = rise.amperes.ravel(), swings.get(rise.part.start)
            both = own.saturation(shown, bend) if own is not None else _saturation(shown, bend)
            share[rise.where], bending[rise.where] = (rise.mean(one) for one in both)
        return share, bending


def _saturation(current: Floats, bend: float) -> tuple[Floats, Floats]:
    """s and ds/d ln ``bend`` at currents (n,)."""
    size = np.hypot(current, bend)
    share = current / size
    return share, -share * (bend / size) ** 2


@dataclass(frozen=True)
class Swing:
    """How the current departs from its mean within the PWM periods of a part.

    ``deviations`` (m,) in A, each for its share of the period, ``weights`` (m,). ``pulses``: of a
    diode's current, where it stops.
    """

    part: Part
    deviations: Floats
    weights: Floats
    pulses: Pulses | None = None

    @classmethod
    def of(
        cls,
        capture: Capture,
        part: Part,
        inductance_h: float,
        resistance_ohm: float,
        emf: Floats,
    ) -> Swing | None:
        """Exponential rise and fall; None without ripple. ``emf`` (n,) is the part's."""
        below, above = ripple(capture, part, inductance_h, resistance_ohm)
        if not below + above > 0.0:
            return None
        rail = capture.supply_v
        duty, _ = driven_share(part, rail)
        decay = resistance_ohm / (inductance_h * capture.wiring.pwm_hz)
        rise = -below + (below + above) * _bent(decay * duty)
        fall = above - (below + above) * _bent(decay * (1.0 - duty))
        weights = np.concatenate([duty * WEIGHTS, (1.0 - duty) * WEIGHTS])
        side = 1.0 if part.level > 0 else -1.0
        pulses = None
        if part.decay == Decay.DIODE:
            floor = ((rail or 0.0) + DIODE_DROPS_V + side * emf) / resistance_ohm
            pulses = Pulses(side, duty, decay, np.maximum(floor, TINY_A))
        return cls(part, side * np.concatenate([rise, fall]), weights, pulses)

    def saturation(self, mean: Floats, bend: float) -> tuple[Floats, Floats]:
        """As ``Flow.saturation``, for the mean current (n,) of the part, or of its beginning."""
        current = mean[:, None] + self.deviations
        share, bending = (one @ self.weights for one in _saturation(current, bend))
        if self.pulses is not None:
            stops, pulsed, bent = self.pulses.saturation(mean, bend)
            share[stops], bending[stops] = pulsed[stops], bent[stops]
        return share, bending


@dataclass(frozen=True)
class Pulses:
    """A current that flows for a part of every PWM period only, ``side`` its sign.

    It rises for ``duty`` of the period and falls towards less than nothing by ``floor`` (n,) A, by
    ``decay`` time constants a period; both until it is zero.
    """

    side: float
    duty: float
    decay: float
    floor: Floats

    def saturation(self, mean: Floats, bend: float) -> tuple[NDArray[np.bool_], Floats, Floats]:
        """Where a ``mean`` (n,) makes it stop, and there what ``Flow.saturation`` asks for."""
        along = np.maximum(self.side * mean, 0.0)
        floor = self.floor if len(mean) == len(self.floor) else np.full(len(mean), self.floor[0])
        rising = self.decay * self.duty
        a = rising / -math.expm1(-rising)
        peak = _peak(a, self.decay * along / floor)
        falling = np.log1p(peak)
        flows = self.duty + falling / self.decay
        rise = np.outer(peak * floor, _bent(rising))
        far = np.maximum(falling, TINY_A)[:, None]
        fall = (peak * floor)[:, None] * (1.0 - np.expm1(-far * PLACES) / np.expm1(-far))
        over = [
            self.duty * (up @ WEIGHTS) + falling / self.decay * (down @ WEIGHTS)
            for up, down in zip(_saturation(rise, bend), _saturation(fall, bend), strict=True)
        ]
        return flows < 1.0, self.side * over[0], self.side * over[1]


def _peak(a: float, charge: Floats) -> Floats:
    """x (n,) of a x - ln(1 + x) = charge (n,), by Newton from where a parabola has it."""
    x = 1.0 - a + np.sqrt((a - 1.0) ** 2 + 2.0 * charge)
    for _ in range(STEPS):
        x = np.maximum(x - (a * x - np.log1p(x) - charge) / (a - 1.0 / (1.0 + x) + TINY_A), 0.0)
    return np.asarray(x)


def _bent(decay: float) -> Floats:
    """How far (m,) an exponential of so many time constants has come at PLACES of its time."""
    if decay < STRAIGHT:
        return PLACES
    return np.asarray(np.expm1(-decay * PLACES) / np.expm1(-decay))
