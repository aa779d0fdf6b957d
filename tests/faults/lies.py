"""Things that a board says and that are not so, each as what it says in place of a payload."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

from motorid.wire.codec import (
    Event,
    Reply,
    SampleBlock,
    channel_mask,
    decode,
    encode_event,
    encode_reply,
)

Lie = Callable[[bytes], list[bytes]]
WRAP = 1 << 32
CHANNELS_AT = 13  # in a block's payload: after code, sequence, tick, dropped and position
PULSE = 1  # runs that are left as they are, so that the run proper begins


def changed(name: str, **fields: Any) -> Lie:
    """Replies of that name carry other values."""

    def lie(payload: bytes) -> list[bytes]:
        message = decode(payload)
        if isinstance(message, Reply) and message.name == name and not message.status:
            return [_reply(message, fields)]
        return [payload]

    return lie


def start(by: int) -> Lie:
    """The reply to start names another tick, in the run proper."""

    def lie(message: Any, payload: bytes) -> list[bytes]:
        if isinstance(message, Reply) and message.name == "start":
            tick = (message.fields["start_tick"] + by) % WRAP
            return [_reply(message, {"start_tick": tick})]
        return [payload]

    return _in_the_run(lie)


def scattered() -> Lie:
    """Every block names any tick at all."""
    rng = random.Random(1)
    return _of_blocks(lambda block, number: [_block(block, first_tick=rng.randrange(WRAP))])


def some_between(every: int) -> Lie:
    """Every so many-th block is a little late by its tick."""
    return _of_blocks(
        lambda block, number: [
            _block(block, first_tick=(block.first_tick + (0 if number % every else 7)) % WRAP)
        ]
    )


def swapped() -> Lie:
    """Of each two blocks the second comes first."""
    held: list[bytes] = []

    def lie(message: Any, payload: bytes) -> list[bytes]:
        if isinstance(message, SampleBlock) and not held:
            held.append(payload)
            return []
        if isinstance(message, SampleBlock) or (isinstance(message, Event) and held):
            return (
                [payload, held.pop()] if isinstance(message, SampleBlock) else [held.pop(), payload]
            )
        return [payload]

    return _in_the_run(lie)


def twice() -> Lie:
    """Every block comes twice."""
    return _of_blocks(lambda block, number: [_block(block)] * 2)


def channels(mask: int) -> Lie:
    """Blocks claim other channels than were asked for."""

    def claim(block: SampleBlock, number: int) -> list[bytes]:
        payload = bytearray(_block(block))
        payload[CHANNELS_AT] = mask
        return [bytes(payload)]

    return _of_blocks(claim)


def ends_at_once() -> Lie:
    """The run is said to be over before its first block."""
    over = encode_event("done", reason=0, tick=0, blocks=0, samples=0, dropped=0)
    return _of_blocks(lambda block, number: ([] if number else [over]) + [_block(block)])


def no_blocks() -> Lie:
    """Not one block is sent."""
    return _of_blocks(lambda block, number: [])


def endless() -> Lie:
    """The last block comes again and again, each time a little later, in place of the end."""
    last: list[SampleBlock] = []

    def lie(message: Any, payload: bytes) -> list[bytes]:
        if isinstance(message, SampleBlock):
            last[:] = [message]
        if isinstance(message, Event) and message.name == "done":
            return [_block(last[0], first_tick=n * 1600) for n in range(1000)]
        return [payload]

    return _in_the_run(lie)


def dropped() -> Lie:
    """The counts of the end are absurd."""

    def lie(message: Any, payload: bytes) -> list[bytes]:
        if isinstance(message, Event) and message.name == "done":
            return [encode_event("done", **(message.fields | {"dropped": WRAP - 1}))]
        return [payload]

    return _in_the_run(lie)


def _in_the_run(lie: Callable[[Any, bytes], list[bytes]]) -> Lie:
    """``lie`` from the second start on."""
    starts = 0

    def later(payload: bytes) -> list[bytes]:
        nonlocal starts
        message = decode(payload)
        if isinstance(message, Reply) and message.name == "start" and not message.status:
            starts += 1
        return lie(message, payload) if starts > PULSE else [payload]

    return later


def _of_blocks(lie: Callable[[SampleBlock, int], list[bytes]]) -> Lie:
    """``lie`` on the blocks of the run proper, which it also gets the number of."""
    number = -1

    def on_blocks(message: Any, payload: bytes) -> list[bytes]:
        nonlocal number
        if not isinstance(message, SampleBlock):
            return [payload]
        number += 1
        return lie(message, number)

    return _in_the_run(on_blocks)


def _reply(message: Reply, fields: dict[str, Any]) -> bytes:
    return encode_reply(message.name, message.request, message.status, **(message.fields | fields))


def _block(block: SampleBlock, **fields: int) -> bytes:
    old = {
        "sequence": block.sequence,
        "first_tick": block.first_tick,
        "dropped": block.dropped,
        "position": block.position,
        "channels": channel_mask(block.channels),
    }
    return encode_event(block.name, **(old | fields), samples=block.samples)
