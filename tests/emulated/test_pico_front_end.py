"""Facts of the front end in a Pico's flash: stored, torn, obeyed and missed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from motorid.rig_front_end import load_front_end
from motorid.sim.motor import find_motor
from motorid.wire.enums import Channel, FrontEndSource, ResetCause, Status
from motorid.wire.hashes import front_end_hash
from tests.conformance.boards import Board, opened, pico_lacks
from tests.conformance.client import Client

pytestmark = pytest.mark.slow
MOTOR = "dunkermotoren-gr42"
STORES_S = 1.5  # docs/protocol.md
NEAR = 0.02
HELD = dict(load_front_end("pico-ina240").facts)
# from the first erasure of a sector (45 ms) to the last byte
MOMENTS_S = (0.001, 0.0445, 0.046, 0.06, 0.072, 0.08)


@pytest.fixture(autouse=True)
def _needs_an_emulator() -> None:
    if lack := pico_lacks():
        pytest.skip(f"no emulated pico: {lack}")


@pytest.fixture
def board() -> Iterator[Any]:
    """A new one, which has its firmware's facts."""
    with opened("pico", motor=MOTOR) as board:
        yield board


def up(board: Board) -> Client:
    """A client of it."""
    client = Client(board.port)
    client.bring_up()
    return client


def write(client: Client, **facts: Any) -> Status:
    return client.await_reply(client.send("write_front_end", **facts), STORES_S).status


def hash_after_a_cut(board: Any, client: Client, moment_s: float, **facts: Any) -> int:
    """Power goes so long after the command. What the board then holds; 0: nothing stored."""
    client.send("write_front_end", **facts)
    client.wait(moment_s)
    board.reset(ResetCause.POWER_ON)
    client.bring_up()
    known = client.get("read_front_end")
    assert known["source"] is not FrontEndSource.NONE
    return int(known["front_end_hash"])


@pytest.mark.parametrize("moment_s", MOMENTS_S)
def test_power_that_goes_while_the_first_facts_are_stored_leaves_none_or_them(
    board: Any, moment_s: float
) -> None:
    found = hash_after_a_cut(board, up(board), moment_s, **HELD)
    assert found in (0, front_end_hash(HELD))


def test_power_that_goes_while_others_are_stored_leaves_the_old_or_the_new(board: Any) -> None:
    client, held = up(board), dict(HELD)
    assert write(client, **held) is Status.OK
    kept = 0
    for number, moment_s in enumerate(0.0023 * n for n in range(1, 18)):
        new = HELD | {"name": f"new {number}", "current_v_a": 0.05 + 0.01 * number}
        found = hash_after_a_cut(board, client, moment_s, **new)
        assert found in (front_end_hash(held), front_end_hash(new))
        if found == front_end_hash(new):
            held = new
        else:
            kept += 1
    assert 0 < kept < 17  # both were seen


def test_facts_outlast_every_reset(board: Any) -> None:
    client = up(board)
    assert write(client, **HELD) is Status.OK
    for cause in (ResetCause.POWER_ON, ResetCause.EXTERNAL, ResetCause.WATCHDOG):
        board.reset(cause)
        client.bring_up()
        known = client.get("read_front_end")
        assert known["source"] is FrontEndSource.STORED
        assert known["front_end_hash"] == front_end_hash(HELD)


def test_the_firmwares_own_facts_are_those_of_the_file(board: Any) -> None:
    known = up(board).get("read_front_end")
    options = board.port.board.setting  # the emulator chose parts that suit its motor
    wanted = HELD | {
        "current_v_a": pytest.approx(20 * options.shunt_ohm, rel=1e-6),
        "supply_divider": options.divider,
        "voltage_divider": 2 * options.divider,
    }
    for name in ("sensor", "bridge", "reference_v", "current_v_a", "current_zero_v", "lift_v"):
        assert known[name] == wanted[name], name
    for name in ("supply_divider", "voltage_divider", "current_filter", "voltage_filter"):
        assert known[name] == wanted[name], name


def test_a_trip_follows_the_stored_facts() -> None:
    """Another sensor and other dividers are wired; the rotor is locked."""
    quiet = {"noise": 0, "gain_error": 0, "voltage_gain_error": 0, "offset_error": 0}
    with opened("pico", motor=MOTOR, **quiet) as opened_board:
        board: Any = opened_board
        emulator = board.port.board
        parts = {"reference": 3.3, "zero": 1.65, "shunt": 0.066, "divider": 10.0, "locked": 1.0}
        for part, value in parts.items():
            emulator.set(part, value)
        client = up(board)
        facts = {"reference_v": 3.3, "current_zero_v": 1.65, "current_v_a": 0.066}
        facts |= {"voltage_divider": 20.0, "supply_divider": 10.0, "max_current_ma": 20_000}
        assert write(client, **HELD | facts) is Status.OK
        client.bring_up()
        drive = client.drive(400, 0.35)
        before = client.start(client.coast(4), drive, current_limit_ma=4000)
        client.wait(0.05)
        truth = emulator.facts()
        assert not client.follow(before).all("fault")
        flows = abs(truth["current"])
        lost = 2 * find_motor(MOTOR)[1].switch_resistance_ohm * truth["current"]
        for channel, true in (
            (Channel.CURRENT, truth["current"]),
            (Channel.TERMINAL_VOLTAGE, 0.35 * truth["bus"] - lost),
            (Channel.SUPPLY_VOLTAGE, truth["bus"]),
        ):
            shown = client.value(channel, float(before.channel(channel)[300]))
            assert shown == pytest.approx(true, rel=NEAR, abs=0.05), channel
        for share, trips in ((1 + NEAR, False), (1 - NEAR, True)):
            limit = round(1e3 * flows * share)
            record = client.run(client.coast(4), drive, current_limit_ma=limit)
            assert bool(record.all("fault")) == trips, share


def test_a_board_that_has_no_facts_does_not_drive() -> None:
    with opened("pico", motor=MOTOR, defines="-DANALOG_HOLDS=false") as board:
        client = up(board)
        assert client.get("read_front_end")["source"] is FrontEndSource.NONE
        hashes = client.load([client.coast(40)])
        assert client.ask("start", **hashes).status is Status.NO_FRONT_END
        board.reset(ResetCause.POWER_ON)  # facts are stored before a configuration
        client.bring_up()
        assert write(client, **HELD) is Status.OK
        client.bring_up()
        hashes = client.load([client.coast(40)])
        assert client.ask("start", **hashes).status is Status.OK
