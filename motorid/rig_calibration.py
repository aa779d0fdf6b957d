"""The calibration file beside a rig file: read, held against the rig, and applied to it.

``bench.calibration.toml`` belongs to ``bench.toml``; ``motorid calibrate`` writes it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any

from motorid.errors import RigError
from motorid.rig_keys import Key, List, Number, Text, read_table, show
from motorid.rig_model import ANALOGUE, Calibration, CalibrationFile, Rig
from motorid.toml_file import closest, read_text, tables_of

FORMAT = "motorid calibration 1"
SUFFIX = ".calibration.toml"
NEAR = 3.0  # standard uncertainties
DAY_S = 86_400.0


@dataclass(frozen=True)
class Moment:
    """A date with its time and zone, as TOML has it."""

    def read(self, value: Any) -> datetime:
        """``value`` itself. Raises ValueError unless it is a date with a zone."""
        if not isinstance(value, datetime) or value.tzinfo is None:
            raise ValueError(
                f"must be a date with time and zone (2026-11-21T12:00:00Z), not {show(value)}"
            )
        return value


_ANY = Number(-1e12, 1e12)
_SIZE = Number(0, 1e12)
_GAIN = Number(1e-3, 1e3)
_SHARE = Number(0, 1)
_WHO: Mapping[str, Key | Moment] = {"date": Moment(), "instrument": Text()}
_CHANNEL: Mapping[str, Key | Moment] = {
    **_WHO,
    "instrument_serial": Text(),
    "accuracy": Text(),
    "method": Text(),
    "gain": _GAIN,
    "gain_uncertainty": _SHARE,
    "zero": _ANY,
    "zero_uncertainty": _SIZE,
    "excess": _SIZE,
    "points": List(List(_ANY)),
    "load_ohm": _SIZE,
    "load_uncertainty_ohm": _SIZE,
    "rest_date": Moment(),
    "rest_offset_counts": _ANY,
    "rest_standard_error_counts": _SIZE,
    "rest_noise_counts": _SIZE,
    "rest_drift_counts_minute": _ANY,
    "rest_drift_uncertainty_counts_minute": _SIZE,
    "offset_counts": _ANY,
    "offset_uncertainty": _SIZE,
}
TABLES: Mapping[str, Mapping[str, Key | Moment]] = {
    "": {
        "format": Text((FORMAT,)),
        "date": Moment(),
        "rig": Text(),
        "by": Text(),
        "note": Text(),
        "replaces_sha256": Text(),
    },
    "board": {"name": Text(), "serial": Text(), "firmware": Text()},
    "ambient": {"c": Number(-100, 300), "uncertainty_c": Number(0, 100)},
    **dict.fromkeys(ANALOGUE, _CHANNEL),
    "clock": {
        **_WHO,
        "rate": Number(0.5, 2),
        "uncertainty": _SHARE,
        "host_uncertainty": _SHARE,
        "span_s": _SIZE,
        "pairs": _SIZE,
    },
    "encoder": {
        **_WHO,
        "counts_per_turn": _SIZE,
        "uncertainty": _SIZE,
        "turns": _SIZE,
        "lost_counts": _ANY,
    },
    "disc": {
        **_WHO,
        **dict.fromkeys(("mass_kg", "diameter_m", "bore_m"), _SIZE),
        **dict.fromkeys(
            ("mass_uncertainty_kg", "diameter_uncertainty_m", "bore_uncertainty_m"), _SIZE
        ),
        "expected_kg_m2": _SIZE,
        "expected_uncertainty_kg_m2": _SIZE,
        "measured_kg_m2": _ANY,
        "measured_uncertainty_kg_m2": _SIZE,
        "zeta": _ANY,
        "outcome": Text(("agrees", "doubtful", "fails")),
        "says": Text(),
    },
}
APPLIED = {  # keys of a channel's table that act, and what of Calibration they are
    "gain": "gain",
    "gain_uncertainty": "gain_uncertainty",
    "offset_uncertainty": "offset_uncertainty",
    "offset_counts": "offset",
}


def path_beside(rig_path: Path) -> Path:
    """The calibration file that belongs to a rig file."""
    return rig_path.with_name(rig_path.stem + SUFFIX)


def read_calibration(path: Path) -> CalibrationFile:
    """The calibration in ``path``. Raises RigError naming file and key."""
    return parse_calibration(read_text(path, "a calibration file", RigError), str(path))


def parse_calibration(text: str, where: str) -> CalibrationFile:
    """The calibration that ``text`` (TOML) holds; ``where`` names it in errors. Raises RigError."""
    document = tables_of(text, where, RigError)
    split: dict[str, dict[str, Any]] = {"": {}}
    for name, value in document.items():
        split.setdefault(name if isinstance(value, dict) else "", {}).update(
            value if isinstance(value, dict) else {name: value}
        )
    tables = {name: _table(name, table, where) for name, table in split.items()}
    for key in ("format", "date"):
        if key not in tables[""]:
            raise RigError(f"{where}: {key} is missing: is it a file of `motorid calibrate`?")
    return CalibrationFile(where, text, tables)


def _table(name: str, table: Mapping[str, Any], where: str) -> dict[str, Any]:
    if name not in TABLES:
        near = closest(name, TABLES)
        raise RigError(f"{where}: unknown table [{name[:60]}]; the nearest is [{near}]")
    return read_table(table, TABLES[name], name, where)


def apply(rig: Rig, file: CalibrationFile) -> Rig:
    """The rig with what the calibration found put into its channels and its clock.

    Raises RigError where the file is of another board, contradicts ``counts_per_turn``, or both
    files calibrate one channel.
    """
    refuse_other_board(file, "", rig.board_serial)
    _refuse_other_encoder(rig, file)
    channels = dict(rig.calibration)
    for name in ANALOGUE:
        table = file.tables.get(name, {})
        given = {field: table[key] for key, field in APPLIED.items() if key in table}
        channels |= _merged(rig, file, name, given) if given else {}
    clock = file.tables.get("clock", {})
    return replace(
        rig,
        calibration=channels,
        clock_rate=clock.get("rate", rig.clock_rate),
        clock_uncertainty=clock.get("uncertainty", rig.clock_uncertainty),
        calibrated=file,
    )


def _merged(
    rig: Rig, file: CalibrationFile, name: str, given: Mapping[str, Any]
) -> dict[str, Calibration]:
    own, plain = rig.calibration.get(name, Calibration()), Calibration()
    for key in given:
        if getattr(own, key) != getattr(plain, key):
            raise RigError(
                f"calibration.{name}.{key} stands in the rig file and in {file.path}: keep one"
            )
    return {name: replace(own, **given)}


def _refuse_other_encoder(rig: Rig, file: CalibrationFile) -> None:
    table = file.tables.get("encoder", {})
    counted, u = table.get("counts_per_turn"), table.get("uncertainty", 0.0)
    if counted and abs(counted - rig.wiring.counts_per_turn) > NEAR * u:
        raise RigError(
            f"wiring.counts_per_turn is {rig.wiring.counts_per_turn:g}, and {file.path} counted "
            f"{counted:.1f} ± {u:.1f} a turn: correct the rig file, or count again with "
            "`motorid calibrate --step encoder`"
        )


def refuse_other_board(file: CalibrationFile, name: str, serial: str) -> None:
    """Raises RigError where ``file`` is of another board than the one of that name and serial.

    What is not known of either, "", is not compared.
    """
    board, number = file.board
    for what, calibrated, present in (("", board, name), ("serial number ", number, serial)):
        if calibrated and present and calibrated != present:
            raise RigError(
                f"{file.path} is the calibration of board {what}{calibrated}, and this board is "
                f"{what}{present}: connect that one, or calibrate this one"
            )


def citation(rig: Rig) -> dict[str, Any]:
    """What captures and estimates cite of the calibration in force; empty where there is none."""
    if rig.calibrated is None:
        return {}
    return rig.calibrated.cited() | {"max_age_days": rig.calibration_max_age_days}


def too_old(cited: Mapping[str, Any], when: datetime) -> str:
    """A sentence where a part of a calibration as cited lies further from a run than allowed."""
    then = datetime.fromisoformat(str(cited["oldest"]))
    days = abs((when - then).total_seconds()) / DAY_S
    if days <= float(cited["max_age_days"]):
        return ""
    return (
        f"the calibration {cited['name']} is old: {cited['oldest_part']} was calibrated on "
        f"{then:%Y-%m-%d}, {days:.0f} days from this run, and calibration.max_age_days is "
        f"{cited['max_age_days']:g}; calibrate again"
    )
