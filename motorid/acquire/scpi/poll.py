"""Instruments that are asked in turn, reading by reading: slow, and each reading a little later.

A row's stamp is the middle of its questions by this computer's clock. How far each channel's own
question lies from that is counted. An instrument may answer with a reading that it took before it
was asked, so the doubt of that delay is a whole row's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from motorid.acquire.scpi.bench_file import SUPPLY, Source
from motorid.acquire.scpi.link import Instrument
from motorid.acquire.scpi.recorder import Clock, Recording, Trace
from motorid.acquire.scpi.scan import WITHIN
from motorid.acquire.scpi.supply import Supply
from motorid.capture.model import CURRENT, SPEED
from motorid.capture.reading_step import reading_step
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
        self._asked: list[list[tuple[float, float]]] = []  # begin and end of each question

    def row(self) -> None:
        """One reading of each. Raises LinkError; then the row is left out."""
        began = self._clock.now()
        answers: dict[tuple[str, str], list[float]] = {}
        times: dict[tuple[str, str], tuple[float, float]] = {}
        values, asked = [], []
        for one in self._sources:
            supplied = one.instrument == SUPPLY
            instrument = self._supply.instrument if supplied else self._meters[one.instrument]
            query = one.query or self._supply.measure_query(one.name)
            key = (one.instrument, query)
            if key not in answers:
                start = self._clock.now()
                answers[key] = instrument.numbers(query)
                times[key] = start, self._clock.now()
            if one.place >= len(answers[key]):
                raise LinkError(
                    f"the {instrument.name} answers {query!r} with {len(answers[key])} numbers, "
                    f"and channels.{one.name}.field is {one.place}"
                )
            values.append(answers[key][one.place])
            asked.append(times[key])
        self.stamps.append((began + self._clock.now()) / 2)
        self.rows.append(values)
        self._asked.append(asked)

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
        asked = np.array(self._asked).reshape(len(stamps), len(self._sources), 2)
        late = np.median(stamps[:, None] - asked.mean(axis=2), axis=0) if len(stamps) else []
        row_s = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
        traces = tuple(
            Trace(
                one,
                raw,
                one.scale,
                one.zero,
                reading_step(raw) * abs(one.scale),
                late=(float(late[n]), row_s / WITHIN),
            )
            for n, (one, raw) in enumerate(zip(self._sources, columns, strict=True))
            if len(stamps)
        )
        return Recording(
            stamps - stamps[:1].sum(), traces, CLOCK_UNCERTAINTY, uniform=False, polled=True
        )
