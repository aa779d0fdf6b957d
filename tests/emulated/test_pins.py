"""Safety by the emulated pins: what opens the bridge, and how soon."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from motorid.wire.enums import Fault, ResetCause, State
from tests.conformance.boards import MCUSR, emulator_lacks, opened
from tests.conformance.client import U32, Client, Fields, Record

BOARDS = ("uno", "mega")
MOTOR = "dunkermotoren-gr42"
CLOCK_HZ = 16e6
ACTS_WITHIN = 200  # cycles from a tick to the enable pin
OPENS_WITHIN = 960  # 60 us, from the end of the window that showed a fault
DEADLINES_WITHIN = 1400
TICK_AT = 3560  # cycles from a window's end to its sample's tick: firmware/ports/avr/timing.h
WATCHDOG_S = 0.3  # 250 ms nominal, by an oscillator of its own
# a storm, and cycles until the bridge is open: two windows, but at 60,000 the four edges too many
# in each window first use up what is saved for uneven ones
STORMS = ((60_000, 48_000), (200_000, 8000), (1_000_000, 8000))
WORST_SLOT = 2000  # cycles that a burst of as many edges as are allowed may take
LEVELS_AT = 3250  # cycles after a window's end at which the next duty must be known
# what minor 3 adds, with thresholds that nothing passes
EVERYTHING = {
    "voltage_limit_mv": 30_000, "inputs_required": 3, "sign_check_ms": 60_000,
    "sign_check_ma": 1500, "sign_check_mv": 8000, "sign_check_counts": 60_000,
}  # fmt: skip
SILENCE_MS = 1500  # for which a host may wait for a core
REST = 40  # samples


class Rig:
    """A board, its client, and the pins behind it."""

    def __init__(self, name: str, stack: ExitStack) -> None:
        board: Any = stack.enter_context(opened(name, motor=MOTOR))
        self.emulator = board.port.board
        self.client = Client(board.port)
        self.client.bring_up()

    @property
    def facts(self) -> dict[str, Any]:
        return dict(self.emulator.facts())

    def drive(self, **changes: int) -> Record:
        """Begin a long drive after a rest, and wait until the bridge is closed."""
        client = self.client
        record = client.start(client.coast(REST), client.drive(8000), **changes)
        until = client.port.now() + 2 * client.seconds(REST)
        while not self.facts["enabled"]:
            client.listen(100e-6)
            assert client.port.now() < until
        return record


@pytest.fixture(params=BOARDS)
def rig(request: pytest.FixtureRequest) -> Iterator[Rig]:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated {request.param}: {lack}")
    with ExitStack() as stack:
        yield Rig(request.param, stack)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"current_limit_ma": 1500}, Fault.OVER_CURRENT),
        ({"speed_limit_counts_s": 2000}, Fault.OVER_SPEED),
        ({"supply_min_mv": 60_000, "supply_max_mv": 90_000}, Fault.SUPPLY_LOW),
        ({"supply_min_mv": 0, "supply_max_mv": 20_000}, Fault.SUPPLY_HIGH),
        ({"run_time_limit_ms": 30}, Fault.RUN_TIME),
        ({"host_silence_ms": 40}, Fault.HOST_SILENCE),
    ],
)
def test_a_trip_does_not_wait_for_its_tick(rig: Rig, changes: Fields, fault: Fault) -> None:
    """The sample that shows a fault is complete 222 us before the tick that the fault tells."""
    client = rig.client
    supply = fault in (Fault.SUPPLY_LOW, Fault.SUPPLY_HIGH)
    if supply:  # shows in the first sample: the bridge never closes
        record = client.run(client.drive(8000), beat=False, **changes)
        assert rig.facts["changed"] == 0.0
    else:
        record = rig.drive(**changes)
        closed_s = rig.facts["changed"]
        rig.emulator.times()
        client.follow(record, beat=False)
        ticks = (record.one("fault")["tick"] - record.all("phase")[1]["tick"]) & U32
        waited = (rig.facts["changed"] - closed_s) * CLOCK_HZ
        deadline = fault in (Fault.RUN_TIME, Fault.HOST_SILENCE)  # these are looked at last
        most = DEADLINES_WITHIN if deadline else OPENS_WITHIN
        assert -ACTS_WITHIN <= waited - (ticks - TICK_AT) <= most
        opened = rig.emulator.times()["opened"]
        assert opened["count"] == 1
        assert opened["most"] <= most
    assert record.one("fault")["fault"] is fault
    assert not rig.facts["enabled"]


@pytest.mark.slow
@pytest.mark.parametrize(("edges_hz", "most"), STORMS)
def test_a_storm_of_edges_trips_and_starves_nobody(rig: Rig, edges_hz: int, most: int) -> None:
    record = rig.drive()
    rig.emulator.times()
    began = rig.emulator.now
    rig.emulator.set("chatter", float(edges_hz))
    rig.client.follow(record)
    assert record.one("fault")["fault"] is Fault.ENCODER_EDGES
    opened_after = (rig.facts["changed"] - began) * CLOCK_HZ
    assert 0 < opened_after <= most
    rig.client.wait(0.05)  # it goes on, and the board answers
    assert rig.client.state is State.FAULTED
    rig.emulator.set("chatter", 0.0)
    times, facts = rig.emulator.times(), rig.facts
    assert times["slot"]["most"] <= WORST_SLOT
    assert facts["resets"] == 0
    rig.client.get("clear_fault")
    again = rig.client.run(rig.client.coast(200))  # slots and PWM are in step again
    assert not again.all("fault")
    closed = rig.client.run(rig.client.drive(20), rig.client.coast(200))
    assert not closed.all("fault")
    assert rig.emulator.times()["enable"]["most"] <= ACTS_WITHIN


@pytest.mark.slow
def test_a_few_edges_too_close_together_trip_too(rig: Rig) -> None:
    """25 edges in a millisecond's fraction are no storm, but they keep slots waiting."""
    record = rig.drive()
    rig.emulator.set("chatter", 600_000.0)
    rig.client.wait(42e-6)
    rig.emulator.set("chatter", 0.0)
    rig.client.follow(record)
    assert record.one("fault")["fault"] is Fault.ENCODER_EDGES
    assert not rig.facts["enabled"]


@pytest.mark.slow
def test_a_fault_of_the_driver_cuts_the_bridge_at_once(rig: Rig) -> None:
    record = rig.drive()
    rig.client.wait(0.01)
    began = rig.emulator.now
    rig.emulator.set("complain", 1)
    rig.client.wait(20e-6)
    assert not rig.facts["enabled"]
    assert 0 < (rig.facts["changed"] - began) * CLOCK_HZ <= ACTS_WITHIN
    rig.client.wait(2e-3)  # nor does a later sample close it
    assert (rig.facts["changed"] - began) * CLOCK_HZ <= ACTS_WITHIN
    rig.client.follow(record)
    assert record.one("fault")["fault"] is Fault.DRIVER


@pytest.mark.slow
def test_a_driver_that_complains_before_the_bridge_closes_trips_when_it_does(rig: Rig) -> None:
    """A pin that the driver holds low while it is off is no fault: many share it with enable."""
    rig.emulator.set("complain", 1)
    client = rig.client
    assert not client.run(client.coast(40)).all("fault")
    record = client.run(client.coast(40), client.drive(4000))
    ticks = (record.one("fault")["tick"] - record.all("phase")[1]["tick"]) & U32
    assert record.one("fault")["fault"] is Fault.DRIVER
    assert 0 < ticks <= 2 * client.period
    assert not rig.facts["enabled"]


@pytest.mark.slow
def test_volts_are_held_while_commands_come_at_full_speed(rig: Rig) -> None:
    """What a sample takes longest for, at once: a division, heartbeats, edges, every check."""
    client = rig.client
    rig.emulator.set("extra_edges", 30_000.0)
    rig.emulator.set("inputs", 3)
    record = client.start(client.hold(2000, 9.0), client.hold(2000, 6.0), **EVERYTHING)
    until = client.port.now() + client.seconds(4100)
    rig.emulator.times()
    while client.port.now() < until:
        client.send("heartbeat", sequence=0)
        client.wait(3e-3)
    client.follow(record)
    assert not record.all("fault")
    assert rig.facts["resets"] == 0
    assert rig.emulator.times()["sample"]["most"] < LEVELS_AT


@pytest.mark.slow
@pytest.mark.parametrize("cause", [ResetCause.EXTERNAL, ResetCause.BROWN_OUT])
def test_through_a_reset_the_bridge_is_off(rig: Rig, cause: ResetCause) -> None:
    rig.drive()
    rig.emulator.set("reset", MCUSR[cause])
    assert not rig.facts["enabled"]  # all pins are inputs: the pull-down holds it
    changed = rig.facts["changed"]
    rig.client.wait(0.1)
    assert rig.facts["changed"] == changed
    assert not rig.facts["enabled"]


@pytest.mark.slow
def test_a_hang_with_interrupts_off_ends_by_the_watchdog(rig: Rig) -> None:
    rig.drive()
    rig.emulator.set("hang", 1)
    hung = rig.emulator.now
    rig.client.wait(0.05)
    assert rig.facts["enabled"]  # nothing but the watchdog can tell
    rig.client.wait(WATCHDOG_S)
    facts = rig.facts
    assert facts["resets"] == 1
    assert not facts["enabled"]
    assert facts["changed"] - hung <= WATCHDOG_S
    rig.client.bring_up()
    assert rig.client.identity["reset_cause"] == ResetCause.WATCHDOG


HOST = """
import sys
from motorid.acquire.port import open_port
from tests.conformance.client import Client
client = Client(open_port(sys.argv[1]), deadline_s=30.0)
client.bring_up()
record = client.start(client.drive(40_000, 0.3), host_silence_ms=int(sys.argv[2]))
print("drives", flush=True)
client.follow(record)
"""


def _facts(board: subprocess.Popen[str]) -> dict[str, Any]:
    assert board.stdin is not None
    assert board.stdout is not None
    board.stdin.write("\n")
    board.stdin.flush()
    found: dict[str, Any] = json.loads(board.stdout.readline())
    return found


def _until(condition: Callable[[], bool], seconds: float) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.01)
    return False


@pytest.mark.slow
def test_kill_9_of_the_host_stops_the_motor(repo_root: Path) -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    server = repo_root / "firmware" / "emulator" / "serve.py"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    command = [sys.executable, str(server), f"emu://uno?motor={MOTOR}"]
    with subprocess.Popen(command, cwd=repo_root, **pipes) as board:  # type: ignore[call-overload]
        try:
            path = next(line.strip() for line in board.stdout if line.startswith("/dev/"))
            words = [sys.executable, "-c", HOST, path, str(SILENCE_MS)]
            with subprocess.Popen(words, cwd=repo_root, **pipes) as host:  # type: ignore[call-overload]
                assert host.stdout.readline().strip() == "drives"
                assert _until(lambda: bool(_facts(board)["enabled"]), 60.0)
                time.sleep(2 * SILENCE_MS * 1e-3)
                assert _facts(board)["enabled"]  # heartbeats keep it driving
                host.kill()
            assert _until(lambda: not _facts(board)["enabled"], 60.0)
        finally:
            board.kill()
