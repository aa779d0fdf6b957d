"""How an instrument wants to be spoken to: its commands as data, one file a family.

``{value}`` stands for a number, ``{channel}`` for the output that the bench names, ``{source}`` for
a recorder's input, ``{sources}`` and ``{inputs}`` for all of them and their number, ``{points}``,
``{readings}`` (of all inputs), ``{rate_hz}``, ``{period_s}`` and ``{duration_s}`` for what a run
needs.
"""

from __future__ import annotations

import string
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motorid.errors import RigError
from motorid.rig_keys import Flag, Key, List, Number, Text, read_table, show
from motorid.toml_file import packaged, read_text, tables_of, unknown

FOLDER = "rigs/instruments"
_LINES = List(Text(), 40)
READING, TIME, CHANNEL = "reading", "time", "channel"
ELEMENTS = (READING, TIME, CHANNEL, "other")  # of a scan's answer, reading by reading
_TOP: Mapping[str, Key] = {
    "kind": Text(("supply", "recorder")),
    "name": Text(),
    "error": Text(),
    "prepare": _LINES,
}
_PAIR: Mapping[str, Key] = {"set": Text(), "ask": Text()}
_PROTECTION: Mapping[str, Key] = {
    **_PAIR,
    "on": Text(),
    "is_on": Text(),
    "tripped": Text(),
}
SUPPLY: Mapping[str, Mapping[str, Key]] = {
    "voltage": _PAIR,
    "current_limit": {**_PAIR, "protects": Flag()},
    "over_voltage": _PROTECTION,
    "over_current": _PROTECTION,
    "output": {"on": Text(), "off": Text(), "ask": Text()},
    "limiting": {"ask": Text(), "mask": Number(1, 2**31), "word": Text()},
    "measure": {
        "current": Text(),
        "current_field": Number(0, 100),
        "terminal_voltage": Text(),
        "terminal_voltage_field": Number(0, 100),
    },
}
RECORDER: Mapping[str, Mapping[str, Key]] = {
    "acquire": {
        "start": _LINES,
        "done": Text(),
        "mask": Number(1, 2**31),
        "value": Number(0, 2**31),
        "stop": _LINES,
    },
    "waveform": {
        "select": _LINES,
        "preamble": Text(),
        "origin": Text(("volts", "counts")),
        "data": Text(),
        "type": Text(("B", "b", "H", "h", "f", "d", "ascii")),
        "big_endian": Flag(),
        "raw_min": Number(-(2**31), 2**31),
        "raw_max": Number(-(2**31), 2**31),
    },
    "scan": {"data": Text(), "elements": List(Text(ELEMENTS), 10)},
}
_NEEDED = {
    "supply": {
        "voltage": ("set", "ask"),
        "current_limit": ("set", "ask"),
        "output": ("on", "off", "ask"),
    },
    "recorder": {"acquire": ("start",), "waveform": ("preamble", "data", "type")},
}
_SCANS = {"acquire": ("start",), "scan": ("data", "elements")}  # in place of waveforms
_FIELDS = (
    *("value", "channel", "source", "sources", "inputs", "points", "readings"),
    *("rate_hz", "period_s", "duration_s"),
)


@dataclass(frozen=True)
class Dialect:
    """A family's commands: ``tables[section][key]``, and what stands at the top."""

    kind: str
    name: str
    error: str
    prepare: tuple[str, ...]
    tables: Mapping[str, Mapping[str, Any]]

    def get(self, section: str, key: str) -> Any:
        """A command, a mask or a list of commands; "" where the family has none."""
        return self.tables.get(section, {}).get(key, "")


def load_dialect(name_or_path: str, folder: Path, kind: str) -> Dialect:
    """One that comes with motorid, or a file, by its path from ``folder``. Raises RigError."""
    own = packaged(FOLDER) / f"{name_or_path}.toml"
    bare = Path(name_or_path).name == name_or_path and not Path(name_or_path).suffix
    path = own if bare else folder / name_or_path
    if bare and not own.is_file():
        known = ", ".join(sorted(one.stem for one in packaged(FOLDER).glob("*.toml")))
        raise RigError(
            f"there is no dialect {show(name_or_path)}; known: {known}, or a file's path"
        )
    found = parse(read_text(path, "a dialect of instruments", RigError), str(path))
    if found.kind != kind:
        raise RigError(f"{path}: this is the dialect of a {found.kind}, and a {kind} is asked for")
    return found


def parse(text: str, where: str) -> Dialect:
    """The dialect that ``text`` (TOML) describes. Raises RigError."""
    document = tables_of(text, where, RigError)
    top = {key: document[key] for key in _TOP if key in document}
    plain = read_table(top, _TOP, "", where)
    if "kind" not in plain:
        raise RigError(f'{where}: kind is missing: write kind = "supply" or "recorder"')
    sections = SUPPLY if plain["kind"] == "supply" else RECORDER
    if problem := unknown(document, (*_TOP, *sections)):
        raise RigError(f"{where}: {problem}")
    tables = {
        name: read_table(document[name], keys, name, where)
        for name, keys in sections.items()
        if name in document
    }
    for section, keys in (_SCANS if "scan" in tables else _NEEDED[plain["kind"]]).items():
        for key in keys:
            if not tables.get(section, {}).get(key):
                raise RigError(f"{where}: {section}.{key} is missing: nothing works without it")
    elements = tables.get("scan", {}).get("elements", ELEMENTS)
    if lacking := [one for one in (READING, TIME, CHANNEL) if elements.count(one) != 1]:
        raise RigError(f"{where}: scan.elements must hold {show(lacking[0])} once")
    found = Dialect(
        plain["kind"],
        plain.get("name", Path(where).stem),
        plain.get("error", "SYST:ERR?"),
        plain.get("prepare", ()),
        tables,
    )
    _check_fields(found, where)
    return found


def _check_fields(found: Dialect, where: str) -> None:
    """Raises RigError on a brace that is no field: it would fail in mid-run."""
    texts = [*found.prepare]
    for table in found.tables.values():
        for value in table.values():
            texts += (
                [value] if isinstance(value, str) else value if isinstance(value, tuple) else []
            )
    for text in texts:
        try:
            named = {name for _, name, _, _ in string.Formatter().parse(text) if name is not None}
        except ValueError:
            named = {text}
        if wrong := named - set(_FIELDS):
            raise RigError(
                f"{where}: {show(text)}: {show(sorted(wrong)[0])} is no field; known: "
                f"{', '.join(_FIELDS)}"
            )
