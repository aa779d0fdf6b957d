"""A rig: wiring facts and safety limits of one bench, frozen."""

from __future__ import annotations

from dataclasses import dataclass

from motorid.capture.model import Wiring
from motorid.program import Program


@dataclass(frozen=True)
class Limits:
    """What the board must never pass; it trips, latches and coasts."""

    current_a: float
    speed_rad_s: float
    supply_min_v: float
    supply_max_v: float
    run_time_s: float = 60.0
    host_silence_s: float = 0.5


@dataclass(frozen=True)
class Nameplate:
    """What is printed on the motor, roughly; guards against burning it. None: not known."""

    resistance_ohm: float | None = None
    inductance_h: float | None = None
    torque_constant_nm_a: float | None = None
    inertia_kg_m2: float | None = None
    no_load_current_a: float | None = None
    voltage_v: float | None = None


@dataclass(frozen=True)
class Sampling:
    """Rate and channels of a capture."""

    rate_hz: float
    channels: tuple[str, ...] = ("current", "terminal_voltage", "position")


@dataclass(frozen=True)
class Rig:
    """One bench. ``text`` is the file it was read from, kept in every capture."""

    name: str
    port: str
    wiring: Wiring
    limits: Limits
    nameplate: Nameplate
    sampling: Sampling
    program: Program
    encoder_reversed: bool = False
    voltage_sense: str = "terminals"  # terminals, bridge, supply
    supply_voltage_v: float | None = None  # nominal
    ambient_c: float | None = None
    ambient_uncertainty_c: float = 0.0
    text: str = ""
