"""Sample blocks on one line of time: ticks and positions past 32 bits, and the gaps between."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, Gap, Phase
from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel

WRAP = 1 << 32
HALF = 1 << 31
DROPPED = "dropped by the board: the link was too slow"
LOST = "lost on the link"
MISSING_END = "lost on the link at the end of the run"


class Blocks:
    """Blocks of one run as flat columns, so that a day of them fits into memory."""

    def __init__(self) -> None:
        self.firsts = array("q")  # tick of the first sample, extended to 64 bits
        self.counts = array("q")
        self.positions = array("q")
        self.channels: tuple[Channel, ...] = ()
        self._raw = bytearray()

    def __len__(self) -> int:
        return len(self.firsts)

    def append(self, first: int, block: SampleBlock) -> None:
        """One more; all of them have the same channels."""
        self.channels = block.channels
        self.firsts.append(first)
        self.counts.append(len(block.samples))
        self.positions.append(block.position)
        self._raw += block.samples.astype("<i2").tobytes()

    def raw(self) -> NDArray[np.int16]:
        """All samples (n, channels)."""
        flat = np.frombuffer(bytes(self._raw), dtype="<i2").astype(np.int16, copy=False)
        return flat.reshape(-1, len(self.channels))


@dataclass(frozen=True)
class Arrays:
    """A run's samples: ticks (n,) int64, raw columns of n readings by channel, gaps."""

    ticks: NDArray[np.int64]
    columns: Mapping[str, NDArray[Any]]
    gaps: tuple[Gap, ...]


class Timeline:
    """Places blocks as they arrive. ``period`` is in ticks, ``samples`` the run's at most."""

    def __init__(self, period: int, samples: int | None = None) -> None:
        self.period = period
        self.limit = samples
        self.blocks = Blocks()
        self.phases: list[Phase] = []
        self.repeated = 0
        self.impossible = 0
        self._gaps: list[Gap] = []
        self._samples = 0
        self._next: int | None = None  # tick that the next sample should have
        self._begin: int | None = None  # tick of the first one

    def start(self, tick: int) -> None:
        """The tick of the run's first sample, from the reply to start."""
        if self._next is None:
            self._next = self._begin = tick

    def add(self, block: SampleBlock) -> None:
        """Places a block after the others; one that was there already is counted and left out.

        So is one that cannot be of this run: a checksum of 16 bits lets a damaged frame in
        65 536 pass.
        """
        first = block.first_tick if self._next is None else self._extend(block.first_tick)
        if self._next is not None and first < self._next:
            self.repeated += 1
            return
        if self._next is not None and not self._possible(first, len(block.samples)):
            self.impossible += 1
            return
        if self.blocks and block.channels != self.blocks.channels:
            self.repeated += 1  # of another run: it has no place in this one
            return
        if self._next is not None:
            self._note_gap((first - self._next) // self.period, block.dropped)
        self.blocks.append(first, block)
        self._samples += len(block.samples)
        self._next = first + len(block.samples) * self.period

    def phase(self, index: int, tick: int) -> None:
        """A program step began."""
        if self._next is None:
            self._next = tick
        extended = self._extend(tick)
        if not self._possible(extended, 0):
            return
        if not any(phase.index == index for phase in self.phases[-8:]):
            self.phases.append(Phase(index, extended))

    def arrays(self, taken: int | None = None, dropped: int = 0) -> Arrays:
        """Everything placed; ``taken`` is how many samples the board took, when known.

        ``dropped``: of them, how many it says that it never sent.
        """
        gaps = list(self._gaps)
        missing = (taken or 0) - self._samples - sum(gap.samples for gap in gaps)
        unsent = dropped - sum(gap.samples for gap in gaps if gap.reason == DROPPED)
        unsent = max(0, min(unsent, missing))
        for samples, reason in ((unsent, DROPPED), (missing - unsent, MISSING_END)):
            if samples > 0:
                gaps.append(Gap(self._samples, samples, reason))
        counts = np.array(self.blocks.counts)
        starts = np.cumsum(counts) - counts
        ticks = np.repeat(np.array(self.blocks.firsts) - self.period * starts, counts)
        ticks += self.period * np.arange(len(ticks))
        raw = self.blocks.raw()
        columns: dict[str, NDArray[Any]] = {}
        for index, channel in enumerate(self.blocks.channels):
            name = channel.name.lower()
            column = np.ascontiguousarray(raw[:, index])
            columns[name] = self._positions(column) if name == POSITION else column
        return Arrays(ticks, columns, tuple(gaps))

    def _extend(self, tick: int) -> int:
        """A 32-bit tick as the 64-bit one nearest to where the run is."""
        near = self._next or 0
        return near + (tick - near + HALF) % WRAP - HALF

    def _possible(self, first: int, samples: int) -> bool:
        """Whether the run has samples at these ticks, as far as its beginning is known.

        Without the reply to start, the first block stands for it: the run began there or earlier.
        """
        begin = self._begin
        if begin is None and self.blocks:
            begin = self.blocks.firsts[0]
        if begin is None:
            return True
        number, between = divmod(first - begin, self.period)
        return not between and (self.limit is None or number + samples <= self.limit)

    def _note_gap(self, missing: int, dropped: int) -> None:
        dropped = min(dropped, missing)
        for samples, reason in ((dropped, DROPPED), (missing - dropped, LOST)):
            if samples > 0:
                self._gaps.append(Gap(self._samples, samples, reason))

    def _positions(self, low: NDArray[Any]) -> NDArray[np.int64]:
        """Full positions (n,): each block's u32, extended, and the 16-bit steps within it."""
        counts = np.array(self.blocks.counts)
        heads = np.array(self.blocks.positions)
        jumps = (np.diff(heads) + HALF) % WRAP - HALF
        first = int((heads[0] + HALF) % WRAP - HALF)  # small where the board began near zero
        bases = first + np.concatenate([[0], np.cumsum(jumps)])
        steps = np.zeros(len(low), dtype=np.int64)
        steps[1:] = np.diff(low.astype(np.int64))
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        steps = (steps + (1 << 15)) % (1 << 16) - (1 << 15)
        steps[starts] = 0
        walked = np.cumsum(steps)
        return np.asarray(walked + np.repeat(bases - walked[starts], counts), dtype=np.int64)
