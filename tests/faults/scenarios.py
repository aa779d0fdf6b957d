"""The faults of docs/faults.md: each a capture of the simulated rig, and what befalls it.

Link faults are a relay's and count from the opening of the port; the run proper lasts from about
0.9 s to 1.3 s (long: 2.4 s). Faults of board and bench are the simulator's and count from the check
pulse, about 0.5 s earlier.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from motorid.acquire.journal import journal_path
from motorid.rig import Rig
from tests.faults import lies
from tests.faults.laws import Lie
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


def nothing(path: Path) -> None:
    """Leaves it."""


def same(rig: Rig) -> Rig:
    """No change."""
    return rig


@dataclass(frozen=True)
class Scenario:
    """A row of the table. ``change`` alters the rig, ``other`` is the fault of a second board.

    ``lie`` is what the board says in place of a payload. ``prepare`` is done to the capture's path
    beforehand, ``act`` at ``host_at_s``.
    """

    what: str
    schedule: Schedule
    change: Callable[[Rig], Rig] = same
    other: str = ""
    lie: Lie | None = None
    act: Callable[[Path], None] = nothing
    prepare: Callable[[Path], None] = nothing


def limits(**values: Any) -> Callable[[Rig], Rig]:
    """A rig with other limits."""
    return lambda rig: replace(rig, limits=replace(rig.limits, **values))


def label(**values: float) -> Callable[[Rig], Rig]:
    """A rig whose nameplate says something else, and whose current limit is lower."""
    return lambda rig: replace(
        limits(current_a=1.5)(rig), nameplate=replace(rig.nameplate, **values)
    )


def plain(
    what: str, *, change: Callable[[Rig], Rig] = same, other: str = "", **more: Any
) -> Scenario:
    """A scenario that differs from a quiet capture in ``more``."""
    return Scenario(what, replace(PLAIN, **more), change, other)


def lying(what: str, lie: Lie) -> Scenario:
    """A board that says what is not so."""
    return Scenario(what, PLAIN, lie=lie)


def acting(what: str, act: Callable[[Path], None]) -> Scenario:
    """Something that befalls the files of a capture in mid-run."""
    return Scenario(what, replace(PLAIN, host="acts", host_at_s=1.0), act=act)


def prepared(what: str, prepare: Callable[[Path], None]) -> Scenario:
    """Something that stands where the capture is to go."""
    return Scenario(what, PLAIN, prepare=prepare)


def options(text: str) -> str:
    """Options of the simulated rig."""
    return f"{PLAIN.options}&{text}"


def take_the_folder(path: Path) -> None:
    """Neither journal nor capture have a place there any more."""
    shutil.rmtree(path.parent)
    path.parent.write_text("in the way")


def lead_nowhere(path: Path) -> None:
    """A link to a folder that is not there."""
    path.symlink_to(path.parent / "nowhere" / "run.h5")


def leave_a_journal(path: Path) -> None:
    """As of a run that was killed."""
    journal_path(path).write_bytes(b"motorid journal 1\n")


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
        plain("a board of protocol 1.2", options=options("minor=2")),
        plain(
            "a board of protocol 1.2 that should watch the guard",
            options=options("minor=2"),
            change=limits(inputs=("guard_closed",)),
        ),
        plain("tick counter wraps in mid-run", options=options("first_tick=4280000000")),
        plain("clock 0.1 % fast", options=options("clock_ppm=1000")),
        plain(
            "a burst that the memory does not hold",
            mode="burst",
            options=options("buffer=2000"),
        ),
    ),
    "A board that states wrong facts": (
        lying("start's reply names a tick between those of the samples", lies.start(7)),
        lying("start's reply names a tick long after the samples", lies.start(1 << 30)),
        lying("every block names a tick of its own, at random", lies.scattered()),
        lying("one block in ten names a tick between the others", lies.some_between(10)),
        lying("blocks come in pairs the wrong way round", lies.swapped()),
        lying("every block is sent twice", lies.twice()),
        lying("blocks of another channel than was asked for", lies.channels(0b1)),
        lying("blocks of a channel that nobody knows", lies.channels(0b10001011)),
        lying("the end is said before the first sample", lies.ends_at_once()),
        lying("the end is said, and no sample was sent", lies.no_blocks()),
        lying("the end is never said, and blocks go on", lies.endless()),
        lying("four billion samples are said to be dropped", lies.dropped()),
        lying("the offsets at rest are no numbers", lies.changed("zero", current_noise=math.nan)),
        lying("a channel's scale is no number", lies.changed("describe_channel", scale=math.nan)),
        lying("a channel's scale is 0", lies.changed("describe_channel", scale=0.0)),
        lying("its clock stands still", lies.changed("identify", clock_hz=0)),
        lying("it has 255 channels", lies.changed("identify", channel_count=255)),
        lying("every limit reads back as 0", lies.changed("read_config", current_limit_ma=0)),
    ),
    "Supply, bridge and motor": (
        plain("supply off", board="supply:0"),
        plain("supply too high", options=options("supply=12")),
        plain("supply off in mid-run", board="supply@0.5"),
        plain("supply sags to 3 V in mid-run", board="supply:3@0.5"),
        plain("supply limits its current to 0.3 A", options=options("supply_limit=0.3")),
        plain("guard open", board="guard_open", change=limits(inputs=("guard_closed",))),
        plain(
            "guard opens in mid-run",
            board="guard_open@0.5",
            change=limits(inputs=("guard_closed", "part_present")),
        ),
        plain("rotor jammed", board="stall"),
        plain("rotor jams in mid-run", board="stall@0.5"),
        plain("the nameplate's resistance is too high", change=label(resistance_ohm=6.0)),
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
        plain("encoder reversed after the check pulse", board="encoder_reversed@0.4"),
        plain("encoder dead", board="encoder_dead"),
        plain("encoder dead from mid-run on", board="encoder_dead@0.5"),
        plain("encoder loses 5 % of its counts", board="encoder_drop"),
        plain("encoder's edges faster than the board", options=options("edge_ceiling=20000")),
        plain("current sensor dead", board="current_dead"),
        plain("current sensor reversed", board="current_reversed"),
        plain("current sensor reversed after the check pulse", board="current_reversed@0.4"),
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
        plain("terminal closed in the check pulse", host="hang-up", host_at_s=0.45),
        plain("terminal closed in mid-run", host="hang-up", host_at_s=1.0),
        plain("terminal and shell closed in mid-run", host="hang-up twice", host_at_s=1.0),
        plain("asked to terminate in mid-run", host="terminate", host_at_s=1.0),
        plain("kill -9 in mid-run", host="kill -9", host_at_s=1.5, long=True),
        plain("power failure in mid-run", host="power failure", host_at_s=1.9, long=True),
        plain("the disk fills up in mid-run", host="full disk", long=True),
        acting("the journal is removed in mid-run", lambda path: journal_path(path).unlink()),
        acting("its folder is removed in mid-run", lambda path: shutil.rmtree(path.parent)),
        acting("a file takes the folder's place in mid-run", take_the_folder),
        prepared("the output is a link that leads nowhere", lead_nowhere),
        prepared("a folder has the output's name", lambda path: path.mkdir()),
        prepared("an earlier run left its journal", leave_a_journal),
    ),
}
