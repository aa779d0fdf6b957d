"""What the pulses of a diode's current tell of the inductance.

A current that stops within every PWM period begins each from nothing: it rises for the duty by the
supply less the back-EMF, and falls by both and two diodes. Its mean is then as good as inverse to L
whatever the sampling.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.bridge import DIODE_DROPS_V, signed_duty
from motorid.estimate.head import HEAD
from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Solution
from motorid.motor.response import Output, Quantity

Floats = NDArray[np.float64]

FEWEST = 24  # intervals of a part that count
LEAST, MOST = 1e-3, 1e2  # L/R in PWM periods


@dataclass(frozen=True)
class Pulses:
    """Of a part of a run: ``mean`` current and back-EMF (n,) along its drive, by the model.

    ``duty`` of every ``period_s`` at ``rail`` V and behind ``ohms`` in all.
    """

    mean: Floats
    emf: Floats
    duty: float
    period_s: float
    rail: float
    ohms: float

    def foretold(self, inductance_h: float) -> Floats:
        """Mean current (n,) of pulses through that inductance."""
        tau = inductance_h / self.ohms
        on_s = self.duty * self.period_s
        towards = (self.rail - self.emf) / self.ohms
        against = (self.rail + DIODE_DROPS_V + self.emf) / self.ohms
        peak = -towards * math.expm1(-on_s / tau)
        off_s = tau * np.log1p(peak / against)
        charge = towards * on_s - against * off_s  # what the peak adds, the fall takes again
        return np.asarray(charge / self.period_s)


def inductance(records: Sequence[MotorRecord], solution: Solution) -> float | None:
    """H by which the pulses of all records are as large as the current is; None: there are none."""
    found = [
        one
        for record, own in zip(records, solution.own, strict=True)
        for one in pulses_of(record, solution.values, own)
    ]
    if not found:
        return None

    def too_large(log_h: float) -> float:
        at = math.exp(log_h)
        return float(sum((one.foretold(at) - one.mean).sum() for one in found))

    per_ohm = found[0].ohms * found[0].period_s
    low, high = math.log(LEAST * per_ohm), math.log(MOST * per_ohm)
    if too_large(low) <= 0.0 or too_large(high) >= 0.0:
        return None
    from scipy.optimize import brentq  # rarely needed, and slow to load

    return math.exp(float(brentq(too_large, low, high, xtol=1e-4)))


def pulses_of(record: MotorRecord, shared: Floats, own: Floats) -> list[Pulses]:
    """Of every part of a record in which the current stops, as the model has it."""
    parts = [part for part in record.timeline.parts if part.discontinuous]
    pwm_hz, rail = record.capture.wiring.pwm_hz, record.supply_v
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
            mean, emf = side * current[late], side * constant * speed[late]
            duty = abs(signed_duty(part, rail))
            found.append(Pulses(mean, emf, duty, 1.0 / pwm_hz, rail, ohms))
    return found
