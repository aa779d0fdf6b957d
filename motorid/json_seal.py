"""JSON documents that carry the SHA-256 of what they say, so that damage to a file is seen.

The digest is that of the document without it, as ``canonical`` writes it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motorid.errors import DataError
from motorid.limits import JSON, refuse_large

MEMBER = "content_sha256"
MINOR = "schema_minor"
SEALED_MINOR = 1  # from this minor of its schema on a document carries its digest


def sealed(document: Mapping[str, Any]) -> dict[str, Any]:
    """``document`` with its minor version and its digest. What JSON cannot say is a text in it."""
    plain = {**document, MINOR: SEALED_MINOR}
    return {**plain, MEMBER: digest(plain)}


def digest(document: Mapping[str, Any]) -> str:
    """The digest that belongs into ``document``."""
    return hashlib.sha256(canonical(document).encode()).hexdigest()


def canonical(document: Mapping[str, Any]) -> str:
    """The text that is digested: without ``MEMBER``, keys sorted, no blanks, shortest numbers."""
    as_read = json.loads(json.dumps(document, allow_nan=False, default=str))
    rest = {key: value for key, value in as_read.items() if key != MEMBER}
    return json.dumps(rest, sort_keys=True, separators=(",", ":"), allow_nan=False)


def read(path: Path, what: str) -> dict[str, Any]:
    """The document in ``path``, which is to be ``what``. Raises DataError, also where damaged."""
    document = parse(path, what)
    _check(document, path)
    return document


def parse(path: Path, what: str) -> dict[str, Any]:
    """As ``read``, whatever its digest says."""
    refuse_large(path, JSON)
    try:
        document = json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse)
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror or error}") from None
    except (ValueError, RecursionError):
        raise DataError(f"{path} is damaged, or is not {what}: it is not JSON") from None
    if not isinstance(document, dict):
        raise DataError(f"{path} is damaged, or is not {what}: it is not a JSON object")
    return document


def carries_digest(document: Mapping[str, Any]) -> bool:
    """Whether a document that was read carries its digest; older ones do not."""
    return MEMBER in document


def _check(document: Mapping[str, Any], path: Path) -> None:
    if not carries_digest(document):
        if MINOR in document:
            raise DataError(f"{path} is damaged: its digest is missing")
        return
    try:
        true = document[MEMBER] == digest(document)
    except (ValueError, RecursionError):
        true = False
    if not true:
        raise DataError(
            f"{path}: its content is not what its digest says: the file is damaged, or was "
            "edited; take another copy of it"
        )


def _refuse(text: str) -> float:
    raise ValueError(text)
