"""The capture that a program would give: a motor's response through the bench's own channels.

The response is the fit's, and so is everything that is made of the capture afterwards; only noise
and rounding are added here. What a plan promises thus rests on the fit's own linearisation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import (
    CURRENT,
    POSITION,
    SPEED,
    SUPPLY,
    VOLTAGE,
    Capture,
    Channel,
    Phase,
    Wiring,
)
from motorid.estimate.signals.source.pwm_bridge import clamp_voltage, pwm_shape
from motorid.estimate.signals.time_grid import Part, lay
from motorid.motor.parameters import Motor
from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.response import Response
from motorid.program import Program, Step, StepKind

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Bench:
    """What measures: ``channels`` as a capture would hold them, with no readings yet."""

    channels: Mapping[str, Channel]
    clock_hz: float
    period_ticks: int  # between samples
    wiring: Wiring
    clock_uncertainty: float = 0.0

    @property
    def period_s(self) -> float:
        """Seconds between samples."""
        return self.period_ticks / self.clock_hz

    def volts(self, step: Step) -> float:
        """What a step's source gives, without its sign; 0 while the bridge is open."""
        duty = step.kind == StepKind.DRIVE_DUTY
        return abs(step.level) * (self.wiring.supply_voltage_v if duty else 1.0)


def skeleton(bench: Bench, program: Program, motor: Motor, seed: int = 0) -> Capture:
    """The capture of one run of ``motor``, with the noise that the channels declare."""
    period = bench.period_ticks
    counts = [max(1, round(s.duration_s * bench.clock_hz / period)) for s in program.steps]
    starts, n = np.cumsum([0, *counts[:-1]]), sum(counts)
    blank = Capture(
        ticks=np.arange(n, dtype=np.int64) * period,
        clock_hz=bench.clock_hz,
        clock_uncertainty=bench.clock_uncertainty,
        channels={name: replace(c, raw=np.zeros(n)) for name, c in bench.channels.items()},
        wiring=bench.wiring,
        program=program,
        phases=tuple(Phase(k, int(first) * period) for k, first in enumerate(starts)),
    )
    noise = np.random.default_rng(seed)
    return replace(blank, channels=_Signals(blank, motor).channels(noise))


class _Signals:
    """What every channel of a blank capture would read."""

    def __init__(self, blank: Capture, motor: Motor) -> None:
        self.blank, self.motor = blank, motor
        self.timeline = lay(blank)
        wiring = blank.wiring
        self.ohms = wiring.bridge_resistance_ohm + wiring.lead_resistance_ohm
        self.source = np.zeros(self.timeline.count)  # V
        self.open = np.zeros(self.timeline.count, dtype=bool)
        for part in self.timeline.parts:
            self.source[part.slice] = self._level(part)
            self.open[part.slice] = part.open

    def _level(self, part: Part) -> float:
        duty = part.kind == StepKind.DRIVE_DUTY
        return part.level * (self.blank.wiring.supply_voltage_v if duty else 1.0)

    def _read(self, output: Output) -> Floats:
        """The response at an output, (n,)."""
        rail = self.blank.wiring.supply_voltage_v or None
        clamp = clamp_voltage(self.blank, float(np.abs(self.source).max()))
        stretches = [
            Stretch(p.start, p.open, self.ohms, clamp, *pwm_shape(p, self._level(p), rail))
            for p in self.timeline.parts
        ]
        pwm = self.blank.wiring.pwm_hz
        period = self.timeline.period_s
        response = Response(period, self.source, [output], stretches, 1.0 / pwm if pwm else 0.0)
        return np.asarray(response(self.motor.values)[0])

    def channels(self, noise: np.random.Generator) -> dict[str, Channel]:
        """Every channel with its readings, rounded as its converter rounds."""
        return {
            name: replace(channel, raw=_converted(channel, self._of(channel), noise))
            for name, channel in self.blank.channels.items()
        }

    def _of(self, channel: Channel) -> Floats:
        def read(quantity: Quantity) -> Floats:
            return self._read(
                Output(quantity, channel.window_s, channel.delay_s, channel.pwm_phase)
            )

        gear = self.blank.wiring.gear_ratio or 1.0
        if channel.name == VOLTAGE:
            return self._voltage(channel, read(Quantity.CURRENT), read(Quantity.SPEED))
        if channel.name == SUPPLY:
            return np.full(len(self.blank), self.blank.wiring.supply_voltage_v)
        scales = {
            CURRENT: (Quantity.CURRENT, 1.0),
            POSITION: (Quantity.POSITION, 1.0 / gear),
            SPEED: (Quantity.SPEED, 1.0 / gear),
        }
        quantity, scale = scales[channel.name]
        return read(quantity) * scale

    def _voltage(self, channel: Channel, current: Floats, speed: Floats) -> Floats:
        wiring = self.blank.wiring
        before = {"bridge": wiring.bridge_resistance_ohm, "supply": 0.0}
        ohms = before.get(channel.sense or "", self.ohms)
        emf = 0.0 if channel.sense == "supply" else self.motor.K * speed
        return np.where(self.open, emf, self.source - ohms * current)


def _converted(channel: Channel, values: Floats, noise: np.random.Generator) -> Floats:
    """Raw readings of ``values``: a declared noise holds the rounding's already."""
    step = channel.resolution / np.sqrt(12.0)
    own = np.sqrt(max(channel.noise**2 - step**2, 0.0))
    raw = (values + own * noise.standard_normal(len(values))) / channel.scale + channel.offset
    if channel.resolution > 0:
        raw = np.rint(raw)
    return np.asarray(np.clip(raw, channel.raw_min, channel.raw_max))
