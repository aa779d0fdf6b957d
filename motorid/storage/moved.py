"""Captures that are not where they were recorded, found again by name or in packs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property

from motorid.errors import DataError
from motorid.storage import captures, pack
from motorid.storage.place import Member, Place


class Moved:
    """Where captures may be now: folders, folders of packs, packs. Each is looked through once."""

    def __init__(self, places: Sequence[Place]) -> None:
        self.places = places

    def find(self, sha256: str, name: str) -> Place | None:
        """The capture of that digest, if it is there. ``name``: of its file."""
        if found := self._packed.get(sha256):
            return found
        return next((one for one in self._named.get(name, ()) if _is(one, sha256)), None)

    @cached_property
    def _all(self) -> list[Place]:
        return list(_within(self.places))

    @cached_property
    def _packed(self) -> dict[str, Place]:
        members = (one for one in self._all if isinstance(one, Member))
        return {pack.known_sha256(one): one for one in members}

    @cached_property
    def _named(self) -> dict[str, list[Place]]:
        found: dict[str, list[Place]] = {}
        for one in self._all:
            if not isinstance(one, Member):
                found.setdefault(one.name, []).append(one)
        return found


def _within(places: Iterable[Place]) -> Iterator[Place]:
    for place in places:
        try:
            yield from captures.captures_in([place])
        except DataError:
            continue  # none in there


def _is(place: Place, sha256: str) -> bool:
    try:
        return captures.sha256_of(place) == sha256
    except DataError:
        return False
