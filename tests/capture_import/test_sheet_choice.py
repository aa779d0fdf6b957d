"""Which sheet of a book is read, as its library hands the sheets over."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture import sheet_child
from motorid.errors import DataError
from motorid.limits import SHEET

Rows = list[list[Any]]


class Sheet:
    """Its first row is empty; a library that is asked to leaves it out."""

    def __init__(self, rows: Rows) -> None:
        self.rows = rows
        self.total_height, self.total_width = len(rows), max(map(len, rows), default=0)

    def to_python(self, skip_empty_area: bool = True) -> Rows:
        return [row for row in self.rows if any(row) or not skip_empty_area]


def read(
    book: dict[str, Rows], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[str, str, list[str]]:
    """Text, sheet, and the other sheets' names."""
    made = SimpleNamespace(sheet_names=list(book), get_sheet_by_name=lambda name: Sheet(book[name]))
    workbook = SimpleNamespace(from_path=lambda path: made)
    library = SimpleNamespace(CalamineWorkbook=workbook)
    monkeypatch.setitem(sys.modules, "python_calamine", library)
    target = folder / "out.npz"
    sheet_child.main("book.xlsx", str(target))
    with np.load(target) as stored:
        text = stored["text"].tobytes().decode()
        return text, stored["sheet"].tolist()[0], stored["others"].tolist()


def test_the_sheet_of_most_numbers_is_read_with_its_empty_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    book: dict[str, Rows] = {
        "notes": [["a", "b", "c"], ["d", "e", "f"]],
        "log": [["", ""], ["Ω", "i"], [0, 1.5], [1, 2.5]],
        "more": [["t"], [1], [2]],
        "as many": [[1, 2], [3, 4]],
    }
    text, sheet, others = read(book, tmp_path, monkeypatch)
    assert text == "\t\nΩ\ti\n0\t1.5\n1\t2.5\n"
    assert (sheet, others) == ("log", ["notes", "more", "as many"])


def test_a_book_without_numbers_or_sheets_is_read_as_far_as_it_goes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert read({"a": [["x"]], "b": [["y"]]}, tmp_path, monkeypatch) == ("x\n", "a", ["b"])
    assert read({}, tmp_path, monkeypatch) == ("", "", [])


def test_a_sheet_beyond_the_limits_is_refused_before_its_cells_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sheet_child, "SHEET", replace(SHEET, columns=3, numbers=8))
    assert read({"a": [[1, 2, 3]], "b": [[1, 2]] * 4}, tmp_path, monkeypatch)[1] == "b"
    for rows, size in (([[1, 2, 3, 4]], "1 rows of 4"), ([[1, 2, 3]] * 3, "3 rows of 3")):
        with pytest.raises(DataError, match=f"sheet 'b' has {size} columns"):
            read({"a": [[1]], "b": rows}, tmp_path, monkeypatch)
