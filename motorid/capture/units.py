"""Units that people write in files and on the command line, and what they are in SI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from types import MappingProxyType

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, TORQUE, VOLTAGE
from motorid.capture.unit_spellings import usual
from motorid.errors import UsageError, nearest

TIME = "time"
AMBIENT = "ambient"  # °C, beside the motor: kept as its mean
COMMAND = "command"  # what the drive was told, where nobody measured what it did
SET_SPEED = "set_speed"  # what a closed loop was told to hold
SET_POSITION = "set_position"

_TURN = 2 * pi
_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
_VOLTS = {"V": 1.0, "mV": 1e-3, "uV": 1e-6, "kV": 1e3}
_AMPERES = {"A": 1.0, "mA": 1e-3, "uA": 1e-6, "kA": 1e3}
_SPEEDS = {
    "rad/s": 1.0,
    "rpm": _TURN / 60,
    "krpm": _TURN / 60e-3,
    "turn/s": _TURN,
    "Hz": _TURN,
    "deg/s": pi / 180,
}
_LINEAR_SPEEDS = {"m/s": 1.0, "mm/s": 1e-3, "m/min": 1 / 60, "km/h": 1 / 3.6}
_ANGLES = {"rad": 1.0, "mrad": 1e-3, "deg": pi / 180, "turn": _TURN}
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
_TORQUES = {
    "N·m": 1.0,
    "mN·m": 1e-3,
    "uN·m": 1e-6,
    "N·cm": 1e-2,
    "oz·in": 7.0615518e-3,
    "lb·in": 0.112984829,
}
_FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3}
_DEGREES = {"°C": 1.0}
_COMMANDS = {"1": 1.0, "%": 1e-2}

# For each quantity: unit in SI -> the spellings that lead to it.
_FAMILIES = MappingProxyType(
    {
        TIME: {"s": _TIMES},
        CURRENT: {"A": _AMPERES},
        VOLTAGE: {"V": _VOLTS},
        SUPPLY: {"V": _VOLTS},
        SPEED: {"rad/s": _SPEEDS, "m/s": _LINEAR_SPEEDS},
        POSITION: {"rad": _ANGLES, "m": _LENGTHS},
        TORQUE: {"N·m": _TORQUES, "N": _FORCES},
        AMBIENT: {"°C": _DEGREES},
        COMMAND: {"1": _COMMANDS, "V": _VOLTS},
        SET_SPEED: {"rad/s": _SPEEDS, "m/s": _LINEAR_SPEEDS},
        SET_POSITION: {"rad": _ANGLES, "m": _LENGTHS},
    }
)
QUANTITIES = tuple(_FAMILIES)
LINEAR = frozenset({"N", "m", "m/s"})  # SI units that only a linear axis has


@dataclass(frozen=True)
class Unit:
    """A unit as written, its SI unit, and how many of the latter make one."""

    written: str
    si: str
    scale: float
    counts: bool = False  # readings are whole numbers of an encoder's edges


def unit_of(quantity: str, written: str, counts_per_turn: float = 0.0) -> Unit:
    """The unit ``written`` for ``quantity``; ``counts`` need ``counts_per_turn``.

    Raises UsageError, naming the units that would do.
    """
    spelling = usual(written)
    if spelling in ("counts", "counts/s"):
        return _counts(quantity, written, spelling, counts_per_turn)
    for si, family in _FAMILIES[quantity].items():
        if spelling in family:
            return Unit(written, si, family[spelling])
    known = [name for family in _FAMILIES[quantity].values() for name in family]
    raise UsageError(
        f"{written!r} is not a unit of {quantity}{nearest(written, known)}; "
        f"known: {', '.join(known)}"
    )


def units_of(quantity: str) -> Mapping[str, tuple[str, float]]:
    """Every unit of ``quantity`` but counts: its SI unit, and how many of that make one."""
    families = _FAMILIES[quantity].items()
    return {name: (si, scale) for si, family in families for name, scale in family.items()}


_SPELLED = frozenset(
    {name for group in _FAMILIES.values() for family in group.values() for name in family}
    | {"counts", "counts/s"}
) - {"1"}


def alike(quantity: str, si: str) -> Mapping[str, float]:
    """Units that a column of ``quantity`` may as well be in, and how many ``si`` make one."""
    return _FAMILIES[quantity].get(si, {})


def _counts(quantity: str, written: str, spelling: str, counts_per_turn: float) -> Unit:
    angle = {POSITION: "rad", SET_POSITION: "rad", SPEED: "rad/s", SET_SPEED: "rad/s"}
    if quantity not in angle or (spelling == "counts/s") != angle[quantity].endswith("/s"):
        raise UsageError(f"{written!r} is not a unit of {quantity}")
    if not counts_per_turn > 0:
        raise UsageError(f"{quantity} in {written} needs --counts-per-turn, edges a turn")
    return Unit(written, angle[quantity], _TURN / counts_per_turn, spelling == "counts")


def spelled(text: str) -> str | None:
    """The time, current or other unit that a header cell spells, alone or in brackets; or None."""
    inside = text.strip().rstrip(")]").replace("[", "(").rpartition("(")[2].strip()
    spelling = usual(inside) if inside else inside
    return spelling if spelling in _SPELLED else None
