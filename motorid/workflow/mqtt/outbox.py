"""Verdicts that nobody has acknowledged yet. The inspections' folders are the outbox.

A verdict is on disk before anybody sees it, so a station that is killed loses none: a folder
without MARK is sent again by the next shift. For one thread.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from motorid.workflow.check import VERDICT
from motorid.workflow.shift_folder import unsettled

MARK = "in-mqtt"  # in an inspection's folder: a consumer, or else the broker, has its verdict
MOST_OPEN = 100  # sent and not acknowledged: a broker may drop what is beyond a thousand
MOST_WAIT_S = 300.0  # between two repetitions


@dataclass
class Sent:
    """A verdict on its way: when it falls due again, and after how long it did last."""

    folder: Path
    due_s: float
    wait_s: float


class Outbox:
    """In order: the oldest first. ``repeat_s`` doubles with each repetition."""

    def __init__(self, folder: Path, repeat_s: float) -> None:
        self.folder, self.repeat_s = folder, repeat_s
        self._waiting: dict[Path, None] = {}
        self._sent: dict[str, Sent] = {}

    def __len__(self) -> int:
        return len(self._waiting) + len(self._sent)

    def find(self) -> None:
        """Takes what earlier shifts left."""
        for one in unsettled(self.folder, MARK, lambda one: (one / MARK).exists()):
            if (one / VERDICT).exists():
                self.add(one)

    def add(self, folder: Path) -> None:
        """A verdict that is on disk; what is here already, or done, stays as it is."""
        known = any(one.folder == folder for one in self._sent.values())
        if not known and not (folder / MARK).exists():
            self._waiting[folder] = None

    def next(self) -> Path | None:
        """The next verdict to send for the first time; None where enough are open."""
        if len(self._sent) >= MOST_OPEN:
            return None
        return next(iter(self._waiting), None)

    def sent(self, key: str, folder: Path, now_s: float) -> None:
        """It is on its way, for the first time or again."""
        self._waiting.pop(folder, None)
        if key not in self._sent:
            self._sent[key] = Sent(folder, now_s + self.repeat_s, self.repeat_s)

    def drop(self, folder: Path) -> None:
        """It cannot be read: it stays where it is, for a person."""
        self._waiting.pop(folder, None)

    def due(self, now_s: float) -> dict[str, Path]:
        """What is to be sent again, by key; it falls due later the next time."""
        found = {}
        for key, one in self._sent.items():
            if one.due_s <= now_s:
                one.wait_s = min(2.0 * one.wait_s, max(MOST_WAIT_S, self.repeat_s))
                one.due_s = now_s + one.wait_s
                found[key] = one.folder
        return found

    def all_due(self, now_s: float) -> None:
        """The broker is another, or has been away: it may have forgotten what it had."""
        for one in self._sent.values():
            one.due_s, one.wait_s = now_s, self.repeat_s / 2.0

    def acknowledged(self, key: str) -> None:
        """Nobody has to send it again. Raises OSError where the disk does not take the mark."""
        if (one := self._sent.get(key)) is not None:
            (one.folder / MARK).write_text(f"{key}\n", encoding="ascii")
            del self._sent[key]
