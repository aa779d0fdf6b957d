"""A Pico that streams as fast as it can, with all that its sample interrupt may have to do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorid.wire.enums import Channel
from tests.conformance.boards import opened
from tests.conformance.client import Client, Record

MOTOR = "dunkermotoren-gr42"
THREE = 0b1011  # current, terminal voltage, position
EDGES_HZ = 200_000.0  # beside the motor's own
PERIOD_S = 50e-6
INTERRUPT_S = PERIOD_S / 2  # from a window's end to that of its interrupt
VOLTS = 6.0
LONGEST = 400_000  # samples of a step: its ticks are 32 bits
CHECKS = {
    "voltage_limit_mv": 30_000,
    "inputs_required": 3,
    "sign_check_ms": 200,
    "sign_check_ma": 2000,
    "sign_check_mv": 9000,
    "sign_check_counts": 60_000,
}


@dataclass(frozen=True)
class Stream:
    """What came of it."""

    samples: int  # that came, each at its tick
    expected: int
    dropped: int
    interrupt_s: float  # the longest
    edges_hz: float  # counted, in the steady half
    bytes_s: float
    faults: int

    @property
    def is_whole(self) -> bool:
        return self.samples == self.expected and not self.dropped and not self.faults


def stream(seconds: float) -> Stream:
    """Three channels at 20 kHz over USB, volts held, every check, heartbeats."""
    with opened("pico-usb", motor=MOTOR) as board:
        client = Client(board.port)
        client.bring_up()
        client.settings["sample_period_ticks"] = client.identity["min_sample_period_ticks"]
        emulator = client.port.board  # type: ignore[attr-defined]
        emulator.set("inputs", 3)
        emulator.set("extra_edges", EDGES_HZ)
        emulator.times()
        samples = round(seconds / client.seconds(1))
        limit = round(1000 * seconds) + 1000
        steps = [client.hold(min(left, LONGEST), VOLTS) for left in range(samples, 0, -LONGEST)]
        record = client.start(*steps, channels=THREE, run_time_limit_ms=limit, **CHECKS)
        client.payloads.clear()
        client.follow(record)
        size = sum(map(len, client.payloads))
        position = positions(record)
        half = len(position) // 2
        return Stream(
            samples=in_step(client, record),
            expected=samples,
            dropped=int(record.one("done")["dropped"]),
            interrupt_s=float(emulator.times()["sample"]),
            edges_hz=float(position[-1] - position[half]) / client.seconds(len(position) - half),
            bytes_s=size / seconds,
            faults=len(record.all("fault")),
        )


def positions(record: Record) -> np.ndarray:
    """The count at each sample, extended beyond 16 bits."""
    low = record.channel(Channel.POSITION).astype(np.int64)
    steps = (np.diff(low) + 2**15) % 2**16 - 2**15
    return np.concatenate([[0], np.cumsum(steps)])


def in_step(client: Client, record: Record) -> int:
    """Samples of blocks that follow each other without a gap."""
    count = 0
    for number, block in enumerate(record.blocks):
        tick = (record.start_tick + count * client.period) % 2**32
        if (block.sequence, block.first_tick) != (number % 2**16, tick):
            break
        count += len(block.samples)
    return count
