"""Every front end that comes with motorid, stored in one and the same firmware: where it trips."""

from __future__ import annotations

import pytest

from motorid.rig_front_end import load_front_end, presets
from motorid.wire.enums import Channel, Fault, Status
from tests.conformance.boards import HostBoard, emulator_lacks, opened
from tests.conformance.client import Client

# By their data sheets, and not by the files: the converter's reference, volts at its input without
# current and for each ampere, and whether they show its sign.
PARTS = {
    "acs712-05": (5.0, 2.5, 0.185, True),
    "acs712-20": (5.0, 2.5, 0.100, True),
    "acs712-30": (5.0, 2.5, 0.066, True),
    "acs724-20": (5.0, 2.5, 0.100, True),
    "bts7960": (5.0, 0.0, 1000 / 8500, False),
    "ina181-20mohm": (4.096, 2.048, 20 * 0.020, True),
    "ina240-10mohm": (4.096, 2.048, 20 * 0.010, True),
    "ina240-2mohm": (4.096, 2.048, 20 * 0.002, True),
    "motor-shield-r3": (5.0, 0.0, 1.65, False),
    "pico-3v3-ina240": (3.27, 1.635, 20 * 0.010, True),
    "pico-ina240": (3.0, 1.5, 20 * 0.010, True),
    "vnh2sp30": (5.0, 0.0, 1500 / 11370, False),
    "vnh5019": (5.0, 0.0, 0.140, False),
}
NEAR = 0.02  # of the limit: so right a trip must be
MOST_A = 50.0


def stored(board: HostBoard, name: str) -> Client:
    """A client of a board that holds that front end."""
    client = Client(board.port)
    client.bring_up()
    reply = client.await_reply(client.send("write_front_end", **load_front_end(name).facts), 1.5)
    assert reply.status is Status.OK
    client.bring_up()
    return client


def test_all_of_them_are_tried() -> None:
    assert set(presets()) == set(PARTS)
    assert len(PARTS) >= 10


@pytest.mark.parametrize("name", sorted(PARTS))
@pytest.mark.parametrize("sign", [1, -1])
def test_its_trip_point_is_right_to_2_percent(name: str, sign: int) -> None:
    reference, zero, slope, signed = PARTS[name]
    with opened("host", current_range=MOST_A, noise=0) as opened_board:
        assert isinstance(opened_board, HostBoard)
        board, client = opened_board, stored(opened_board, name)
        most = client.identity["max_current_ma"] * 1e-3
        for share in (0.3, 0.9):
            limit = round(share * most, 3)
            for over, trips in ((1 - NEAR, False), (1 + NEAR, True)):
                flows = sign * limit * over
                board.sense(zero, reference)
                record = client.start(client.coast(60), current_limit_ma=round(limit * 1e3))
                client.wait(client.seconds(20))
                board.sense(zero + slope * (flows if signed else abs(flows)), reference)
                client.follow(record)
                faults = [event["fault"] for event in record.all("fault")]
                assert faults == ([Fault.OVER_CURRENT] if trips else []), (limit, over)
                if trips:
                    client.get("clear_fault")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["acs712-20", "motor-shield-r3"])
def test_so_it_is_on_an_emulated_uno_that_drives(name: str) -> None:
    """The rotor is locked, and the emulator says what flows."""
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    reference, zero, slope, signed = PARTS[name]
    quiet = {"noise": 0, "gain_error": 0, "voltage_gain_error": 0, "offset_error": 0}
    with opened("uno", motor="dunkermotoren-gr42", **quiet) as board:
        emulator = board.port.board
        wired = {"reference": reference, "zero": zero, "shunt": slope, "lift": reference / 16}
        for part, value in (wired | {"one_sided": float(not signed), "locked": 1.0}).items():
            emulator.set(part, value)
        client = stored(board, name)  # type: ignore[arg-type]
        drive = client.drive(400, -0.35)
        before = client.start(client.coast(4), drive, current_limit_ma=2000)
        client.wait(0.08)
        flows = abs(emulator.facts()["current"])
        assert not client.follow(before).all("fault")
        shown = client.value(Channel.CURRENT, float(before.channel(Channel.CURRENT)[300]))
        assert shown == pytest.approx(flows if not signed else -flows, rel=NEAR, abs=0.02)
        for share, trips in ((1 + NEAR, False), (1 - NEAR, True)):
            limit = round(1e3 * flows * share)
            record = client.run(client.coast(4), drive, current_limit_ma=limit)
            assert bool(record.all("fault")) == trips, share
