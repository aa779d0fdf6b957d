"""Captures into packs, and packs out of the archive once a rule says that they are old enough.

ARCHIVE/STATION/DAY.zip, DAY.2.zip, ...    see ``storage/pack.py``
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from motorid import json_seal
from motorid.errors import DataError, MotoridError, UsageError
from motorid.storage import captures, object_store, pack, pack_write
from motorid.storage.pack import INDEX, Index
from motorid.storage.pack_write import Source
from motorid.storage.place import PACK, File, Member, Place, Url
from motorid.workflow.check import CAPTURE, VERDICT, WARM_UP

if TYPE_CHECKING:
    from motorid.capture.model import Capture

MOST_BYTES = 256 << 20  # of a pack
OWN_FOLDER = (CAPTURE, WARM_UP)  # names of captures whose folder says which motor they are of


@dataclass(frozen=True)
class Packed:
    """One pack that was made; or a capture, ``place``, that went into none, and why."""

    place: Place
    count: int = 0
    failure: str = ""


@dataclass(frozen=True)
class Found:
    """A capture on its way into a pack: a copy on this computer, and what is beside it."""

    place: Place
    source: Source
    sha256: str
    beside: tuple[Source, ...]  # its verdict


def pack_captures(
    places: Sequence[Place], archive: File, *, station: str = "", most_bytes: int = MOST_BYTES
) -> Iterator[Packed]:
    """Packs the captures in ``places`` by station and day (UTC); those that are packed stay so.

    The station is that of the verdict beside a capture, or ``station``. A day that was packed
    before gets one more pack. Raises DataError where the archive cannot be written.
    """
    days: dict[tuple[str, str], list[Found]] = defaultdict(list)
    for place in captures.captures_in(places):
        if isinstance(place, Member):
            continue  # it is in one
        try:
            found, of = _look(place, station)
        except MotoridError as error:
            yield Packed(place, failure=str(error))
            continue
        days[of].append(found)
    for (named, day), new in sorted(days.items()):
        folder = archive / quote(named, safe=" ")
        known = _known(folder, day)
        missing = {one.sha256: one for one in new if one.sha256 not in known}
        for part in _parts(list(missing.values()), most_bytes):
            target = _next(folder, day)
            pack_write.write(target, _named(part), named, day)
            yield Packed(target, len(part))


def _look(place: File, station: str) -> tuple[Found, tuple[str, str]]:
    """A capture, with its station and day. Raises DataError or UsageError where one is unknown."""
    capture = captures.load(place)
    beside = _beside(place)
    known = json_seal.read(beside, "a verdict") if beside else {}
    named = str(known.get("station") or station)
    if not named:
        raise UsageError(f"{place}: no verdict beside it names its station: say it by --station")
    path = captures.local(place, capture.sha256)
    serial = str(capture.provenance.get("serial", ""))
    created = str(capture.provenance.get("created", ""))
    folder = f"{place.parent.name}/" if place.name in OWN_FOLDER else ""
    source = Source(path, folder + place.name, serial, created)
    verdict = (Source(beside, folder + VERDICT, serial, created),) if beside and folder else ()
    return Found(place, source, capture.sha256, verdict), (named, _day(capture))


def _beside(place: File) -> Path | None:
    """The verdict in the folder of a capture, on this computer; None for none."""
    there = place.parent / VERDICT
    if isinstance(there, Url):
        return captures.local(there) if object_store.exists(there) else None
    return there if there.is_file() else None


def _day(capture: Capture) -> str:
    """UTC. Raises DataError where the capture does not say when it was taken."""
    try:
        at = datetime.fromisoformat(str(capture.provenance.get("created")))
    except ValueError:
        raise DataError(f"{capture.path} does not say when it was taken, so on no day") from None
    return (at if at.tzinfo else at.replace(tzinfo=UTC)).astimezone(UTC).date().isoformat()


def _known(folder: File, day: str) -> set[str]:
    """Digests of what the sealed packs of a day hold."""
    return {
        entry.sha256
        for one in sealed(folder)
        if one.name.partition(".")[0] == day
        for entry in pack.index_of(one).entries
    }


def _next(folder: File, day: str) -> File:
    """The first pack of that day that is not sealed."""
    names = itertools.chain([day], (f"{day}.{number}" for number in itertools.count(2)))
    return next(one for name in names if not pack.is_sealed(one := folder / f"{name}{PACK}"))


def _parts(found: Sequence[Found], most_bytes: int) -> Iterator[list[Found]]:
    """Pieces of a day that fit a pack each, by time."""
    part: list[Found] = []
    size = 0
    for one in sorted(found, key=lambda one: (one.source.created, one.source.name)):
        bytes_ = one.source.path.stat().st_size
        if part and size + bytes_ > most_bytes:
            yield part
            part, size = [], 0
        part.append(one)
        size += bytes_
    if part:
        yield part


def _named(part: Iterable[Found]) -> list[Source]:
    """Each file under a name of its own: two captures of one name get their digest in it."""
    sources: dict[str, Source] = {}
    for one in part:
        for source in (one.source, *one.beside):
            name = source.name
            if name in sources:
                head, _, tail = name.rpartition("/")
                name = f"{head}/{one.sha256[:12]}-{tail}".lstrip("/")
            sources[name] = Source(source.path, name, source.serial, source.created)
    return list(sources.values())


def sealed(archive: File) -> list[File]:
    """The sealed packs under a folder, at any depth; none where it is not there."""
    if isinstance(archive, Url):
        names = [one.url for one in object_store.files(archive)]
        found: list[File] = [pack.pack_place(one) for one in names if one.name.endswith(INDEX)]
        return found
    return [pack.pack_place(one) for one in sorted(archive.rglob(f"*{INDEX}"))]


def listed(archive: File) -> Iterator[tuple[File, Index]]:
    """Each sealed pack with its index."""
    for one in sealed(archive):
        yield one, pack.index_of(one)


def search(archive: File, what: str) -> Iterator[tuple[Member, pack.Entry]]:
    """The files of a motor, by its serial number or the beginning of a SHA-256."""
    for where, index in listed(archive):
        for entry in index.entries:
            if entry.serial == what or (len(what) >= 6 and entry.sha256.startswith(what.lower())):
                yield Member(where, entry.name), entry
