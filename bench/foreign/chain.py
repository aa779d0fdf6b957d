"""From what a plant did to a capture: means over windows, converters, an encoder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.foreign import drawn
from bench.foreign.drawn import CLOCK_HZ, Rig
from motorid.capture.model import (
    CURRENT,
    POSITION,
    SUPPLY,
    VOLTAGE,
    Capture,
    Channel,
    Phase,
    Stated,
    Wiring,
)

Floats = NDArray[np.float64]
TURN = 2 * np.pi


@dataclass(frozen=True)
class Trace:
    """What was true, at times that may lie close together where something switches; shapes (n,)."""

    time_s: Floats
    current: Floats  # A
    sensed: Floats  # V, where the rig reads its voltage
    speed: Floats  # rad/s

    def means(self, what: Floats, ends_s: Floats, width_s: float) -> Floats:
        """Means over windows of that width which end there; before the beginning nothing moved."""
        area = np.concatenate([[0.0], np.cumsum(np.diff(self.time_s) * (what[1:] + what[:-1]) / 2)])

        def to(at: Floats) -> Floats:
            k = np.clip(np.searchsorted(self.time_s, at) - 1, 0, len(area) - 2)
            left = at - self.time_s[k]
            step = self.time_s[k + 1] - self.time_s[k]
            bend = np.where(step > 0, (what[k + 1] - what[k]) / np.where(step > 0, step, 1.0), 0.0)
            return np.asarray(area[k] + what[k] * left + bend * left**2 / 2)

        return np.asarray((to(ends_s) - to(ends_s - width_s)) / width_s)

    def angle(self, at: Floats) -> Floats:
        """rad at those times."""
        turned = np.concatenate(
            [[0.0], np.cumsum(np.diff(self.time_s) * (self.speed[1:] + self.speed[:-1]) / 2)]
        )
        return np.asarray(np.interp(at, self.time_s, turned))


def seconds(rig: Rig) -> float:
    """True seconds of the run."""
    return sum(step.duration_s for step in rig.program.steps) / (1 + rig.clock_error)


def capture(rig: Rig, trace: Trace) -> Capture:
    """The run as the board would have read it."""
    rng = np.random.default_rng([rig.seed, 78])
    period = round(CLOCK_HZ / rig.rate_hz)
    starts = np.concatenate([[0.0], np.cumsum([s.duration_s for s in rig.program.steps])])
    ticks = np.arange(2, round(starts[-1] * rig.rate_hz), dtype=np.int64) * period
    true_s = ticks / CLOCK_HZ / (1 + rig.clock_error)
    turned = trace.angle(true_s) + rig.first_line
    counts = np.floor(turned * rig.counts_per_turn / TURN).astype(np.int64)
    volts = VOLTAGE if rig.sense != "supply" else SUPPLY
    return Capture(
        ticks=ticks,
        clock_hz=CLOCK_HZ,
        clock_uncertainty=rig.clock_u,
        channels={
            CURRENT: _read(CURRENT, "A", rig, rig.current, trace, trace.current, true_s, rng),
            volts: _read(volts, "V", rig, rig.voltage, trace, trace.sensed, true_s, rng),
            POSITION: Channel(
                POSITION, "rad", counts, TURN / rig.counts_per_turn, float(counts[0]),
                resolution=TURN / rig.counts_per_turn,
            ),
        },
        wiring=Wiring(
            bridge_resistance_ohm=rig.stated_bridge_ohm,
            bridge_resistance_uncertainty_ohm=rig.bridge_u,
            lead_resistance_ohm=rig.stated_lead_ohm,
            lead_resistance_uncertainty_ohm=rig.lead_u,
            counts_per_turn=rig.counts_per_turn,
            pwm_hz=rig.pwm_hz,
            dead_time_s=rig.dead_s,
            supply_voltage_v=rig.supply_v,
        ),
        stated=Stated(nameplate=rig.nameplate),
        program=rig.program,
        phases=tuple(
            Phase(k, round(s * rig.rate_hz) * period) for k, s in enumerate(starts[:-1])
        ),
    )  # fmt: skip


def _read(
    name: str, unit: str, rig: Rig, adc: drawn.Channel, trace: Trace, what: Floats, at: Floats,
    rng: np.random.Generator,
) -> Channel:  # fmt: skip
    aperture = adc.aperture_s / (1 + rig.clock_error)
    values = trace.means(what, at - adc.true_delay_s, aperture)
    counts = adc.true_gain * values / adc.scale + adc.middle + adc.true_offset
    raw = np.round(counts + adc.noise * rng.standard_normal(len(at)))
    more: dict[str, Any] = {} if name == CURRENT else {"sense": rig.sense}
    return Channel(
        name, unit, np.clip(raw, 0, adc.raw_max).astype(np.int16), adc.scale, adc.middle,
        kind="mean", aperture_s=adc.aperture_s, delay_s=adc.delay_s, resolution=adc.scale,
        noise=adc.noise * adc.scale, gain_uncertainty=adc.gain_u,
        offset_uncertainty=adc.offset_u * adc.scale, delay_uncertainty_s=adc.delay_u_s,
        raw_min=0.0, raw_max=float(adc.raw_max), **more,
    )  # fmt: skip
