"""What the import of text tables promises of any bytes: a capture, or one sentence."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import motorid.capture.csv_reader  # noqa: F401 - imported late by the import, too late to be seen
from motorid.capture.table import read_table
from motorid.errors import DataError, UsageError
from tests.fuzz.sentence import check_sentence

CORPUS = Path(__file__).with_name("tables")
MAPS = (
    ("time=column1:s", "current=column2:A"),
    ("time=t:s", "current=i:A", "voltage=u:V"),
    ("speed=column1:rad/s", "voltage=column2*column2:V"),
)
DROP_BAD, THOUSANDS, MISSING = 0x40, 0x20, 0x10  # bits of the first byte
MEMORY = Path("/dev/shm")  # Linux: files that cost no disk
_folder = tempfile.TemporaryDirectory(
    prefix="motorid-fuzz-", dir=MEMORY if MEMORY.is_dir() else None
)
_path = Path(_folder.name, f"table{os.getpid()}.csv")


def check(data: bytes) -> None:
    """Raises where a table breaks a promise. Its first byte says how it is read."""
    _path.write_bytes(data[1:])
    choice = data[0] if data else 0
    try:
        with warnings.catch_warnings(action="error"):  # a person would see them, unexplained
            capture = read_table(
                _path,
                MAPS[(choice & ~(DROP_BAD | THOUSANDS | MISSING)) % len(MAPS)],
                drop_bad=bool(choice & DROP_BAD),
                thousands="." if choice & THOUSANDS else None,
                missing=(0.0,) if choice & MISSING else (),
            )
    except (DataError, UsageError) as error:
        check_sentence(str(error), len(data))
        return
    assert 0 < len(capture) <= len(data)
    assert np.all(np.diff(capture.ticks) > 0)
    known = np.array([np.isfinite(channel.values) for channel in capture.channels.values()])
    assert known.shape == (len(capture.channels), len(capture))
    partial = choice & (DROP_BAD | MISSING)  # a row keeps its good cells
    assert np.all(known.any(axis=0) if partial else known)


def seeds() -> Iterator[bytes]:
    """The tables kept, as each way of reading them takes them."""
    for path in sorted(CORPUS.glob("*")):
        for choice in (0, 1, 2, 0x40, 0x41, 0x42, 0x21, 0x51):
            yield bytes([choice]) + path.read_bytes()
