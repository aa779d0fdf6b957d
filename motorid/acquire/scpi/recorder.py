"""A scope or a DAQ that records a run by its own clock, and hands it over afterwards.

A scope has a waveform of each input, by one time base. A DAQ that scans has readings, each with a
time of its own: ``scan``.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.scpi.bench_file import Source
from motorid.acquire.scpi.dialect import Dialect
from motorid.acquire.scpi.link import Instrument, number_of, written
from motorid.acquire.scpi.scan import scans_of
from motorid.capture import quadrature
from motorid.capture.reading_step import reading_step
from motorid.errors import DataError, LinkError

SLICE_S = 0.02
PREAMBLE = 10  # numbers: format, type, points, count, and increment, origin, reference of x and y


class Clock:
    """This computer's clock, in seconds."""

    def now(self) -> float:
        """Monotonic."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Waits."""
        time.sleep(max(0.0, seconds))


@dataclass(frozen=True)
class Trace:
    """One quantity: value = scale (raw - offset) in SI, for raw (n,); its ends and its step."""

    source: Source
    raw: NDArray[Any]
    scale: float
    offset: float
    resolution: float
    raw_min: float = -math.inf
    raw_max: float = math.inf
    late: tuple[float, float] | None = None  # s behind the stamp, and its standard doubt


@dataclass(frozen=True)
class Recording:
    """Traces of one clock: ``time_s`` (n,) from the first sample, and that clock's doubt."""

    time_s: NDArray[np.float64]
    traces: tuple[Trace, ...]
    clock_uncertainty: float  # relative, standard
    uniform: bool
    polled: bool = False  # by this computer, query by query
    notes: tuple[str, ...] = ()  # what could not be made of the inputs


class Recorder:
    """One recording instrument, told by its dialect."""

    def __init__(
        self, instrument: Instrument, dialect: Dialect, sources: Sequence[Source], doubt: float
    ) -> None:
        self.instrument, self._dialect = instrument, dialect
        self._sources, self._doubt = sources, doubt
        self._fields: dict[str, str] = {}

    def start(self, rate_hz: float, duration_s: float) -> None:
        """Has it record so long, from now on. Raises RigError or LinkError."""
        points, inputs = math.ceil(rate_hz * duration_s), self._inputs()
        self._fields = {
            "rate_hz": written(rate_hz),
            "period_s": written(1.0 / rate_hz),
            "duration_s": written(duration_s),
            "points": str(points),
            "inputs": str(len(inputs)),
            "readings": str(points * len(inputs)),
            "sources": ",".join(inputs),
        }
        lines = (*self._dialect.prepare, *self._dialect.get("acquire", "start"))
        for line in lines:
            self.instrument.command(line.format_map(self._fields))

    def wait(self, clock: Clock, patience_s: float) -> None:
        """Until it has recorded all. Raises LinkError after ``patience_s``."""
        ask = self._dialect.get("acquire", "done")
        if not ask:
            clock.sleep(patience_s / 2)
            return
        mask = int(self._dialect.get("acquire", "mask") or 0)
        wanted = int(self._dialect.get("acquire", "value") or 0)
        until = clock.now() + patience_s
        while True:
            found = int(self.instrument.number(ask))
            if (found & mask if mask else found) == wanted:
                return
            if clock.now() > until:
                raise LinkError(
                    f"the recorder has not finished (it answers {ask!r} with {found}): is it "
                    "triggered, and its record no longer than the run?"
                )
            clock.sleep(SLICE_S)

    def stop(self) -> None:
        """Ends a recording early, where the instrument can."""
        for line in self._dialect.get("acquire", "stop") or ():
            self.instrument.command(line)

    def recording(self) -> Recording:
        """What it recorded. Raises LinkError where its inputs are not of one time base."""
        if "scan" in self._dialect.tables:
            return self._scanned()
        inputs = {name: self._input(name) for name in self._inputs()}
        periods = {round(period_s, 15) for _, period_s in inputs.values()}
        sizes = {len(trace.raw) for trace, _ in inputs.values()}
        if len(periods) != 1 or len(sizes) != 1 or not min(periods) > 0:
            raise LinkError(
                f"the recorder's inputs differ in their time base ({sizes} points, {periods} s "
                "apart): record all of them alike"
            )
        time_s = np.arange(sizes.pop(), dtype=np.float64) * periods.pop()
        traces, notes = [], []
        for one in self._sources:
            try:
                traces.append(self._trace(one, [inputs[name][0] for name in one.sources]))
            except DataError as error:  # edges were lost: what else was measured stays
                notes.append(f"{one.name} is left out: {error}")
        return Recording(time_s, tuple(traces), self._doubt, uniform=True, notes=tuple(notes))

    def _inputs(self) -> list[str]:
        return [name for one in self._sources for name in one.sources]

    def _scanned(self) -> Recording:
        facts = self._dialect.tables["scan"]
        found = scans_of(self._numbers(facts["data"]), facts["elements"], self._inputs())
        traces = []
        for one in self._sources:
            (name,) = one.sources
            raw, late = found.readings[name], (found.late_s[name], found.late_uncertainty_s)
            step = reading_step(raw)
            trace = self._trace(one, [Trace(Source(name), raw, 1.0, 0.0, step)])
            traces.append(replace(trace, late=late))
        doubt = math.hypot(self._doubt, found.period_uncertainty)
        return Recording(found.time_s, tuple(traces), doubt, found.is_uniform, notes=(found.note,))

    def _input(self, name: str) -> tuple[Trace, float]:
        """One input in its own unit, and s between its readings."""
        for line in self._dialect.get("waveform", "select") or ():
            self.instrument.command(line.format_map({**self._fields, "source": name}))
        ask = self._dialect.get("waveform", "preamble")
        facts = self.instrument.numbers(ask.format_map({"source": name}))
        if len(facts) < PREAMBLE:
            raise LinkError(
                f"the recorder answers {ask!r} with {len(facts)} numbers, and {PREAMBLE} are its "
                "preamble: correct `waveform.preamble` in its dialect"
            )
        raw = self._data(self._dialect.get("waveform", "data").format_map({"source": name}))
        period_s, scale = facts[4], facts[7]
        if not len(raw) or not math.isfinite(period_s) or not (math.isfinite(scale) and scale):
            raise LinkError(f"the recorder has nothing on input {name}: is it switched on?")
        if self._dialect.get("waveform", "origin") == "counts":
            offset = facts[8] + facts[9]
        else:
            offset = facts[9] - facts[8] / scale
        facts_of = self._dialect.tables["waveform"]
        low, high = facts_of.get("raw_min", -math.inf), facts_of.get("raw_max", math.inf)
        step = abs(scale) if np.issubdtype(raw.dtype, np.integer) else 0.0
        return Trace(Source(name), raw, scale, offset, step, low, high), period_s

    def _data(self, query: str) -> NDArray[Any]:
        kind = self._dialect.get("waveform", "type")
        if kind == "ascii":
            return self._numbers(query)
        big = bool(self._dialect.get("waveform", "big_endian"))
        return self.instrument.block(query, kind, big)

    def _numbers(self, query: str) -> NDArray[np.float64]:
        """Of a text, in a block or without one."""
        text, said = self.instrument.ask(query), f"the recorder answers {query!r}"
        if text.startswith("#") and len(text) > 1 and text[1].isdecimal():
            text = text[2 + int(text[1]) :]
        return np.array([number_of(part, said) for part in text.split(",") if part.strip()])

    def _trace(self, one: Source, lines: Sequence[Trace]) -> Trace:
        first = lines[0]
        if len(lines) == 2:
            volts = [line.scale * (line.raw.astype(np.float64) - line.offset) for line in lines]
            return Trace(one, quadrature.counts(*volts), one.scale, 0.0, abs(one.scale))
        scale = first.scale * one.scale
        return Trace(
            one,
            first.raw,
            scale,
            first.offset + one.zero / first.scale,
            first.resolution * abs(one.scale),
            first.raw_min,
            first.raw_max,
        )
