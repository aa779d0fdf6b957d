"""The user's own defaults of options, in one file: which rig, which port.

A default is what one would else type each time. Limits, calibration and gains are never among
them: they belong to the rig file, where the next person finds them.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from motorid.errors import UsageError

PLACE = "MOTORID_CONFIG"  # a file, in place of the usual one
MEASURING = ("run", "capture", "check", "station")


@dataclass(frozen=True)
class Setting:
    """``commands`` take it as their parameter ``parameter``; ``kind`` is str, or int."""

    commands: tuple[str, ...]
    parameter: str
    meaning: str
    kind: type = str


SETTINGS = {
    # never of check: there a rig, beside --capture, changes the meaning of stored readings
    "rig": Setting(
        ("run", "capture", "station", "plan"), "rig_name", "rig file, or a packaged rig's name"
    ),
    "port": Setting(MEASURING, "port", "port in place of the rig file's; auto: the only board"),
    "note": Setting(("run", "capture"), "note", "free text kept in each capture"),
    "product": Setting(("check", "station"), "product_name", "product file, or a packaged one"),
    "history": Setting(("check", "station"), "history", "history that gets the verdicts"),
    "station": Setting(("station",), "name", "this station's name in the history"),
    "jobs": Setting(("compare",), "jobs", "processes of a comparison; -1 is one a core", int),
}
ELSEWHERE = {
    "limit": "limits of a rig belong into its rig file",
    "calibrat": "a calibration belongs beside its rig file: motorid calibrate",
    "gain": "gains belong into the calibration of a rig: motorid calibrate",
}


def place() -> Path:
    """The file of the defaults; it need not exist."""
    return Path(os.environ.get(PLACE) or Path(click.get_app_dir("motorid")) / "config.toml")


def read() -> dict[str, Any]:
    """What is set, by the keys of SETTINGS. Raises UsageError naming file and key."""
    path = place()
    if not path.is_file():
        return {}
    from motorid.toml_file import read_text, tables_of

    found = tables_of(
        read_text(path, "motorid's file of defaults", UsageError), str(path), UsageError
    )
    for key, value in found.items():
        check(key, value, str(path))
    return found


def check(key: str, value: Any, where: str) -> None:
    """Raises UsageError where ``key`` cannot be set, or not to ``value``."""
    if key not in SETTINGS:
        from motorid.errors import nearest

        told = next((said for part, said in ELSEWHERE.items() if part in key), "")
        raise UsageError(
            f"{where}: {key[:60]!r} is no default{nearest(key, SETTINGS)}"
            f"{'; ' + told if told else ''}; the defaults are {', '.join(SETTINGS)}"
        )
    kind = SETTINGS[key].kind
    if not isinstance(value, kind) or isinstance(value, bool) or value == "":
        name = "a whole number" if kind is int else "a text"
        raise UsageError(f"{where}: {key} is to be {name}, not {value!r}")


def defaults() -> dict[str, dict[str, object]]:
    """The defaults of each command, as click takes them. Raises what ``read`` raises."""
    found: dict[str, dict[str, object]] = {}
    for key, value in read().items():
        for command in SETTINGS[key].commands:
            found.setdefault(command, {})[SETTINGS[key].parameter] = value
    return found


def taken(context: click.Context | None) -> dict[str, str]:
    """The settings that the running command took from the file, for its capture to record."""
    if context is None:
        return {}
    from click.core import ParameterSource

    return {
        key: str(context.params[one.parameter])
        for key, one in SETTINGS.items()
        if one.parameter in context.params
        and context.get_parameter_source(one.parameter) == ParameterSource.DEFAULT_MAP
    }


def write(values: Mapping[str, Any]) -> Path:
    """Writes the file with ``values`` and nothing else; returns its path."""
    from motorid.capture.whole import write_whole
    from motorid.json_text import dumps

    path = place()
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [
        f"{key} = {dumps(value).strip()}  # {SETTINGS[key].meaning}"
        for key, value in values.items()
    ]
    head = "# Defaults of motorid's options: motorid config\n"
    write_whole(path, (head + "".join(f"{line}\n" for line in lines)).encode(), force=True)
    return path
