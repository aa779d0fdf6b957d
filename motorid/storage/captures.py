"""Captures from wherever they are: the door for all who read them.

What comes from an object store is copied to this computer first, and checked against the digest
that is known of it (see ``cache``). A capture cites the place that it was named by.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from motorid.errors import DataError
from motorid.reading import open_file
from motorid.storage import cache, object_store, pack
from motorid.storage.place import PACK, File, Member, Place, Url

if TYPE_CHECKING:
    from motorid.capture.model import Capture

SUFFIX = ".h5"


def load(place: Place, sha256: str = "") -> Capture:
    """The capture in ``place``. ``sha256``: of its bytes, where it is known.

    Raises DataError where it is none, is damaged, cannot be reached, or has other bytes.
    """
    from motorid.capture import store

    path = local(place, sha256)
    try:
        capture = store.load(path)
    except DataError as error:
        raise DataError(str(error).replace(str(path), str(place))) from None
    if sha256 and capture.sha256 != sha256:
        raise DataError(f"{place} changed while it was read: run again")
    return capture if path == place else replace(capture, path=str(place))


def local(place: Place, sha256: str = "") -> Path:
    """A file on this computer with the bytes of ``place``. Raises DataError."""
    if isinstance(place, Path):
        return place
    sha256 = sha256 or pack.known_sha256(place)
    if sha256 and (copy := cache.kept(sha256)):
        return copy
    data = pack.read(place) if isinstance(place, Member) else object_store.read(place)
    path, found = cache.keep(data)
    if sha256 and found != sha256:
        raise DataError(f"{place} has other bytes than it had: take another copy of it")
    return path


def sha256_of(place: Place) -> str:
    """The digest of the bytes in ``place``. Raises DataError where they cannot be read."""
    if known := pack.known_sha256(place):
        return known
    path = local(place)
    if path != place:
        return path.stem  # as the cache names it
    try:
        with open_file(path, DataError) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror or error}") from None


def captures_in(places: Iterable[Place]) -> list[Place]:
    """The captures among ``places``; a folder or a pack stands for those in it, at any depth.

    Raises DataError where one holds none.
    """
    found: list[Place] = []
    for place in places:
        if not is_many(place):
            found.append(place)
            continue
        inside = list(_inside(place))
        if not inside:
            raise DataError(f"the folder {place} holds no capture ({SUFFIX}): name another")
        found += inside
    return list(dict.fromkeys(found))


def is_many(place: Place) -> bool:
    """Whether ``place`` is a folder or a pack. A URL's name says it, and nobody is asked."""
    if isinstance(place, Member):
        return False
    if isinstance(place, Url):
        return place.suffix != SUFFIX
    return place.is_dir() or (place.suffix == PACK and place.is_file())


def _inside(place: Place) -> Iterator[Place]:
    if isinstance(place, Member):
        yield place
        return
    if place.suffix == PACK:
        yield from _of_pack(place)
        return
    for one in _files(place):
        if one.suffix == SUFFIX:
            yield one
        elif one.suffix == PACK and pack.is_sealed(one):
            yield from _of_pack(one)


def _files(folder: File) -> Sequence[File]:
    if isinstance(folder, Url):
        return [one.url for one in object_store.files(folder)]
    inside = (path for path in folder.rglob("*") if path.suffix in (SUFFIX, PACK))
    return sorted(path for path in inside if not path.name.startswith("."))


def _of_pack(where: File) -> Iterator[Member]:
    for entry in pack.index_of(where).entries:
        if entry.name.endswith(SUFFIX):
            yield Member(where, entry.name)
