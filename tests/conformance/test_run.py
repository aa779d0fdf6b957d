"""A run: what is sent, when, and at which ticks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.wire.codec import mask_channels
from motorid.wire.enums import Channel, EndReason, State, Status
from tests.conformance.client import ALL, LIMITS, U32, Client, Fields, Record

BLOCK = {1: 32, 2: 32, 3: 32, 4: 28}  # samples in a full block, by channels


def check_blocks(record: Record, period: int, channels: int) -> None:
    """Blocks follow each other without a gap, from the start on."""
    tick, count = record.start_tick, 0
    for number, block in enumerate(record.blocks):
        assert block.sequence == number
        assert block.first_tick == tick & U32
        assert block.channels == mask_channels(channels)
        assert block.dropped == 0
        tick += len(block.samples) * period
        count += len(block.samples)
    done = record.one("done")
    assert (done["blocks"], done["samples"], done["dropped"]) == (len(record.blocks), count, 0)


def total(steps: tuple[Fields, ...]) -> int:
    return sum(step["ticks"] for step in steps)


def test_steps_begin_and_end_exactly_on_their_ticks(client: Client) -> None:
    steps = (client.drive(50), client.coast(37), client.drive(20, -0.4), client.brake(1))
    record = client.run(*steps)
    tick = record.start_tick
    for index, (step, phase) in enumerate(zip(steps, record.all("phase"), strict=True)):
        assert phase == {"index": index, "tick": tick & U32}
        tick += step["ticks"]
    done = record.one("done")
    assert done["reason"] is EndReason.COMPLETED
    assert done["tick"] == tick & U32
    assert record.told[-1].name == "done"
    check_blocks(record, client.period, ALL)
    assert done["samples"] == total(steps) // client.period
    assert client.state is State.LOADED


@pytest.mark.parametrize("channels", [0b0001, 0b1000, 0b0011, 0b1011, 0b1111])
def test_blocks_of_every_width(client: Client, channels: int) -> None:
    record = client.run(client.drive(100), channels=channels)
    check_blocks(record, client.period, channels)
    size = BLOCK[channels.bit_count()]
    sizes = [len(block.samples) for block in record.blocks]
    assert sizes == [size] * (100 // size) + [100 % size] * (100 % size > 0)


def test_a_sample_at_the_tick_of_a_step_is_taken_before_the_step_acts(client: Client) -> None:
    current = client.run(client.drive(60)).channel(Channel.CURRENT).astype(float)
    noise = 6 * client.descriptors[Channel.CURRENT]["noise"] + 4
    rest = client.get("read_status")["current_raw"]
    assert abs(current[0] - rest) <= 2 * noise
    assert current[1:10].max() > current[0] + 2 * noise


def test_coast_shows_the_back_emf_and_no_current(client: Client) -> None:
    record = client.run(client.drive(400), client.coast(100))
    coasting = record.samples[420:]
    descriptor = client.descriptors[Channel.CURRENT]
    zero = record.channel(Channel.CURRENT)[0]
    assert np.abs(coasting[:, Channel.CURRENT].mean() - zero) < 2 * descriptor["noise"] + 2
    volts = client.value(Channel.TERMINAL_VOLTAGE, coasting[0, Channel.TERMINAL_VOLTAGE])
    supply = client.value(Channel.SUPPLY_VOLTAGE, coasting[0, Channel.SUPPLY_VOLTAGE])
    assert 0.05 * supply < volts < 0.4 * supply


def test_brake_stops_sooner_than_coast(client: Client) -> None:
    travel = []
    for end in (client.coast(300), client.brake(300)):
        position = client.run(client.drive(300), end).channel(Channel.POSITION).astype(np.int16)
        steps = np.diff(position.view(np.int16)).astype(np.int16)
        travel.append(int(steps[299:].astype(int).sum()))
        client.rest()
    assert travel[1] < 0.7 * travel[0]


def test_position_of_a_block_is_the_count_that_its_samples_follow(client: Client) -> None:
    record = client.run(client.drive(600, 0.6), channels=0b1001)
    count = record.blocks[0].position
    for block in record.blocks:
        low = block.samples[:, 1].view(np.uint16)
        assert block.position & 0xFFFF == low[0]
        assert block.position == count
        steps = np.diff(low).view(np.int16).astype(int)
        count = block.position + int(steps.sum())
        following = record.blocks.index(block) + 1
        if following < len(record.blocks):
            jump = np.uint16(record.blocks[following].position & 0xFFFF) - np.uint16(low[-1])
            count = (count + int(np.int16(jump))) & U32


@pytest.mark.parametrize("duty", [0.4, -0.4])
def test_encoder_reversed_negates_the_position(client: Client, duty: float) -> None:
    moved = []
    for reversed_ in (0, 1):
        client.rest()
        record = client.run(client.drive(300, duty), encoder_reversed=reversed_)
        position = record.channel(Channel.POSITION).view(np.uint16)
        moved.append(int(np.diff(position).view(np.int16).astype(int).sum()))
    assert moved[0] * duty > 0
    assert abs(moved[0] + moved[1]) <= 0.02 * abs(moved[0]) + 2


def test_reversing_negates_the_position_that_read_status_gives(client: Client) -> None:
    client.run(client.drive(200))
    client.rest()
    before = client.get("read_status")["position"]
    assert before != 0
    assert client.configure(encoder_reversed=1).status is Status.OK
    assert client.get("read_status")["position"] == -before & U32


def test_volts_follow_the_supply(client: Client) -> None:
    record = client.run(client.hold(400, 2.0), channels=ALL)
    volts = record.samples[50:, Channel.TERMINAL_VOLTAGE].astype(float)
    assert client.value(Channel.TERMINAL_VOLTAGE, volts.mean()) == pytest.approx(2.0, rel=0.15)


def test_a_program_can_be_run_again(client: Client) -> None:
    hashes = client.load([client.drive(40), client.coast(40)])
    records = []
    for _ in range(2):
        client.told.clear()
        records.append(client.follow(Record(client.get("start", **hashes)["start_tick"])))
    for record in records:
        check_blocks(record, client.period, ALL)
    assert records[1].start_tick != records[0].start_tick
    assert [len(r.blocks) for r in records] == [3, 3]


@pytest.mark.parametrize("wrong", ["config_hash", "program_hash"])
def test_start_refuses_another_hash(client: Client, wrong: str) -> None:
    hashes = client.load([client.drive(40)])
    reply = client.ask("start", **hashes | {wrong: hashes[wrong] ^ 1})
    assert reply.status is Status.HASH_MISMATCH
    assert client.state is State.LOADED


def test_stop_ends_a_run(client: Client) -> None:
    record = client.start(client.drive(5000))
    client.wait(client.seconds(200))
    reply = client.ask("stop")
    assert reply.status is Status.OK
    assert reply.fields["state"] == State.LOADED
    client.follow(record)
    done = record.one("done")
    assert done["reason"] is EndReason.STOPPED
    assert 0 < (done["tick"] - record.start_tick) & U32 < 5000 * client.period
    last = record.blocks[-1]
    assert done["tick"] == (last.first_tick + (len(last.samples) - 1) * client.period) & U32
    check_blocks(record, client.period, ALL)


@pytest.mark.needs("exact")
def test_stop_right_after_start(client: Client) -> None:
    hashes = client.load([client.drive(50)])
    client.told.clear()
    start, halt = client.send("start", **hashes), client.send("stop")
    record = Record(client.await_reply(start).fields["start_tick"])
    assert client.await_reply(halt).status is Status.OK
    done = client.follow(record).one("done")
    assert done["reason"] is EndReason.STOPPED
    assert done["samples"] <= 4  # a link has its rate, so a few may have been taken
    last = max(done["samples"] - 1, 0) * client.period
    assert done["tick"] == (record.start_tick + last) & U32


def test_a_slow_run_sends_blocks_of_one_age(client: Client) -> None:
    step = client.identity["sample_period_step_ticks"]
    period = client.identity["clock_hz"] // 100 // step * step  # about 10 ms
    client.settings["sample_period_ticks"] = period
    record = client.run(client.coast(24))
    check_blocks(record, client.period, ALL)
    age = LIMITS.block_age_ms * client.identity["clock_hz"] // 1000
    expected = min(28, age // period + 1)
    sizes = [len(block.samples) for block in record.blocks]
    assert sizes[:-1] == [expected] * (len(sizes) - 1)
    assert 0 < sizes[-1] <= expected


def test_phase_comes_when_its_step_begins(client: Client) -> None:
    record = client.start(client.coast(2000), client.coast(2000))
    began = client.port.now()
    times: list[float] = []
    while len(times) < 2:
        client.listen()
        client.send("heartbeat", sequence=0)
        times += [client.port.now() - began] * sum(m.name == "phase" for m in client.told)
        client.told = [m for m in client.told if m.name == "done"]
    assert times[0] < 0.1
    assert client.seconds(2000) - 0.05 < times[1] < client.seconds(2000) + 0.1
    client.get("stop")
    client.follow(record)


def test_heartbeats_are_answered(client: Client) -> None:
    assert client.ask("heartbeat", sequence=7).status is Status.OK
    record = client.start(client.coast(3000))
    for sequence in range(4):
        assert client.ask("heartbeat", sequence=sequence).status is Status.OK
    client.follow(record)


def test_the_bridge_is_open_but_for_a_run(open_board: Any, board_name: str) -> None:
    if board_name == "device":
        pytest.skip("no device: its switches are not seen")
    board = open_board()
    client = Client(board.port)
    client.bring_up()
    assert board.is_open()
    client.load([client.drive(400), client.coast(200)])
    assert board.is_open()
    record = client.start(client.drive(400), client.coast(200))
    client.wait(client.seconds(100))
    assert not board.is_open()
    client.follow(record)
    assert board.is_open()


def test_burst_keeps_its_samples_until_the_end(client: Client) -> None:
    count = min(client.identity["buffer_samples"], 64)
    record = client.run(client.drive(count), mode=1)
    names = [message.name for message in record.told]
    assert names[:2] == ["phase", "sample_block"]
    check_blocks(record, client.period, ALL)
    assert record.one("done")["samples"] == count


def test_burst_sends_nothing_while_it_runs(client: Client) -> None:
    record = client.start(client.coast(3000), mode=1)
    client.send("heartbeat", sequence=0)
    client.wait(client.seconds(2000))
    assert {message.name for message in client.told} == {"phase"}
    client.follow(record)


def test_burst_drops_what_it_cannot_keep_and_says_so(client: Client) -> None:
    room = client.identity["buffer_samples"]
    record = client.run(client.coast(room + 500), mode=1)
    done = record.one("done")
    assert done["samples"] == len(record.samples) == room
    assert done["dropped"] == 500
    assert client.get("read_status")["dropped"] == 500
    client.run(client.coast(10), mode=0)
    assert client.get("read_status")["dropped"] == 0


@pytest.mark.slow
@pytest.mark.needs("options")
def test_what_the_link_cannot_carry_is_dropped_and_counted(make_client: Any) -> None:
    client: Client = make_client(baud=300_000)
    record = client.run(client.coast(9000))
    done = record.one("done")
    assert done["dropped"] > 0
    assert done["samples"] + done["dropped"] == 9000
    assert sum(len(block.samples) for block in record.blocks) == done["samples"]
    tick = record.start_tick
    for block in record.blocks:
        tick += block.dropped * client.period
        assert block.first_tick == tick & U32
        tick += len(block.samples) * client.period
    assert [block.sequence for block in record.blocks] == list(range(done["blocks"]))


@pytest.mark.needs("options")
def test_ticks_wrap_in_mid_run(make_client: Any) -> None:
    client: Client = make_client(first_tick=2**32 - 9_000_000)
    record = client.run(client.drive(8000), client.coast(400), channels=0b1001)
    check_blocks(record, client.period, 0b1001)
    firsts = [block.first_tick for block in record.blocks]
    assert min(firsts) < 10_000_000 < 2**32 - 10_000_000 < max(firsts)
    assert record.one("done")["tick"] == (record.start_tick + 8400 * client.period) & U32
    assert record.one("done")["tick"] < record.start_tick
