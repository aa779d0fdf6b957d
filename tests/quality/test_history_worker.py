"""A history that hangs, fails or falls behind holds no line up, and loses nothing."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from motorid.errors import DataError
from motorid.workflow.history_worker import HistoryWorker

PATIENCE_S = 60.0  # for a thread of this process to come to its turn


class Book:
    """A history whose database does as it is told, and what it was given."""

    def __init__(self) -> None:
        self.open, self.asked = threading.Event(), threading.Event()
        self.added: list[str] = []
        self.wrong = ""
        self.caught_up = 0

    def take(self, folder: Path) -> str:
        self.asked.set()
        assert self.open.wait(PATIENCE_S)
        if not self.wrong:
            self.added.append(folder.name)
        return self.wrong

    def catch_up(self, folder: Path) -> str:
        self.caught_up += 1
        if self.wrong:
            raise DataError(self.wrong)
        return ""

    def judged(self, serial: str) -> list[Mapping[str, Any]]:
        if self.wrong:
            raise DataError(self.wrong)
        assert self.open.wait(PATIENCE_S)
        return [{"outcome": "FAIL", "time": "2026-01-01", "station": f"of {serial}"}]


@pytest.fixture
def book() -> Iterator[Book]:
    found = Book()
    yield found
    found.open.set()  # so that no thread outlives its test


def begun(book: Book, tmp_path: Path, most: int = 1000) -> tuple[HistoryWorker, list[str]]:
    told: list[str] = []
    worker = HistoryWorker(book, tmp_path, told.append, most)
    worker.start()
    return worker, told


def test_a_silent_database_holds_nobody_up(book: Book, tmp_path: Path) -> None:
    """All of a shift's verdicts are taken while the first of them is still being added."""
    worker, _ = begun(book, tmp_path)
    for number in range(5):
        worker.take(tmp_path / f"D{number}")
    assert book.asked.wait(PATIENCE_S)
    assert worker.waiting() == 5
    assert "5 verdicts are not in the history yet" in worker.close(patience_s=0.01)
    book.open.set()


def test_what_waits_is_added_in_order_at_the_end(book: Book, tmp_path: Path) -> None:
    worker, told = begun(book, tmp_path)
    for number in range(5):
        worker.take(tmp_path / f"D{number}")
    book.open.set()
    assert worker.close(PATIENCE_S) == ""
    assert book.added == [f"D{number}" for number in range(5)]
    assert told == []


def test_trouble_is_told_and_made_up_for_once_it_is_over(book: Book, tmp_path: Path) -> None:
    book.open.set()
    book.wrong = "D0 is not in the history yet (no such host)"
    worker, told = begun(book, tmp_path)
    worker.take(tmp_path / "D0")
    while worker.waiting():
        threading.Event().wait(0.001)
    assert told[-1] == worker.trouble == "D0 is not in the history yet (no such host)"
    before = book.caught_up
    book.wrong = ""
    worker.take(tmp_path / "D1")
    assert worker.close(PATIENCE_S) == ""
    assert book.caught_up == before + 1
    assert worker.trouble == ""


def test_a_full_queue_leaves_verdicts_to_their_folders(book: Book, tmp_path: Path) -> None:
    worker, _ = begun(book, tmp_path, most=2)
    worker.take(tmp_path / "D0")
    assert book.asked.wait(PATIENCE_S)  # it is in work, and the queue is empty
    for number in range(1, 9):
        worker.take(tmp_path / f"D{number}")
    assert worker.waiting() == 3
    before = book.caught_up
    book.open.set()
    assert worker.close(PATIENCE_S) == ""
    assert book.added == ["D0", "D1", "D2"]
    assert book.caught_up > before  # which adds the others: they have no mark


def test_a_history_that_hangs_is_asked_for_no_longer_than_the_line_waits(
    book: Book, tmp_path: Path
) -> None:
    worker = HistoryWorker(book, tmp_path, lambda said: None)
    assert worker.judged("D1", patience_s=0.01) is None
    assert worker.judged("D1", patience_s=PATIENCE_S) is None  # the first still waits: at once
    book.open.set()
    worker._asking.join(PATIENCE_S)
    (known,) = worker.judged("D2", patience_s=PATIENCE_S) or []
    assert known["station"] == "of D2"
    book.wrong = "no such table"
    assert worker.judged("D3", patience_s=PATIENCE_S) is None
