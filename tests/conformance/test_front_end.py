"""Facts of the front end: told, stored, obeyed, and missed where they are damaged."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest

from motorid.wire.enums import (
    Bridge,
    Channel,
    Feature,
    FrontEndSource,
    ResetCause,
    Sensor,
    State,
    Status,
)
from motorid.wire.hashes import front_end_hash
from motorid.wire.spec import load
from tests.conformance.boards import PICOS, Board
from tests.conformance.client import Client, Fields

LACKS = "no device: it says that it lacks this feature"
NAMES = [field.name for field in load().commands["write_front_end"].fields]
STORES_S = 1.5  # docs/protocol.md: longer than other commands
ROUNDED = 0.5 / 13873  # a Pico's reading is a sum times that factor, to the next whole number
HALL = {
    "name": "acs712-20",
    "sensor": Sensor.HALL,
    "ratiometric": 1,
    "bridge": 1,
    "reference_v": 5.0,
    "current_v_a": 0.1,
    "current_zero_v": 2.5,
    "voltage_divider": 8.0,
    "supply_divider": 6.0,
    "lift_v": 0.3125,
    "max_current_ma": 2000,
    "current_filter": 100,
    "current_filter2": 40,
    "voltage_filter": 500,
    "voltage_filter2": 0,
    "current_gain_uncertainty": 900,
    "voltage_gain_uncertainty": 300,
    "current_zero_uncertainty": 150,
}


def facts_of(client: Client) -> Fields:
    """Those in force, as they can be written."""
    known = client.get("read_front_end")
    return {name: known[name] for name in NAMES}


def write(client: Client, **facts: Any) -> Status:
    reply = client.await_reply(client.send("write_front_end", **facts), STORES_S)
    if reply.status is Status.OK:
        assert reply.fields["front_end_hash"] == front_end_hash(facts)
    return reply.status


def stores(client: Client) -> None:
    if not client.has(Feature.FRONT_END):
        pytest.skip(LACKS)


def start(client: Client) -> Status:
    hashes = client.load([client.coast(40)])
    return client.ask("start", **hashes).status


@pytest.mark.needs("fresh", "own")
def test_a_new_board_tells_the_firmwares_own_and_drives(client: Client) -> None:
    stores(client)
    known = client.get("read_front_end")
    assert known["source"] == FrontEndSource.COMPILED
    assert known["front_end_hash"] == client.identity["front_end_hash"] == 0
    assert known["name"]
    assert start(client) is Status.OK


@pytest.mark.needs("fresh", "reset")
def test_stored_facts_hold_at_once_and_after_a_reset(client: Client, board: Board) -> None:
    stores(client)
    assert write(client, **HALL) is Status.OK
    for cause in (None, ResetCause.POWER_ON, ResetCause.EXTERNAL):
        if cause is not None:
            board.reset(cause)
        client.bring_up()
        known = client.get("read_front_end")
        assert known["source"] == FrontEndSource.STORED
        assert known["front_end_hash"] == client.identity["front_end_hash"] == front_end_hash(HALL)
        assert front_end_hash(facts_of(client)) == front_end_hash(HALL)  # to the bit
    assert write(client, **HALL | {"name": "another"}) is Status.OK
    assert client.get("read_front_end")["name"] == "another"


@pytest.mark.needs("fresh")
def test_descriptors_follow_the_facts(client: Client, board: Board) -> None:
    stores(client)
    before = dict(client.descriptors)
    firmwares = facts_of(client)
    assert write(client, **HALL) is Status.OK
    client.bring_up()
    current = client.descriptors[Channel.CURRENT]
    volts = client.descriptors[Channel.TERMINAL_VOLTAGE]
    supply = client.descriptors[Channel.SUPPLY_VOLTAGE]
    a_volt = {
        Channel.CURRENT: 1 / firmwares["current_v_a"],
        Channel.TERMINAL_VOLTAGE: firmwares["voltage_divider"],
        Channel.SUPPLY_VOLTAGE: firmwares["supply_divider"],
    }  # at the converter, in the channel's unit
    codes = {
        channel: firmwares["reference_v"] * unit / before[channel]["scale"]
        for channel, unit in a_volt.items()
    }  # that the reference reads as, whatever the facts
    within = ROUNDED if board.name in (*PICOS, "device") else 1e-5
    for channel, count in codes.items():
        assert count == pytest.approx(2.0 ** before[channel]["bits"], rel=within)
    count_v = 5.0 / codes[Channel.CURRENT]
    assert current["scale"] == pytest.approx(count_v / 0.1, rel=1e-5)
    assert current["offset"] == pytest.approx(codes[Channel.CURRENT] / 2, rel=1e-5)
    assert supply["scale"] == pytest.approx(5.0 / codes[Channel.SUPPLY_VOLTAGE] * 6.0, rel=1e-5)
    assert supply["offset"] == pytest.approx(0.3125 / count_v, rel=1e-5)
    assert volts["scale"] == pytest.approx(5.0 / codes[Channel.TERMINAL_VOLTAGE] * 8.0, rel=1e-5)
    for new, old, name in (
        (current, before[Channel.CURRENT], "current_gain_uncertainty"),
        (volts, before[Channel.TERMINAL_VOLTAGE], "voltage_gain_uncertainty"),
    ):
        # the board's own share, of its converter, stays
        own_squared = old["gain_uncertainty"] ** 2 - (firmwares[name] * 1e-5) ** 2
        parts_squared = new["gain_uncertainty"] ** 2 - own_squared
        assert parts_squared == pytest.approx((HALL[name] * 1e-5) ** 2, rel=1e-4)
    own = before[Channel.CURRENT]["offset_uncertainty"]
    zero = 150e-4 / count_v
    assert current["offset_uncertainty"] == pytest.approx(math.hypot(own, zero), rel=1e-3)
    assert (current["filter_ns"], current["filter2_ns"]) == (10_000, 4_000)
    assert (volts["filter_ns"], volts["filter2_ns"]) == (50_000, 0)
    for channel in (Channel.CURRENT, Channel.TERMINAL_VOLTAGE, Channel.SUPPLY_VOLTAGE):
        old, new = before[channel], client.descriptors[channel]
        assert new["delay_ns"] - new["filter_ns"] == old["delay_ns"] - old["filter_ns"]
        assert new["aperture_ns"] == old["aperture_ns"]


WRONG: dict[str, Fields] = {
    "no name": {"name": ""},
    "a name of control characters": {"name": "a\tb"},
    "a sensor nobody knows": {"sensor": 3},
    "ratiometric neither way": {"ratiometric": 2},
    "a bridge nobody knows": {"bridge": 5},
    "no reference": {"reference_v": 0.0},
    "a reference that is no number": {"reference_v": math.nan},
    "an infinite reference": {"reference_v": math.inf},
    "no gain": {"current_v_a": 0.0},
    "a gain that is no number": {"current_v_a": math.nan},
    "an infinite gain": {"current_v_a": -math.inf},
    "a zero beyond the reference": {"current_zero_v": 5.1},
    "a zero below ground": {"current_zero_v": -0.1},
    "no divider": {"voltage_divider": 0.0},
    "a negative divider": {"supply_divider": -1.0},
    "a lift near the reference": {"lift_v": 4.0},
    "a lift that is no number": {"lift_v": math.nan},
    "no current at all": {"max_current_ma": 0},
}


@pytest.mark.needs("fresh")
def test_facts_of_no_front_end_are_refused_and_change_nothing(client: Client) -> None:
    stores(client)
    before = client.get("read_front_end")
    for why, change in WRONG.items():
        assert write(client, **HALL | change) is Status.BAD_VALUE, why
        assert client.get("read_front_end") == before, why


@pytest.mark.needs("fresh")
def test_facts_lower_the_largest_limit_and_never_raise_it(client: Client) -> None:
    stores(client)
    mine, ceiling = facts_of(client), client.identity["max_current_ma"]
    for most, told in ((ceiling // 2, ceiling // 2), (0xFFFF_FFFF, None)):
        assert write(client, **mine | {"max_current_ma": most}) is Status.OK
        client.bring_up()
        found = client.identity["max_current_ma"]
        assert found == told if told else 0.98 * ceiling <= found <= 1.05 * ceiling
        refused = client.ask("configure", **client.settings | {"current_limit_ma": found + 1})
        assert refused.status is Status.BAD_VALUE
    insensitive = mine | {"current_v_a": mine["current_v_a"] * 1e-3, "max_current_ma": 0xFFFF_FFFF}
    assert write(client, **insensitive) is Status.OK
    client.bring_up()
    assert client.identity["max_current_ma"] <= 50_000


@pytest.mark.needs("fresh")
def test_a_configuration_carries_their_hash(client: Client) -> None:
    stores(client)
    assert write(client, **HALL) is Status.OK
    client.bring_up()
    for known, status in (
        (front_end_hash(HALL) ^ 1, Status.HASH_MISMATCH),
        (front_end_hash(HALL), Status.OK),
        (0, Status.OK),
    ):
        fields = client.settings | {"front_end_hash": known}
        assert client.ask("configure", **fields).status is status
    assert client.ask("write_front_end", **HALL).status is Status.BAD_STATE


@pytest.mark.needs("fresh", "bridge")
@pytest.mark.parametrize("bridge", Bridge)
def test_a_driver_drives_and_opens_as_far_as_it_can(
    client: Client, board: Board, bridge: Bridge
) -> None:
    """It may refuse facts of a driver that it does not know; one that takes them drives it."""
    stores(client)
    status = write(client, **facts_of(client) | {"bridge": bridge})
    if status is not Status.OK:
        assert status is Status.BAD_VALUE
        assert bridge not in (Bridge.MOSFET, Bridge.BIPOLAR)
        return
    client.bring_up()
    assert client.configure().status is Status.OK
    coast = client.ask("add_step", index=0, **client.coast(40)).status
    bare = bridge is Bridge.PWM_DIR_BARE
    assert coast is (Status.NOT_SUPPORTED if bare else Status.OK)
    if "options" in board.traits:  # its driver is what the facts say; tests/emulated has the pins
        record = client.run(client.brake(40), client.drive(200), client.brake(40))
        assert not record.all("fault")
        raw = record.channel(Channel.TERMINAL_VOLTAGE)
        volts = [client.value(Channel.TERMINAL_VOLTAGE, count) for count in raw]
        assert max(volts[60:230]) > 5 * max(map(abs, volts[:38]))
    client.get("stop")
    assert board.is_open()


@pytest.mark.needs("blank")
def test_a_board_without_facts_drives_once_it_has_some(
    make_client: Callable[..., Client],
) -> None:
    client = make_client(front_end="none")
    mine = HALL | {"max_current_ma": client.identity["max_current_ma"]}
    known = client.get("read_front_end")
    assert known["source"] == FrontEndSource.NONE
    assert not any(known[name] for name in NAMES)
    assert start(client) is Status.NO_FRONT_END
    assert client.state is State.LOADED
    again = make_client(front_end="none")
    assert write(again, **mine) is Status.OK
    again.bring_up()
    assert start(again) is Status.OK


@pytest.mark.needs("memory", "reset", "bridge")
def test_damaged_facts_keep_the_bridge_open(client: Client, board: Board) -> None:
    stores(client)
    assert write(client, **HALL) is Status.OK
    board.spoil()
    board.reset(ResetCause.POWER_ON)
    client.bring_up()
    assert client.get("read_front_end")["source"] == FrontEndSource.NONE
    assert client.identity["front_end_hash"] == 0
    assert start(client) is Status.NO_FRONT_END
    assert board.is_open()
    board.reset(ResetCause.POWER_ON)
    client.bring_up()
    assert write(client, **HALL) is Status.OK
    client.bring_up()
    assert start(client) is Status.OK


@pytest.mark.needs("fresh", "reset")
def test_a_reset_while_they_are_stored_leaves_the_old_or_the_new(
    client: Client, board: Board
) -> None:
    """Power goes at moments all over the time that storing takes."""
    stores(client)
    assert write(client, **HALL) is Status.OK
    held = HALL
    for number, moment_s in enumerate((0.004, 0.05, 0.12, 0.19, 0.205, 0.215, 0.23)):
        new = HALL | {"name": f"new {number}", "current_v_a": 0.05 + 0.01 * number}
        client.send("write_front_end", **new)
        client.wait(moment_s)
        board.reset(ResetCause.POWER_ON)
        client.bring_up()
        known = client.get("read_front_end")
        assert known["source"] == FrontEndSource.STORED
        assert known["front_end_hash"] in (front_end_hash(held), front_end_hash(new))
        if known["front_end_hash"] == front_end_hash(new):
            held = new
        assert front_end_hash(facts_of(client)) == front_end_hash(held)
