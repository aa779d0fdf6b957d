"""Where a run is watched from: a bounded queue that the run fills and never waits for."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from motorid.acquire.board import Board, Fields
from motorid.acquire.channels import offset_of
from motorid.capture.model import POSITION
from motorid.rig import Rig
from motorid.rig_model import Calibration
from motorid.wire.codec import SampleBlock, mask_channels
from motorid.wire.enums import Channel

MOST_BLOCKS = 4096  # that wait for the viewer; beyond them the oldest go


@dataclass(frozen=True)
class Scale:
    """Of one channel: SI units a count, and the counts at zero."""

    name: str
    unit: str
    factor: float
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class RunFacts:
    """What turns the sample blocks of one run into SI units. ``period``: ticks between samples."""

    clock_hz: float
    period: int
    channels: tuple[Channel, ...]
    scales: tuple[Scale, ...]  # one a channel, in the same order


Consume = Callable[[SampleBlock], None]
Watch = Callable[[RunFacts], Consume]  # told when a run begins; what it returns gets each block
UNITS = {"current": "A", POSITION: "rad"}


def run_facts(rig: Rig, board: Board, config: Fields, zero: Fields) -> RunFacts:
    """Of the run that ``config`` is for, with the offsets that were read before it."""
    channels = mask_channels(config["channels"])
    return RunFacts(
        clock_hz=board.identity["clock_hz"] * rig.clock_rate,
        period=config["sample_period_ticks"],
        channels=channels,
        scales=tuple(_scale(rig, board, zero, one.name.lower()) for one in channels),
    )


def _scale(rig: Rig, board: Board, zero: Fields, name: str) -> Scale:
    if name == POSITION:
        return Scale(name, "rad", 2 * math.pi / rig.wiring.counts_per_turn)
    fact, known = board.descriptors[name], rig.calibration.get(name, Calibration())
    offset, _, _ = offset_of(name, fact, zero, 1, known)
    return Scale(name, UNITS.get(name, "V"), fact["scale"] * known.gain, offset)


class Tap:
    """Blocks on their way from the thread that measures to one that shows them.

    ``begin`` is a ``Watch``. Giving a block costs a microsecond and cannot fail: a viewer that is
    late loses the oldest blocks, and learns how many.
    """

    def __init__(self) -> None:
        self._blocks: deque[tuple[int, RunFacts, SampleBlock]] = deque(maxlen=MOST_BLOCKS)
        self._given = 0
        self._taken = 0
        self.lost = 0  # blocks that the viewer was too late for

    def begin(self, facts: RunFacts) -> Consume:
        """A run begins."""

        def consume(block: SampleBlock) -> None:
            self._given += 1
            self._blocks.append((self._given, facts, block))

        return consume

    @property
    def waiting(self) -> bool:
        """Whether blocks wait."""
        return bool(self._blocks)

    def taken(self) -> Iterator[tuple[RunFacts, SampleBlock]]:
        """All blocks that wait, the oldest first."""
        while self._blocks:
            number, facts, block = self._blocks.popleft()
            self.lost += number - self._taken - 1
            self._taken = number
            yield facts, block


def both(one: Consume, watch: Watch | None, facts: Callable[[], RunFacts]) -> Consume:
    """A consumer that also gives each block to ``watch``, where somebody watches."""
    if watch is None:
        return one
    other = watch(facts())

    def consume(block: SampleBlock) -> None:
        one(block)
        other(block)

    return consume
