"""One run of fields as bytes, and back. Pure.

Unknown enumeration values stay plain integers, so that a board can answer ``bad_value`` and an old
host survives a newer minor.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Any

from motorid.wire import enums
from motorid.wire.enums import Status
from motorid.wire.render_enums import class_name
from motorid.wire.spec import FORMATS, Field, field_ends


class BadPayload(ValueError):  # noqa: N818 - it is data gone bad, counted like BadFrame
    """A payload that is no message of this protocol.

    Where the bytes allow it, ``code`` and ``request`` name the command and ``status`` is what a
    board answers (see ``encode_refusal``).
    """

    def __init__(
        self,
        reason: str,
        code: int | None = None,
        request: int | None = None,
        status: Status = Status.BAD_LENGTH,
    ) -> None:
        super().__init__(reason)
        self.code = code
        self.request = request
        self.status = status


class UnknownMessage(BadPayload):
    """A code that this minor does not have; from a newer peer it is no error."""


class Layout:
    """Packs and unpacks one run of fields."""

    def __init__(self, where: str, fields: tuple[Field, ...]) -> None:
        self.where = where
        self.fields = fields
        self.names = tuple(field.name for field in fields)
        self.struct = struct.Struct("<" + "".join(FORMATS[field.type] for field in fields))
        self.lengths = frozenset(field_ends(fields))
        self.appended = {f.name: "" if f.type == "text16" else 0 for f in fields if f.since}
        self.readers = {f.name: reader for f in fields if (reader := _reader(f))}

    def pack(self, values: Mapping[str, Any]) -> bytes:
        """The fields' bytes; those that a later minor appended may be absent, and are 0 then.

        Raises ValueError naming what is absent, foreign or too big.
        """
        values = {**self.appended, **values}
        if values.keys() != set(self.names):
            absent = sorted(set(self.names) - values.keys())
            foreign = sorted(values.keys() - set(self.names))
            raise ValueError(f"{self.where}: absent fields {absent}, foreign fields {foreign}")
        wire = [_to_wire(values[name]) for name in self.names]
        try:
            return self.struct.pack(*wire)
        except (struct.error, OverflowError):
            raise ValueError(self._misfit(wire)) from None

    def unpack(self, data: bytes, start: int = 0) -> dict[str, Any]:
        """The fields that begin at ``start``; what follows them is ignored.

        Fields that an older minor lacks are 0. Raises BadPayload when the bytes end elsewhere.
        """
        size = self.struct.size
        length = len(data) - start
        if length < size:
            if length not in self.lengths:
                raise BadPayload(f"{self.where}: {length} bytes of fields, {size} expected")
            data, start = data[start:] + bytes(size - length), 0
        fields = dict(zip(self.names, self.struct.unpack_from(data, start), strict=True))
        for name, read in self.readers.items():
            fields[name] = read(fields[name])
        return fields

    def _misfit(self, wire: list[Any]) -> str:
        for field, value in zip(self.fields, wire, strict=True):
            try:
                struct.pack("<" + FORMATS[field.type], value)
            except (struct.error, OverflowError):
                return f"{self.where}: {field.name} = {value!r} does not fit {field.type}"
        return f"{self.where}: does not fit"


def _to_wire(value: Any) -> Any:
    """Text as the bytes of a text16; anything else as it is."""
    if not isinstance(value, str):
        return value
    if len(value) > 16 or not value.isascii():
        raise ValueError(f"a text has at most 16 ASCII characters: {value!r}")
    return value.encode("ascii")


def _reader(field: Field) -> Callable[[Any], Any] | None:
    """What turns the wire's value into the caller's, where they differ."""
    if field.type == "text16":
        return lambda data: data.split(b"\0")[0].decode("ascii", "replace")
    if field.enum is None:
        return None
    enum: type[IntEnum] = getattr(enums, class_name(field.enum))
    members = {int(member): member for member in enum}
    return lambda value: members.get(value, value)
