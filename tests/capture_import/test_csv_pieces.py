"""A table that is parsed piece by piece is as one that is parsed at once."""

from __future__ import annotations

import re
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture import csv_numbers, csv_reader
from motorid.capture.columns import BadCell
from motorid.capture.csv_marks import Ambiguous, Marks
from motorid.capture.csv_numbers import MarkedError, NotPlainError, Parser
from motorid.capture.csv_reader import CsvSource
from motorid.errors import DataError

NAN = float("nan")


@pytest.fixture(params=[1, 2, 1000])
def piece(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """Lines that are parsed at a time."""
    monkeypatch.setattr(csv_numbers, "PIECE", request.param)
    return int(request.param)


def parser(width: int, marks: Marks | None = None, separator: str = ",", **how: Any) -> Parser:
    return Parser(separator, marks or Marks("."), width, **how)


def test_plain_columns_by_their_place(piece: int) -> None:
    found = parser(3).plain(StringIO("1,x,2\n3,y,4\n5,z,6\n"), {"b": 2, "a": 0}, 9)
    assert found.rows == 3
    assert {n: v.tolist() for n, v in found.values.items()} == {"b": [2, 4, 6], "a": [1, 3, 5]}
    assert found.bad == ()
    commas = parser(2, Marks(","), ";").plain(StringIO("1,5;2\n2,5;3\n"), {"a": 0}, 2)
    assert commas.values["a"].tolist() == [1.5, 2.5]
    blanks = parser(2, separator=" ").plain(StringIO("1   2\n 3 4\n"), {"a": 1}, 2)
    assert blanks.values["a"].tolist() == [2.0, 4.0]


@pytest.mark.parametrize(
    "text", ["1,2\nx,3\n", "1,2\n,3\n", "1,2\ninf,3\n", "1,2\n3\n", "1,2\nnan,3\n"]
)
def test_a_cell_that_is_no_number_is_not_plain(text: str, piece: int) -> None:
    read = parser(2)
    with pytest.raises(NotPlainError):
        read.plain(StringIO(text), {"a": 0, "b": 1}, 9)


def test_nothing_is_no_rows(piece: int) -> None:
    for read in (parser(2).plain, parser(2).careful):
        found = read(StringIO(""), {"a": 0}, 9)
        assert (found.rows, found.values["a"].tolist(), found.bad) == (0, [], ())


def test_the_first_bad_cell_of_each_column_is_named_by_its_row(piece: int) -> None:
    text = "1,2,x\n2,,y\n" + "z" * 50 + ",odd,1\n4,5,6\nmore,7,8\n"
    found = parser(3).careful(StringIO(text), {"a": 0, "b": 1}, 9)
    assert found.rows == 5
    assert found.values["a"] == pytest.approx(np.array([1, 2, NAN, 4, NAN]), nan_ok=True)
    assert found.values["b"] == pytest.approx(np.array([2, NAN, NAN, 5, 7]), nan_ok=True)
    assert {cell.column: cell for cell in found.bad} == {
        "a": BadCell(2, "a", "z" * 40), "b": BadCell(1, "b", ""),
    }  # fmt: skip


def test_a_number_by_other_marks_is_asked_about_where_it_stands(piece: int) -> None:
    with pytest.raises(MarkedError, match="for a decimal mark") as caught:
        parser(2).careful(StringIO('1,2\nx,3\n4,5\n"1,5",6\n'), {"b": 1, "a": 0}, 9)
    assert caught.value.cell == BadCell(3, "a", "1,5")
    assert "has ',' for a decimal mark, where others have '.'" in caught.value.question


def test_groups_of_thousands_are_read_with_care_alone(piece: int) -> None:
    read, text = parser(2, Marks(",", "."), ";"), "1.234,5;1\n12;2\nx;3\n"
    with pytest.raises(NotPlainError):
        read.plain(StringIO(text), {"a": 0}, 9)
    found = read.careful(StringIO(text), {"a": 0}, 9)
    assert found.values["a"] == pytest.approx(np.array([1234.5, 12.0, NAN]), nan_ok=True)


def test_moments_count_from_the_first_of_their_column(piece: int) -> None:
    day = "2026-01-01 00:00:0"
    text = f"x,{day}1\n{day}3,{day}2\n{day}4.5,x\n{day}2,{day}9\n"
    found = parser(2, moments={0, 1}).careful(StringIO(text), {"a": 0, "b": 1}, 9)
    assert found.values["a"] == pytest.approx(np.array([NAN, 0.0, 1.5, -1.0]), nan_ok=True)
    assert found.values["b"] == pytest.approx(np.array([0.0, 1.0, NAN, 8.0]), nan_ok=True)
    with pytest.raises(NotPlainError):
        parser(2, moments={1}).plain(StringIO("1,2\n"), {"b": 1}, 9)
    assert parser(2, moments={1}).plain(StringIO("1,2\n"), {"a": 0}, 9).rows == 1


def test_what_a_mark_means_is_looked_for_in_all_pieces(piece: int) -> None:
    seen = parser(2).ambiguous(StringIO("x,12\nx,\nx,12.003\nx,13\n"), {"v": 1})
    assert seen.first == BadCell(2, "v", "12.003")
    assert (seen.beside, seen.clear) == ("12", False)
    assert "holds '12.003' and '12': say whether '.' groups thousands" in seen.question


def test_extremes_are_those_of_all_pieces() -> None:
    near, far = ["12", "12.003"] * 3, ["30.003", "12"]
    for pieces, asks in (([near, near], False), ([near, far], True), ([far, near], True)):
        seen = Ambiguous("v", ".")
        for number, cells in enumerate(pieces):
            seen.look(cells, 10 * number)
        assert bool(seen.question) is asks
        assert seen.first is not None
        assert seen.first.row == (0 if pieces[0] is far else 1)


def test_a_wide_table_is_parsed_in_fewer_lines_at_a_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(csv_numbers, "CELLS", 250)
    rows = np.arange(700).reshape(7, 100)
    (tmp_path / "a.csv").write_text("\n".join(",".join(map(str, row)) for row in rows))
    found = CsvSource(tmp_path / "a.csv").read(["column1", "column100"])
    assert found.values["column1"].tolist() == rows[:, 0].tolist()
    assert found.values["column100"].tolist() == rows[:, 99].tolist()
    monkeypatch.setattr(csv_numbers, "CELLS", 50)  # not even a line
    assert CsvSource(tmp_path / "a.csv").read(["column2"]).rows == 7


# -- headers and settings
def source(folder: Path, text: str, **how: Any) -> CsvSource:
    (folder / "a.csv").write_text(text)
    return CsvSource(folder / "a.csv", **how)


def test_a_header_of_one_line_is_of_names_even_if_they_are_units(tmp_path: Path) -> None:
    one = source(tmp_path, "s,A\n0,1\n1,2\n")
    assert list(one.names) == ["s", "A", "column1", "column2"]
    assert one.header_units == {}
    two = source(tmp_path, "t,i\ns,A\n0,1\n1,2\n")
    assert (two.header_units["t"], two.header_units["i"]) == ("s", "A")
    assert [(d.name, d.unit) for d in two.described] == [("t", "s"), ("i", "A")]


def test_constants_are_read_as_one_number_each(tmp_path: Path) -> None:
    one = source(tmp_path, "Gain,2.5,\nt,v,w\n0,1,2\n1,2,3\n")
    found = one.read(["Gain", "w"])
    assert (found.values["Gain"].tolist(), found.values["w"].tolist()) == ([2.5], [2.0, 3.0])
    assert found.rows == 2


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("t,v\n0,1.009\n1,12\n", r"line 2, column 'v' holds '1\.009' and '12': say whether"),
        ('t,v\n0,1\n1,"1,5"\n', r"line 3, column 'v' holds '1,5', which has ',' for a decimal"),
        ("t,v\n0,1\n1,2,3\n", r"line 3 has 3 cells where the first data line has 2"),
    ],
)
def test_a_cell_that_must_be_asked_about_is_named(text: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=says):
        source(tmp_path, text).read(["t", "v"])


@pytest.mark.parametrize("told", [{"decimal": "."}, {"thousands": ","}])
def test_a_mark_that_was_told_is_not_asked_about(told: dict[str, str], tmp_path: Path) -> None:
    text = "t;v\n0;1.009\n1;12\n"
    assert source(tmp_path, text, **told).read(["v"]).values["v"].tolist() == [1.009, 12.0]


def test_a_table_beyond_the_limits_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for limits, said in (({"columns": 2}, "3 columns"), ({"rows": 3}, "4 rows")):
        most = next(iter(limits.values()))
        text = "a,b,c\n" + "1,2,3\n" * 4
        monkeypatch.setattr(csv_reader, "CSV", replace(csv_reader.CSV, **limits))
        with pytest.raises(DataError, match=rf"has {said}; a table may have {most}: import"):
            source(tmp_path, text)
        more = dict.fromkeys(limits, most + 1)
        monkeypatch.setattr(csv_reader, "CSV", replace(csv_reader.CSV, **more))
        assert source(tmp_path, text).rows == 4
        monkeypatch.undo()


def test_an_error_of_the_parser_is_one_line(tmp_path: Path) -> None:
    found = source(tmp_path, "a,b\n1,2\n")._ragged("odd\nand more")
    assert re.search(r"a\.csv is not a table: odd$", str(found))


def test_a_line_wider_than_the_table_names_no_columns(tmp_path: Path) -> None:
    found = source(tmp_path, "a,b,c,d\nx,y,\n0,1\n1,2\n")  # a comma more may end a line
    assert list(found.names) == ["x", "y", "column1", "column2"]
    assert found.header_lines == 2


def test_a_header_that_is_a_comment_names_columns_without_its_mark(tmp_path: Path) -> None:
    found = source(tmp_path, "# t,#v\n0,1\n1,2\n")
    assert list(found.names) == ["t", "#v", "column1", "column2"]


@pytest.mark.parametrize(
    ("cell", "decimal", "number"),
    [("1,5", ",", True), ("1,5", ".", False), ("1.5", ".", True), ("1.5", ",", True),
     (" -.5e3 ", ".", True), (",5", ",", True), ("e3", ".", False), ("1x", ".", False)],
)  # fmt: skip
def test_a_cell_is_a_number_by_its_mark(cell: str, decimal: str, number: bool) -> None:
    assert csv_reader._is_number(cell, decimal) is number
