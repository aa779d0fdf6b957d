"""JSON in and out, strictly as RFC 8259 has it: every reader and writer here goes through this.

Python's own writes and reads ``NaN``, ``Infinity`` and lone surrogates, which no other program
takes, and reads ``1e999`` as infinity. None of them gets in here, and none gets out.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motorid.errors import MotoridError
from motorid.limits import JSON
from motorid.reading import read_file
from motorid.visible import HIDDEN

LARGEST = 1 << 64  # an integer beyond it fits no column and no counter


class JsonError(ValueError):
    """A text that is no strict JSON; the message is the end of a sentence: "is not JSON: ..."."""


def dumps(value: Any, *, indent: int | None = None) -> str:
    """Strict JSON of ``value`` for people and programs, in UTF-8 once encoded.

    What is not finite is null. Control characters and halves of surrogate pairs are escaped, so
    that the text can go to a terminal too. What JSON does not know (a path, a date) is its text.
    """
    text = json.dumps(plain(value), indent=indent, ensure_ascii=False, allow_nan=False)
    return HIDDEN.sub(lambda found: _escaped(found.group()), text)


def canonical(value: Any, *, blanks: bool = True) -> str:
    """One text for one value, for a digest: ASCII, sorted keys, ``blanks`` after , and : or not."""
    separators = None if blanks else (",", ":")
    return json.dumps(plain(value), sort_keys=True, separators=separators, allow_nan=False)


def loads(text: str | bytes) -> Any:
    """The value of a strict JSON text; bytes are UTF-8. Raises JsonError, in words."""
    try:
        decoded = text if isinstance(text, str) else text.decode("utf-8-sig")
        value = json.loads(
            decoded,
            parse_constant=_constant,
            parse_float=_float,
            parse_int=_int,
            object_pairs_hook=_object,
        )
        _refuse_surrogates(decoded, value)
    except JsonError:
        raise
    except UnicodeDecodeError:
        raise JsonError("it is not UTF-8 text") from None
    except RecursionError:
        raise JsonError("it is nested too deeply") from None
    except ValueError as error:
        raise JsonError(str(error)) from None
    return value


def read_object(path: Path, error: type[MotoridError]) -> dict[str, Any]:
    """The JSON object in a file. Raises ``error``, naming ``path``, where it holds none."""
    try:
        value = loads(read_file(path, error, JSON.file, "a JSON file"))
    except JsonError as problem:
        raise error(f"{path}: not JSON: {problem}") from None
    if not isinstance(value, dict):
        raise error(f"{path}: not a JSON object: is it the right file?")
    return value


def plain(value: Any) -> Any:
    """``value`` as strict JSON knows it: arrays unwrapped, NaN and infinity null, keys text."""
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(one) for one in value]
    if hasattr(value, "tolist"):  # an array or a scalar of numpy, which this need not import
        return plain(value.tolist())
    return str(value)


def _escaped(character: str) -> str:
    if "\ud800" <= character <= "\udfff":
        return "\ufffd"  # stands for no character, and strict JSON has no way to write it
    return f"\\u{ord(character):04x}"


def _constant(name: str) -> Any:
    raise JsonError(f"{name} is no number of JSON")


def _float(digits: str) -> float:
    value = float(digits)
    if not math.isfinite(value):
        raise JsonError(f"the number {digits[:20]} is out of range")
    return value


def _int(digits: str) -> int:
    if len(digits) > 21 or not -LARGEST < (value := int(digits)) < LARGEST:
        raise JsonError(f"the number {digits[:20]}... is out of range")
    return value


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise JsonError(f"{twice[:40]!r} is in it twice")
    return found


def _refuse_surrogates(text: str, value: Any) -> None:
    """Only an escape can make a lone one, so a text without such escapes is not searched."""
    if "\\ud" not in text.lower() and text.isascii():
        return
    try:
        json.dumps(value, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError:
        raise JsonError("it holds half of a surrogate pair, which is no character") from None
