"""What was measured: raw readings with their scales, SI on read, gaps and provenance.

A capture is one run. It is never changed; a correction makes a new one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError
from motorid.look import Look
from motorid.program import Program

Floats = NDArray[np.float64]
Kind = Literal["instant", "mean"]
Sense = Literal["terminals", "bridge", "supply", "command"]
Fact = Literal["gain", "offset", "delay", "filter", "aperture"]
Curve = Literal["bow", "cubic", "s"]

FACTS: tuple[Fact, ...] = get_args(Fact)  # of a channel, which somebody states or nobody does
BUTTERWORTH = 0.5**0.5  # damping of a filter of second order whose cut-off is 1/(2 pi filter_s)

CURRENT = "current"  # A, into the motor
VOLTAGE = "terminal_voltage"  # V, across the motor's terminals (see Channel.sense)
SUPPLY = "supply_voltage"  # V, at the bridge's supply
POSITION = "position"  # rad, at the motor's shaft unless Capture.wiring says otherwise
SPEED = "speed"  # rad/s
TORQUE = "torque"  # N·m, applied by the drive (captures whose drive commands torque)
QUANTITIES = {
    CURRENT: "A",
    VOLTAGE: "V",
    SUPPLY: "V",
    POSITION: "rad",
    SPEED: "rad/s",
    TORQUE: "N·m",
}


HELD = "held"  # provenance: channel -> for how many samples each of its readings is repeated
SUPPLY_BEFORE = "supply_before_v"  # provenance: V, as the board read its supply before the run
SUPPLY_OFF = 0.05  # relative: beyond it a reading of the supply contradicts the rig's figure
NOTES = "notes"  # provenance: what import or capture noticed, as sentences


@dataclass(frozen=True)
class Channel:
    """One measured quantity.

    ``values = scale * (raw - offset)``, in ``unit``. A ``mean`` channel's reading is the average
    over ``aperture_s`` ending ``delay_s`` before the sample's tick; an ``instant`` reading is the
    value ``delay_s`` before it. ``filter_s`` is the time constant of a filter before the converter,
    which ``delay_s`` counts by ``filter_delay_s``: 1/(1 + s t), or of second order
    1/(1 + 2 d s t + s² t²) with the damping d; 1 makes two equal stages. ``resolution`` is the SI
    size of one count (0 for continuous data). ``noise`` is the declared standard deviation of a
    reading (SI; 0: unknown). Uncertainties are standard ones: ``gain_uncertainty`` relative, the
    others SI. ``undeclared`` are the facts that nobody stated: their numbers are no knowledge.
    ``nonlinearity`` of the course ``nonlinearity_shape`` is a standard uncertainty in shares of
    ``full_scale`` (SI). A ``ratiometric`` sensor follows the converter's reference.
    ``step_uncertainty`` (SI) is of how far readings jump at 1/8, 3/8, 5/8 and 7/8 of the range of
    the converter, which ``raw_min`` and ``raw_max`` nearly are.
    """

    name: str
    unit: str
    raw: NDArray[Any]
    scale: float = 1.0
    offset: float = 0.0
    kind: Kind = "instant"
    aperture_s: float = 0.0
    delay_s: float = 0.0
    pwm_phase: float | None = None  # of the PWM period: where an instant is; a mean's spacing
    resolution: float = 0.0
    noise: float = 0.0
    gain_uncertainty: float = 0.0
    offset_uncertainty: float = 0.0
    delay_uncertainty_s: float = 0.0
    filter_s: float = 0.0
    filter_order: int = 1  # 1 or 2
    filter_damping: float = 1.0  # of second order
    undeclared: tuple[Fact, ...] = ()
    raw_min: float = -np.inf  # a reading at or beyond these is saturated
    raw_max: float = np.inf
    sense: Sense | None = None  # voltages only: where it is measured
    unsigned: bool = False  # the instrument reports a magnitude
    nonlinearity: float = 0.0
    nonlinearity_shape: Curve | None = None
    full_scale: float = 0.0  # 0: not stated
    ratiometric: bool = False
    step_uncertainty: float = 0.0

    @property
    def window_s(self) -> float:
        """Seconds that a reading averages over; 0: it is of an instant."""
        return self.aperture_s if self.kind == "mean" else 0.0

    @property
    def filter_delay_s(self) -> float:
        """Seconds by which its filter makes a steady change late: its part of ``delay_s``."""
        return (1.0 if self.filter_order == 1 else 2.0 * self.filter_damping) * self.filter_s

    def states(self, fact: Fact) -> bool:
        """Whether somebody stated that fact, be it as 0."""
        return fact not in self.undeclared

    @cached_property
    def values(self) -> Floats:
        """Readings in ``unit``, shape (n,); NaN where a reading is missing."""
        return self.scale * (np.asarray(self.raw, dtype=np.float64) - self.offset)

    @cached_property
    def saturated(self) -> NDArray[np.bool_]:
        """Where the converter was at an end of its range, shape (n,)."""
        raw = np.asarray(self.raw, dtype=np.float64)
        return (raw <= self.raw_min) | (raw >= self.raw_max)


@dataclass(frozen=True)
class Phase:
    """A program step as the board began it: its index and its exact first tick."""

    index: int
    tick: int


@dataclass(frozen=True)
class Gap:
    """Samples that the board took and the host does not have: they lie before sample ``index``."""

    index: int
    samples: int
    reason: str


@dataclass(frozen=True)
class Wiring:
    """Facts of the rig that a fit needs. Resistances in ohm; ``pwm_hz`` 0: no PWM."""

    bridge_resistance_ohm: float = 0.0
    bridge_resistance_uncertainty_ohm: float = 0.0
    lead_resistance_ohm: float = 0.0
    lead_resistance_uncertainty_ohm: float = 0.0
    gear_ratio: float = 1.0  # motor turns for one turn of the shaft that carries the encoder
    counts_per_turn: float = 0.0  # 0: no encoder
    pwm_hz: float = 0.0
    dead_time_s: float = 0.0
    pwm_alignment: float | None = None  # share of a period's off part before its on part
    supply_voltage_v: float = 0.0  # nominal; 0: unknown
    bridge_drop_v: float = 0.0  # over both switches, beside their resistance: bipolar ones
    bridge_drop_uncertainty_v: float = 0.0  # standard
    brush_drop_v: float | None = None  # of the motor, over both brushes; None: not declared
    brush_drop_uncertainty_v: float = 0.0  # standard
    encoder_eccentricity_rad: float = 0.0  # amplitude of its error once a turn of its own shaft
    reference_drift: float | None = None  # standard, relative, in a run; None: not declared
    reference_time_s: float = 0.0  # over which that drift sets in
    terminal_load_ohm: float = 0.0  # across the motor, behind the current's sensor; 0: none
    terminal_load_uncertainty_ohm: float = 0.0  # standard

    @property
    def terminal_load_s(self) -> float:
        """S across the motor."""
        return 1.0 / self.terminal_load_ohm if self.terminal_load_ohm else 0.0


@dataclass(frozen=True)
class Stated:
    """What the rig's file states of the motor: SI numbers by the keys of [nameplate] and [thermal].

    ``unread``: what of it could not be read, as a clause; empty: nothing. Raises DataError on a
    value that is no finite number.
    """

    nameplate: Mapping[str, float] = field(default_factory=dict)
    thermal: Mapping[str, float] = field(default_factory=dict)
    unread: str = ""

    def __post_init__(self) -> None:
        for table in (self.nameplate, self.thermal):
            for name, value in table.items():
                if not isinstance(value, int | float) or not np.isfinite(value):
                    raise DataError(f"{name} of the motor is {value!r}: give a finite number")

    def under(self, rig: Stated) -> Stated:
        """As another rig states it; what that does not state stays."""
        nameplate, thermal = {**self.nameplate, **rig.nameplate}, {**self.thermal, **rig.thermal}
        return Stated(nameplate, thermal, self.unread)


@dataclass(frozen=True, repr=False)
class Capture(Look):
    """One run: ``ticks`` (n,) int64 of the board's clock, and channels of n readings each."""

    ticks: NDArray[np.int64]
    clock_hz: float
    channels: Mapping[str, Channel]
    clock_uncertainty: float = 0.0  # relative, standard
    wiring: Wiring = Wiring()
    stated: Stated = Stated()
    program: Program | None = None
    phases: tuple[Phase, ...] = ()
    gaps: tuple[Gap, ...] = ()
    end_reason: str = "completed"  # completed, stopped, fault: NAME, link lost, interrupted
    ambient_c: float | None = None
    ambient_uncertainty_c: float = 0.0
    provenance: Mapping[str, Any] = field(
        default_factory=dict
    )  # identity, rig text, serial, notes, versions
    sha256: str = ""  # of the file it came from; empty when not stored
    content_sha256: str = ""  # that the file carries of its content; empty where it carries none
    path: str = ""

    __repr__ = Look.brief

    def __post_init__(self) -> None:
        for channel in self.channels.values():
            if len(channel.raw) != len(self.ticks):
                raise DataError(
                    f"channel {channel.name} has {len(channel.raw)} readings "
                    f"for {len(self.ticks)} ticks"
                )

    def __len__(self) -> int:
        return len(self.ticks)

    @cached_property
    def time_s(self) -> Floats:
        """Sample times in seconds from the first sample, shape (n,)."""
        if not len(self.ticks):
            return np.zeros(0)
        return np.asarray((self.ticks - self.ticks[0]) / self.clock_hz, dtype=np.float64)

    @cached_property
    def period_s(self) -> float:
        """The usual time between samples, in seconds. Raises DataError below two samples."""
        if len(self.ticks) < 2:
            raise DataError(
                "a capture of fewer than two samples has no sample period: capture again"
            )
        return float(np.median(np.diff(self.ticks))) / self.clock_hz

    @cached_property
    def supply_measured_v(self) -> float | None:
        """V at the bridge, of the run's own channel, else as the board read it before the run.

        None where nothing measured it.
        """
        supply = self.get(SUPPLY)
        if supply is not None and np.isfinite(supply.values).any():
            return float(np.nanmedian(supply.values))
        known = self.provenance.get(SUPPLY_BEFORE)
        if isinstance(known, int | float) and known > 0:
            return float(known)
        return self._check_v if SUPPLY in self.provenance.get("descriptors", {}) else None

    @property
    def _check_v(self) -> float | None:
        """V of the supply by which the first weak pulse was driven: read, or as stated."""
        check = self.provenance.get("check") or {}
        duty, volts = abs(check.get("duty") or 0.0), abs(check.get("volts") or 0.0)
        return volts / duty if duty and volts else None

    @cached_property
    def supply_v(self) -> float | None:
        """V at the bridge: of the run's channel, else of the rig, else as the board found it.

        A rig's figure that the board's reading contradicts is not taken. None: unknown.
        """
        measured, stated = self.supply_measured_v, self.wiring.supply_voltage_v
        if measured is not None and (
            self.get(SUPPLY) is not None or abs(stated - measured) > SUPPLY_OFF * measured
        ):
            return measured
        return stated if stated > 0 else self._check_v

    def get(self, name: str) -> Channel | None:
        """The channel of that quantity, or None."""
        return self.channels.get(name)

    def rows(self, which: slice, gaps: tuple[Gap, ...]) -> Capture:
        """These samples alone, as another capture; ``gaps`` by their indices in it."""
        channels = {n: replace(c, raw=c.raw[which]) for n, c in self.channels.items()}
        return replace(self, ticks=self.ticks[which], channels=channels, gaps=gaps)
