"""What a rig file may say: every table's keys, with their types and reasonable ranges."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, get_args

from motorid.capture.model import CURRENT, POSITION, SUPPLY, VOLTAGE, Curve
from motorid.errors import RigError
from motorid.excitation import TAPS
from motorid.program import Rotor, StepKind
from motorid.toml_file import dotted, unknown

CHANNELS = (CURRENT, VOLTAGE, SUPPLY, POSITION)


@dataclass(frozen=True)
class Number:
    """A number from ``low`` to ``high``."""

    low: float
    high: float

    def read(self, value: Any) -> float:
        """``value`` as a float. Raises ValueError saying what was wanted."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"must be a number, not {show(value)}")
        if not self.low <= value <= self.high:  # NaN fails too
            raise ValueError(f"must lie between {self.low:g} and {self.high:g}, not {show(value)}")
        return float(value)


@dataclass(frozen=True)
class Whole:
    """A whole number from ``low`` to ``high``."""

    low: int
    high: int

    def read(self, value: Any) -> int:
        """``value`` itself. Raises ValueError saying what was wanted."""
        if isinstance(value, bool) or not isinstance(value, int):
            raise ValueError(f"must be a whole number, not {show(value)}")
        if not self.low <= value <= self.high:
            raise ValueError(f"must lie between {self.low} and {self.high}, not {show(value)}")
        return value


@dataclass(frozen=True)
class Text:
    """A short text, or one of ``choices``."""

    choices: tuple[str, ...] = ()

    def read(self, value: Any) -> str:
        """``value`` as text. Raises ValueError saying what was wanted."""
        if not isinstance(value, str) or len(value) > 1000:
            raise ValueError(f"must be a short text, not {show(value)}")
        if self.choices and value not in self.choices:
            raise ValueError(f"must be one of {', '.join(self.choices)}, not {show(value)}")
        return value


@dataclass(frozen=True)
class Flag:
    """true or false."""

    def read(self, value: Any) -> bool:
        """``value`` itself. Raises ValueError unless it is true or false."""
        if not isinstance(value, bool):
            raise ValueError(f"must be true or false, not {show(value)}")
        return value


@dataclass(frozen=True)
class List:
    """A list of at least one ``item`` and at most ``longest``."""

    item: Number | Text | List
    longest: int = 200

    def read(self, value: Any) -> tuple[Any, ...]:
        """The items read. Raises ValueError saying what was wanted."""
        if not isinstance(value, list) or not 0 < len(value) <= self.longest:
            raise ValueError(f"must be a list of 1 to {self.longest} items, not {show(value)}")
        return tuple(self.item.read(one) for one in value)


Key = Number | Whole | Text | Flag | List
_OHM, _SHARE = Number(0, 1e4), Number(0, 1)
_DURATION = Number(1e-6, 1e6)
_DECAY = Text(("synchronous_slow", "diode", "fast"))
CURVE = Text(get_args(Curve))
BENT, DRIFT, DRIFT_TIME = Number(0, 0.5), Number(0, 0.5), Number(1e-6, 1e6)

SECTIONS: Mapping[str, Mapping[str, Key]] = {
    "wiring": {
        "bridge_resistance_ohm": _OHM,
        "bridge_resistance_uncertainty_ohm": _OHM,
        "bridge_drop_v": Number(0, 1e2),
        "bridge_drop_uncertainty_v": Number(0, 1e2),
        "lead_resistance_ohm": _OHM,
        "lead_resistance_uncertainty_ohm": _OHM,
        "gear_ratio": Number(1e-4, 1e5),
        "counts_per_turn": Number(0, 1e8),
        "encoder_reversed": Flag(),
        "voltage_sense": Text(("terminals", "bridge", "supply")),
        "supply_voltage_v": Number(0.1, 1e3),
        "pwm_alignment": _SHARE,
        "brush_drop_v": Number(0, 1e2),
        "brush_drop_uncertainty_v": Number(0, 1e2),
        "encoder_eccentricity_rad": Number(0, 0.5),
        "reference_drift": DRIFT,
        "reference_time_s": DRIFT_TIME,
        "terminal_load_ohm": Number(0, 1e9),
        "terminal_load_uncertainty_ohm": Number(0, 1e9),
    },
    "limits": {
        "current_a": Number(1e-3, 1e4),
        "speed_rad_s": Number(1e-2, 1e6),
        "supply_min_v": Number(0, 1e3),
        "supply_max_v": Number(0.1, 1e3),
        "run_time_s": Number(0.01, 4e6),
        "host_silence_s": Number(0.02, 60),
        "voltage_v": Number(0.1, 1e3),
        "inputs": List(Text(("part_present", "guard_closed")), 2),
        "sign_check_s": Number(0, 60),
    },
    "nameplate": {
        "resistance_ohm": Number(1e-4, 1e5),
        "inductance_h": Number(1e-9, 1e2),
        "torque_constant_nm_a": Number(1e-6, 1e4),
        "inertia_kg_m2": Number(1e-12, 1e6),
        "no_load_current_a": Number(1e-6, 1e4),
        "rated_current_a": Number(1e-6, 1e4),
        "voltage_v": Number(0.1, 1e3),
    },
    "thermal": {
        "winding_k_w": Number(1e-4, 1e4),
        "winding_s": Number(1e-2, 1e5),
        "copper_per_k": Number(0, 0.01),
        "copper_uncertainty_per_k": Number(0, 0.01),
        "magnet_per_k": Number(-0.02, 0.02),
        "magnet_uncertainty_per_k": Number(0, 0.02),
    },
    "sampling": {
        "rate_hz": Number(0.1, 1e6),
        "channels": List(Text(CHANNELS), 4),
        "mode": Text(("stream", "burst")),
    },
    "conditions": {
        "ambient_c": Number(-100, 300),
        "ambient_uncertainty_c": Number(0, 100),
    },
    "program": {
        "levels_v": List(List(Number(-1e3, 1e3))),
        "levels_duty": List(List(Number(-1, 1))),
        "drive_s": _DURATION,
        "coast_s": _DURATION,
        "rest_s": _DURATION,
        "decay": _DECAY,
    },
}
HELD: Mapping[str, Key] = {  # of [program], beside steps or climbs
    "rotor": Text(tuple(one.value for one in Rotor if one is not Rotor.FREE)),
    "energy_j": Number(1e-6, 1e6),
}
PRBS, MULTISINE, SLOW_TURN = "prbs", "multisine", "slow_turn"
SIGNALS = (PRBS, MULTISINE)  # for a rotor that is held
STEP: Mapping[str, Key] = {
    "kind": Text((*(kind.name.lower() for kind in StepKind), *SIGNALS, SLOW_TURN)),
    "duration_s": _DURATION,
    "volts": Number(-1e3, 1e3),
    "duty": Number(-1, 1),
    "decay": _DECAY,
    "amplitude_v": Number(1e-3, 1e3),
    "amplitude_duty": Number(1e-6, 1),
    "bits": Whole(min(TAPS), max(TAPS)),
    "tones": Whole(1, 100),
    "points": Whole(4, 1000),
    "turns": Number(0.1, 1e3),
}
CALIBRATION: Mapping[str, Key] = {
    "gain": Number(1e-3, 1e3),
    "gain_uncertainty": _SHARE,
    "offset_uncertainty": Number(0, 1e4),
    "delay_uncertainty_s": Number(0, 1),
    "offset": Number(-1e6, 1e6),
    "nonlinearity": BENT,
    "nonlinearity_shape": CURVE,
    "full_scale": Number(1e-6, 1e6),
}
CALIBRATION_FILE: Mapping[str, Key] = {  # of [calibration] itself
    "file": Text(),
    "max_age_days": Number(0, 1e5),
}
REQUIRED = {
    "limits": ("current_a", "speed_rad_s", "supply_min_v", "supply_max_v"),
    "sampling": ("rate_hz",),
}


def show(value: Any) -> str:
    """``value`` as an error quotes it: short."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


class Checked(Protocol):
    """What a key may hold. ``read``: the value; raises ValueError with what it must be."""

    def read(self, value: Any) -> Any: ...


def read_table(table: Any, keys: Mapping[str, Checked], section: str, where: str) -> dict[str, Any]:
    """The values of one table, checked. Raises RigError naming ``where`` and the key."""
    if not isinstance(table, dict):
        raise RigError(f"{where}: [{section}] must be a table, not {show(table)}")
    if problem := unknown(table, keys, section):
        raise RigError(f"{where}: {problem}")
    found = {}
    for key, value in table.items():
        try:
            found[key] = keys[key].read(value)
        except ValueError as error:
            raise RigError(f"{where}: {dotted(section, key)} {error}") from None
    return found
