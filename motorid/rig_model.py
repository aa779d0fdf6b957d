"""A rig and its calibration file as data: wiring facts, safety limits, channels. Frozen."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Curve, Stated, Wiring
from motorid.program import Program

ANALOGUE = (CURRENT, VOLTAGE, SUPPLY)
STEPS = (*ANALOGUE, "clock", "encoder", "disc")  # parts of a calibration with a date of their own


@dataclass(frozen=True)
class Limits:
    """What the board must never pass; it trips, latches and coasts."""

    current_a: float
    speed_rad_s: float
    supply_min_v: float
    supply_max_v: float
    run_time_s: float = 60.0
    host_silence_s: float = 0.5
    voltage_v: float | None = None  # at the motor's terminals, either sign
    inputs: tuple[str, ...] = ()  # contacts that must be closed
    sign_check_s: float = 0.05  # from the first drive on; 0: the board checks no signs


@dataclass(frozen=True)
class Nameplate:
    """What is printed on the motor, roughly; guards against burning it. None: not known."""

    resistance_ohm: float | None = None
    inductance_h: float | None = None
    torque_constant_nm_a: float | None = None
    inertia_kg_m2: float | None = None
    no_load_current_a: float | None = None
    voltage_v: float | None = None
    rated_current_a: float | None = None  # at which K and L of a wider model are stated


@dataclass(frozen=True)
class Sampling:
    """Rate and channels of a capture.

    ``mode`` stream sends samples as they are taken; burst keeps them and sends them after the run,
    for boards whose link is slower than their converter.
    """

    rate_hz: float
    channels: tuple[str, ...] = ("current", "terminal_voltage", "position")
    mode: str = "stream"  # stream, burst


@dataclass(frozen=True)
class Calibration:
    """What the rig knows better than the board about one channel. None: believe the board."""

    gain: float = 1.0  # multiplies the board's scale
    gain_uncertainty: float | None = None  # standard, relative
    offset_uncertainty: float | None = None  # standard, in the channel's SI unit
    delay_uncertainty_s: float = 0.0  # standard; the board takes its delay for exact
    offset: float | None = None  # counts, of a channel that a run does not zero
    nonlinearity: float | None = None  # standard, share of full scale; of the current alone
    nonlinearity_shape: Curve | None = None
    full_scale: float | None = None  # A; None: the converter's range


@dataclass(frozen=True)
class CalibrationFile:
    """One calibration as it was read: ``tables`` by name ("" is the top), and its identity."""

    path: str
    text: str
    tables: Mapping[str, Mapping[str, Any]]

    @property
    def sha256(self) -> str:
        """Digest of the file's text."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @property
    def date(self) -> datetime:
        """When it was last added to."""
        found: datetime = self.tables[""]["date"]
        return found

    @property
    def oldest(self) -> tuple[str, datetime]:
        """The part that was calibrated longest ago, and when."""
        dates = {n: self.tables[n]["date"] for n in STEPS if "date" in self.tables.get(n, {})}
        if not dates:
            return "the file", self.date
        name = min(dates, key=lambda name: dates[name])
        return name.replace("_", " "), dates[name]

    @property
    def board(self) -> tuple[str, str]:
        """Name and serial number of the board that was calibrated; "" where it has none."""
        known = self.tables.get("board", {})
        return str(known.get("name", "")), str(known.get("serial", ""))

    def cited(self) -> dict[str, str]:
        """What captures and reports cite of it."""
        return {
            "name": Path(self.path).name,
            "sha256": self.sha256,
            "date": self.date.isoformat(),
            "oldest": self.oldest[1].isoformat(),
            "oldest_part": self.oldest[0],
        }


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
    thermal: Mapping[str, float] = field(default_factory=dict)  # of the motor, as the file has it
    calibration: Mapping[str, Calibration] = field(default_factory=dict)  # by channel
    clock_rate: float = 1.0  # true ticks a second over the nominal ones
    clock_uncertainty: float | None = None  # standard, relative; None: believe the board
    board_serial: str = ""  # where the port does not tell it
    front_end: str = ""  # what the board must hold: a name, or a path from the rig file
    folder: str = field(default="", compare=False)  # of the rig file
    calibration_file: str = ""  # named in the rig file, in place of the one beside it
    calibration_max_age_days: float = 365.0
    calibrated: CalibrationFile | None = None  # the file that is applied in the above
    text: str = ""
    settings: Mapping[str, str] = field(default_factory=dict)  # the user's defaults, as taken

    @property
    def stated(self) -> Stated:
        """What the file states of the motor, as a capture carries it."""
        plate = {n: float(v) for n, v in vars(self.nameplate).items() if v is not None}
        return Stated(plate, {name: float(value) for name, value in self.thermal.items()})
