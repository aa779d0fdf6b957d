"""Packs that are old enough leave the archive, whole; never without a word to what cites them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from typing import TYPE_CHECKING

from motorid.errors import DataError, UsageError
from motorid.storage import object_store, pack
from motorid.storage.place import File, Url
from motorid.workflow.archive import listed

if TYPE_CHECKING:
    from motorid.quality.history import History
    from motorid.storage.pack import Index

DELETED = "delete captures"  # of the trail


@dataclass(frozen=True)
class Old:
    """A pack that the rule lets go: how many files it holds, and how many results cite them."""

    pack: File
    index: Index
    results: int


def old(archive: File, keep_days: int, history: History | None, today: date) -> list[Old]:
    """The packs of days that are more than ``keep_days`` ago."""
    from motorid.quality.history.citing import results_citing

    before = today - timedelta(days=keep_days)
    found = []
    for where, index in listed(archive):
        try:
            day = date.fromisoformat(index.day)
        except ValueError:
            raise DataError(f"{where}: its index names no day: {index.day!a}") from None
        if day < before:
            digests = [entry.sha256 for entry in index.entries]
            cited = results_citing(history, digests) if history is not None else 0
            found.append(Old(where, index, cited))
    return found


def refuse_cited(packs: Sequence[Old]) -> None:
    """Raises UsageError where results rest on what would be deleted."""
    results = sum(one.results for one in packs)
    if results:
        cited = sum(bool(one.results) for one in packs)
        raise UsageError(
            f"{results} results of the history cite captures in {cited} of these {len(packs)} "
            "packs: nothing was deleted. --cited deletes them all the same, and the results stay"
        )


def delete(packs: Sequence[Old], history: History | None, by: str) -> Iterator[Old]:
    """Deletes each pack, after the trail says so; its index goes last, so it can be done again."""
    from motorid.quality.history import Entry

    for one in packs:
        if history is not None:
            said = f"{len(one.index.entries)} files; {one.results} results cite them"
            key = f"{DELETED} {one.index.sha256}"
            at = datetime.now(UTC)
            history.note(Entry(DELETED, "done", by, key, str(one.pack), said, at=at))
        for place in (one.pack, pack.index_place(one.pack)):
            _delete(place)
        yield one


def _delete(place: File) -> None:
    if isinstance(place, Url):
        if object_store.exists(place):
            object_store.remove(place)
        return
    try:
        with suppress(FileNotFoundError):  # an earlier call came so far
            place.unlink()
    except OSError as error:
        raise DataError(f"{place} cannot be deleted: {error.strerror or error}") from None
