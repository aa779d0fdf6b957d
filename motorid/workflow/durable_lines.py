"""A line of JSON at the end of a file, on disk before anybody is told of it, or not at all."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path

from motorid import json_text
from motorid.errors import DataError


def append(path: Path, line: Mapping[str, str]) -> None:
    """Synced when it returns. Raises DataError where the disk does not take it."""
    size = path.stat().st_size if path.exists() else 0
    try:
        with path.open("ab") as file:
            file.write(json_text.dumps(line).encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        with contextlib.suppress(OSError):  # half a line would spoil the next one
            os.truncate(path, size)
        raise DataError(
            f"{path} cannot be written ({error.strerror or error}), so no order can be accepted: "
            "make room, or mend the disk"
        ) from None
