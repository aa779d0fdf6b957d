"""Packs: many captures in one uncompressed zip, and an index beside it that seals both.

    packs/line-1/2026-11-25.zip         any program that knows zip opens it
    packs/line-1/2026-11-25.index.json  place, length and SHA-256 of each file in it, and its own

A pack is sealed once its index is there, and never changes from then on. One file of it is read by
its place, without the rest of the pack.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property, lru_cache
from hashlib import sha256
from typing import Any

from motorid import json_seal, json_text
from motorid.errors import DataError
from motorid.limits import JSON, refuse_size
from motorid.reading import open_file, read_file
from motorid.storage import object_store
from motorid.storage.place import File, Member, Place, Url

SCHEMA = "motorid-pack-1"
INDEX = ".index.json"
MOST_INDICES = 64  # that a process keeps at hand
_DIGEST = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Entry:
    """One file of a pack: its bytes begin at ``offset``. ``created``: ISO 8601, or ""."""

    name: str
    offset: int
    bytes: int
    sha256: str
    serial: str = ""
    created: str = ""


@dataclass(frozen=True)
class Index:
    """A sealed pack: of which station and day (UTC), how long, and what is in it."""

    station: str
    day: str
    bytes: int
    sha256: str
    entries: tuple[Entry, ...]

    @cached_property
    def by_name(self) -> dict[str, Entry]:
        """The entries, by the names of their files."""
        return {one.name: one for one in self.entries}

    def to_text(self) -> str:
        """The document, with the digest of its content."""
        return json_text.dumps(json_seal.sealed({"schema": SCHEMA, **asdict(self)})) + "\n"


def index_place(pack: File) -> File:
    """Where the index of a pack is."""
    name = pack.stem + INDEX
    return pack.parent / name


def pack_place(index: File) -> File:
    """The pack that an index belongs to."""
    return index.parent / f"{index.name.removesuffix(INDEX)}.zip"


def is_sealed(pack: File) -> bool:
    """Whether a zip has an index beside it."""
    place = index_place(pack)
    return object_store.exists(place) if isinstance(place, Url) else place.is_file()


@lru_cache(MOST_INDICES)
def index_of(pack: File) -> Index:
    """The index of a sealed pack; read once. Raises DataError."""
    return read_index(pack)


def read_index(pack: File) -> Index:
    """The index as it is now. Raises DataError where there is none, or a damaged one."""
    place = index_place(pack)
    document = json_seal.document(_bytes(place), str(place), "the index of a pack")
    try:
        if document["schema"] != SCHEMA or not json_seal.carries_digest(document):
            raise ValueError("it is of another schema")
        return _index(document)
    except (KeyError, TypeError, ValueError) as error:
        raise DataError(f"{place} is damaged, or is no index of a pack ({error!r})") from None


def _index(document: Mapping[str, Any]) -> Index:
    entries = tuple(
        Entry(
            str(one["name"]), int(one["offset"]), int(one["bytes"]), _digest(one["sha256"]),
            str(one["serial"]), str(one["created"]),
        )
        for one in document["entries"]
    )  # fmt: skip
    return Index(
        str(document["station"]),
        str(document["day"]),
        int(document["bytes"]),
        _digest(document["sha256"]),
        entries,
    )


def _digest(text: Any) -> str:
    if not isinstance(text, str) or not _DIGEST.fullmatch(text):
        raise ValueError(f"{str(text)[:80]!r} is no SHA-256")
    return text


def entry_of(member: Member) -> Entry:
    """What the index says of a file. Raises DataError where the pack holds none of that name."""
    found = index_of(member.pack).by_name.get(member.inner)
    if found is None:
        raise DataError(f"{member.pack} holds no {member.inner!r}: see motorid archive list")
    return found


def known_sha256(place: Place) -> str:
    """The digest of a pack's file, from the index alone; "" for any other place."""
    return entry_of(place).sha256 if isinstance(place, Member) else ""


def read(member: Member) -> bytes:
    """One file of a pack; nothing else of the pack is read. Raises DataError, also on damage."""
    entry = entry_of(member)
    refuse_size(str(member), entry.bytes)
    data = part(member.pack, entry.offset, entry.bytes)
    if sha256(data).hexdigest() != entry.sha256:
        raise DataError(f"{member} is damaged: its bytes are not those that its index seals")
    return data


def part(pack: File, offset: int, count: int) -> bytes:
    """``count`` bytes of a pack, fewer where it ends before. Raises DataError."""
    if isinstance(pack, Url):
        return object_store.read(pack, offset, offset + count)
    with open_file(pack, DataError) as file:
        try:
            file.seek(offset)
            return file.read(count)
        except (OSError, ValueError) as error:
            raise DataError(f"{pack}: cannot be read: {error}") from None


def damage(pack: File) -> str:
    """What is wrong with a sealed pack, in a sentence; "" where it is whole. Raises DataError."""
    index = read_index(pack)
    whole, at = sha256(), 0
    for entry in sorted(index.entries, key=lambda one: one.offset):
        if entry.offset < at:
            return f"its index says that {entry.name} begins within another file"
        whole.update(part(pack, at, entry.offset - at))
        data = part(pack, entry.offset, entry.bytes)
        if sha256(data).hexdigest() != entry.sha256:
            return f"{entry.name} in it is not what its index seals"
        whole.update(data)
        at = entry.offset + entry.bytes
    whole.update(part(pack, at, max(0, index.bytes - at)))
    if whole.hexdigest() != index.sha256:
        return "its bytes beside the captures are not those that its index seals"
    return ""


def _bytes(place: File) -> bytes:
    if isinstance(place, Url):
        return object_store.read(place)
    return read_file(place, DataError, JSON.file, "the index of a pack")
