"""Instruments that are asked in turn, reading by reading: slow, and each reading a little later.

A row's stamp is the middle of its questions by this computer's clock. When within that time an
instrument measured, and over how long, nobody states: the fit takes its lags as unknown.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from motorid.acquire.scpi.bench_file import SUPPLY, Source
from motorid.acquire.scpi.link import Instrument
from motorid.acquire.scpi.recorder import Clock, Recording, Trace
from motorid.acquire.scpi.supply import Supply
from motorid.capture.model import CURRENT, SPEED
from motorid.capture.table_checks import quantum
from motorid.errors import LinkError

CLOCK_UNCERTAINTY = 1e-4  # of a computer's clock: standard, relative


class Poller:
    """Asks every channel, and keeps the rows."""

    def __init__(
        self,
        supply: Supply,
        meters: Mapping[str, Instrument],
        sources: Sequence[Source],
        clock: Clock,
    ) -> None:
        self._supply, self._meters, self._sources, self._clock = supply, meters, sources, clock
        self.stamps: list[float] = []
        self.rows: list[list[float]] = []

    def row(self) -> None:
        """One reading of each. Raises LinkError; then the row is left out."""
        began = self._clock.now()
        answers: dict[tuple[str, str], list[float]] = {}
        values = []
        for one in self._sources:
            supplied = one.instrument == SUPPLY
            instrument = self._supply.instrument if supplied else self._meters[one.instrument]
            query = one.query or self._supply.measure_query(one.name)
            key = (one.instrument, query)
            if key not in answers:
                answers[key] = instrument.numbers(query)
            if one.place >= len(answers[key]):
                raise LinkError(
                    f"the {instrument.name} answers {query!r} with {len(answers[key])} numbers, "
                    f"and channels.{one.name}.field is {one.place}"
                )
            values.append(answers[key][one.place])
        self.stamps.append((began + self._clock.now()) / 2)
        self.rows.append(values)

    def latest(self) -> tuple[float | None, float | None]:
        """Current in A and speed in rad/s of the last row, as far as they are there."""
        found: dict[str, float] = {}
        for one, value in zip(self._sources, self.rows[-1] if self.rows else (), strict=False):
            found[one.name] = one.scale * (value - one.zero)
        known = {name: value for name, value in found.items() if math.isfinite(value)}
        return known.get(CURRENT), known.get(SPEED)

    def recording(self) -> Recording:
        """The rows so far."""
        stamps = np.array(self.stamps)
        columns = np.array(self.rows, dtype=np.float64).reshape(len(stamps), len(self._sources)).T
        traces = tuple(
            Trace(one, raw, one.scale, one.zero, quantum(raw[np.isfinite(raw)]) * abs(one.scale))
            for one, raw in zip(self._sources, columns, strict=True)
        )
        return Recording(stamps - stamps[:1].sum(), traces, CLOCK_UNCERTAINTY, uniform=False)
