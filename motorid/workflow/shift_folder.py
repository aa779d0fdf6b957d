"""The inspections in a station's folder, of which there may be a year's.

Each is a folder of its own, named after the motor and the local time. What an inspection needs once
(a verdict, a place in the history, an upload) is asked of its files until it is done, and then
stands by name in a list beside them. The lists only save looks at the disk: one that is deleted is
made anew.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Iterator
from datetime import datetime, timedelta
from pathlib import Path
from urllib.parse import quote, unquote

LIST = ".settled-"  # a list's name begins
STAMP = "%Y%m%dT%H%M%S"
STAMPED = re.compile(r"_(\d{8}T\d{6})(-\d+)?$")
NEWEST = "9"
CHANGE = timedelta(hours=2)  # of a local time: an hour may come twice
STEP = 64  # inspections that are ordered by their files at a time


def name_of(serial: str, begin: datetime) -> str:
    """Of the folder of an inspection that begins then."""
    return f"{quote(serial, safe='')}_{begin.strftime(STAMP)}"


def serial_of(inspection: Path) -> str:
    """The motor that an inspection's folder is named after."""
    return unquote(inspection.name.rpartition("_")[0])


def newest_first(folder: Path, serial: str | None = None) -> Iterator[Path]:
    """Every inspection, or each of one motor. Few are looked at before the first comes."""
    names = _names(folder)
    if serial is not None:
        begins = f"{quote(serial, safe='')}_"
        names = [n for n in names if n.startswith(begins) and serial_of(Path(n)) == serial]
    names.sort(key=_began, reverse=True)
    while names:
        edge = _before(_began(names[min(STEP, len(names)) - 1]))
        count = next((k for k, name in enumerate(names) if _began(name) < edge), len(names))
        some, names = names[:count], names[count:]
        yield from sorted((folder / name for name in some), key=_written, reverse=True)


def unsettled(folder: Path, what: str, settled: Callable[[Path], bool]) -> list[Path]:
    """Inspections, by name, that are not ``settled``. One that is, is not asked again.

    ``what`` names the list of these.
    """
    path = folder / f"{LIST}{what}"
    done = set(_listed(path))
    left: list[str] = []
    more: list[str] = []
    for name in sorted(name for name in _names(folder) if name not in done):
        (more if settled(folder / name) else left).append(name)
    if more:
        with contextlib.suppress(OSError), path.open("a", encoding="utf-8") as file:
            file.write("".join(f"{name}\n" for name in more))  # else they are asked again
    return [folder / name for name in left]


def _names(folder: Path) -> list[str]:
    try:
        with os.scandir(folder) as found:
            return [one.name for one in found if one.is_dir() and not one.name.startswith(LIST)]
    except (FileNotFoundError, NotADirectoryError):
        return []


def _listed(path: Path) -> list[str]:
    """A line that was cut off is no name, or the name of what is settled."""
    try:
        return path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []


def _began(name: str) -> str:
    """As the folder's name says; one that does not counts as the newest."""
    found = STAMPED.search(name)
    return found.group(1) if found else NEWEST


def _before(stamp: str) -> str:
    try:
        return (datetime.strptime(stamp, STAMP) - CHANGE).strftime(STAMP)
    except (ValueError, OverflowError):
        return stamp


def _written(inspection: Path) -> tuple[float, str]:
    times = [0.0]
    for name in ("verdict.json", "capture.h5", ""):
        with contextlib.suppress(OSError):
            times.append((inspection / name).stat().st_mtime)
            break
    return times[-1], inspection.name
