"""Spreadsheets: the sheet that holds readings is read whole, by rows as a person counts them."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from datetime import date, datetime, time, timedelta
from pathlib import Path

import openpyxl
import pytest

from motorid.capture import sheet_child
from motorid.capture.sheet_reader import SheetSource
from motorid.capture.table import read_table
from motorid.errors import DataError
from tests.capture_import.corpus.libraries import spreadsheet
from tests.fuzz.files import changed
from tests.fuzz.sentence import check_sentence

MAPS = ["time=Zeit:ms", "current=Strom:A"]


@pytest.mark.slow
def test_a_bad_cell_is_named_by_its_row(tmp_path: Path) -> None:
    path = tmp_path / "log.xlsx"
    spreadsheet(path)
    book = openpyxl.load_workbook(path)
    book["Messung"]["C9"] = "defekt"
    book.save(path)
    with pytest.raises(DataError, match="row 9, column 'Strom' holds 'defekt'"):
        read_table(path, MAPS)
    assert len(read_table(path, MAPS, drop_bad=True)) == 599


def test_other_sheets_are_named(tmp_path: Path) -> None:
    path = tmp_path / "log.xlsx"
    spreadsheet(path)
    source = SheetSource(path)
    assert "'Messung'" in source.layout
    assert "not read: 'Notizen'" in source.layout
    with pytest.raises(Exception, match="not 'Notizen'"):
        read_table(path, ["time=Zeit:ms", "current=Moment:A"])


def test_cells_become_text_that_loses_nothing() -> None:
    moment = datetime(2026, 11, 2, 10, 41, 12, 2000)
    row = [0.1 + 0.2, 5.0, True, moment, date(2026, 11, 2), time(0, 1, 2, 500000)]
    row += [timedelta(seconds=1.5), 'a\tb "c"', ""]
    text = sheet_child.as_text([row])
    assert text == ("0.3\t5\t1\t2026-11-02T10:41:12.002000\t2026-11-02\t62.5\t1.5\ta b 'c'\t\n")


def test_without_its_package_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "python_calamine", None)
    with pytest.raises(DataError, match=r"pip install 'motorid\[xlsx\]'"):
        sheet_child.main(str(tmp_path / "log.xlsx"), str(tmp_path / "out.npz"))


@pytest.mark.parametrize(("rows", "columns"), [(10**6, 10), (10, 1000)])
def test_a_sheet_beyond_the_limits_is_refused(rows: int, columns: int) -> None:
    with pytest.raises(DataError, match="save a part of it"):
        sheet_child.refuse_shape("Log", rows, columns)


def damaged(path: Path, read: Callable[[Path], object], files: int = 25) -> None:
    """Changed bytes give a table, or one sentence."""
    whole, rng = path.read_bytes(), random.Random(1)
    for _ in range(files):
        data = changed(whole, rng)
        path.write_bytes(data)
        try:
            read(path)
        except DataError as error:
            check_sentence(str(error), len(data), begins=str(path))


@pytest.mark.slow
def test_damage_costs_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "log.xlsx"
    spreadsheet(path)
    damaged(path, SheetSource)
    path.write_bytes(b"PK\x03\x04" + bytes(300))
    with pytest.raises(DataError, match="is it damaged"):
        SheetSource(path)
