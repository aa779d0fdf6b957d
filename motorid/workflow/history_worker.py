"""A shift's history in a thread of its own: a database that hangs costs the line nothing."""

from __future__ import annotations

import queue
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Protocol

from motorid.errors import MotoridError
from motorid.workflow import behind
from motorid.workflow.behind import Behind, Tell

ANSWERS_S = 0.1  # for the history to say what it knows of a motor: the line waits no longer


class Book(behind.Book, Protocol):
    """Where verdicts go: ``ShiftHistory``."""

    def judged(self, serial: str) -> list[Mapping[str, Any]]:
        """What it holds of a motor. Raises DataError."""

    def story(self, serial: str) -> Mapping[str, Any]:
        """Results and trail of a motor. Raises DataError."""


class HistoryWorker(Behind):
    """Adds verdicts to a history, and asks it what it knows of a motor."""

    what, where, does = "verdicts", "in the history", "adds"

    def __init__(self, shift: Book, folder: Path, tell: Tell, *rest: int) -> None:
        super().__init__(shift, folder, tell, *rest)
        self.shift = shift
        self.patience_s = ANSWERS_S
        self._asking = threading.Thread()  # none yet

    def judged(
        self, serial: str, patience_s: float | None = None
    ) -> list[Mapping[str, Any]] | None:
        """What the history holds of a motor; None where it does not answer in time, or cannot.

        ``patience_s``: as a rule the worker's own.
        """
        if self._asking.is_alive():
            return None  # by the last one
        found: queue.Queue[list[Mapping[str, Any]] | None] = queue.Queue(1)

        def ask() -> None:
            try:
                found.put(self.shift.judged(serial))
            except (MotoridError, OSError):
                found.put(None)

        self._asking = threading.Thread(target=ask, name="history asked", daemon=True)
        self._asking.start()
        try:
            return found.get(timeout=self.patience_s if patience_s is None else patience_s)
        except queue.Empty:
            return None
