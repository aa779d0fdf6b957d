"""The same scripted run on two boards: every event exactly, raw samples within stated bounds.

Simulated board and core get the same bench, computed by the same plant. Without noise and with
duties that the core's bridge has exactly, they agree to the last count; a duty that follows the
supply is rounded by the core to 1/32000, which is worth a fraction of a count here.

An emulated board has its own converter and samples at other moments, so its samples are held
against what its descriptors promise: the mean over the declared window, taken from a run of the
simulated board that is sampled every PWM period.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

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
# by what an emulated board's samples may differ from what its descriptors promise: A, V, V, counts
PROMISED = {
    Channel.CURRENT: 8e-3,
    Channel.TERMINAL_VOLTAGE: 16e-3,
    Channel.SUPPLY_VOLTAGE: 12e-3,
    Channel.POSITION: 3.0,
}
# at a step's edge a mean of four conversions is not the mean of the window: a share of the step;
# a window misplaced by a fifth of its width would show
EDGE = 5  # samples from a step's beginning on
EDGE_SHARE = 0.15
IDEAL = QUIET | {"gain_error": 0, "voltage_gain_error": 0, "offset_error": 0, "heating": 0}
FINE = {"aperture": 50e-6, "delay": 0, "voltage_aperture": 50e-6, "bits": 15, "baud": 0}
FINE_TICKS = 800  # one PWM period
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


@pytest.mark.slow
@pytest.mark.parametrize("script", [all_kinds, decays])
@pytest.mark.parametrize("motor", ["faulhaber", "maxon-amax22", "pittman"])
def test_raw_samples_agree_to_the_last_count(
    pair: Callable[..., Pair], motor: str, script: Script
) -> None:
    compare(pair(motor=motor, **QUIET), script, EXACT)


@pytest.mark.slow
def test_volts_agree_within_the_rounding_of_the_duty(pair: Callable[..., Pair]) -> None:
    compare(pair(**QUIET), volts, ROUNDED)


@pytest.mark.parametrize("channels", [0b0001, 0b1011])
def test_fewer_channels_agree(pair: Callable[..., Pair], channels: int) -> None:
    compare(pair(**QUIET), all_kinds, EXACT, channels=channels)


def test_bursts_agree(pair: Callable[..., Pair]) -> None:
    compare(pair(**QUIET), all_kinds, EXACT, mode=1)


def brief(client: Client) -> Sequence[Fields]:
    """As all_kinds, so short that a fast burst of it is kept."""
    watch = client.identity["min_sample_period_ticks"]
    kinds = [client.coast(3), client.drive(120, 0.5), client.coast(31), client.drive(90, -0.25)]
    return [step | {"ticks": step["ticks"] // client.period * watch} for step in kinds]


def test_fast_bursts_agree(pair: Callable[..., Pair]) -> None:
    boards = pair(**QUIET)
    period = boards[0].identity["burst_sample_period_ticks"]
    compare(boards, brief, EXACT, mode=1, sample_period_ticks=period)


def test_fast_bursts_that_trip_agree(pair: Callable[..., Pair]) -> None:
    boards = pair(**QUIET)
    period = boards[0].identity["burst_sample_period_ticks"]
    fast = {"mode": 1, "sample_period_ticks": period, "current_limit_ma": 900}
    compare(boards, brief, EXACT, **fast)


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


# ---------------------------------------------------------------- emulated boards


def timed(client: Client, ticks: int) -> Sequence[Fields]:
    """A program of fixed duration, whatever the sample period."""

    def samples(ms: int) -> int:
        return ms * client.identity["clock_hz"] // 1000 // ticks

    client.settings["sample_period_ticks"] = ticks
    slow = {"decay": Decay.SYNCHRONOUS_SLOW}
    return [
        client.coast(samples(20)),
        client.drive(samples(100), 0.5) | slow,
        client.coast(samples(60)),
        client.drive(samples(80), -0.25) | slow,
        client.brake(samples(50)),
        client.coast(samples(10)),
    ]


def counts(record: Record) -> NDArray[np.int64]:
    """The whole encoder count at each sample, from 0."""
    steps = np.diff(record.channel(Channel.POSITION).view(np.uint16)).view(np.int16)
    return np.concatenate([[0], np.cumsum(steps.astype(int))])


def promised(client: Client, record: Record, fact: Fields, ticks: NDArray[Any]) -> NDArray[Any]:
    """What a channel so described reads at these ticks, in its own counts, by a finer record."""
    per_ns = client.identity["clock_hz"] * 1e-9
    end = ticks - fact["delay_ns"] * per_ns
    fine = np.arange(len(record.samples)) * FINE_TICKS
    channel = Channel(fact["channel"])
    if channel is Channel.POSITION:
        return np.interp(end, fine, counts(record))
    ours = client.descriptors[channel]
    value = ours["scale"] * (record.channel(channel).astype(float) - ours["offset"])
    integral = np.concatenate([[0.0], np.cumsum(value[1:]) * FINE_TICKS])
    width = fact["aperture_ns"] * per_ns
    area = np.interp(end, fine, integral) - np.interp(end - width, fine, integral)
    return area / width / fact["scale"] + fact["offset"]


@pytest.mark.parametrize("board_name", ["uno", "mega"])
def test_an_emulated_board_reads_what_its_descriptors_promise(board_name: str) -> None:
    bench = IDEAL | {"motor": "faulhaber", "counts_per_turn": 256}
    with opened(board_name, **bench) as board, opened("sim", **bench, **FINE) as simulated:
        client, reference = Client(board.port), Client(simulated.port)
        client.bring_up()
        reference.bring_up()
        ceiling = client.identity["encoder_edge_ceiling_hz"]
        fine = reference.run(*timed(reference, FINE_TICKS), speed_limit_counts_s=ceiling)
        record = client.run(*timed(client, client.period))
    assert events(record)[:-1] == events(fine)[:-1]
    assert events(record)[-1][1]["tick"] == events(fine)[-1][1]["tick"]
    ticks = np.arange(len(record.samples)) * client.period
    begun = np.array([fields["tick"] for name, fields in events(record) if name == "phase"])
    near = (ticks[:, None] >= begun) & (ticks[:, None] <= begun + EDGE * client.period)
    calm = ~near.any(axis=1)
    assert calm.sum() > 0.9 * len(calm)
    for channel, most in PROMISED.items():
        raw = counts(record) if channel is Channel.POSITION else record.channel(channel)
        ideal = promised(reference, fine, client.descriptors[channel], ticks)
        scale = client.descriptors[channel]["scale"]
        off = scale * np.abs(raw - ideal)
        off[:EDGE] = 0  # windows that begin before the finer record does
        assert off[calm].max() <= most, f"{channel.name} is off by {off[calm].max():.3g}"
        assert off[~calm].max() <= EDGE_SHARE * scale * np.ptp(ideal) + most, channel.name
