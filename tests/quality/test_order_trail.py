"""The trail of a shift's orders: on disk first, bounded, and handed over whole."""

from __future__ import annotations

import os
from datetime import UTC, datetime
from pathlib import Path

import pytest

from motorid.errors import DataError
from motorid.quality.history import Entry, open_history
from motorid.quality.history.names import FORGOTTEN
from motorid.quality.history.trail import ORDER
from motorid.quality.product import Product
from motorid.workflow.shift_history import ShiftHistory
from motorid.workflow.trail import ADDING, FILE, MOST_REFUSED, OrderTrail, hand_over


def handed(folder: Path) -> list[Entry]:
    found: list[Entry] = []
    hand_over(folder, found.append)
    return found


def test_what_was_ordered_is_handed_over_once(tmp_path: Path) -> None:
    trail = OrderTrail(tmp_path, "line-1")
    trail.accepted("D1", "anna", "bearing changed")
    trail.refused("D2", "controller at 10.0.0.7", "D1 is in work")
    first, second = handed(tmp_path)
    assert (first.subject, first.outcome, first.who, first.reason, first.station) == (
        "D1", "accepted", "anna", "bearing changed", "line-1",
    )  # fmt: skip
    assert (second.subject, second.outcome, second.reason) == ("D2", "refused", "D1 is in work")
    assert first.key != second.key
    assert first.at <= second.at
    assert handed(tmp_path) == []
    assert list(tmp_path.iterdir()) == []


def test_what_the_history_does_not_take_is_given_again(tmp_path: Path) -> None:
    trail = OrderTrail(tmp_path)
    trail.accepted("D1", "anna")

    def down(entry: Entry) -> None:
        raise DataError("the history cannot be used")

    with pytest.raises(DataError):
        hand_over(tmp_path, down)
    trail.accepted("D2", "anna")  # meanwhile
    assert (tmp_path / ADDING).exists()
    assert [one.subject for one in handed(tmp_path)] == ["D1", "D2"]


def test_a_flood_of_refusals_is_bounded_and_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [100.0]
    monkeypatch.setattr("motorid.workflow.trail.time.monotonic", lambda: now[0])
    trail = OrderTrail(tmp_path)
    for number in range(MOST_REFUSED + 40):
        trail.refused(f"D{number}", "controller", "no")
    now[0] += 61.0
    trail.refused("last", "controller", "no")
    found = handed(tmp_path)
    assert len(found) == MOST_REFUSED + 1
    assert found[-1].reason == "no (and 40 refusals before it that are not listed)"
    trail.refused("after it", "controller", "no")
    assert handed(tmp_path)[0].reason == "no"


def test_a_torn_line_spoils_no_other(tmp_path: Path) -> None:
    OrderTrail(tmp_path).accepted("D1", "anna")
    path = tmp_path / FILE
    path.write_bytes(path.read_bytes() + b'{"at": "2026')
    OrderTrail(tmp_path).accepted("D2", "anna")
    assert [one.subject for one in handed(tmp_path)] == ["D1", "D2"]


@pytest.mark.parametrize("line", [b"nonsense", b"[]", b"{}", b'{"at": 3}', b"\xff"])
def test_a_damaged_line_holds_up_no_other(tmp_path: Path, line: bytes) -> None:
    OrderTrail(tmp_path).accepted("D1", "anna")
    path = tmp_path / FILE
    path.write_bytes(line + b"\n" + path.read_bytes())
    assert [one.subject for one in handed(tmp_path)] == ["D1"]


def test_what_no_database_takes_is_shown_in_its_place(tmp_path: Path) -> None:
    OrderTrail(tmp_path).refused("D\x001\ud800\n", "\x1b[31m", "x" * 9999)
    (entry,) = handed(tmp_path)
    assert (entry.subject, entry.who) == ("D\\x001\\ud800\\n", "\\x1b[31m")
    assert len(entry.reason) == 400


def test_an_order_that_cannot_be_noted_is_not_accepted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trail = OrderTrail(tmp_path)
    trail.accepted("D1", "anna")

    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(DataError, match="make room"):
            trail.accepted("D2", "anna")
    trail.accepted("D3", "anna")
    assert [one.subject for one in handed(tmp_path)] == ["D1", "D3"]


@pytest.mark.slow
def test_a_shift_hands_its_trail_over_and_forgets_old_names(
    tmp_path: Path, product: Product
) -> None:
    book, shift = tmp_path / "line.db", tmp_path / "shift"
    shift.mkdir()
    with open_history(book) as history:
        history.note(Entry(ORDER, "accepted", "anna", "1", at=datetime(2020, 1, 1, tzinfo=UTC)))
    OrderTrail(shift, "line-1").refused("D2", "ben", "D1 is in work")
    assert ShiftHistory(str(book), product, {}).catch_up(shift) == ""
    assert list(shift.iterdir()) == []
    with open_history(book, create=False) as history:
        seen = {one["who"]: one["action"] for one in history.trail()}
        assert history.verify().problems == ()
    assert seen == {FORGOTTEN: ORDER, "ben": ORDER, "": "forget names"}
