"""Texts of others in files and on the screen: no formula, no escape sequence, nothing lost."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import hypothesis
import pytest
from hypothesis import strategies as st

from motorid import csv_text
from motorid.quality.history import open_history
from motorid.quality.history.export import export
from motorid.quality.history.records import MeasurementRecord, ResultRecord
from motorid.report.page import page
from motorid.report.screen import Screen, render
from motorid.visible import on_one_line, visible

FORMULAS = ("=1+1", "+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "\r=1", " =1", "＝1+1")
HARMLESS = ("D000123", "-5", "+1.5e3", "a=b", "", "µ", "'quoted'", "O'Neil")
STEERING = "\x1b[2J\x9b\x07\u202egnp.exe\x00"


def read_back(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text, newline="")))


def test_formulas_are_marked_and_numbers_stay() -> None:
    cells = read_back(csv_text.table(["a"], [[f] for f in FORMULAS]))[1:]
    assert all(cell.startswith("'") for (cell,) in cells)
    cells = read_back(csv_text.table(["a"], [[text] for text in HARMLESS]))[1:]
    assert [cell[0] if cell else "" for cell in cells] == list(HARMLESS)
    assert read_back(csv_text.table(["=a"], [[-1.5, -2, None]])) == [["'=a"], ["-1.5", "-2", ""]]


@pytest.mark.slow
@hypothesis.given(st.text(st.sampled_from("'=+-@a 1\t\n")))
@hypothesis.settings(max_examples=150)
def test_a_mark_can_be_taken_away(text: str) -> None:
    assert csv_text.as_written(csv_text.cell(text)) == text or csv_text.NUMBER.fullmatch(text)


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_an_export_runs_nothing(ending: str, tmp_path: Path) -> None:
    measured = MeasurementRecord("R", "ohm", -2.5, reason="=1+1")
    path = tmp_path / f"out.{ending}"
    with open_history(tmp_path / "line.db") as history:
        history.add(ResultRecord("check", "=HYPERLINK(0)", (measured,), station="@x"))
        assert export(history, path) == 1
    if ending == "parquet":
        from pyarrow import parquet

        (row,) = parquet.read_table(path).to_pylist()
    else:
        head, cells = read_back(path.read_text(encoding="utf-8"))
        row = dict(zip(head, cells, strict=True))
    assert (row["serial"], row["station"], row["reason"]) == ("'=HYPERLINK(0)", "'@x", "'=1+1")
    assert float(row["value"]) == -2.5


def test_control_characters_are_shown() -> None:
    assert visible(STEERING) == r"\x1b[2J\x9b\x07\u202egnp.exe\x00"
    assert visible("two\nlines\r\nand a\ttab") == "two\nlines\r\nand a\ttab"
    assert visible("over\rwritten") == r"over\rwritten"
    assert on_one_line("a\nb\udcff") == r"a\nb\xff"


def test_neither_screen_nor_page_is_steered() -> None:
    shown = render(Screen("PASS", (STEERING,), STEERING, STEERING), width=200)
    assert not {"\x1b", "\x9b", "\u202e", "\x07", "\0"} & set(shown)
    html = page(STEERING, [f"<p>{STEERING}</p>"])
    assert not {"\x1b", "\x9b", "\u202e", "\x07", "\0"} & set(html)
    assert r"\x1b[2J" in html
