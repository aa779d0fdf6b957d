"""Responses of a record that need no new computation: the last few, and those computed ahead."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Key = tuple[float, ...]

REMEMBERED = 3  # responses: an offset of a reading needs no new one


class AtHand:
    """Readings (outputs, count) by what they are of, while what drives the record stays."""

    def __init__(self) -> None:
        self._last: dict[Key, Floats] = {}
        self._ahead: dict[Key, tuple[Floats, int]] = {}

    def __contains__(self, key: Key) -> bool:
        return key in self._last

    def take(self, key: Key) -> tuple[Floats | None, int]:
        """Readings that are here, and what they were worth if they are used for the first time."""
        return self._ahead.pop(key, None) or (self._last.get(key), 0)

    def use(self, key: Key, readings: Floats) -> None:
        """These were used last; what was used longest ago is forgotten."""
        self._last.pop(key, None)
        if len(self._last) >= REMEMBERED:
            del self._last[next(iter(self._last))]
        self._last[key] = readings

    def expect(self, found: Mapping[Key, tuple[Floats, int]]) -> None:
        """These were computed ahead, and no others."""
        self._ahead = dict(found)

    def clear(self) -> None:
        """Something else drives the record."""
        self._last.clear()
        self._ahead.clear()
