"""What a person states of a motor without a rig: tables of a file, or KEY=VALUE."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from motorid.capture.model import Stated
from motorid.errors import MotoridError, RigError, UsageError
from motorid.rig_keys import SECTIONS, Number
from motorid.toml_file import closest, read_text, tables_of, unknown

PLATE, THERMAL = "nameplate", "thermal"
KEYS: Mapping[str, Number] = {
    name: key
    for section in (PLATE, THERMAL)
    for name, key in SECTIONS[section].items()
    if isinstance(key, Number)
}
ELSEWHERE = (
    "name",
    "port",
    "board_serial",
    "front_end",
    "calibration",
    *SECTIONS,
)  # of a whole rig file
SUCH_AS = "--nameplate torque_constant_nm_a=0.0514"


def read_nameplate(said: Iterable[str]) -> Stated:
    """What each of ``said`` states, a later one over an earlier: a file, or ``KEY=VALUE``.

    Keys, units and ranges are those of a rig file's [nameplate] and [thermal]. A file may hold
    these tables, their keys alone, or a whole rig. Raises UsageError on a bad key or value,
    RigError on a bad file.
    """
    found = Stated()
    for one in said:
        key, equals, value = (part.strip() for part in one.partition("="))
        if equals and not Path(one).is_file():
            found = found.under(of_numbers({key: _number(key, value)}))
        else:
            found = found.under(_of_file(one))
    return found


def of_numbers(numbers: Mapping[str, Any]) -> Stated:
    """By key, in SI. Raises UsageError on an unknown key, or a value out of its range."""
    return _checked(numbers, "--nameplate ", UsageError)


def _number(key: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise UsageError(
            f"--nameplate {key}={text}: give a number in SI units, such as {SUCH_AS}"
        ) from None


def _of_file(name: str) -> Stated:
    path = Path(name)
    if not (name and path.exists()):
        raise UsageError(
            f"--nameplate {name!r}: there is no such file; name one, or give KEY=VALUE, such as "
            f"{SUCH_AS}"
        )
    tables = tables_of(read_text(path, "a nameplate file", RigError), str(path), RigError)
    sections = [tables[name] for name in (PLATE, THERMAL) if name in tables]
    if not sections:
        sections = [tables]
    elif said := unknown(tables, ELSEWHERE):
        raise RigError(f"{path}: {said}")
    if not all(isinstance(table, dict) for table in sections):
        raise RigError(f"{path}: nameplate and thermal must be tables")
    numbers = {key: value for table in sections for key, value in table.items()}
    if not numbers:
        raise RigError(f"{path}: it states nothing of a motor: see [nameplate] of a rig file")
    return _checked(numbers, f"{path}: ", RigError)


def _checked(numbers: Mapping[str, Any], where: str, error: type[MotoridError]) -> Stated:
    tables: dict[str, dict[str, float]] = {PLATE: {}, THERMAL: {}}
    for key, value in numbers.items():
        if key not in KEYS:
            raise error(
                f"{where}{key}: no such key of a nameplate; the nearest is {closest(key, KEYS)}; "
                f"known: {', '.join(KEYS)}"
            )
        try:
            number = KEYS[key].read(value)
        except ValueError as problem:
            raise error(f"{where}{key} {problem}") from None
        tables[PLATE if key in SECTIONS[PLATE] else THERMAL][key] = number
    return Stated(tables[PLATE], tables[THERMAL])
