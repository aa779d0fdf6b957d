"""What a person sees while a run goes on: how far it is, current and speed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from motorid.acquire.board import Board, Fields
from motorid.acquire.plan import WireProgram
from motorid.capture.model import CURRENT
from motorid.rig import Rig
from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel

REDRAW_S = 0.1
WRAP, HALF = 1 << 32, 1 << 31


@dataclass(frozen=True)
class Live:
    """A run in progress: seconds done and in all, and the latest current and speed."""

    done_s: float
    total_s: float
    current_a: float | None
    speed_rad_s: float | None


class LiveView:
    """Consumes sample blocks and calls ``progress`` about ten times a second, and at the end."""

    def __init__(
        self,
        rig: Rig,
        board: Board,
        zero: Fields,
        program: WireProgram,
        progress: Callable[[Live], None] | None,
    ) -> None:
        self.clock_hz = board.identity["clock_hz"]
        self.total_s = program.ticks / self.clock_hz
        self.count_rad = 2 * math.pi / rig.wiring.counts_per_turn
        self.scale = board.descriptors.get(CURRENT, {}).get("scale", 0.0)
        self.offset = zero["current_offset"]
        self.progress = progress
        self.first: SampleBlock | None = None
        self.last: SampleBlock | None = None
        self.drawn = -math.inf

    def consume(self, block: SampleBlock) -> None:
        """Takes a block as it arrives."""
        if self.progress is None:
            return
        if self.first is None:
            self.first = self.last = block
            self.progress(Live(0.0, self.total_s, None, None))
        now = time.monotonic()
        if now - self.drawn >= REDRAW_S:
            self.drawn = now
            self.progress(self._live(self.first, block))
            self.last = block

    def _live(self, first: SampleBlock, block: SampleBlock) -> Live:
        done_s = (block.first_tick - first.first_tick) % WRAP / self.clock_hz
        current = None
        if Channel.CURRENT in block.channels:
            column = block.samples[:, block.channels.index(Channel.CURRENT)]
            current = float(self.scale * (column.mean() - self.offset))
        return Live(min(done_s, self.total_s), self.total_s, current, self._speed(block))

    def _speed(self, block: SampleBlock) -> float | None:
        if self.last is None:
            return None
        ticks = (block.first_tick - self.last.first_tick) % WRAP
        counts = (block.position - self.last.position + HALF) % WRAP - HALF
        return counts * self.count_rad * self.clock_hz / ticks if ticks else None
