"""A rig: wiring facts and safety limits of one bench, frozen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from motorid.capture.model import Stated, Wiring
from motorid.errors import RigError
from motorid.program import Program, StepKind, climbs

if TYPE_CHECKING:
    from motorid.rig_calibration import CalibrationFile

DEFAULT_CLIMBS = ((0.3, 0.5, 0.75), (1.0,))  # fractions of the nameplate's voltage


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
    calibration_file: str = ""  # named in the rig file, in place of the one beside it
    calibration_max_age_days: float = 365.0
    calibrated: CalibrationFile | None = None  # the file that is applied in the above
    text: str = ""

    @property
    def stated(self) -> Stated:
        """What the file states of the motor, as a capture carries it."""
        plate = {n: float(v) for n, v in vars(self.nameplate).items() if v is not None}
        return Stated(plate, {name: float(value) for name, value in self.thermal.items()})


def load_rig(name_or_path: str) -> Rig:
    """The rig of a preset's name ("sim") or of a TOML file.

    Raises RigError, naming the file and the key, when it is absent, unreadable or absurd.
    """
    from motorid.rig_file import load

    return load(name_or_path)


def default_program(nameplate: Nameplate) -> Program:
    """Levels up to the nameplate's voltage, each long enough to settle; climbs that coast to rest.

    Raises RigError when the nameplate names no voltage.
    """
    if nameplate.voltage_v is None:
        raise RigError("a rig without [program] needs nameplate.voltage_v to derive one from")
    coast_s = coasting_s(nameplate)
    return climbs(
        [[share * nameplate.voltage_v for share in climb] for climb in DEFAULT_CLIMBS],
        kind=StepKind.DRIVE_VOLTS,
        drive_s=settling_s(nameplate),
        coast_s=[round(coast_s * climb[-1], 4) for climb in DEFAULT_CLIMBS],
    )


def settling_s(plate: Nameplate) -> float:
    """Eight mechanical time constants RJ/K² in seconds, or a long guess where they are unknown."""
    R, J, K = plate.resistance_ohm, plate.inertia_kg_m2, plate.torque_constant_nm_a
    if R is None or J is None or K is None:
        return 0.5
    return round(min(max(8 * R * J / K**2, 0.06), 2.0), 4)


def coasting_s(plate: Nameplate) -> float:
    """Seconds in which a motor surely stops: 1.7 times what a constant no-load torque would take.

    Where only a share s of that torque is dry friction, it takes -ln(s)/(1-s) times: 1.7 at 30 %.
    """
    J, K, V = plate.inertia_kg_m2, plate.torque_constant_nm_a, plate.voltage_v
    if J is None or K is None or V is None or plate.no_load_current_a is None:
        return 1.5
    return round(min(max(1.7 * J * (V / K) / (K * plate.no_load_current_a), 0.1), 4.0), 4)
