"""What the pulses of a diode's current tell of the inductance.

A current that stops within every PWM period begins each from nothing: it rises for the duty by the
supply less what opposes it (back-EMF, brushes), and falls by all of them and two diodes. Its mean
is then as good as inverse to L, whatever the sampling.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.source.pwm_bridge import DIODE_DROPS_V, signed_duty
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.solver.problem import Solution
from motorid.motor.reading import Output, Quantity

Floats = NDArray[np.float64]

FEWEST = 24  # intervals of a part that count
LEAST, MOST = 1e-3, 1e2  # L/R in PWM periods


@dataclass(frozen=True)
class Pulses:
    """Of a part of a run: ``mean`` current (A) and what opposes it (V), (n,), by the model.

    ``duty`` of every ``period_s`` at ``rail`` V and behind ``ohms`` in all.
    """

    mean: Floats
    against: Floats
    duty: float
    period_s: float
    rail: float
    ohms: float

    def mean_current(self, inductance_h: float) -> Floats:
        """A (n,) in the mean of pulses through that inductance."""
        charge = self._rising * self._on_s - self._falling * self._off_s(inductance_h)
        return np.asarray(charge / self.period_s)  # what the peak adds, the fall takes again

    def stops(self, inductance_h: float) -> bool:
        """Most of the pulses end before their periods do."""
        return float(np.median(self._on_s + self._off_s(inductance_h))) < self.period_s

    @property
    def _on_s(self) -> float:
        return self.duty * self.period_s

    @property
    def _rising(self) -> Floats:
        """A (n,) that the current rises towards."""
        return np.asarray(np.maximum(self.rail - self.against, 0.0) / self.ohms)

    @property
    def _falling(self) -> Floats:
        """A (n,) below nothing that it falls towards."""
        opposed = self.rail + DIODE_DROPS_V + self.against
        return np.asarray(np.maximum(opposed, DIODE_DROPS_V) / self.ohms)

    def _off_s(self, inductance_h: float) -> Floats:
        tau = inductance_h / self.ohms
        peak = -self._rising * math.expm1(-self._on_s / tau)
        return np.asarray(tau * np.log1p(peak / self._falling))


def inductance(records: Sequence[MotorRecord], solution: Solution) -> float | None:
    """H by which the pulses of all records are as large as the current is; None: there are none."""
    each = zip(records, solution.own, strict=True)
    found = [one for record, own in each for one in pulses_of(record, solution.values, own)]
    inductance_h = _as_large(found)
    kept = [one for one in found if inductance_h and one.stops(inductance_h)]
    return inductance_h if len(kept) == len(found) else _as_large(kept)


def _as_large(found: Sequence[Pulses]) -> float | None:
    if not found:
        return None

    def too_large(log_h: float) -> float:
        at = math.exp(log_h)
        return float(sum((one.mean_current(at) - one.mean).sum() for one in found))

    per_ohm = found[0].ohms * found[0].period_s
    low, high = math.log(LEAST * per_ohm), math.log(MOST * per_ohm)
    if too_large(low) <= 0.0 or too_large(high) >= 0.0:
        return None
    from scipy.optimize import brentq  # rarely needed, and slow to load

    return math.exp(float(brentq(too_large, low, high, xtol=1e-4)))


def pulses_of(record: MotorRecord, shared: Floats, own: Floats) -> list[Pulses]:
    """Of every part of a record in which the voltage shows a current that stops.

    Whatever an inductance that is wrong made of the part since.
    """
    parts = [part for part in record.shown_parts if part.discontinuous]
    pwm_hz, rail = record.capture.wiring.pwm_hz, record.capture.supply_v
    if not parts or not pwm_hz or not rail:
        return []
    period_s = record.timeline.period_s
    over = [Output(Quantity.SPEED, period_s), Output(Quantity.CURRENT, period_s)]
    speed, current = record.runs(shared, own, over)
    constant = record.emf_constant(shared)
    source = max((s.ohms for s in record.sources if s is not None), default=0.0)
    ohms = float(record.motor(shared)[0]) + record.sensed.series_ohm + source
    found = []
    for part in parts:
        late, side = slice(part.start + HEAD, part.stop), math.copysign(1.0, part.level)
        if part.stop - part.start - HEAD >= FEWEST:
            mean, duty = side * current[late], abs(signed_duty(part, rail))
            emf, drop = side * constant * speed[late], record.brush_drop(shared, own, mean / duty)
            found.append(Pulses(mean, emf + drop, duty, 1.0 / pwm_hz, rail, ohms))
    return found
