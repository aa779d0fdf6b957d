"""The trail of a shift's orders, on disk until the history has it: who ordered what, and refusals.

A line is on disk before its order is answered. Refusals are bounded: who floods a station fills
no disk, and the trail says how many were left out.
"""

from __future__ import annotations

import math
import secrets
import threading
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from motorid import json_text
from motorid.errors import DataError
from motorid.visible import on_one_line
from motorid.workflow import durable_lines

if TYPE_CHECKING:
    from motorid.quality.history import Entry

FILE = "trail.jsonl"  # in a shift's folder
ADDING = "trail-adding.jsonl"  # the same, while the history takes it
MOST_REFUSED = 60  # refusals that are kept in a
MINUTE_S = 60.0
LONGEST = 200  # characters of what an order says
_TURN = threading.Lock()  # to write a folder's trail, or to take it away


class OrderTrail:
    """Notes of a shift's orders; for any thread."""

    def __init__(self, folder: Path, station: str = "") -> None:
        self.path, self.station = folder / FILE, station
        self._since_s, self._kept, self._left_out = -math.inf, 0, 0
        self._end_torn()

    def _end_torn(self) -> None:
        """Ends a line that a crash tore: nobody was told of it, and the next one stands apart."""
        try:
            with self.path.open("rb+") as file:
                held = file.read()
                if held and not held.endswith(b"\n"):
                    file.write(b"\n")
        except FileNotFoundError:
            return
        except OSError as error:
            raise DataError(f"{self.path} cannot be read ({error.strerror or error})") from None

    def accepted(self, serial: str, who: str, reason: str = "") -> None:
        """On disk when this returns. Raises DataError where it cannot be."""
        with _TURN:
            durable_lines.append(self.path, self._line("accepted", serial, who, reason))

    def refused(self, serial: str, who: str, why: str) -> None:
        """As ``accepted``, of some a minute; how many more there were is said with the next."""
        with _TURN:
            now = time.monotonic()
            if now - self._since_s > MINUTE_S:
                self._since_s, self._kept = now, 0
            if self._kept >= MOST_REFUSED:
                self._left_out += 1
                return
            self._kept += 1
            if self._left_out:
                why += f" (and {self._left_out} refusals before it that are not listed)"
                self._left_out = 0
            durable_lines.append(self.path, self._line("refused", serial, who, why))

    def _line(self, outcome: str, serial: str, who: str, reason: str) -> dict[str, str]:
        return {
            "at": datetime.now(UTC).isoformat(),
            "station": self.station,
            "outcome": outcome,
            "serial": _kept(serial, LONGEST),
            "who": _kept(who, LONGEST),
            "reason": _kept(reason, 2 * LONGEST),
            "key": secrets.token_hex(16),
        }


def _kept(text: str, longest: int) -> str:
    """What every database takes: no control characters, no half of a pair, and so long."""
    return on_one_line(text)[:longest]


def hand_over(folder: Path, add: Callable[[Entry], object]) -> int:
    """Gives ``add`` what a shift's folder holds of the trail, and removes it there; how many.

    What is interrupted is given again. Raises what ``add`` does, and OSError.
    """
    found = 0
    adding = folder / ADDING
    while adding.exists() or _take_away(folder / FILE, adding):
        for line in adding.read_bytes().split(b"\n")[:-1]:  # what was torn, nobody was told of
            if (entry := _entry(line)) is not None:
                add(entry)
                found += 1
        adding.unlink()
    return found


def _take_away(path: Path, to: Path) -> bool:
    with _TURN:
        if path.exists():
            path.replace(to)
            return True
        return False


def _entry(line: bytes) -> Entry | None:
    """None for a line that is damaged: it cannot hold up the others."""
    from motorid.quality.history import Entry
    from motorid.quality.history.trail import ORDER

    try:
        said = {name: str(value) for name, value in json_text.loads(line).items()}
        return Entry(
            ORDER, said["outcome"], said["who"], said["key"], said["serial"], said["reason"],
            said["station"], datetime.fromisoformat(said["at"]).astimezone(UTC),
        )  # fmt: skip
    except (json_text.JsonError, AttributeError, LookupError, ValueError):
        return None
