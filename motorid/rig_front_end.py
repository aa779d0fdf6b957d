"""A front-end file: what measures current and voltages before a board's converter, as facts.

``rigs/frontends/`` has one for each part that is common; ``motorid board set`` stores one.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from motorid.capture.model import CURRENT
from motorid.errors import RigError
from motorid.rig_keys import (
    BENT,
    CURVE,
    DRIFT,
    DRIFT_TIME,
    Flag,
    Key,
    List,
    Number,
    Text,
    read_table,
    show,
)
from motorid.rig_model import Calibration, Rig
from motorid.toml_file import dotted, packaged, read_text, tables_of, unknown
from motorid.wire.enums import Bridge, Sensor
from motorid.wire.hashes import front_end_hash

GAIN_UNIT, ZERO_UNIT_V, FILTER_UNIT_S = 1e-5, 1e-4, 1e-7  # of the wire
U16 = (1 << 16) - 1
NAME_LETTERS = 16
BOARDS = ("uno", "mega", "pico")  # a Nano is an Uno
FAMILY = "motorid-"  # before the name that such a board tells
MOST_LIFT = 0.75  # of the reference
_SHARE = Number(0, 0.6)  # what the wire holds: 65535 of 1e-5
_FILTER = List(Number(1e-7, 6e-3), 2)  # time constants, one behind the other
_TOP: Mapping[str, Key] = {
    "name": Text(),
    "sensor": Text(tuple(one.name.lower() for one in Sensor)),
    "ratiometric": Flag(),
    "bridge": Text(tuple(one.name.lower() for one in Bridge)),
    "boards": List(Text(BOARDS)),
    "sources": List(Text()),
}
_SECTIONS: Mapping[str, Mapping[str, Key]] = {
    "converter": {
        "reference_v": Number(0.5, 10),
        "reference_uncertainty": _SHARE,
        "reference_drift": DRIFT,
        "reference_time_s": DRIFT_TIME,
    },
    "current": {
        "volts_per_ampere": Number(-1e3, 1e3),
        "zero_v": Number(0, 10),
        "zero_uncertainty_v": Number(0, 5),
        "gain_uncertainty": _SHARE,
        "nonlinearity": BENT,
        "nonlinearity_shape": CURVE,
        "most_a": Number(1e-3, 4e6),
        "filter_s": _FILTER,
    },
    "voltage": {
        "divider": Number(0.1, 1e3),
        "supply_divider": Number(0.1, 1e3),
        "lift_v": Number(0, 7.5),
        "gain_uncertainty": _SHARE,
        "filter_s": _FILTER,
    },
}
_DRIFT = ("reference_drift", "reference_time_s")
_BENT = ("nonlinearity", "nonlinearity_shape")
_OPTIONAL = (
    *("sources", "supply_divider", "filter_s", "bridge", "boards", "ratiometric"),
    *_DRIFT,
    *_BENT,
)


@dataclass(frozen=True)
class FrontEnd:
    """One front end. ``facts``: the fields of write_front_end; ``text``: the file.

    ``boards``: those whose converter and wiring it is for; empty: it does not say.
    ``drift`` of the reference and ``bent``, the non-linearity of the current's sensor, by the names
    of ``Wiring`` and ``Calibration``: no board holds them.
    """

    facts: Mapping[str, Any]
    text: str
    boards: tuple[str, ...] = ()
    drift: Mapping[str, Any] = field(default_factory=dict)
    bent: Mapping[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Its name, as the board tells it."""
        return str(self.facts["name"])

    @property
    def hash(self) -> int:
        """The hash that a board tells which holds these facts."""
        return front_end_hash(self.facts)

    def misfit(self, board: str) -> str:
        """Why it does not belong to the board that tells this name, or ""."""
        known = board.removeprefix(FAMILY)
        if not self.boards or known not in BOARDS or known in self.boards:
            return ""
        return (
            f"the front end {self.name} is that of {' or '.join(self.boards)}, and {board} has "
            "another reference and other dividers"
        )

    def under(self, rig: Rig) -> Rig:
        """The rig with what no board holds of it, as far as the rig says nothing itself."""
        wiring, channels = rig.wiring, dict(rig.calibration)
        if self.drift and wiring.reference_drift is None:
            wiring = replace(wiring, **self.drift)
        own = channels.get(CURRENT, Calibration())
        if self.bent and own.nonlinearity is None:
            channels[CURRENT] = replace(own, **self.bent)
        return replace(rig, wiring=wiring, calibration=channels)


def presets() -> tuple[str, ...]:
    """Names of the front ends that come with motorid."""
    return tuple(sorted(path.stem for path in packaged("rigs/frontends").glob("*.toml")))


def load_front_end(name_or_path: str, beside: Path | None = None) -> FrontEnd:
    """The front end of a preset's name or of a file; a path may count from ``beside``.

    Raises RigError, naming file and key, where it is absent, unreadable or absurd.
    """
    path = _find(name_or_path, beside)
    return parse(read_text(path, "a front-end file", RigError), str(path))


def parse(text: str, where: str = "front end") -> FrontEnd:
    """The front end that ``text`` (TOML) describes; ``where`` names it. Raises RigError."""
    document = tables_of(text, where, RigError)
    if problem := unknown(document, (*_TOP, *_SECTIONS)):
        raise RigError(f"{where}: {problem}")
    plain = {key: document[key] for key in _TOP if key in document}
    top = _read(plain, _TOP, "", where)
    parts = {
        name: _read(document.get(name, {}), _SECTIONS[name], name, where) for name in _SECTIONS
    }
    _consistent(top, parts, where)
    converter, current = parts["converter"], parts["current"]
    bent = {key: current[key] for key in _BENT if key in current}
    return FrontEnd(
        _facts(top, parts, where),
        text,
        tuple(top.get("boards", ())),
        drift={key: converter[key] for key in _DRIFT if key in converter},
        bent=bent | {"full_scale": current["most_a"]} if bent else {},
    )


def _read(table: Any, keys: Mapping[str, Key], section: str, where: str) -> dict[str, Any]:
    found = read_table(table, keys, section, where)
    for key in keys:
        if key not in found and key not in _OPTIONAL:
            raise RigError(f"{where}: {dotted(section, key)} is missing: it has no safe default")
    return found


def _consistent(top: dict[str, Any], parts: dict[str, dict[str, Any]], where: str) -> None:
    name, current, volts = top["name"], parts["current"], parts["voltage"]
    reference = parts["converter"]["reference_v"]
    if not 0 < len(name) <= NAME_LETTERS or not (name.isascii() and name.isprintable()):
        raise RigError(f"{where}: name must be 1 to {NAME_LETTERS} plain letters, not {show(name)}")
    if abs(current["volts_per_ampere"]) < 1e-5:
        raise RigError(f"{where}: current.volts_per_ampere is too near to 0 to measure anything")
    if current["zero_v"] > reference:
        raise RigError(f"{where}: current.zero_v lies above converter.reference_v")
    if top["sensor"] != "magnitude" and not 0.02 < current["zero_v"] / reference < 0.98:
        raise RigError(
            f"{where}: current.zero_v lies at an end of the range, where a {top['sensor']} shows "
            'one sign alone: set sensor = "magnitude", or correct the zero'
        )
    for keys, table, section in (
        (_DRIFT, parts["converter"], "converter"),
        (_BENT, current, "current"),
    ):
        if 0 < sum(key in table for key in keys) < len(keys):
            raise RigError(
                f"{where}: {section}.{keys[0]} and {section}.{keys[1]} go together: state both"
            )
    if volts["lift_v"] > MOST_LIFT * reference:
        raise RigError(f"{where}: voltage.lift_v leaves no range below converter.reference_v")


def _facts(top: dict[str, Any], parts: dict[str, dict[str, Any]], where: str) -> dict[str, Any]:
    """The wire's fields. A sensor that follows the reference has not the reference's error."""
    converter, current, volts = parts["converter"], parts["current"], parts["voltage"]
    ratiometric = top.get("ratiometric", False)
    doubt = 0.0 if ratiometric else converter["reference_uncertainty"]
    zero = math.hypot(current["zero_uncertainty_v"], doubt * current["zero_v"])
    gain = math.hypot(current["gain_uncertainty"], doubt)
    both = math.hypot(volts["gain_uncertainty"], converter["reference_uncertainty"])
    counted = {
        "max_current_ma": current["most_a"] * 1e3,
        **_filter("current", current.get("filter_s", ())),
        **_filter("voltage", volts.get("filter_s", ())),
        "current_gain_uncertainty": gain / GAIN_UNIT,
        "voltage_gain_uncertainty": both / GAIN_UNIT,
        "current_zero_uncertainty": zero / ZERO_UNIT_V,
    }
    for name, value in counted.items():
        if name != "max_current_ma" and value > U16:
            raise RigError(f"{where}: {name.replace('_', ' ')} is larger than a board can hold")
    return {
        "name": top["name"],
        "sensor": int(Sensor[top["sensor"].upper()]),
        "ratiometric": int(ratiometric),
        "bridge": int(Bridge[top.get("bridge", "mosfet").upper()]),
        "reference_v": converter["reference_v"],
        "current_v_a": current["volts_per_ampere"],
        "current_zero_v": current["zero_v"],
        "voltage_divider": volts["divider"],
        "supply_divider": volts.get("supply_divider", volts["divider"]),
        "lift_v": volts["lift_v"],
        **{name: round(value) for name, value in counted.items()},
    }


def _filter(name: str, seconds: tuple[float, ...]) -> dict[str, float]:
    """Coefficients of s and the root of that of s², of filters one behind the other."""
    root = math.sqrt(math.prod(seconds)) if len(seconds) > 1 else 0.0
    return {
        f"{name}_filter": sum(seconds) / FILTER_UNIT_S,
        f"{name}_filter2": root / FILTER_UNIT_S,
    }


def _find(name_or_path: str, beside: Path | None) -> Path:
    bare = Path(name_or_path).name == name_or_path and not Path(name_or_path).suffix
    preset = packaged("rigs/frontends") / f"{name_or_path}.toml"
    if bare and preset.is_file():
        return preset
    path = (beside or Path()) / name_or_path
    if "\0" not in name_or_path and path.is_file():
        return path
    near = difflib.get_close_matches(Path(name_or_path).stem, presets(), n=1)
    hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(presets())}"
    raise RigError(f"no front-end file {show(name_or_path)}; {hint}")
