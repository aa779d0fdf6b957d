"""How soon a limit opens the bridge: over currents of every phase, while the processor is busy."""

from __future__ import annotations

import random
from typing import Any

import pytest

from motorid.wire.enums import Fault
from tests.conformance.boards import emulator_lacks, opened
from tests.conformance.client import Client, Fields

pytestmark = pytest.mark.slow
BOARDS = ("uno", "mega")
MOTOR = "dunkermotoren-gr42"
OPENS_WITHIN = 960  # cycles, 60 us, from the end of the window that showed it
FULL_SPEED_HZ = 39_000.0  # of the encoder; the ceiling is 40,000
WINDOW = 4000  # ticks
RUNS = 6


class Busy:
    """Runs that trip, on a board that has more or less else to do."""

    def __init__(self, port: Any, edges_hz: float, beats: bool) -> None:
        self.emulator = port.board
        self.client = Client(port)
        self.client.bring_up()
        self.dice = random.Random(1)
        self.edges_hz, self.beats = edges_hz, beats

    def trip(self, **limits: int) -> tuple[Fault, int]:
        """One run from rest: what tripped, and cycles from its window's end to the open bridge."""
        client, dice = self.client, self.dice
        client.rest()
        self.emulator.set("extra_edges", self.edges_hz)
        duty = dice.uniform(0.4, 0.8) * dice.choice((1, -1))
        record = client.start(client.coast(dice.randint(1, 4)), client.drive(4000, duty), **limits)
        self.emulator.times()
        until = client.port.now() + 0.05
        while client.port.now() < until:
            if self.beats:  # their bytes come at any phase
                client.send("heartbeat", sequence=0)
            client.wait(dice.uniform(0.6e-3, 1e-3))
        client.follow(record)
        times = self.emulator.times()["opened"]
        self.emulator.set("extra_edges", 0.0)
        client.get("clear_fault")
        assert times["count"] == 1
        return Fault(record.one("fault")["fault"]), int(times["most"])


def ask(name: str, edges_hz: float, beats: bool, fault: Fault, period: int, **limits: Any) -> int:
    """The longest time of some runs, each of which passes the one limit."""
    if lack := emulator_lacks():
        pytest.skip(f"no emulated {name}: {lack}")
    with opened(name, motor=MOTOR) as board:
        busy = Busy(board.port, edges_hz, beats)
        busy.client.settings["sample_period_ticks"] = period
        found = []
        for _ in range(RUNS):
            changes: Fields = {key: busy.dice.randint(*span) for key, span in limits.items()}
            tripped, cycles = busy.trip(**changes)
            assert tripped is fault
            found.append(cycles)
    return max(found)


@pytest.mark.parametrize("name", BOARDS)
@pytest.mark.parametrize(("edges_hz", "beats"), [(0.0, False), (FULL_SPEED_HZ, True)])
def test_an_over_current_opens_the_bridge_within_60_us(
    name: str, edges_hz: float, beats: bool
) -> None:
    most = ask(name, edges_hz, beats, Fault.OVER_CURRENT, WINDOW, current_limit_ma=(500, 1200))
    assert most <= OPENS_WITHIN


@pytest.mark.parametrize("name", BOARDS)
def test_it_does_so_in_a_window_between_two_samples(name: str) -> None:
    """At 500 samples a second seven windows of eight are nobody's sample."""
    most = ask(name, 0.0, False, Fault.OVER_CURRENT, 8 * WINDOW, current_limit_ma=(500, 1200))
    assert most <= OPENS_WITHIN


@pytest.mark.parametrize("name", BOARDS)
def test_so_does_an_over_speed(name: str) -> None:
    most = ask(name, 0.0, False, Fault.OVER_SPEED, WINDOW, speed_limit_counts_s=(1500, 4000))
    assert most <= OPENS_WITHIN
