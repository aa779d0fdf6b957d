"""Facts of the front end in a Pico's flash: stored, torn, obeyed and missed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motorid.cli.main import run
from motorid.rig_front_end import load_front_end
from motorid.sim.motor import find_motor
from motorid.wire.enums import Channel, FrontEndSource, ResetCause, Status
from motorid.wire.hashes import front_end_hash
from motorid.wire.spec import load
from tests.conformance.boards import ROOT, Board, opened, pico_lacks
from tests.conformance.client import Client

pytestmark = pytest.mark.slow
MOTOR = "dunkermotoren-gr42"
STORES_S = 1.5  # docs/protocol.md
NEAR = 0.02
PERIOD_S = 50e-6  # of PWM
HELD = dict(load_front_end("pico-ina240").facts)
# from the first erasure of a sector (45 ms) to the last byte
MOMENTS_S = (0.001, 0.0445, 0.046, 0.06, 0.072, 0.08)


@pytest.fixture(autouse=True)
def _needs_an_emulator() -> None:
    if lack := pico_lacks():
        pytest.skip(f"no emulated pico: {lack}")


@pytest.fixture
def board() -> Iterator[Any]:
    """A new one, whose flash is blank but for its firmware."""
    with opened("pico", motor=MOTOR, front_end="none") as board:
        yield board


def up(board: Board) -> Client:
    """A client of it."""
    client = Client(board.port)
    client.bring_up()
    return client


def write(client: Client, **facts: Any) -> Status:
    return client.await_reply(client.send("write_front_end", **facts), STORES_S).status


def start(client: Client) -> Status:
    """What it says to a program that only coasts."""
    hashes = client.load([client.coast(40)])
    return client.ask("start", **hashes).status


def hash_after_a_cut(board: Any, client: Client, moment_s: float, **facts: Any) -> int:
    """Power goes so long after the command. What the board then holds; 0: nothing stored."""
    client.send("write_front_end", **facts)
    client.wait(moment_s)
    board.reset(ResetCause.POWER_ON)
    client.bring_up()
    known = client.get("read_front_end")
    assert (known["source"] is FrontEndSource.STORED) == (known["front_end_hash"] != 0)
    return int(known["front_end_hash"])


@pytest.mark.parametrize("moment_s", MOMENTS_S)
def test_power_that_goes_while_the_first_facts_are_stored_leaves_none_or_them(
    board: Any, moment_s: float
) -> None:
    client = up(board)
    found = hash_after_a_cut(board, client, moment_s, **HELD)
    assert found in (0, front_end_hash(HELD))
    assert (start(client) is Status.OK) == (found != 0)


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


SCALES = ("scale", "offset", "filter_ns", "delay_ns")


def test_a_blank_board_scales_its_readings_as_the_file_does(board: Any) -> None:
    client = up(board)
    blank = {channel: dict(fact) for channel, fact in client.descriptors.items()}
    assert write(client, **HELD) is Status.OK
    client.bring_up()
    for channel in (Channel.CURRENT, Channel.TERMINAL_VOLTAGE, Channel.SUPPLY_VOLTAGE):
        stored = client.descriptors[channel]
        for name in SCALES:
            assert blank[channel][name] == pytest.approx(stored[name], rel=1e-6, abs=2e-4), name


def test_a_board_whose_facts_were_set_by_the_command_has_what_the_emulator_begins_with() -> None:
    """Its flash image is as the firmware would have left it."""
    with opened("pico", motor=MOTOR) as begun, opened("pico", motor=MOTOR, front_end="none") as new:
        known = up(begun).get("read_front_end")
        assert known["source"] is FrontEndSource.STORED
        setting = begun.port.board.setting  # type: ignore[attr-defined]
        assert known["current_v_a"] == pytest.approx(20 * setting.shunt_ohm, rel=1e-6)
        client, names = up(new), [field.name for field in load().commands["write_front_end"].fields]
        assert write(client, **{name: known[name] for name in names}) is Status.OK
        assert client.get("read_front_end") == known


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
        amperes = []
        for _ in range(20):  # all over a PWM period, for the current ripples
            client.wait(PERIOD_S / 20)
            amperes.append(emulator.facts()["current"])
        flows, bus = sum(amperes) / len(amperes), emulator.facts()["bus"]
        assert not client.follow(before).all("fault")
        lost = 2 * find_motor(MOTOR)[1].switch_resistance_ohm * flows
        for channel, true in (
            (Channel.CURRENT, flows),
            (Channel.TERMINAL_VOLTAGE, 0.35 * bus - lost),
            (Channel.SUPPLY_VOLTAGE, bus),
        ):
            shown = client.value(channel, float(before.channel(channel)[300]))
            assert shown == pytest.approx(true, rel=NEAR, abs=0.05), channel
        for share, trips in ((1 + NEAR, False), (1 - NEAR, True)):
            limit = round(1e3 * flows * share)
            record = client.run(client.coast(4), drive, current_limit_ma=limit)
            assert bool(record.all("fault")) == trips, share


def test_a_blank_board_refuses_a_run_and_says_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "rigs" / "emulated-pico.toml").read_text(encoding="utf-8")
    rig = tmp_path / "blank.toml"
    rig.write_text(text.replace("?motor", "?front_end=none&motor"), encoding="utf-8")
    assert run(["run", "--rig", str(rig), "-o", str(tmp_path / "out")]) == 3
    (said,) = capsys.readouterr().err.strip().splitlines()
    assert "motorid-pico has no valid facts of its front end and refuses to drive" in said
    assert "`motorid board set NAME`" in said
