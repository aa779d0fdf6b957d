"""A shift's history in a thread of its own: a database that hangs costs the line nothing.

Each verdict is on disk before it comes here. What the history does not take keeps no mark in its
folder, so nothing is lost where the queue is full, the database silent or the station killed.
"""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from motorid.errors import MotoridError

MOST_WAITING = 1000  # verdicts; further ones wait in their folders alone
ANSWERS_S = 0.1  # for the history to say what it knows of a motor: the line waits no longer
LAST_WORDS_S = 10.0  # for what waits at the end of a shift
Tell = Callable[[str], None]


class Book(Protocol):
    """Where verdicts go: ``ShiftHistory``."""

    def take(self, folder: Path) -> str:
        """Adds one inspection; what went wrong, in a sentence, or nothing."""

    def catch_up(self, folder: Path) -> str:
        """Adds what is missing; a sentence of it, or nothing. Raises DataError."""

    def judged(self, serial: str) -> list[Mapping[str, Any]]:
        """What it holds of a motor. Raises DataError."""

    def story(self, serial: str) -> Mapping[str, Any]:
        """Results and trail of a motor. Raises DataError."""


class HistoryWorker:
    """Adds what ``take`` is given to ``shift``, in order. ``tell`` hears what a person should know.

    ``folder`` holds the shift's inspections; what an earlier one left out is added first, and what
    this one had to leave out as soon as the history answers again. ``tell`` is called from the
    worker's thread.
    """

    def __init__(self, shift: Book, folder: Path, tell: Tell, most: int = MOST_WAITING) -> None:
        self.shift, self.folder, self.tell = shift, folder, tell
        self.patience_s = ANSWERS_S
        self.trouble = ""  # why the latest verdict is not in the history; "" when it is
        self._jobs: queue.Queue[Path | None] = queue.Queue(most)
        self._behind = True  # whether folders may hold what the history lacks
        self._unfinished = 0
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._work, name="history", daemon=True)
        self._asking = threading.Thread()  # none yet

    def start(self) -> None:
        """Begins with what earlier shifts left out."""
        self._thread.start()

    def take(self, folder: Path | None) -> None:
        """An inspection whose records are on disk; never waits."""
        if folder is None:
            return
        with self._lock:
            self._unfinished += 1
        try:
            self._jobs.put_nowait(folder)
        except queue.Full:
            self._behind = True
            with self._lock:
                self._unfinished -= 1

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

    def waiting(self) -> int:
        """Verdicts that were given and are not in the history yet, the one in work among them."""
        return self._unfinished

    def close(self, patience_s: float = LAST_WORDS_S) -> str:
        """Ends once what waits is added; what is left to the next shift, in a sentence."""
        with contextlib.suppress(queue.Full):
            self._jobs.put(None, timeout=patience_s)
            self._thread.join(patience_s)
        left = self.waiting()
        if not left:
            return ""
        return f"{left} verdicts are not in the history yet: the next shift adds them"

    def _work(self) -> None:
        self._catch_up()
        while (folder := self._jobs.get()) is not None:
            self.trouble = self.shift.take(folder)
            with self._lock:
                self._unfinished -= 1
            if self.trouble:
                self._behind = True
                self.tell(self.trouble)
            elif self._behind:
                self._catch_up()

    def _catch_up(self) -> None:
        try:
            said = self.shift.catch_up(self.folder)
        except (MotoridError, OSError) as error:
            said = self.trouble = f"earlier verdicts are not in the history yet ({error})"
        else:
            self._behind = False
        if said:
            self.tell(said)
