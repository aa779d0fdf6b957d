"""Sample blocks in SI units as they come: for who watches a run, never for its capture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.tap import RunFacts
from motorid.capture.model import POSITION
from motorid.wire.codec import SampleBlock

WRAP, HALF = 1 << 32, 1 << 31
SHORT, SHORT_HALF = 1 << 16, 1 << 15
SPEED_S = 0.01  # the speed shown is the mean over this long: one count a sample says little
SPEED, SPEED_UNIT = "speed", "rad/s"
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Strip:
    """Consecutive samples: ``values`` (names, n) in ``units``; NaN where nothing can be said.

    ``start_s`` counts from the first sample that was watched, by the board's clock, and ``run``
    the runs from 1 on.
    """

    run: int
    start_s: float
    period_s: float
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Floats

    @property
    def end_s(self) -> float:
        """When the next sample is due."""
        return self.start_s + int(self.values.shape[1]) * self.period_s

    def follows(self, other: Strip) -> bool:
        """Whether no sample is missing between ``other`` and this."""
        return self.run == other.run and abs(self.start_s - other.end_s) < self.period_s / 2


class Strips:
    """Turns blocks into strips, over all runs of one board that are watched.

    A block that repeats an earlier time gives none. ``speed`` is the slope of the position over
    the last SPEED_S.
    """

    def __init__(self) -> None:
        self._facts: RunFacts | None = None
        self._run = 0
        self._next = 0  # tick of the next sample, on a line without end
        self._first: int | None = None
        self._position = 0  # counts at the latest block, extended
        self._tail: NDArray[np.int64] = np.zeros(0, np.int64)

    def take(self, facts: RunFacts, block: SampleBlock) -> Strip | None:
        """The strip of one block; None where it is late, or of other channels."""
        if block.channels != facts.channels or not len(block.samples):
            return None
        first = self._extended(block.first_tick)
        anew = facts is not self._facts
        if anew and first < self._next:
            first += WRAP  # the board was reset, or rested for longer than its ticks can count
        if first < self._next:
            return None
        if self._first is None:
            self._first = first
        if anew or first != self._next:
            self._tail = self._tail[:0]
        self._run += anew
        self._facts, self._next = facts, first + len(block.samples) * facts.period
        return self._strip(facts, first - self._first, block)

    def _extended(self, tick: int) -> int:
        if self._first is None:
            return tick
        return self._next + (tick - self._next + HALF) % WRAP - HALF

    def _strip(self, facts: RunFacts, since: int, block: SampleBlock) -> Strip:
        period_s = facts.period / facts.clock_hz
        rows: list[tuple[str, str, Floats]] = []
        for scale, raw in zip(facts.scales, block.samples.T, strict=True):
            if scale.name == POSITION:
                counts = self._counts(block.position, raw)
                speed = self._speed(counts, scale.factor, period_s)
                rows.append((scale.name, scale.unit, np.multiply(scale.factor, counts)))
                rows.append((SPEED, SPEED_UNIT, speed))
            else:
                shown = scale.factor * (raw.astype(np.float64) - scale.offset)
                rows.append((scale.name, scale.unit, shown))
        names, units, values = zip(*rows, strict=True)
        return Strip(self._run, since / facts.clock_hz, period_s, names, units, np.array(values))

    def _counts(self, head: int, low: NDArray[np.int16]) -> NDArray[np.int64]:
        """Full positions (n,): the block's 32 bits, extended, and the 16-bit steps within it."""
        self._position += (head - self._position + HALF) % WRAP - HALF
        steps = np.zeros(len(low), dtype=np.int64)
        steps[1:] = np.diff(low.astype(np.int64))
        steps = (steps + SHORT_HALF) % SHORT - SHORT_HALF
        return np.asarray(self._position + np.cumsum(steps), dtype=np.int64)

    def _speed(self, counts: NDArray[np.int64], factor: float, period_s: float) -> Floats:
        window = max(1, round(SPEED_S / period_s))
        known = np.concatenate([self._tail, counts])
        self._tail = known[-window:]
        speed = np.full(len(counts), np.nan)
        slopes = (known[window:] - known[:-window]) * (factor / (window * period_s))
        if len(slopes):
            speed[-len(slopes) :] = slopes
        return speed


def joined(strips: Iterable[Strip]) -> Iterator[Strip]:
    """The same samples in as few strips as gaps and runs allow."""
    waiting: list[Strip] = []
    for strip in strips:
        if waiting and not strip.follows(waiting[-1]):
            yield _one(waiting)
            waiting = []
        waiting.append(strip)
    if waiting:
        yield _one(waiting)


def _one(strips: list[Strip]) -> Strip:
    first = strips[0]
    if len(strips) == 1:
        return first
    values = np.concatenate([strip.values for strip in strips], axis=1)
    return replace(first, values=values)
