"""Faults of stated size, and what each is to be called."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SUPPLY, VOLTAGE, Capture
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.rigs import FINE_HZ, Bench

RPM = 60 / (2 * np.pi)


class Runs:
    """The captures of one bench that faults are put into."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench

    @cached_property
    def fine(self) -> Capture:
        """At the finer rate."""
        return self.bench.capture(rate_hz=FINE_HZ)

    @cached_property
    def good(self) -> Capture:
        """Without a fault."""
        return inject.decimated(self.fine)

    @property
    def peak_a(self) -> float:
        """The highest current."""
        return float(np.abs(self.good.channels[CURRENT].values).max())

    @property
    def peak_v(self) -> float:
        """The highest voltage."""
        return float(np.abs(self.good.channels[VOLTAGE].values).max())

    @property
    def top_counts_s(self) -> float:
        """The highest speed."""
        counts = np.asarray(self.good.channels[POSITION].raw, dtype=np.float64)
        smooth = np.convolve(counts, np.ones(20) / 20, "valid")
        return float(np.abs(np.diff(smooth)).max() / self.good.period_s)

    def slipping(self) -> Capture:
        """A load as heavy as the rotor, whose joint holds half of what the run asks of it."""
        m = self.bench.preset
        asked = 0.5 * m.torque_constant_nm_a * self.peak_a
        return self.bench.capture(f"&load_inertia={m.inertia_kg_m2:g}&coupling={0.5 * asked:g}")

    def limited(self, *channels: str) -> Capture:
        """A supply, with a small capacitor, that gives 40 % of the current asked of it."""
        c = self.good.channels
        asked = np.abs(c[CURRENT].values * c[VOLTAGE].values).max() / self.bench.preset.supply_v
        return self.bench.capture(
            f"&supply_capacitance=5e-4&supply_limit={0.4 * asked:.3g}", channels
        )

    def in_series(self, share: float) -> Capture:
        """Leads of that share of R, and the voltage sensed before them."""
        ohms = share * self.bench.preset.resistance_ohm
        return self.bench.capture(f"&lead_resistance={ohms:g}&sense=bridge")


@dataclass(frozen=True)
class Case:
    """One fault: its name among the cases, what it is to be called, its size in words."""

    name: str
    code: str
    size: str
    capture: Callable[[Runs], Capture]


def _fine(change: Callable[..., Capture], *args: object) -> Callable[[Runs], Capture]:
    return lambda r: inject.decimated(change(r.fine, *args))


def _plain(change: Callable[..., Capture], *args: object) -> Callable[[Runs], Capture]:
    return lambda r: change(r.good, *args)


CHAIN = (
    Case("current offset", "current_offset", "2 % of the highest current",
         lambda r: inject.offset(r.good, 0.02 * r.peak_a)),
    Case("offset while driven", "current_offset", "2 % of the highest current",
         lambda r: inject.offset_driven(r.good, 0.02 * r.peak_a)),
    Case("current lag", "current_lag", "200 µs, 2 samples", _fine(inject.lag, CURRENT, 4)),
    Case("position lag", "position_lag", "400 µs, 4 samples", _fine(inject.lag, POSITION, 8)),
    Case("voltage lag", "voltage_lag", "300 µs, 3 samples", _plain(inject.lag, VOLTAGE, 3)),
    Case("filtered current", "current_filtered", "300 µs", _fine(inject.low_pass, 3e-4)),
    Case("current averaged", "current_smoothed", "a new reading counts a half",
         _plain(inject.averaged, 0.5)),
    Case("mean of currents", "current_smoothed", "of the last 4",
         _plain(inject.mean_of_last, 4)),
    Case("current saturated", "current_saturated", "70 % of the highest current",
         lambda r: inject.clip(r.good, 0.7 * r.peak_a)),
    Case("voltage saturated", "voltage_saturated", "90 % of the highest voltage",
         lambda r: inject.clip(r.good, 0.9 * r.peak_v, VOLTAGE)),
    Case("current reversed", "current_sign", "", _plain(inject.reversed_, CURRENT)),
    Case("encoder reversed", "encoder_sign", "", _plain(inject.reversed_, POSITION)),
    Case("voltage reversed", "voltage_sign", "", _plain(inject.reversed_, VOLTAGE)),
    Case("supply limit, measured", "supply_limited", "40 % of the current asked of it; 0.5 mF",
         lambda r: r.limited(CURRENT, VOLTAGE, POSITION)),
    Case("slipping load", "load_slips", "as heavy as the rotor; joint holds half the torque asked",
         Runs.slipping),
    Case("samples dropped", "samples_dropped", "12 times 1 to 6 samples",
         lambda r: inject.dropped(r.good, r.bench.seed, 12, 6)),
    Case("current held", "readings_held", "10 % of the readings, 30 to 60 at a time",
         lambda r: inject.held(r.good, r.bench.seed, 0.1, 60)),
    Case("voltage held", "readings_held", "10 % of the readings, 30 to 60 at a time",
         lambda r: inject.held(r.good, r.bench.seed, 0.1, 60, VOLTAGE)),
    Case("counts lost at times", "encoder_loses_counts", "40 times 30 to 60 counts",
         lambda r: inject.lost_counts(r.good, r.bench.seed, 40, 60)),
    Case("fast edges lost", "encoder_loses_counts", "above 85 % of the highest speed",
         lambda r: inject.slow_edges(r.good, 0.85 * r.top_counts_s)),
)  # fmt: skip
# where volts are commanded, and only the supply's are measured
COMMANDED = Case(
    "supply limit, volts commanded", "supply_limited", "40 % of the current asked of it; 0.5 mF",
    lambda r: r.limited(CURRENT, SUPPLY, POSITION),
)  # fmt: skip
SCALES = (
    Case("counts per turn x 2", "speed_scale", "2", _plain(inject.scaled, POSITION, 2.0)),
    Case("counts per turn x 4", "speed_scale", "4", _plain(inject.scaled, POSITION, 4.0)),
    Case("rpm for rad/s", "speed_scale", "9.55", _plain(inject.scaled, POSITION, RPM)),
    Case("mA for A", "current_scale", "1000", _plain(inject.scaled, CURRENT, 1e3)),
    Case("current gain", "current_scale", "1.5", _plain(inject.scaled, CURRENT, 1.5)),
    Case("mV for V", "voltage_scale", "1000", _plain(inject.scaled, VOLTAGE, 1e3)),
    Case("voltage gain", "voltage_scale", "1.5", _plain(inject.scaled, VOLTAGE, 1.5)),
    Case("series resistance", "series_resistance", "60 % of R", lambda r: r.in_series(0.6)),
)
