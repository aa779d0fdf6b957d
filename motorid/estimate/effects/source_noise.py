"""What stays unknown of the voltage that drove the motor, although its source was fitted.

The mean of n noisy readings knows a part's level to noise/√n and to what its converter is straight
by, and an encoder sees less than that leaves open. And a bridge that renews its duty by a noisy
measurement really jitters: a motor then enters its coast a little faster or slower than the mean
voltage says, and stays so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import SUPPLY, Capture
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.source.thevenin_source import FEWEST, Source
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.estimate.solver.dense_products import square
from motorid.program import StepKind

Floats = NDArray[np.float64]

LEAST_JITTER = 0.1  # of a voltage's noise, as variance: what may be true although reading shows all
LEAST = 1e-9  # of a level: no uncertainty is smaller


class SourceNoise:
    """Of one capture: the parts whose ``levels`` readings leave open, and ``coasts`` that begin
    where a part ends whose readings scatter (indices of the timeline's parts).
    """

    def __init__(self, capture: Capture, timeline: Timeline, sensed: Sense) -> None:
        self._parts, self._period = timeline.parts, timeline.period_s
        self._sensed = sensed
        supply = capture.get(SUPPLY)
        self._supply = None if supply is None else timeline.spread(supply.values)
        driven = [k for k, p in enumerate(self._parts) if not p.open and p.kind is not None]
        scattered = {k for k in driven if self._noise(k, None) > 0.0}
        self.levels = tuple(k for k in driven if k in scattered or self._rounded(k))
        self.coasts = tuple(
            k for k, part in enumerate(self._parts)
            if k - 1 in scattered and part.open and _samples(part) >= FEWEST
        )  # fmt: skip

    def level_deviation(self, k: int, source: Source | None) -> float:
        """Standard uncertainty (V) of the mean voltage of part ``k``."""
        part = self._parts[k]
        volts = float(np.abs(self._sensed.volts[part.slice]).mean())
        mean = self._noise(k, source) / math.sqrt(_samples(part))
        return max(math.hypot(mean, self._sensed.level_uncertainty), LEAST * volts, LEAST)

    def speed_deviation(
        self, k: int, source: Source | None, motor: Sequence[float] | Floats
    ) -> float:
        """Standard deviation (rad/s) of the speed at which coast ``k`` begins, about the model's.

        ``source`` is that of the part before. The true voltage jitters each sample, and a lag of
        first order with the mechanical time constant averages that.
        """
        R, _, K, B, J = motor[:5]
        settling = max(J * R / (K**2 + R * B), self._period)
        jitter = self._jitter(k - 1, source)
        return float(jitter / K * np.sqrt(self._period / (2.0 * settling)))

    def _jitter(self, k: int, source: Source | None) -> float:
        """V by which the true voltage jumps: what its readings scatter more than when open."""
        noise = self._noise(k, source)
        idle = [np.diff(self._late(p)) for p in self._parts if p.open and _samples(p) >= FEWEST]
        count = sum(len(d) for d in idle)
        if not self._sensed.shows_emf or not count:
            return noise
        reading = sum(square(d) for d in idle) / (2 * count)
        return float(np.sqrt(max(noise**2 - reading, LEAST_JITTER * noise**2)))

    def _rounded(self, k: int) -> bool:
        """Whether part ``k`` has readings whose converter's steps leave its level open."""
        part = self._parts[k]
        return _samples(part) >= FEWEST and self._sensed.level_uncertainty > 0.0

    def _noise(self, k: int, source: Source | None) -> float:
        """Standard deviation (V) of a reading of part ``k``'s voltage, by its neighbours."""
        part = self._parts[k]
        if _samples(part) < FEWEST:
            return 0.0
        if part.kind == StepKind.DRIVE_VOLTS and self._sensed.commanded:
            # the board renews its duty by the supply that it reads
            if self._supply is None:
                return 0.0
            here = self._supply[part.start + HEAD : part.stop]
            here = here[np.isfinite(here)]
            return abs(part.level) * _scatter(here) / max(float(np.abs(here).mean()), LEAST)
        return source.noise if source is not None else _scatter(self._late(part))

    def _late(self, part: Part) -> Floats:
        return self._sensed.volts[part.start + HEAD : part.stop]


def _samples(part: Part) -> int:
    """Without the few just after the command."""
    return part.stop - part.start - HEAD


def _scatter(values: Floats) -> float:
    steps = np.diff(values)
    return float(np.sqrt(square(steps) / (2 * len(steps)))) if len(steps) else 0.0
