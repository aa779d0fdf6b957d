"""A TOML file that a person wrote: text, tables, and one sentence for what is wrong in it."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from motorid.errors import MotoridError
from motorid.limits import TOML
from motorid.reading import read_file

LONGEST_SHOWN = 60  # of a name that is none


def packaged(folder: str) -> Path:
    """A folder inside an installed package, else beside the package in a working copy."""
    inside = Path(__file__).parent / folder
    return inside if inside.is_dir() else Path(__file__).parent.parent / folder


def read_text(path: Path, what: str, error: type[MotoridError]) -> str:
    """The text of ``path``, which is to be ``what`` ("a rig file"). Raises ``error``."""
    data = read_file(path, error, TOML.file, what)
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError:
        raise error(f"{path}: not UTF-8 text: is it {what}?") from None


def tables_of(text: str, where: str, error: type[MotoridError]) -> dict[str, Any]:
    """The document that ``text`` is; ``where`` names it. Raises ``error``."""
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, ValueError, RecursionError) as problem:
        raise error(f"{where}: not valid TOML: {problem}") from None


def unknown(table: Iterable[str], known: Iterable[str], section: str = "") -> str:
    """A sentence on the first key of ``table`` that is not known, or nothing."""
    names = tuple(known)
    for key in table:
        if key not in names:
            near = closest(key, names)
            wrong, right = dotted(section, key[:LONGEST_SHOWN]), dotted(section, near)
            return f"unknown key {wrong}; the nearest is {right}"
    return ""


def closest(name: str, known: Iterable[str]) -> str:
    """The known name that is most like ``name``."""
    return difflib.get_close_matches(name[:LONGEST_SHOWN], list(known), n=1, cutoff=0.0)[0]


def dotted(section: str, key: str) -> str:
    """How a key is named to a person."""
    return f"{section}.{key}" if section else key
