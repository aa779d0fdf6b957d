"""Fast bursts: sampled faster than a stream can be, guarded as one is."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from motorid.wire.enums import Channel, Fault, Mode, Status
from tests.conformance.boards import Board
from tests.conformance.client import Client, Fields, Record
from tests.conformance.conftest import brought_up

U32 = 0xFFFF_FFFF
SAME = ("channel", "unit", "scale", "offset", "gain_uncertainty", "raw_min", "raw_max")


@pytest.fixture
def fast(client: Client) -> Client:
    """A client whose settings ask for the fast burst; steps are made in watch periods."""
    return hasty(client)


def hasty(client: Client) -> Client:
    period = client.identity["burst_sample_period_ticks"]
    if not period:
        pytest.skip("no fast burst on this board")
    client.settings |= {"mode": Mode.BURST, "sample_period_ticks": period}
    return client


def watch(client: Client) -> int:
    """Ticks between looks of the guard."""
    identity = client.identity
    return math.lcm(identity["min_sample_period_ticks"], identity["burst_sample_period_ticks"])


def per_watch(client: Client) -> int:
    return watch(client) // client.period


def periods(client: Client, step: Fields, count: int) -> Fields:
    """A step that lasts so many watch periods."""
    return step | {"ticks": count * watch(client)}


def room(client: Client) -> int:
    """Watch periods that the board keeps."""
    return int(client.identity["burst_samples"]) // per_watch(client)


def check_ticks(client: Client, record: Record, samples: int) -> None:
    """Blocks in sequence, without a gap, from the first tick on; positions that agree."""
    tick, count = record.start_tick, None
    for number, block in enumerate(record.blocks):
        assert (block.sequence, block.dropped) == (number, 0)
        assert block.first_tick == tick & U32
        tick += len(block.samples) * client.period
        if Channel.POSITION in block.channels:
            low = block.samples[:, block.channels.index(Channel.POSITION)].view(np.uint16)
            assert int(low[0]) == block.position & 0xFFFF
            if count is not None:
                assert abs((block.position - count + 2**31) % 2**32 - 2**31) < 1000
            count = block.position + int(np.int16(low[-1] - low[0]))
    assert len(record.samples) == samples == record.one("done")["samples"]


def test_it_is_faster_than_any_stream(client: Client) -> None:
    period, shortest = (
        client.identity[name] for name in ("burst_sample_period_ticks", "min_sample_period_ticks")
    )
    if not period:  # a board without a fast burst, which it must say
        assert not client.identity["burst_samples"]
        return
    assert period < shortest
    assert watch(client) // period <= 255
    assert client.identity["burst_samples"] >= 2 * watch(client) // period


def test_samples_come_at_their_ticks_after_the_run(fast: Client) -> None:
    count = min(room(fast), 12)
    record = fast.run(periods(fast, fast.drive(1), count - 4), periods(fast, fast.coast(1), 4))
    names = [message.name for message in record.told]
    assert names[:3] == ["phase", "phase", "sample_block"]
    ticks = [fields["tick"] for fields in record.all("phase")]
    assert ticks == [record.start_tick, (record.start_tick + (count - 4) * watch(fast)) & U32]
    check_ticks(fast, record, count * per_watch(fast))
    assert record.one("done")["tick"] == (record.start_tick + count * watch(fast)) & U32


@pytest.mark.parametrize("channels", [0b0001, 0b1011, 0b1111])
def test_any_channels_can_be_kept(fast: Client, channels: int) -> None:
    record = fast.run(periods(fast, fast.drive(1), 9), channels=channels)
    assert all(block.samples.shape[1] == channels.bit_count() for block in record.blocks)
    check_ticks(fast, record, 9 * per_watch(fast))


def test_the_same_program_runs_twice_and_then_streams(fast: Client) -> None:
    program = periods(fast, fast.drive(1), 5)
    first, second = fast.run(program), fast.run(program)
    check_ticks(fast, first, 5 * per_watch(fast))
    check_ticks(fast, second, 5 * per_watch(fast))
    fast.settings |= {"mode": Mode.STREAM, "sample_period_ticks": watch(fast)}
    check_ticks(fast, fast.run(fast.drive(100)), 100)


def test_what_the_memory_does_not_hold_is_dropped_and_counted(fast: Client) -> None:
    most = fast.identity["burst_samples"]
    record = fast.run(periods(fast, fast.coast(1), room(fast) + 30))
    done = record.one("done")
    assert done["samples"] == len(record.samples) == most
    assert done["samples"] + done["dropped"] == (room(fast) + 30) * per_watch(fast)
    assert fast.get("read_status")["dropped"] == done["dropped"]


def test_nothing_is_sent_while_it_runs(fast: Client) -> None:
    record = fast.start(periods(fast, fast.coast(1), 300))
    fast.send("heartbeat", sequence=0)
    fast.wait(150 * watch(fast) / fast.identity["clock_hz"])
    assert {message.name for message in fast.told} == {"phase"}
    fast.follow(record)


def test_channels_are_described_for_it(fast: Client) -> None:
    for index in range(fast.identity["channel_count"]):
        streamed = fast.get("describe_channel", index=index, mode=Mode.STREAM)
        burst = fast.get("describe_channel", index=index, mode=Mode.BURST)
        assert [burst[name] for name in SAME] == [streamed[name] for name in SAME]
        assert burst["aperture_ns"] <= streamed["aperture_ns"]
    assert fast.ask("describe_channel", index=0, mode=2).status is Status.NOT_SUPPORTED
    assert fast.ask("describe_channel", index=99, mode=1).status is Status.BAD_VALUE


def test_a_host_of_minor_0_does_not_name_a_mode(client: Client) -> None:
    from motorid.wire.framing import encode

    request = client.next_request()
    told = client.exchange(encode(bytes([2]) + request.to_bytes(2, "little") + b"\x00"))
    asked = client.exchange(encode(bytes([2]) + (request + 1).to_bytes(2, "little") + b"\x00\x00"))
    assert told[0][3:] == asked[0][3:]
    assert told[0][3] == Status.OK


def test_only_that_period_and_only_in_burst_mode(fast: Client) -> None:
    assert fast.configure().status is Status.OK
    assert fast.configure(mode=Mode.STREAM).status is Status.BAD_VALUE
    for period in (fast.period - 1, fast.period + 1, 2 * fast.period - 1, 0):
        answer = fast.configure(mode=Mode.BURST, sample_period_ticks=period)
        assert answer.status is Status.BAD_VALUE, period


def test_steps_begin_where_the_guard_looks(fast: Client) -> None:
    assert fast.configure().status is Status.OK
    step = fast.coast(1) | {"index": 0}
    odd = watch(fast) + fast.period
    assert fast.ask("add_step", **step | {"ticks": odd}).status is Status.BAD_VALUE
    assert fast.ask("add_step", **step | {"ticks": watch(fast)}).status is Status.OK


def test_zero_is_measured_as_in_a_stream(fast: Client) -> None:
    assert fast.configure(mode=Mode.STREAM, sample_period_ticks=watch(fast)).status is Status.OK
    streamed = fast.get("zero", samples=64)
    hasty(fast)
    assert fast.configure().status is Status.OK
    burst = fast.get("zero", samples=64)
    for name in ("current", "voltage"):
        apart = abs(burst[f"{name}_offset"] - streamed[f"{name}_offset"])
        assert apart <= 5 * max(streamed[f"{name}_noise"], 1) / 8, name


def test_current_trips_at_the_next_look(fast: Client) -> None:
    record = fast.run(periods(fast, fast.drive(1), 40), current_limit_ma=20)
    fault = record.one("fault")
    assert fault["fault"] == Fault.OVER_CURRENT
    assert record.one("done")["tick"] == fault["tick"]
    apart = (fault["tick"] - record.start_tick) & U32
    assert apart % watch(fast) == 0
    assert len(record.samples) == min(apart // fast.period + 1, fast.identity["burst_samples"])
    assert fast.fault is Fault.OVER_CURRENT


def test_a_silent_host_trips_it(fast: Client) -> None:
    record = fast.run(periods(fast, fast.coast(1), 4000), beat=False, host_silence_ms=20)
    fault = record.one("fault")
    assert fault["fault"] == Fault.HOST_SILENCE
    late = ((fault["tick"] - record.start_tick) & U32) / fast.identity["clock_hz"] - 0.02
    assert abs(late) <= 2 * watch(fast) / fast.identity["clock_hz"]
    done = record.one("done")
    apart = (fault["tick"] - record.start_tick) & U32
    assert done["samples"] == min(apart // fast.period + 1, fast.identity["burst_samples"])
    assert done["samples"] + done["dropped"] == apart // fast.period + 1


def test_stop_ends_it(fast: Client) -> None:
    record = fast.start(periods(fast, fast.coast(1), 4000))
    fast.wait(20 * watch(fast) / fast.identity["clock_hz"])
    fast.get("stop")
    fast.follow(record)
    done = record.one("done")
    apart = (done["tick"] - record.start_tick) & U32
    assert done["samples"] + done["dropped"] == apart // fast.period + 1


@pytest.mark.slow
def test_reversed_counts_are_reversed(open_board: Callable[..., Board]) -> None:
    fast = hasty(brought_up(open_board()))
    change = []
    for other in (0, 1):
        drive = periods(fast, fast.drive(1, 0.9), min(room(fast), 200))
        record = fast.run(drive, encoder_reversed=other)
        low = record.channel(Channel.POSITION)
        change.append(int(np.int16(low[-1] - low[0])))
        fast.rest()
    assert change[0] > 0 > change[1]


def test_it_reads_what_a_stream_reads(fast: Client) -> None:
    """The mean of a burst's readings, beside that of the guard's: a steady state at full duty."""
    settle, count = 300, min(room(fast), 15)
    fast.settings |= {"mode": Mode.STREAM, "sample_period_ticks": watch(fast)}
    streamed = fast.run(fast.drive(settle, 1.0), fast.drive(count, 1.0)).samples[-count + 4 :]
    fast.rest()
    hasty(fast)
    burst = fast.run(periods(fast, fast.drive(1, 1.0), count)).samples
    supply = Channel.SUPPLY_VOLTAGE
    scale = fast.descriptors[supply]["scale"]
    apart = scale * abs(float(burst[:, supply].mean()) - float(streamed[:, supply].mean()))
    assert apart < 0.05 * fast.value(supply, float(streamed[:, supply].mean()))
