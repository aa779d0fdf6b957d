"""Orders that were accepted and have no verdict yet, on disk: a station that is killed knows them.

A motor turns only for somebody who is there, so a station that starts again drives none of them by
itself: it names them, and each is ordered again.
"""

from __future__ import annotations

import threading
from pathlib import Path

from motorid import json_text
from motorid.capture.whole import write_whole
from motorid.errors import DataError
from motorid.workflow import durable_lines

FILE = "orders.jsonl"  # in a shift's folder; one line for each order accepted, one for each judged


class KeptOrders:
    """The orders of a shift's folder, for any thread. Raises DataError where they cannot be kept.

    A line that was torn by a crash, the last, is left out: nobody was told of that order.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE
        self._open: dict[str, None] = {}
        self._lock = threading.Lock()
        for line in self._lines():
            self._note(line)
        self._rewrite()

    def waiting(self) -> tuple[str, ...]:
        """Serial numbers without a verdict, oldest first."""
        return tuple(self._open)

    def accepted(self, serial: str) -> None:
        """On disk when this returns."""
        self._append({"accepted": serial})

    def done(self, serial: str) -> None:
        """Its verdict is on disk, or the order is given up."""
        if serial in self._open:
            self._append({"done": serial})

    def _append(self, line: dict[str, str]) -> None:
        with self._lock:
            durable_lines.append(self.path, line)
            self._note(line)

    def _note(self, line: dict[str, str]) -> None:
        if "accepted" in line:
            self._open[line["accepted"]] = None
        if "done" in line:
            self._open.pop(line["done"], None)

    def _lines(self) -> list[dict[str, str]]:
        """What was kept. Raises DataError where another line than the last is damaged."""
        try:
            lines = self.path.read_bytes().split(b"\n")
        except FileNotFoundError:
            return []
        except OSError as error:
            raise DataError(f"{self.path} cannot be read ({error.strerror or error})") from None
        found = []
        for number, line in enumerate(lines[:-1], 1):
            try:
                value = json_text.loads(line)
            except json_text.JsonError:
                value = None
            if not isinstance(value, dict) or not all(isinstance(v, str) for v in value.values()):
                raise DataError(
                    f"{self.path}, line {number}, is damaged: look there for orders without a "
                    "verdict, then remove the file"
                )
            found.append(value)
        return found

    def _rewrite(self) -> None:
        """The open orders alone, so that the file does not grow from shift to shift."""
        if self.path.exists():
            text = "".join(json_text.dumps({"accepted": one}) + "\n" for one in self._open)
            write_whole(self.path, text.encode(), force=True)
