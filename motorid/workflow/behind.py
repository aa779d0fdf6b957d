"""Work behind a shift's cycle, in a thread of its own: what hangs costs the line nothing.

Each verdict is on disk before it comes here. What is not taken keeps no mark in its folder, so
nothing is lost where the queue is full, the other side silent or the station killed.
"""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from motorid.errors import MotoridError

MOST_WAITING = 1000  # inspections; further ones wait in their folders alone
AGAIN_S = 60.0  # between attempts at what was left out, while nothing else is to be done
LAST_WORDS_S = 10.0  # for what waits at the end of a shift
Tell = Callable[[str], None]


class Book(Protocol):
    """Where inspections go: ``ShiftHistory``, ``Uploads``."""

    def take(self, folder: Path) -> str:
        """Adds one inspection; what went wrong, in a sentence, or nothing."""

    def catch_up(self, folder: Path) -> str:
        """Adds what is missing; a sentence of it, or nothing. Raises DataError."""


class Behind:
    """Gives ``book`` what ``take`` is given, in order. ``tell`` hears what a person should know.

    ``folder`` holds the shift's inspections; what an earlier one left out is added first, and what
    this one had to leave out as soon as the other side answers again. ``tell`` is called from this
    thread.
    """

    what, where, does = "inspections", "there", "keeps"  # words of sentences

    def __init__(
        self,
        book: Book,
        folder: Path,
        tell: Tell,
        most: int = MOST_WAITING,
        again_s: float = AGAIN_S,
    ) -> None:
        self._book, self.folder, self.tell, self._again_s = book, folder, tell, again_s
        self.trouble = ""  # why the latest inspection was not taken; "" when it was
        self._jobs: queue.Queue[Path | None] = queue.Queue(most)
        self._behind = True  # whether folders may hold what was not taken
        self._unfinished = 0
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._work, name=self.where, daemon=True)

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

    def waiting(self) -> int:
        """Inspections that were given and are not taken yet, the one in work among them."""
        return self._unfinished

    def close(self, patience_s: float = LAST_WORDS_S) -> str:
        """Ends once what waits is taken; what is left to the next shift, in a sentence."""
        with contextlib.suppress(queue.Full):
            self._jobs.put(None, timeout=patience_s)
            self._thread.join(patience_s)
        left = self.waiting()
        if not left:
            return ""
        return f"{left} {self.what} are not {self.where} yet: the next shift {self.does} them"

    def _work(self) -> None:
        self._catch_up()
        while True:
            try:
                folder = self._jobs.get(timeout=self._again_s if self._behind else None)
            except queue.Empty:
                self._catch_up()
                continue
            if folder is None:
                return
            self._take(folder)

    def _take(self, folder: Path) -> None:
        self.trouble = self._book.take(folder)
        if self.trouble:
            self._behind = True
            self.tell(self.trouble)
        with self._lock:
            self._unfinished -= 1
        if self._behind and not self.trouble:
            self._catch_up()

    def _catch_up(self) -> None:
        before = self.trouble
        try:
            said = self._book.catch_up(self.folder)
        except (MotoridError, OSError) as error:
            said = self.trouble = f"earlier {self.what} are not {self.where} yet ({error})"
        else:
            self._behind, self.trouble = False, ""
        if said and said != before:
            self.tell(said)
