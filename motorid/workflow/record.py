"""A rig, as the command line adjusts it, driven through its program once or several times."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from motorid.errors import RigError, UsageError

if TYPE_CHECKING:
    from motorid.acquire.record import Progress, Say
    from motorid.acquire.tap import Watch
    from motorid.rig import Rig

CAPTURE_FILE = "capture.h5"
SIM = "sim://"
NO_BOARD = "scpi://"
LONGEST_LABEL = 60  # characters of a serial number in the name of a folder
AUTO = "auto"  # as a port: the only one that has a board


def bench(name_or_path: str, *, port: str | None = None, speed: str | None = None) -> Rig:
    """The rig of a name or a file, on another port or at another simulated pace if asked.

    Raises RigError where there is no such rig, UsageError where a real rig is given a pace.
    """
    from motorid.rig import load_rig

    return adjusted(load_rig(name_or_path), port=port, speed=speed)


def adjusted(rig: Rig, *, port: str | None = None, speed: str | None = None) -> Rig:
    """``rig`` on another port or at another simulated pace.

    Raises UsageError for a real one, LinkError where ``auto`` finds no port or several.
    """
    url = port or rig.port
    if url == AUTO:
        from motorid.acquire.ports import only_port

        url = only_port()
    if not rig.wiring.counts_per_turn and not url.startswith(NO_BOARD):
        raise RigError(f"{rig.name}: wiring.counts_per_turn is missing, which a board needs")
    return replace(rig, port=_at_speed(url, speed) if speed else url)


def bursting(rig: Rig) -> Rig:
    """``rig``, sampled in a burst as fast as the board can."""
    return replace(rig, sampling=replace(rig.sampling, mode="burst", rate_hz=math.inf))


def old_calibration(rig: Rig) -> str:
    """A sentence where the rig's calibration is older than it allows; "" where not."""
    from motorid.rig_calibration import citation, too_old

    cited = citation(rig)
    return too_old(cited, datetime.now(UTC)) if cited else ""


def _at_speed(url: str, speed: str) -> str:
    if not url.startswith(SIM):
        raise UsageError(f"--speed is for simulated rigs; {url} goes at its own pace")
    return sim_url(url, speed=speed)


def sim_url(url: str, **options: str) -> str:
    """A sim:// URL with some options in place of its own."""
    from urllib.parse import parse_qsl, urlencode, urlsplit

    own = dict(parse_qsl(urlsplit(url).query, keep_blank_values=True))
    return f"{SIM}?{urlencode({**own, **options}, safe=',:')}"


def numbered(path: Path, runs: int) -> list[Path]:
    """The files of so many runs: ``run.h5``, or ``run-1.h5``, ``run-2.h5``, ..."""
    if runs == 1:
        return [path]
    return [path.with_stem(f"{path.stem}-{run}") for run in range(1, runs + 1)]


def capture_runs(
    rig: Rig,
    path: Path,
    *,
    repeat: int = 1,
    force: bool = False,
    serial: str = "",
    note: str = "",
    progress: Progress | None = None,
    say: Say | None = None,
    watch: Watch | None = None,
) -> list[Path]:
    """Drives the rig's program ``repeat`` times; each run is a file of its own.

    ``say`` is told, before the first run, in what rig and board contradict one another.
    ``watch`` is given the samples as they come.

    Raises what ``acquire.record.capture`` raises; before anything moves where a file exists.
    """
    from motorid.acquire.record import capture_all

    return capture_all(
        rig,
        rig.program,
        numbered(path, repeat),
        force=force,
        progress=progress,
        serial=serial,
        note=note,
        say=say,
        watch=watch,
    )


def make_way(path: Path, runs: int = 1) -> list[str]:
    """Moves aside the journals of earlier runs that lie in the way; says so, a sentence for each.

    Raises UsageError while another capture writes one.
    """
    from motorid.acquire import leftover

    return [said for one in numbered(path, runs) if (said := leftover.make_way(one))]


def remarks(path: Path) -> list[str]:
    """What a person should know of a capture before using it, in sentences."""
    from motorid.acquire import record
    from motorid.capture import store

    return record.remarks(store.load(path))


def dated_folder(parent: Path, serial: str = "") -> Path:
    """A folder that does not exist yet: ``M17_2026-11-23_1405``, with -2 where that is taken.

    Of the serial number only letters, digits, dashes and underscores enter a name of a file.
    """
    label = re.sub(r"[^\w-]+", "-", serial).strip("-") or "run"
    name = f"{label[:LONGEST_LABEL]}_{datetime.now().astimezone():%Y-%m-%d_%H%M}"
    more = (f"{name}-{number}" for number in itertools.count(2))
    return next(parent / n for n in itertools.chain([name], more) if not (parent / n).exists())


def capture_into(folder: Path) -> Path:
    """The capture file of a ``motorid run`` into ``folder``, which is made if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder / CAPTURE_FILE
