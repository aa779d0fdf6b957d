"""Lines of text tables: what is a number, a header, a separator; by lines of a few cells."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture import csv_reader, csv_text
from motorid.capture.array_source import ArraySource
from motorid.capture.columns import BadCell
from motorid.capture.csv_marks import Ambiguous, Marks, looks_marked, may_be_groups
from motorid.capture.csv_reader import CsvSource
from motorid.capture.csv_text import head, measure
from motorid.capture.record_reader import RecordSource, _past_midnight
from motorid.errors import DataError, UsageError

NAN = float("nan")


def table(folder: Path, text: str | bytes, **how: Any) -> CsvSource:
    path = folder / "log.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return CsvSource(path, **how)


# -- the text
@pytest.mark.parametrize(
    ("data", "encoding", "lines", "characters"),
    [
        (b"a\n1\n", "utf-8-sig", 2, 3),
        (b"a\r\n1\r\n\r\n  \n", "utf-8-sig", 2, 3),
        (b"\n\na\n\n1", "utf-8-sig", 5, 6),
        (b"\xef\xbb\xbf" + "µ\n1".encode(), "utf-8-sig", 2, 3),
        (b"\xb5\n1", "latin-1", 2, 3),
        ("a\n1".encode("utf-16"), "utf-16", 2, 3),
        ("a\n1".encode("utf-16-be"), "utf-16", 2, 3),
    ],
)
@pytest.mark.parametrize("block", [1000, 2])
def test_a_text_s_size_is_up_to_its_last_mark(
    data: bytes, encoding: str, lines: int, characters: int, block: int, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(csv_text, "BLOCK", block)
    path = tmp_path / "a"
    path.write_bytes(b"\xfe\xff" + data if data[:1] == b"\0" else data)
    found = measure(path)
    assert (found.encoding, found.lines, found.characters) == (encoding, lines, characters)


@pytest.mark.parametrize(("block", "good"), [(5, True), (4, False)])
@pytest.mark.parametrize("text", ["12345\n1\n", "1\n12345", "1\n12345\n2", "1\n\n12345\n"])
def test_a_line_of_so_many_characters(
    text: str, block: int, good: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(csv_text, "BLOCK", block)
    (tmp_path / "a").write_text(text)
    if good:
        measure(tmp_path / "a")
    else:
        with pytest.raises(DataError, match="has a line of more than"):
            measure(tmp_path / "a")


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "is empty"), (b" \n\t\n", "is empty"), (b"a\0b\n", "is a binary file"),
        (b"\xff\xfe\x00\xd8a", "begins as UTF-16 and is not"),
    ],
)  # fmt: skip
def test_a_text_that_is_none(data: bytes, says: str, tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(data)
    with pytest.raises(DataError, match=says):
        measure(tmp_path / "a")


@pytest.mark.parametrize(("lines", "good"), [(103, True), (105, False)])
def test_a_table_of_so_many_lines(
    lines: int, good: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(csv_text, "CSV", replace(csv_text.CSV, rows=3))
    (tmp_path / "a").write_text("1\n" * lines)
    if good:
        assert measure(tmp_path / "a").lines == lines
    else:
        with pytest.raises(DataError, match="more than 3 lines"):
            measure(tmp_path / "a")


def test_the_first_lines_of_a_text(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("one\ntwo\n\nfour")
    assert head(tmp_path / "a", "ascii", 9, 99) == ["one", "two", "", "four"]
    assert head(tmp_path / "a", "ascii", 2, 99) == ["one", "two"]
    assert head(tmp_path / "a", "ascii", 9, 4) == ["one"]
    assert head(tmp_path / "a", "ascii", 9, 5) == ["one", "two"]


# -- separators, marks and headers
@pytest.mark.parametrize(
    ("lines", "decimal", "separator"),
    [
        (["1;2", "3;4"], None, ";"), (["1\t2"], None, "\t"), (["1|2"], None, "|"),
        (["1 2"], None, " "),
        (["1,2", "3,4"], None, ","), (["1,2", "3,4"], ",", ","), (["1,5;2,5"], None, ";"),
        (["a;b", "1,2;x", "1,2", "3,4", "1;2"], None, ","), (["x"], None, ","),
        (["1,5 2,5"], ",", " "),
    ],
)  # fmt: skip
def test_the_separator_of_most_lines(lines: list[str], decimal: str | None, separator: str) -> None:
    assert csv_reader._find_separator(lines, decimal) == separator


@pytest.mark.parametrize(
    ("lines", "separator", "decimal"),
    [
        (["1,5;2,5", "1.5;x"], ";", ","), (["1,5;2.5"], ";", "."), (["1;2"], ";", "."),
        (["1,5;2,5"], ",", "."), (["-1,5e3;,5;7"], ";", ","),
    ],
)  # fmt: skip
def test_the_decimal_mark_of_most_cells(lines: list[str], separator: str, decimal: str) -> None:
    assert csv_reader._find_decimal(lines, separator) == decimal


def test_cells_of_a_line() -> None:
    assert csv_reader._cells(' a , "b,c" ', ",") == ["a", '"b', 'c"']
    assert csv_reader._cells('"b,c", d', ",") == ["b,c", "d"]
    assert csv_reader._cells("  a   b ", " ") == ["a", "b"]
    assert csv_reader._cells("", ",") == []


def test_a_header_of_names_and_units(tmp_path: Path) -> None:
    text = "# made by hand\nt,i,w (rpm),,i2\ns,mA,-,,[A]\n0,1,2,3,4\n1,2,3,4,5\n"
    source = table(tmp_path, text)
    assert (source.header_lines, source.rows) == (3, 2)
    assert source.layout == "','-separated, decimal '.', 3 header lines"
    assert source.place(0) == "line 4"
    assert {"t", "i", "w (rpm)", "i2", "column4"} <= set(source.names)
    units = source.header_units
    assert (units["t"], units["i"], units["w (rpm)"], units["i2"]) == ("s", "mA", "rpm", "A")
    assert "column4" not in units
    assert [(one.name, one.unit) for one in source.described] == [
        ("t", "s"), ("i", "mA"), ("w (rpm)", "rpm"), ("column4", ""), ("i2", "A"),
    ]  # fmt: skip
    assert source.described[0].said == ("t", "s")
    found = source.read(["i", "column4"])
    assert found.values["i"].tolist() == [1.0, 2.0]
    assert found.values["column4"].tolist() == [3.0, 4.0]
    with pytest.raises(UsageError, match="no column 'x'"):
        source.read(["x"])


def test_a_name_that_two_columns_have_names_none(tmp_path: Path) -> None:
    source = table(tmp_path, "t,v,v\n0,1,2\n1,2,3\n")
    assert list(source.names) == ["t", "column1", "column2", "column3"]
    assert source.layout.endswith("1 header line")


def test_a_table_without_a_header_or_with_settings(tmp_path: Path) -> None:
    source = table(tmp_path, "0,1\n1,2\n")
    assert (source.header_lines, list(source.names)) == (0, ["column1", "column2"])
    source = table(tmp_path, "Rate,1000,\nName,x,y\nt,v,w\n0,1,2\n1,2,3\n")
    assert source.constants == {"Rate": 1000.0}
    assert source.read(["Rate", "t"]).values["Rate"].tolist() == [1000.0]
    beside = table(tmp_path, "Rate,1000,0.0,5\nName,x,0.1,6\n,,0.2,7\n")
    assert (beside.header_lines, beside.rows, beside.constants) == (0, 3, {"Rate": 1000.0})


@pytest.mark.parametrize("text", ["a,b\nc,d\n", "#1,2\n#3,4\n", "1,a,b\n2,c,d\n"])
def test_a_table_without_numbers_is_none(text: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"has no line of numbers among its first \d: give"):
        table(tmp_path, text)


def test_moments_are_seconds_since_the_first(tmp_path: Path) -> None:
    text = "t,v\n2026-01-01 00:00:01,1\n,2\n2026-01-01 00:00:02.5,3\n"
    source = table(tmp_path, text)
    assert source.header_units["t"] == "s"
    found = source.read(["t", "v"])
    assert found.values["t"].tolist() == pytest.approx([0.0, NAN, 1.5], nan_ok=True)
    assert found.bad == (BadCell(1, "t", ""),)


def test_a_ragged_line_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"line 3 has 3 cells where the first data line has 2"):
        table(tmp_path, "t,v\n0,1\n1,2,3\n2,3\n").read(["v"])


# -- marks
@pytest.mark.parametrize(
    ("cell", "decimal", "thousands", "number"),
    [
        ("1.5", ".", "", 1.5), ("1,5", ",", "", 1.5), ("1.5", ",", "", NAN), ("1,5", ".", "", NAN),
        ("1,234.5", ".", ",", 1234.5), ("1.234,5", ",", ".", 1234.5), ("12,34.5", ".", ",", NAN),
        ("12,34,567", ".", ",", 1234567.0), ("1'234", ".", "’", 1234.0),
        ("1 234", ".", "\u2009", 1234.0),
        ("-1,234", ".", ",", -1234.0), ("inf", ".", "", NAN), ("", ".", "", NAN),
        ("x", ".", "", NAN),
    ],
)  # fmt: skip
def test_a_cell_s_number(cell: str, decimal: str, thousands: str, number: float) -> None:
    (found,) = Marks(decimal, thousands).numbers([cell])
    assert found == pytest.approx(number, nan_ok=True)


@pytest.mark.parametrize(
    ("cell", "marked"),
    [("1,5", True), ("1.234.567", True), ("1_234", True), ("12.34.567", False), ("5", False),
     ("1234,567,8", False), (",5e3", True), ("1,2,3", False), ("x,5", False)],
)  # fmt: skip
def test_a_cell_with_other_marks(cell: str, marked: bool) -> None:
    assert looks_marked(cell) is marked


@pytest.mark.parametrize(
    ("values", "groups"),
    [
        ([1.009, 12.0], True), ([1.0095, 12.0], False), ([0.5, 12.0], False), ([1.009], False),
        ([12.0], False), ([1.009, 1000.0], False), ([1.009, 999.0], True), ([-1.009, 3.0], True),
        ([1.0, 1.001], True), ([], False), ([NAN], False), ([NAN, 1.25, 3.0], True),
    ],
)  # fmt: skip
def test_numbers_that_could_be_thousands(values: list[float], groups: bool) -> None:
    assert may_be_groups(np.array(values)) is groups


@pytest.mark.parametrize(
    ("cells", "asks"),
    [
        (["1.009", "12"], True), (["1.5", "12"], False), (["1009", "1.009"], False),
        (["0.009", "12"], False), (["1.009", "", "1.010"], False), (["12", "13"], False),
        (["12", "12.003"] * 2, True),  # changes three times
        ([*["12", "12.003"] * 2, "12"], False),  # four times, within a factor of two
        ([*["12", "24.003"] * 2, "12"], True),
        ([*["12", "24.000"] * 2, "12"], True),
        ([*["12", "23.003"] * 2, "12"], False),
    ],
)  # fmt: skip
def test_a_mark_that_could_group_is_asked_about(cells: list[str], asks: bool) -> None:
    seen = Ambiguous("v", ".")
    seen.look(cells, 7)
    assert bool(seen.question) is asks
    if asks:
        assert seen.first is not None
        assert seen.first.row == 7 + next(n for n, cell in enumerate(cells) if "." in cell)
        assert repr(next(cell for cell in cells if "." not in cell)) in seen.question


# -- arrays and records
def test_arrays_go_by_every_tail_that_one_alone_has(tmp_path: Path) -> None:
    arrays = {
        "a.x.v": np.array([1.0, NAN, 3.0]), "b.x.w": np.array([4.0, 5.0, 6.0]),
        "k": np.array([7.0]), "b.v": np.array([1.0, 2.0]), "bad": np.array([NAN]),
    }  # fmt: skip
    source = ArraySource(tmp_path, arrays, "arrays", units={"b.x.w": "[rpm]", "k": "odd"})
    assert source.names[0] == "w"
    assert {"x.w", "b.x.w", "x.v", "a.x.v", "b.v", "k"} < set(source.names)
    assert not {"v"} & set(source.names)
    assert source.constants == {"k": 7.0}
    assert source.header_units == {"w": "rpm", "x.w": "rpm", "b.x.w": "rpm"}
    assert [(one.name, one.said, one.unit) for one in source.described] == [
        ("x.v", ("a.x.v",), ""), ("w", ("b.x.w",), "rpm"), ("b.v", ("b.v",), ""),
    ]  # fmt: skip
    assert (source.rows, source.place(4)) == (3, "element 5")
    found = source.read(["w", "x.v", "k"])
    assert found.rows == 3
    assert found.bad == (BadCell(1, "x.v", "nan"),)
    with pytest.raises(DataError, match=r"differ in length: w has 3, b\.v has 2; map columns"):
        source.read(["w", "b.v"])


def test_records_of_lines_become_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text(
        '{"a": 1}\n\n{"a": "x", "t": "2026-01-01T00:00:01"}\nodd\n'
        '{"t": "2026-01-01T00:00:03", "a": 4}\n'
    )
    source = RecordSource(path, "JSON lines")
    found = source.read(["a", "t"])
    assert found.values["a"].tolist() == pytest.approx([1.0, NAN, NAN, 4.0], nan_ok=True)
    assert np.isnan(found.values["t"]).all()  # the first row has none
    assert found.bad == (BadCell(1, "a", "x"), BadCell(0, "t", ""))
    assert (source.rows, source.place(2), source.header_units) == (4, "line 4", {})
    path.write_text('{"t": "2026-01-01T00:00:01"}\n{"t": "2026-01-01T00:00:03"}\n{"t": 5}\n')
    source = RecordSource(path, "JSON lines")
    assert source.read(["t"]).values["t"].tolist() == [0.0, 2.0, 5.0]
    assert source.header_units == {"t": "s"}


def test_a_day_s_seconds_go_on_over_midnight() -> None:
    from array import array

    seconds = array("d", [86399.0, NAN, 1.0, 0.5, 50000.0, 2.0])
    _past_midnight(seconds)
    on = [86399.0, NAN, 86401.0, 86400.5, 136400.0, 172802.0]
    assert list(seconds) == pytest.approx(on, nan_ok=True)
