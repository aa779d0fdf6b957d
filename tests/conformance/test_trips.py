"""Trips: each limit opens the bridge within one sample, latches, and is told in order."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel, EndReason, Fault, State, Status
from tests.conformance.boards import PICOS, Board
from tests.conformance.client import U32, Client, Fields, Record

# They read each PWM period, or may: docs/porting.md has those readings trip as well.
READ_BETWEEN_SAMPLES = (*PICOS, "device")


def check_trip(client: Client, record: Record, fault: Fault) -> Fields:
    """The fault's event, after seeing that everything around it is as it must be."""
    event, done = record.one("fault"), record.one("done")
    assert event["fault"] is fault
    assert done["reason"] is EndReason.FAULT
    assert done["tick"] == event["tick"]
    last = record.blocks[-1]
    assert event["tick"] == (last.first_tick + (len(last.samples) - 1) * client.period) & U32
    names = [message.name for message in record.told]
    assert names[-1] == "done"
    assert names.index("fault") < len(names) - 2  # the samples that waited follow it
    assert isinstance(record.told[-2], SampleBlock)
    status = client.get("read_status")
    assert (status["state"], status["fault"]) == (State.FAULTED, fault)
    return event


def check_reading(
    board: Board,
    client: Client,
    record: Record,
    channel: Channel,
    is_beyond: Callable[[float], bool],
) -> None:
    """What tripped was the first reading beyond the limit: the last sample, or where the board has
    readings between samples, perhaps one since the sample before.
    """
    told, raw = record.one("fault")["value"], record.channel(channel)
    assert is_beyond(client.value(channel, told))
    assert not any(is_beyond(client.value(channel, sample)) for sample in raw[:-1])
    is_seldom = client.period > client.identity["sample_period_step_ticks"]
    if not (is_seldom and board.name in READ_BETWEEN_SAMPLES):
        assert told == raw[-1]


def supply_mv(client: Client) -> float:
    raw = client.get("read_status")["supply_voltage_raw"]
    return 1000 * client.value(Channel.SUPPLY_VOLTAGE, raw)


def test_over_current(board: Board, client: Client) -> None:
    limit = client.identity["max_current_ma"] // 25
    record = client.run(client.drive(2000), current_limit_ma=limit)
    check_trip(client, record, Fault.OVER_CURRENT)
    check_reading(board, client, record, Channel.CURRENT, lambda amps: abs(amps) * 1000 > limit)


def test_over_current_the_other_way(client: Client) -> None:
    limit = client.identity["max_current_ma"] // 25
    record = client.run(client.drive(2000, -0.4), current_limit_ma=limit)
    event = check_trip(client, record, Fault.OVER_CURRENT)
    assert client.value(Channel.CURRENT, event["value"]) < 0


def half_speed(client: Client) -> int:
    """Half of what the motor reaches at the gentle duty, counts a second."""
    position = client.run(client.drive(1500)).channel(Channel.POSITION).view("u2")
    moved = (position[-1] - position[-201]).view("i2")
    client.get("stop")
    client.rest()
    return abs(round(0.5 * int(moved) / client.seconds(200)))


@pytest.mark.parametrize("duty", [0.4, -0.4])
def test_over_speed(client: Client, duty: float) -> None:
    limit = half_speed(client)
    record = client.run(client.drive(4000, duty), speed_limit_counts_s=limit)
    event = check_trip(client, record, Fault.OVER_SPEED)
    assert abs(event["value"]) > limit
    assert event["value"] * duty > 0
    assert abs(event["value"]) < 1.2 * limit + 1000


def test_supply_low(board: Board, client: Client) -> None:
    supply = supply_mv(client)
    least = round(1.1 * supply)
    record = client.run(client.coast(2000), supply_min_mv=least, supply_max_mv=round(2 * supply))
    event = check_trip(client, record, Fault.SUPPLY_LOW)
    assert event["tick"] == record.start_tick & U32  # the very first sample shows it
    check_reading(board, client, record, Channel.SUPPLY_VOLTAGE, lambda volts: volts * 1000 < least)


def test_supply_high(board: Board, client: Client) -> None:
    supply = supply_mv(client)
    most = round(0.9 * supply)
    record = client.run(client.coast(2000), supply_min_mv=round(0.5 * supply), supply_max_mv=most)
    event = check_trip(client, record, Fault.SUPPLY_HIGH)
    assert event["tick"] == record.start_tick & U32
    check_reading(board, client, record, Channel.SUPPLY_VOLTAGE, lambda volts: volts * 1000 > most)


def test_run_time(client: Client) -> None:
    record = client.run(client.coast(4000), run_time_limit_ms=30)
    event = check_trip(client, record, Fault.RUN_TIME)
    limit = 30 * client.identity["clock_hz"] // 1000
    expected = math.ceil(limit / client.period) * client.period
    assert (event["tick"] - record.start_tick) & U32 == expected
    assert event["value"] == 30


def test_a_program_as_long_as_its_limit_completes(client: Client) -> None:
    ms = 30
    samples = ms * client.identity["clock_hz"] // 1000 // client.period
    record = client.run(client.coast(samples), run_time_limit_ms=ms)
    assert record.one("done")["reason"] is EndReason.COMPLETED


def test_host_silence(client: Client) -> None:
    record = client.run(client.coast(4000), beat=False, host_silence_ms=40)
    event = check_trip(client, record, Fault.HOST_SILENCE)
    silence = 40 * client.identity["clock_hz"] // 1000
    expected = math.ceil(silence / client.period) * client.period
    assert (event["tick"] - record.start_tick) & U32 == expected
    assert event["value"] == 40


def test_silence_counts_from_the_last_heartbeat(client: Client) -> None:
    record = client.start(client.coast(9000), host_silence_ms=150)
    for _ in range(5):
        client.wait(0.05)
        client.send("heartbeat", sequence=0)
    client.follow(record, beat=False)
    event = check_trip(client, record, Fault.HOST_SILENCE)
    elapsed = ((event["tick"] - record.start_tick) & U32) / client.identity["clock_hz"]
    assert 0.3 < elapsed < 0.45


def test_other_commands_are_no_heartbeats(client: Client) -> None:
    record = client.start(client.coast(9000), host_silence_ms=100)
    while not any(message.name == "done" for message in client.told):
        client.ask("read_status")
        client.wait(0.01)
    client.follow(record, beat=False)
    check_trip(client, record, Fault.HOST_SILENCE)


def test_a_short_run_needs_no_heartbeat(client: Client) -> None:
    record = client.run(client.coast(100), beat=False, host_silence_ms=40)
    assert record.one("done")["reason"] is EndReason.COMPLETED


def test_a_fault_is_latched_until_it_is_cleared(client: Client) -> None:
    client.run(client.coast(4000), run_time_limit_ms=5)
    for name, fields in (
        ("configure", client.settings),
        ("clear_program", {}),
        ("add_step", {"index": 0, **client.coast(1)}),
        ("start", {"config_hash": 0, "program_hash": 0}),
        ("zero", {"samples": 1}),
    ):
        assert client.ask(name, **fields).status is Status.FAULT_LATCHED
    client.get("clear_fault")
    record = client.run(client.coast(20), run_time_limit_ms=60_000)
    assert record.one("done")["reason"] is EndReason.COMPLETED


def test_the_first_fault_wins(client: Client) -> None:
    record = client.run(client.coast(4000), beat=False, run_time_limit_ms=20, host_silence_ms=10)
    check_trip(client, record, Fault.HOST_SILENCE)


def test_a_limit_passed_while_nothing_runs_is_no_fault(client: Client) -> None:
    client.configure(supply_max_mv=1, supply_min_mv=0)
    client.wait(0.05)
    assert client.state is State.CONFIGURED


@pytest.mark.needs("exact", "bridge")
@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"current_limit_ma": 120}, Fault.OVER_CURRENT),
        ({"speed_limit_counts_s": 0}, Fault.OVER_SPEED),  # half of what the motor reaches
        ({"run_time_limit_ms": 20}, Fault.RUN_TIME),
        ({"host_silence_ms": 20}, Fault.HOST_SILENCE),
    ],
)
def test_the_bridge_is_open_within_one_sample(board: Any, changes: Fields, fault: Fault) -> None:
    client = Client(board.port)
    client.bring_up()
    if fault is Fault.OVER_SPEED:
        changes = {"speed_limit_counts_s": half_speed(client)}
    record = client.start(client.drive(4000), **changes)
    sample_s = client.seconds(1)
    opened_after = 0
    while not board.is_open() or not opened_after:
        client.listen(0.9 * sample_s)
        opened_after += 1
        assert opened_after < 4000
    opened = client.port.now()
    client.follow(record, beat=False)
    event = check_trip(client, record, fault)
    assert event["fault"] is fault
    assert client.port.now() >= opened


@pytest.mark.needs("break")
@pytest.mark.parametrize("fault", [Fault.DRIVER, Fault.ENCODER_EDGES])
def test_faults_of_the_board_itself(board: Any, fault: Fault) -> None:
    client = Client(board.port)
    client.bring_up()
    board.break_(int(fault), 1)
    client.wait(0.01)
    assert client.state is State.IDLE  # nothing runs: nothing is latched
    record = client.start(client.drive(4000))
    client.wait(client.seconds(50))
    board.break_(int(fault), 123_456)
    client.wait(client.seconds(2))
    assert board.is_open()
    client.follow(record)
    event = check_trip(client, record, fault)
    assert event["value"] == 123_456


@pytest.mark.needs("driver")
def test_a_fault_of_the_driver_trips_and_is_latched(board: Any) -> None:
    client = Client(board.port)
    client.bring_up()
    board.complain(True)
    client.wait(0.01)
    board.complain(False)
    assert client.state is State.IDLE  # nothing runs: nothing is latched
    record = client.start(client.drive(4000))
    client.wait(client.seconds(45))
    assert not board.is_open()
    board.complain(True)
    client.wait(client.seconds(2))
    assert board.is_open()
    client.follow(record)
    assert check_trip(client, record, Fault.DRIVER)["value"] == 0
    board.complain(False)
    client.wait(client.seconds(20))
    assert client.fault is Fault.DRIVER
    assert client.get("clear_fault")["state"] == State.CONFIGURED
    assert client.run(client.drive(20)).one("done")["reason"] == EndReason.COMPLETED
