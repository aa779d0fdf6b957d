"""A calibration as the text of its file."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from motorid import json_text

HEAD = """\
# Written by `motorid calibrate`. It holds whenever the rig file beside it is loaded.
# Uncertainties are standard ones. Calibrate again rather than edit: earlier files are kept.
"""


def render(tables: Mapping[str, Mapping[str, Any]]) -> str:
    """TOML of ``tables`` by name, of which "" is the top: numbers, texts, dates and lists."""
    parts = [HEAD + _lines(tables.get("", {}))]
    parts += [f"[{name}]\n{_lines(table)}" for name, table in tables.items() if name and table]
    return "\n".join(parts)


def _lines(table: Mapping[str, Any]) -> str:
    return "".join(f"{key} = {_value(value)}\n" for key, value in table.items())


def _value(value: Any) -> str:
    match value:
        case datetime():
            return value.isoformat(timespec="seconds")
        case str():
            return json_text.dumps(value)  # its escapes are those of TOML too
        case bool():
            return "true" if value else "false"
        case list() | tuple():
            return "[" + ", ".join(_value(one) for one in value) + "]"
    return repr(float(value)) if isinstance(value, float) else repr(int(value))
