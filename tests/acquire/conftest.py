"""Journals that outlive their captures."""

from __future__ import annotations

import pytest

from motorid.acquire import leftover


@pytest.fixture
def keep_journal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Journals stay after their capture is saved, and recovery need not wait to see them rest."""
    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    monkeypatch.setattr("motorid.acquire.journal_writer.JournalWriter.discard", lambda self: None)
