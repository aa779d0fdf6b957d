"""Sample blocks on one line of time: ticks and positions past 32 bits, and the gaps between."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections import Counter
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
OFF_GRID = "samples between the ticks of the run"
OUTSIDE = "samples before the run's beginning or beyond its end"
OTHER_CHANNELS = "samples of other channels than were asked for"
TAKEN = "samples at ticks that other samples have"


class Blocks:
    """Blocks of one run as flat columns, so that a day of them fits into memory."""

    def __init__(self) -> None:
        self.firsts = array("q")  # tick of the first sample, extended to 64 bits
        self.counts = array("q")
        self.positions = array("q")
        self.dropped = array("q")  # before it, by the board's word
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
        self.dropped.append(block.dropped)
        self._raw += block.samples.astype("<i2").tobytes()

    def raw(self) -> NDArray[np.int16]:
        """All samples (n, channels), as they came."""
        flat = np.frombuffer(bytes(self._raw), dtype="<i2").astype(np.int16, copy=False)
        return flat.reshape(-1, len(self.channels))

    def holds(self, index: int, first: int, period: int, block: SampleBlock) -> bool:
        """Whether a block repeats what the one at ``index`` says."""
        skipped = (first - self.firsts[index]) // period
        if skipped + len(block.samples) > self.counts[index]:
            return False
        row = 2 * len(self.channels)
        begin = (sum(self.counts[:index]) + skipped) * row
        return self._raw[begin : begin + block.samples.size * 2] == block.samples.tobytes()


@dataclass(frozen=True)
class Arrays:
    """A run's samples: ticks (n,) int64, raw columns of n readings by channel, gaps."""

    ticks: NDArray[np.int64]
    columns: Mapping[str, NDArray[Any]]
    gaps: tuple[Gap, ...]


class Timeline:
    """Places blocks by their ticks. ``period`` is in ticks, ``samples`` the run's at most.

    ``channels`` are those asked for; without them, the first block's are. Samples without a place
    are counted in ``unplaced``, by the reason.
    """

    def __init__(
        self, period: int, samples: int | None = None, channels: tuple[Channel, ...] = ()
    ) -> None:
        self.period = period
        self.limit = samples
        self.channels = channels
        self.wrong_start: int | None = None  # what the board called the first tick, and was not
        self._clear()
        # what came while nothing had a place: a wrong word on the beginning must not cost it
        self._unfit: list[SampleBlock | Phase] = []

    def _clear(self) -> None:
        self.blocks = Blocks()
        self.phases: list[Phase] = []
        self.repeated = 0
        self.impossible = 0
        self.unplaced: Counter[str] = Counter()
        self._late: list[tuple[int, SampleBlock]] = []
        self._order: list[int] | None = None  # of the blocks by time; None: as they came
        self._next: int | None = None  # tick that the next sample should have
        self._begin: int | None = None  # tick of the first one, by the board's word
        self._first_phase: int | None = None

    def start(self, tick: int) -> None:
        """The tick of the run's first sample, from the reply to start."""
        if self._next is None:
            self._next = self._begin = tick

    def add(self, block: SampleBlock) -> None:
        """Places a block, or counts it in ``unplaced``.

        One that cannot be of this run has no place in it: a checksum of 16 bits lets a damaged
        frame in 65 536 pass, and a board may be wrong.
        """
        first = block.first_tick if self._next is None else self._extend(block.first_tick)
        if reason := self._why_not(first, block):
            self._refuse(block, reason)
            if not self.blocks and self._begin is not None:
                self._unfit.append(block)
        elif self._next is not None and first < self._next and self.blocks:
            self._late.append((first, block))
        else:
            self.blocks.append(first, block)
            self._next = first + len(block.samples) * self.period

    def phase(self, index: int, tick: int) -> None:
        """A program step began."""
        if not self.blocks and self._begin is not None:
            self._unfit.append(Phase(index, tick))
        if self._next is None:
            self._next = self._first_phase = tick
        extended = self._extend(tick)
        if self._outside(extended, 0) or self._off_grid(extended):
            return
        if not any(phase.index == index for phase in self.phases[-8:]):
            self.phases.append(Phase(index, extended))

    def settle(self) -> None:
        """Finds a place for what came out of order, once all has come. May be called again."""
        if not self.blocks and self._unfit:
            self._overrule_start()
        late, self._late = self._late, []
        if not late:
            return
        order = self._order or list(range(len(self.blocks)))
        firsts = [self.blocks.firsts[index] for index in order]
        for first, block in late:
            self._insert(first, block, order, firsts)
        self._order = order

    def _overrule_start(self) -> None:
        """Places everything by the first block, as not one fits what the reply to start said.

        Unless that leaves more samples without a place than with one: then it is no grid either.
        """
        told, unfit, self._unfit = self._begin, self._unfit, []
        before = self.unplaced
        self._clear()
        for one in unfit:
            if isinstance(one, Phase):
                self.phase(one.index, one.tick)
            else:
                self.add(one)
        placed = sum(self.blocks.counts) + sum(len(block.samples) for _, block in self._late)
        if placed > sum(self.unplaced.values()):
            self.wrong_start = told
            return
        self._clear()
        self.unplaced, self._begin = before, told

    def _insert(self, first: int, block: SampleBlock, order: list[int], firsts: list[int]) -> None:
        place = bisect_right(firsts, first)
        before = order[place - 1] if place else None
        end = first + len(block.samples) * self.period
        free = place == len(firsts) or end <= firsts[place]
        if before is not None and first < self._end(before):
            if self.blocks.holds(before, first, self.period, block):
                self.repeated += 1
                return
            free = False
        if not free:
            self._refuse(block, TAKEN)
            return
        order.insert(place, len(self.blocks))
        firsts.insert(place, first)
        self.blocks.append(first, block)

    def _refuse(self, block: SampleBlock, reason: str) -> None:
        self.impossible += 1
        self.unplaced[reason] += len(block.samples)

    def arrays(self, taken: int | None = None, dropped: int = 0) -> Arrays:
        """Everything placed; ``taken`` is how many samples the board took, when known.

        ``dropped``: of them, how many it says that it never sent.
        """
        self.settle()
        order = np.array(self._order or range(len(self.blocks)), dtype=np.int64)
        if not len(order):
            return Arrays(np.zeros(0, np.int64), {}, ())
        counts, firsts = np.array(self.blocks.counts), np.array(self.blocks.firsts)[order]
        raw = self._raw(order, counts)
        counts = counts[order]
        starts = np.cumsum(counts) - counts
        ticks = np.repeat(firsts - self.period * starts, counts)
        ticks += self.period * np.arange(len(ticks))
        columns: dict[str, NDArray[Any]] = {}
        for index, channel in enumerate(self.blocks.channels):
            name = channel.name.lower()
            column: NDArray[Any] = np.ascontiguousarray(raw[:, index])
            if name == POSITION:
                column = self._positions(column, counts, np.array(self.blocks.positions)[order])
            columns[name] = column
        gaps = self._gaps(firsts, counts, np.array(self.blocks.dropped)[order], taken, dropped)
        return Arrays(ticks, columns, gaps)

    def _raw(self, order: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int16]:
        """All samples (n, channels) in the order of their ticks."""
        raw = self.blocks.raw()
        if self._order is None:
            return raw
        starts = (np.cumsum(counts) - counts)[order]
        sizes = counts[order]
        rows = np.repeat(starts - (np.cumsum(sizes) - sizes), sizes) + np.arange(len(raw))
        return raw[rows]

    def _gaps(
        self,
        firsts: NDArray[np.int64],
        counts: NDArray[np.int64],
        said: NDArray[np.int64],
        taken: int | None,
        dropped: int,
    ) -> tuple[Gap, ...]:
        """What is missing before each block of ``counts`` samples, and at the end."""
        expected = np.r_[self._first_expected(int(firsts[0])), firsts + counts * self.period]
        missing = (firsts - expected[:-1]) // self.period
        index = np.cumsum(counts) - counts
        gaps: list[Gap] = []
        for block in np.flatnonzero(missing > 0).tolist():
            unsent = min(int(said[block]), int(missing[block]))
            _note(gaps, int(index[block]), unsent, int(missing[block]) - unsent, LOST)
        samples = int(counts.sum())
        left = (taken or 0) - samples - sum(gap.samples for gap in gaps)
        unsent = dropped - sum(gap.samples for gap in gaps if gap.reason == DROPPED)
        unsent = max(0, min(unsent, left))
        _note(gaps, samples, unsent, left - unsent, MISSING_END)
        return tuple(gaps)

    def _first_expected(self, first: int) -> int:
        """The tick that the run's first sample should have, as far as the board said."""
        told = self._begin if self._begin is not None else self._first_phase
        fits = told is not None and told <= first and not (first - told) % self.period
        if told is None or not fits or (first - told) // self.period > (self.limit or WRAP):
            return first
        return told

    def _end(self, index: int) -> int:
        return self.blocks.firsts[index] + self.blocks.counts[index] * self.period

    def _extend(self, tick: int) -> int:
        """A 32-bit tick as the 64-bit one nearest to where the run is."""
        near = self._next or 0
        return near + (tick - near + HALF) % WRAP - HALF

    def _why_not(self, first: int, block: SampleBlock) -> str:
        """Why a block has no place in the run; "" when it may have one."""
        channels = self.channels or self.blocks.channels
        if channels and block.channels != channels:
            return OTHER_CHANNELS
        if self._off_grid(first):
            return OFF_GRID
        return OUTSIDE if self._outside(first, len(block.samples)) else ""

    def _origin(self) -> int | None:
        """Without the reply to start, the first block stands for the run's beginning."""
        if self._begin is None and self.blocks:
            return self.blocks.firsts[0]
        return self._begin

    def _off_grid(self, first: int) -> bool:
        origin = self._origin()
        return origin is not None and bool((first - origin) % self.period)

    def _outside(self, first: int, samples: int) -> bool:
        """Whether the run has no samples at these ticks, as far as its beginning is known."""
        origin = self._origin()
        if origin is None:
            return False
        number = (first - origin) // self.period
        if number < (0 if self._begin is not None else -(self.limit or WRAP)):
            return True
        return self.limit is not None and number + samples > self.limit

    def _positions(
        self, low: NDArray[Any], counts: NDArray[np.int64], heads: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """Full positions (n,): each block's u32, extended, and the 16-bit steps within it."""
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


def _note(gaps: list[Gap], index: int, unsent: int, lost: int, why: str) -> None:
    for samples, reason in ((unsent, DROPPED), (lost, why)):
        if samples > 0:
            gaps.append(Gap(index, samples, reason))
