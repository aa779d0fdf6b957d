"""JSON documents that carry the SHA-256 of what they say, so that damage to a file is seen.

The digest is that of the document without it, as ``canonical`` writes it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motorid import json_text
from motorid.errors import DataError
from motorid.limits import JSON, refuse_large
from motorid.reading import read_file

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
    as_read = json_text.loads(json_text.dumps(document))
    rest = {key: value for key, value in as_read.items() if key != MEMBER}
    return json_text.canonical(rest, blanks=False)


def read(path: Path, what: str) -> dict[str, Any]:
    """The document in ``path``, which is to be ``what``. Raises DataError, also where damaged."""
    found = parse(path, what)
    _check(found, str(path))
    return found


def parse(path: Path, what: str) -> dict[str, Any]:
    """As ``read``, whatever its digest says."""
    refuse_large(path, JSON)
    return _object(read_file(path, DataError, JSON.file, what), str(path), what)


def document(data: bytes, where: str, what: str) -> dict[str, Any]:
    """As ``read``, of bytes that were read from ``where``."""
    found = _object(data, where, what)
    _check(found, where)
    return found


def _object(data: bytes, where: str, what: str) -> dict[str, Any]:
    try:
        found = json_text.loads(data)
    except json_text.JsonError as error:
        raise DataError(f"{where} is damaged, or is not {what}: it is not JSON: {error}") from None
    if not isinstance(found, dict):
        raise DataError(f"{where} is damaged, or is not {what}: it is not a JSON object")
    return found


def carries_digest(document: Mapping[str, Any]) -> bool:
    """Whether a document that was read carries its digest; older ones do not."""
    return MEMBER in document


def _check(document: Mapping[str, Any], path: str) -> None:
    if not carries_digest(document):
        if MINOR in document:
            raise DataError(f"{path} is damaged: its digest is missing")
        return
    if document[MEMBER] != digest(document):
        raise DataError(
            f"{path}: its content is not what its digest says: the file is damaged, or was "
            "edited; take another copy of it"
        )
