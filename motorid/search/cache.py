"""Memory assistance (Jesenik et al. 2020): an individual that was simulated is not simulated again.

``long`` remembers the whole history, ``short`` the current generation and the one before.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search.algorithms.population import Cost

Memory = Literal["long", "short"]


class Cache:
    """Wraps ``f(U) -> cost``; ``hits`` of ``calls`` were answered from memory.

    Only bit-for-bit equal candidates count as the same, so the answer never changes.
    The search's budget still counts every request: what memory saves is time.
    """

    def __init__(self, f: Cost, memory: Memory = "long") -> None:
        self.f, self.memory = f, memory
        self.calls = self.hits = 0
        self._known: dict[bytes, float] = {}
        self._previous: dict[bytes, float] = {}

    @property
    def hit_rate(self) -> float:
        """Part of the requests that cost no simulation, 0 to 1."""
        return self.hits / self.calls if self.calls else 0.0

    def __call__(self, u: Floats) -> Floats:
        keys = [row.tobytes() for row in np.ascontiguousarray(u)]
        if self.memory == "short":
            self._previous, self._known = self._known, {}
        fresh: dict[bytes, int] = {}
        for index, key in enumerate(keys):
            if key in self._previous:
                self._known[key] = self._previous[key]
            if key not in self._known:
                fresh.setdefault(key, index)
        if fresh:
            cost = self.f(u[list(fresh.values())])
            self._known.update(zip(fresh, cost.tolist(), strict=True))
        self.calls += len(keys)
        self.hits += len(keys) - len(fresh)
        return np.array([self._known[key] for key in keys])
