"""Samples to blocks: the board's way of sending, keeping and dropping them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from motorid.sim.bench import Counts, Raw
from motorid.wire.codec import encode_event, mask_channels
from motorid.wire.enums import Channel, Mode
from motorid.wire.spec import load

BLOCK_HEADER = 15  # bytes of a sample_block before its samples
U32 = 0xFFFF_FFFF


class Stream:
    """Collects one run's samples and sends them as ``sample_block`` events.

    ``has_room`` says whether the link can take another block; without room a streamed block is
    dropped and counted. In burst mode blocks wait for ``finish``, at most ``keep`` samples.
    ``age_ticks`` is the age of its first sample at which a part-filled block goes.
    """

    def __init__(
        self,
        config: Mapping[str, int],
        age_ticks: int,
        send: Callable[[bytes], None],
        has_room: Callable[[], bool],
        keep: int,
    ) -> None:
        limits = load().limits
        self._mask = config["channels"]
        self._channels = mask_channels(self._mask)
        self._burst = config["mode"] == Mode.BURST
        self._send, self._has_room, self._keep = send, has_room, keep
        room = (load().max_payload - BLOCK_HEADER) // (2 * len(self._channels))
        aged = age_ticks // config["sample_period_ticks"] + 1
        self.size = min(limits.block_samples, room, aged)
        self._kept: list[dict[str, Any]] = []
        self._waiting = 0  # samples in _kept
        self._part: list[tuple[Raw, Counts]] = []
        self._part_tick = 0
        self._filled = 0
        self._sequence = 0
        self._just_dropped = 0
        self.blocks = self.samples = self.dropped = 0

    @property
    def space(self) -> int:
        """Samples that the present block still takes."""
        return self.size - self._filled

    def add(self, tick: int, raw: Raw, counts: Counts) -> None:
        """Samples (n, 3) and counts (n,), n at most ``space``; ``tick`` is the first one's."""
        if not self._filled:
            self._part_tick = tick
        self._part.append((raw, counts))
        self._filled += len(counts)
        if self._filled == self.size:
            self._close()

    def finish(self) -> None:
        """Send whatever is left."""
        self._close()
        for block in self._kept:
            self._emit(block)
        self._kept.clear()

    def _close(self) -> None:
        if not self._filled:
            return
        raw = np.concatenate([part[0] for part in self._part])
        counts = np.concatenate([part[1] for part in self._part])
        self._part.clear()
        self._filled = 0
        room = self._keep - self._waiting if self._burst else self.size * self._has_room()
        kept = min(len(counts), room)
        self._drop(len(counts) - kept)
        if not kept:
            return
        block = {
            "first_tick": self._part_tick & U32,
            "position": int(counts[0]) & U32,
            "samples": self._columns(raw[:kept], counts[:kept]),
        }
        if self._burst:
            self._waiting += kept
            self._kept.append(block)
        else:
            self._emit(block)

    def _drop(self, samples: int) -> None:
        self.dropped += samples
        if not self._burst:  # what a burst drops lies behind its last block
            self._just_dropped += samples

    def _columns(self, raw: Raw, counts: Counts) -> Raw:
        low = (counts & 0xFFFF).astype(np.uint16).view(np.int16)
        columns = [low if c == Channel.POSITION else raw[:, c] for c in self._channels]
        return np.stack(columns, axis=1)

    def _emit(self, block: dict[str, Any]) -> None:
        self._send(
            encode_event(
                "sample_block",
                sequence=self._sequence & 0xFFFF,
                dropped=min(self._just_dropped, 0xFFFF),
                channels=self._mask,
                **block,
            )
        )
        self._just_dropped = 0
        self._sequence += 1
        self.blocks += 1
        self.samples += len(block["samples"])
