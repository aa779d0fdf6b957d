"""WPILib's data log (``.wpilog``, version 1.0): records of named entries, each with a time stamp.

After the header, a record is a byte that says how many bytes its three numbers take, the entry's
number, the size of the data, the stamp in µs, and the data; all little-endian. Records of entry 0
begin entries and end them.
"""

from __future__ import annotations

import struct
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field

from motorid.errors import DataError
from motorid.limits import beyond

MAGIC = b"WPILOG"
_HEADER = struct.Struct("<6sHI")
_VERSION = 0x0100
_START, _FINISH = 0, 1
_NUMBERS: dict[str, Callable[[bytes], tuple[float, ...]]] = {
    "double": struct.Struct("<d").unpack,
    "float": struct.Struct("<f").unpack,
    "int64": struct.Struct("<q").unpack,
    "boolean": struct.Struct("<?").unpack,
}


@dataclass
class Entry:
    """``stamps`` in s, and ``values`` if they are numbers; ``metadata`` as the program wrote it."""

    name: str
    kind: str
    metadata: str
    stamps: array[float] = field(default_factory=lambda: array("d"))
    values: array[float] = field(default_factory=lambda: array("d"))


def entries(data: bytes, most: int | None) -> tuple[list[Entry], list[str]]:
    """Entries of numbers, and the names of others. At most ``most`` numbers in all.

    Raises DataError where the data are no such log, are cut short, or hold more.
    """
    if len(data) < _HEADER.size or not data.startswith(MAGIC):
        raise DataError("it is no WPILib data log")
    _, version, extra = _HEADER.unpack_from(data)
    if version >> 8 != _VERSION >> 8:
        raise DataError(f"it is a WPILib data log of version {version >> 8}; 1 can be read")
    at, count = _HEADER.size + extra, 0
    open_: dict[int, Entry] = {}
    found: list[Entry] = []
    others: list[Entry] = []
    while at < len(data):
        number, stamp, payload, at = _record(data, at)
        if number == 0:
            begun = _control(payload, open_)
            if begun is not None:
                (found if begun.kind in _NUMBERS else others).append(begun)
        elif (entry := open_.get(number)) is not None and entry.kind in _NUMBERS:
            try:
                (value,) = _NUMBERS[entry.kind](payload)
            except struct.error:
                raise DataError(f"a record of {entry.name} has a wrong size") from None
            entry.stamps.append(stamp * 1e-6)
            entry.values.append(float(value))
            count += 2
            if beyond(count, most):
                raise DataError(f"it holds more than {most:,} numbers: save a part of it")
    return found, [entry.name for entry in others]


def _record(data: bytes, at: int) -> tuple[int, int, bytes, int]:
    """Entry, stamp in µs, data, and where the next record begins."""
    sizes = data[at]
    widths = (sizes & 3) + 1, (sizes >> 2 & 3) + 1, (sizes >> 4 & 7) + 1
    numbers, place = [], at + 1
    for width in widths:
        numbers.append(int.from_bytes(data[place : place + width], "little"))
        place += width
    entry, size, stamp = numbers
    if place + size > len(data):
        raise DataError(f"its record at byte {at:,} is cut short")
    return entry, stamp, data[place : place + size], place + size


def _control(payload: bytes, open_: dict[int, Entry]) -> Entry | None:
    """Begins or ends an entry; the one that begins."""
    if len(payload) < 5:
        raise DataError("a control record has a wrong size")
    number = int.from_bytes(payload[1:5], "little")
    if payload[0] == _FINISH:
        open_.pop(number, None)
    if payload[0] != _START:
        return None
    texts, at = [], 5
    for _ in range(3):
        size = int.from_bytes(payload[at : at + 4], "little")
        texts.append(payload[at + 4 : at + 4 + size].decode("utf-8", "replace"))
        at += 4 + size
    if at > len(payload):
        raise DataError("the beginning of an entry is cut short")
    name, kind, metadata = texts
    open_[number] = Entry(name, kind, metadata)
    return open_[number]
