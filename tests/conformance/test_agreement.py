"""The same scripted run on two boards: every event exactly, raw samples within stated bounds.

Simulated board and core get the same bench, computed by the same plant. Without noise and with
duties that the core's bridge has exactly, they agree to the last count; a duty that follows the
supply is rounded by the core to 1/32000, which is worth a fraction of a count here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest

from motorid.wire.enums import Channel, Decay
from tests.conformance.boards import opened
from tests.conformance.client import Client, Fields, Record

# raw counts by which samples may differ: exactly equal, and where the duty is rounded
EXACT = dict.fromkeys(Channel, 0)
ROUNDED = {
    Channel.CURRENT: 1,
    Channel.TERMINAL_VOLTAGE: 1,
    Channel.SUPPLY_VOLTAGE: 1,
    Channel.POSITION: 1,
}
QUIET = {"noise": 0, "clock_ppm": 0, "seed": 11}
Script = Callable[[Client], Sequence[Fields]]
Pair = tuple[Client, Client]


@pytest.fixture
def pair() -> Iterator[Callable[..., Pair]]:
    """Opens the simulated board and the core on the same bench."""
    with ExitStack() as stack:

        def make(**options: Any) -> Pair:
            boards = [stack.enter_context(opened(name, **options)) for name in ("sim", "host")]
            clients = [Client(board.port) for board in boards]
            for client in clients:
                client.bring_up()
            return clients[0], clients[1]

        yield make


def run(client: Client, script: Script, **changes: Any) -> Record:
    client.settings |= changes
    return client.run(*script(client))


def events(record: Record) -> list[tuple[str, Fields]]:
    """Events with their ticks counted from the start: what idled before differs by board."""
    told = []
    for event in record.events:
        fields = dict(event.fields)
        fields["tick"] = (fields["tick"] - record.start_tick) & 0xFFFF_FFFF
        told.append((event.name, fields))
    return told


def layout(record: Record) -> list[tuple[int, int, int, int]]:
    """Everything about the blocks but their samples."""
    return [
        (
            block.sequence,
            (block.first_tick - record.start_tick) & 0xFFFF_FFFF,
            block.dropped,
            len(block.samples),
        )
        for block in record.blocks
    ]


def compare(boards: Pair, script: Script, bounds: dict[Channel, int], **changes: Any) -> None:
    first, second = (run(client, script, **changes) for client in boards)
    assert events(first) == events(second)
    assert layout(first) == layout(second)
    difference = first.samples.astype(int) - second.samples.astype(int)
    worst = np.abs(difference).max(axis=0)
    for channel, most in zip(first.blocks[0].channels, worst, strict=True):
        assert most <= bounds[channel], f"{channel.name} differs by {most} counts"


def all_kinds(client: Client) -> Sequence[Fields]:
    return [
        client.coast(40),
        client.drive(400, 0.5),
        client.coast(200),
        client.drive(300, -0.25),
        client.brake(200),
        client.drive(1, 1.0),
        client.coast(100),
    ]


def decays(client: Client) -> Sequence[Fields]:
    modes = (Decay.SYNCHRONOUS_SLOW, Decay.DIODE, Decay.FAST)
    return [client.drive(200, duty) | {"decay": mode} for mode in modes for duty in (0.5, -0.75)]


def volts(client: Client) -> Sequence[Fields]:
    return [client.hold(400, 3.0), client.hold(300, -1.5), client.coast(200)]


@pytest.mark.parametrize("script", [all_kinds, decays])
@pytest.mark.parametrize("motor", ["faulhaber", "maxon-amax22", "pittman"])
def test_raw_samples_agree_to_the_last_count(
    pair: Callable[..., Pair], motor: str, script: Script
) -> None:
    compare(pair(motor=motor, **QUIET), script, EXACT)


def test_volts_agree_within_the_rounding_of_the_duty(pair: Callable[..., Pair]) -> None:
    compare(pair(**QUIET), volts, ROUNDED)


@pytest.mark.parametrize("channels", [0b0001, 0b1011])
def test_fewer_channels_agree(pair: Callable[..., Pair], channels: int) -> None:
    compare(pair(**QUIET), all_kinds, EXACT, channels=channels)


def test_bursts_agree(pair: Callable[..., Pair]) -> None:
    compare(pair(**QUIET), all_kinds, EXACT, mode=1)


def test_another_rate_agrees(pair: Callable[..., Pair]) -> None:
    compare(pair(**QUIET), all_kinds, EXACT, sample_period_ticks=4000)


@pytest.mark.parametrize(
    "changes",
    [
        {"current_limit_ma": 900},
        {"speed_limit_counts_s": 45_000},
        {"speed_limit_counts_s": 77_777},
        {"run_time_limit_ms": 33},
        {"supply_max_mv": 6800},
        {"supply_min_mv": 7100},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_trips_agree_in_tick_value_and_samples(pair: Callable[..., Pair], changes: Fields) -> None:
    compare(pair(**QUIET), all_kinds, EXACT, **changes)


def test_with_noise_the_readings_agree_within_it(pair: Callable[..., Pair]) -> None:
    boards = pair(noise=1.0, clock_ppm=0, seed=11)
    bound = 12  # two readings of 1 count rms each, and rounding: beyond 8 sigma
    near = dict.fromkeys(Channel, bound) | {Channel.POSITION: 0}
    compare(boards, all_kinds, near)


def test_drawn_errors_and_a_wrong_clock_are_the_same_bench(pair: Callable[..., Pair]) -> None:
    compare(pair(noise=0, seed=5, clock_ppm=40, ripple=0.02, cogging=1e-5), all_kinds, EXACT)


def test_a_different_bench_does_not_agree(pair: Callable[..., Pair]) -> None:
    sim, _ = pair(**QUIET)
    _, host = pair(**QUIET | {"seed": 12})
    with pytest.raises(AssertionError, match="differs by"):
        compare((sim, host), all_kinds, EXACT)
