"""Start values where nobody measured the motion: its back-EMF is what R i leaves of the voltage.

K is held, because nothing tells it. Each resistance that the peaks of the current allow gives a
speed, and with that the friction and the inertia. The likelihood of the readings chooses.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT
from motorid.errors import DataError
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.fit.parameter_bounds import searched, unknowns_of
from motorid.estimate.fit.start_signals import Signals
from motorid.estimate.fit.start_values import mechanical, shows_motion
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.solver.concentrated_likelihood import Concentrated

Floats = NDArray[np.float64]

SHARES = np.linspace(0.3, 1.0, 8)  # of the largest R that a peak of the current allows
TIMES = (0.1, 1.0, 10.0)  # L/R in sample periods


def suits(records: Sequence[MotorRecord], fixed: Mapping[str, float]) -> bool:
    """No record has a motion, and K is held."""
    return "K" in fixed and not any(shows_motion(record) for record in records)


def start_values(records: Sequence[MotorRecord], fixed: Mapping[str, float]) -> dict[str, float]:
    """R, L, B, J, T0 (SI) near the answer for the K that ``fixed`` holds.

    Raises DataError where no current was measured, or the motor never driven.
    """
    if not any(np.abs(record.volts).max() > 0.0 for record in records):
        raise DataError("the motor was never driven in these captures: capture a run with a step")
    tried = list(_starts([_Readings(record) for record in records], fixed))
    if not tried:
        raise DataError(
            "what the current leaves of the voltage shows no motion that follows the current: "
            "check their signs and scales, or capture the position or speed as well"
        )
    return min(tried, key=lambda start: _misfit(records, start, fixed))


class _Readings:
    """A record's voltage and current on its grid, and the back-EMF where its bridge is open."""

    def __init__(self, record: MotorRecord) -> None:
        named = {m.block.name: m for m in record.measured}
        if CURRENT not in named or named[CURRENT].unsigned:
            raise DataError(
                "neither a motion nor a signed current can be used in a capture: capture the "
                "current with its sign, and better the position or speed as well"
            )
        self.record = record
        ticks, m = np.arange(record.timeline.count), named[CURRENT]
        offset = {u.name: u.start for u in record.unknowns}.get(CURRENT_OFFSET.name, 0.0)
        self.current = np.where(record.driven, np.interp(ticks, m.keep, m.values) - offset, 0.0)
        self.volts = np.where(record.driven, record.sensed.volts, 0.0)
        self.open = np.zeros(len(ticks))
        if EMF in named:
            shown = named[EMF]
            self.open[shown.keep] = shown.values
        self.net = self.volts - record.sensed.series_ohm * self.current

    def signals(self, ohms: float, constant: float) -> Signals:
        """Its signals if the winding has such a resistance."""
        line = self.record.timeline
        speed = np.where(self.record.driven, self.net - ohms * self.current, self.open) / constant
        return Signals(
            line.period_s, self.volts, self.current, np.cumsum(speed) * line.period_s, None,
            (*(p.start for p in line.parts), line.count), tuple(p.open for p in line.parts),
            self.record.sensed.series_ohm,
        )  # fmt: skip


def _starts(
    readings: Sequence[_Readings], fixed: Mapping[str, float]
) -> Iterator[dict[str, float]]:
    K = fixed["K"]
    if not all(r.current.any() for r in readings):
        raise DataError(
            "no current flowed while the motor was driven in a capture: check the current's "
            "channel and the wiring"
        )
    most = min(float(np.abs(r.net).max() / np.abs(r.current).max()) for r in readings)
    period = min(r.record.timeline.period_s for r in readings)
    for ohms in [fixed["R"]] if "R" in fixed else most * SHARES:
        data = [r.signals(float(ohms), K) for r in readings]
        try:
            B, J, T0 = mechanical(data, K, fixed)
        except DataError:  # with such a resistance it would not move, or move by itself
            continue
        for periods in TIMES:
            found = {"R": float(ohms), "L": periods * float(ohms) * period}
            yield {**found, "B": B, "J": J, "T0": T0, **fixed}


def _misfit(
    records: Sequence[MotorRecord], start: Mapping[str, float], fixed: Mapping[str, float]
) -> float:
    """Twice the negative log-likelihood, but for a constant, each channel's noise unknown."""
    free = searched(fixed)
    return Concentrated(unknowns_of(records, free, start), records).start.objective
