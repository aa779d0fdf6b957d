"""A new pack: its zip first, then the index that seals it. A zip without an index is none yet."""

from __future__ import annotations

import hashlib
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from struct import unpack_from

from motorid.capture.whole import write_whole
from motorid.errors import DataError
from motorid.reading import open_file
from motorid.storage import object_store, pack
from motorid.storage.pack import Entry, Index
from motorid.storage.place import File, Url

DATE = (1980, 1, 1, 0, 0, 0)  # of every file in it: the same files make the same bytes
LOCAL_HEADER = 30  # bytes before name and extra field
LENGTHS_AT = 26  # of which the lengths are here, as two 16-bit numbers


@dataclass(frozen=True)
class Source:
    """A file on this computer that goes into a pack as ``name``."""

    path: Path
    name: str
    serial: str = ""
    created: str = ""


def write(target: File, sources: Sequence[Source], station: str, day: str) -> Index:
    """Makes and seals the pack ``target``; what is there without an index is replaced.

    Raises DataError where it cannot be written, or does not read back as written.
    """
    with tempfile.TemporaryDirectory(prefix="motorid-pack-") as scratch:
        made = Path(scratch, target.name)
        index = _index(made, _zipped(made, sources), station, day)
        sealing = made.with_name(pack.index_place(target).name)
        sealing.write_text(index.to_text(), encoding="utf-8")
        for path, place in ((made, target), (sealing, pack.index_place(target))):
            _put(path, place)
    if said := pack.damage(target):
        raise DataError(f"{target} does not read back as it was written: {said}")
    return index


def _zipped(made: Path, sources: Sequence[Source]) -> list[tuple[Source, str]]:
    """Writes the zip; each file with the digest of what went in."""
    found = []
    with zipfile.ZipFile(made, "w", zipfile.ZIP_STORED) as archive:
        for one in sources:
            with open_file(one.path, DataError) as file:
                data = file.read()
            member = zipfile.ZipInfo(one.name, DATE)
            member.external_attr = 0o644 << 16
            archive.writestr(member, data)
            found.append((one, hashlib.sha256(data).hexdigest()))
    return found


def _index(made: Path, written: Sequence[tuple[Source, str]], station: str, day: str) -> Index:
    with zipfile.ZipFile(made) as archive, made.open("rb") as file:
        entries = []
        for source, sha256 in written:
            member = archive.getinfo(source.name)
            file.seek(member.header_offset)
            lengths = unpack_from("<HH", file.read(LOCAL_HEADER), LENGTHS_AT)
            offset = member.header_offset + LOCAL_HEADER + sum(lengths)
            about = (source.serial, source.created)
            entries.append(Entry(source.name, offset, member.file_size, sha256, *about))
        file.seek(0)
        whole = hashlib.file_digest(file, "sha256").hexdigest()
    return Index(station, day, made.stat().st_size, whole, tuple(entries))


def _put(path: Path, place: File) -> None:
    if isinstance(place, Url):
        object_store.put(path, place, force=True)
        return
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise DataError(f"{place.parent} cannot be made: {error.strerror or error}") from None
    write_whole(place, path.read_bytes(), force=True)
