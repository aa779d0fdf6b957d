"""The faults of docs/faults.md: each a capture of the simulated rig, and what befalls it.

Link faults are a relay's and count from the opening of the port; the run proper lasts from about
0.9 s to 1.3 s (long: 2.4 s). Faults of board and bench are the simulator's and count from the check
pulse, about 0.5 s earlier.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from motorid.rig import Rig
from tests.faults.schedule import Schedule

PLAIN = Schedule(
    seed=1,
    long=False,
    link="",
    board="",
    host="runs",
    host_at_s=0.0,
    options="seed=1&speed=max",
    rate_hz=10_000,
    channels=3,
    mode="stream",
    host_silence_s=0.5,
)


def same(rig: Rig) -> Rig:
    """No change."""
    return rig


@dataclass(frozen=True)
class Scenario:
    """A row of the table. ``change`` alters the rig, ``other`` is the fault of a second board."""

    what: str
    schedule: Schedule
    change: Callable[[Rig], Rig] = same
    other: str = ""


def limits(**values: float) -> Callable[[Rig], Rig]:
    """A rig with other limits."""
    return lambda rig: replace(rig, limits=replace(rig.limits, **values))


def lies(**values: float) -> Callable[[Rig], Rig]:
    """A rig whose nameplate says something else, and whose current limit is lower."""
    return lambda rig: replace(
        limits(current_a=1.5)(rig), nameplate=replace(rig.nameplate, **values)
    )


def plain(
    what: str, *, change: Callable[[Rig], Rig] = same, other: str = "", **more: Any
) -> Scenario:
    """A scenario that differs from a quiet capture in ``more``."""
    return Scenario(what, replace(PLAIN, **more), change, other)


def options(text: str) -> str:
    """Options of the simulated rig."""
    return f"{PLAIN.options}&{text}"


SCENARIOS: dict[str, tuple[Scenario, ...]] = {
    "The link": (
        plain("one byte in 2,000 has a bit flipped", link="flip:5e-4"),
        plain("one byte in 2,000 is lost", link="drop:5e-4"),
        plain("one byte in 2,000 is doubled", link="double:5e-4"),
        plain("a foreign byte before one in 2,000", link="insert:5e-4"),
        plain("one byte in 50 has a bit flipped", link="flip:0.02"),
        plain("reads return a few bytes at a time", link="split"),
        plain("bytes arrive in lumps, every 50 ms", link="burst:0.05"),
        plain("every byte is 30 ms late", link="delay:0.03"),
        plain("every byte is 0.4 s late", link="delay:0.4"),
        plain("0.2 s of silence in mid-run", link="silence@0.95..1.15"),
        plain("the host hears nothing for 0.2 s", link="mute@0.95..1.15"),
        plain("the board hears nothing for 0.2 s", link="deaf@0.95..1.15"),
        plain("silence from mid-run on", link="silence@1.0", long=True),
        plain("the host hears nothing from mid-run on", link="mute@1.0", long=True),
        plain("the board hears nothing from mid-run on", link="deaf@1.0", long=True),
        plain("cable pulled while setting up", link="unplug@0.1"),
        plain("cable pulled in mid-run", link="unplug@1.0", long=True),
        plain("nothing at the port", board="silence"),
        plain("the line to the board is cut", board="deaf"),
        plain("another device, which prints text", board="text"),
        plain("another device, or another baud rate", board="garbage"),
        plain("a board of another protocol major", board="major:2"),
        plain("another board plugged in, in mid-run", link="swap@1.0", long=True),
        plain("another device plugged in, in mid-run", link="swap@1.0", long=True, other="text"),
        plain("a line too slow for the rate", options=options("baud=250000&buffer=256")),
    ),
    "The board": (
        plain("reset in the check pulse", board="reset@0.05"),
        plain("reset while the program is loaded", board="reset@0.2"),
        plain("reset in mid-run", board="reset@0.5"),
        plain("reset in mid-run, its greeting lost", board="reset@0.5,mute@0.499..0.505"),
        plain("firmware hangs in mid-run", board="watchdog@0.5"),
        plain("supply dips for 50 ms and the board resets", board="brownout@0.5"),
        plain("tick counter wraps in mid-run", options=options("first_tick=4280000000")),
        plain("clock 0.1 % fast", options=options("clock_ppm=1000")),
        plain(
            "a burst that the memory does not hold",
            mode="burst",
            options=options("buffer=2000"),
        ),
    ),
    "Supply, bridge and motor": (
        plain("supply off", board="supply:0"),
        plain("supply too high", options=options("supply=12")),
        plain("supply off in mid-run", board="supply@0.5"),
        plain("supply sags to 3 V in mid-run", board="supply:3@0.5"),
        plain("supply limits its current to 0.3 A", options=options("supply_limit=0.3")),
        plain("rotor jammed", board="stall"),
        plain("rotor jams in mid-run", board="stall@0.5"),
        plain("the nameplate's resistance is too high", change=lies(resistance_ohm=6.0)),
        plain(
            "faster than the speed limit",
            change=lambda rig: replace(
                limits(speed_rad_s=300)(rig),
                nameplate=replace(rig.nameplate, torque_constant_nm_a=None),
            ),
        ),
        plain("program longer than the run time", change=limits(run_time_s=0.3)),
    ),
    "Sensors": (
        plain("encoder reversed", board="encoder_reversed"),
        plain("encoder dead", board="encoder_dead"),
        plain("encoder dead from mid-run on", board="encoder_dead@0.5"),
        plain("encoder loses 5 % of its counts", board="encoder_drop"),
        plain("encoder's edges faster than the board", options=options("edge_ceiling=20000")),
        plain("current sensor dead", board="current_dead"),
        plain("current sensor reversed", board="current_reversed"),
        plain("current sensor at an end of its range", board="current_saturated"),
        plain("the same, from mid-run on", board="current_saturated@0.5"),
        plain("sense wires of the voltage off", board="voltage_dead"),
        plain("converter repeats its last readings", board="adc_stuck"),
        plain("the converter, from mid-run on", board="adc_stuck@0.5"),
    ),
    "The host": (
        plain("Ctrl-C while setting up", host="ctrl-c", host_at_s=0.2),
        plain("Ctrl-C in the check pulse", host="ctrl-c", host_at_s=0.45),
        plain("Ctrl-C in mid-run", host="ctrl-c", host_at_s=1.0),
        plain("Ctrl-C twice", host="ctrl-c twice", host_at_s=1.0),
        plain("kill -9 in mid-run", host="kill -9", host_at_s=1.5, long=True),
        plain("power failure in mid-run", host="power failure", host_at_s=1.9, long=True),
        plain("the disk fills up in mid-run", host="full disk", long=True),
    ),
}
