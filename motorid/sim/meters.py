"""Meters on a simulated bench, and a hand on its shaft.

A hook for tests and for trying `motorid calibrate` without hardware: it looks past the board, at
the plant's own variables.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from motorid.errors import UsageError
from motorid.sim.bench import Bench, Counts, Raw
from motorid.sim.port import SimPort

QUANTITIES = ("current", "terminal_voltage", "supply_voltage")
SETTLING_S = 0.1


class Meters:
    """Averaging meters on the plant behind an open ``sim://`` port.

    ``errors``: relative error of each meter's reading, by quantity; none: perfect. A meter shows
    the mean over the last half of the level that was driven last.
    """

    def __init__(self, port: SimPort, errors: Mapping[str, float] | None = None) -> None:
        self._bench: Bench = port.device.bench
        self._errors = dict(errors or {})
        self._driven: list[tuple[float, ...]] = []  # time and the integrals, along a level
        self._was_open = True
        self._run = self._bench.run
        self._bench.run = self._watched  # type: ignore[method-assign]

    def _watched(self, samples: int) -> tuple[Raw, Counts]:
        """As the bench runs, but noting the true integrals while it drives."""
        opened = self._bench.is_open
        if self._was_open and not opened:
            self._driven = [self._bench.integrals()]
        self._was_open = opened
        found = self._run(samples)
        if not opened and not self._bench.is_open:
            self._driven.append(self._bench.integrals())
        return found

    def read(self, quantity: str) -> float:
        """What the meter shows, in A or V. Raises UsageError before anything was driven."""
        if len(self._driven) < 2:
            raise UsageError("the simulated meters have seen no level yet: drive one first")
        first, last = self._driven[len(self._driven) // 2], self._driven[-1]
        k = 1 + QUANTITIES.index(quantity)
        true = (last[k] - first[k]) / (last[0] - first[0])
        return true * (1 + self._errors.get(quantity, 0.0))

    def settled_supply(self) -> float:
        """What the meter at the supply shows with the bridge open, once it has settled."""
        self._run(max(1, round(SETTLING_S / self._bench.period_s)))
        error = self._errors.get("supply_voltage", 0.0)
        return float(self._bench.plant.bus) * (1 + error)

    def turn(self, turns: float) -> None:
        """Turn the shaft by hand, forwards or (negative) back."""
        self._bench.plant.angle += 2 * math.pi * turns

    def set_supply(self, volts: float) -> None:
        """Turn the supply's knob."""
        self._bench.set_supply(volts)
