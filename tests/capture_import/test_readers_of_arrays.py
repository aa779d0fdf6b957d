"""What the readers of binary files make of the arrays that their child hands back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture import columnar_reader, mat_reader, record_reader, sheet_child, sheet_reader
from motorid.capture.child import ChildFailedError
from motorid.capture.columnar_reader import ColumnarSource
from motorid.capture.mat_reader import MatSource
from motorid.capture.record_reader import RecordSource
from motorid.capture.recording_reader import RecordingSource
from motorid.capture.sheet_reader import SheetSource
from motorid.errors import DataError, UsageError
from motorid.limits import COLUMNAR, MAT, RECORDING, RECORDS, SHEET


def given(monkeypatch: pytest.MonkeyPatch, module: Any, answer: Any) -> list[Any]:
    """Has a child answer so; what it is asked."""
    asked: list[Any] = []

    def arrays_from(*order: Any) -> Any:
        asked.append(order)
        if isinstance(answer, Exception):
            raise answer
        return answer

    monkeypatch.setattr(module, "arrays_from", arrays_from)
    return asked


def arrays(others: list[str], **columns: list[float]) -> dict[str, Any]:
    found: dict[str, Any] = {f"a{n}": np.array(c) for n, c in enumerate(columns.values())}
    objects = np.array([(name, "no numbers") for name in others], dtype=str).reshape(-1, 2)
    return {**found, "names": np.array(list(columns)), "objects": objects}


# -- NPZ, Parquet and logs
def test_columns_by_name_with_their_units(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = {**arrays([], t=[0.0, 1.0], i=[2.0, 3.0]), "units": np.array(["s", "mA"])}
    asked = given(monkeypatch, columnar_reader, answer)
    source = ColumnarSource(Path("a.npz"), "NPZ")
    assert source.read(["i"]).values["i"].tolist() == [2.0, 3.0]
    assert source.header_units == {"t": "s", "i": "mA"}
    assert (source.elsewhere, source.layout) == ("", "NPZ")
    RecordingSource(Path("a.log"), "log")
    assert [(Path(order[0]).name, *order[1:]) for order in asked] == [
        ("columnar_child.py", Path("a.npz"), COLUMNAR),
        ("recording_child.py", Path("a.log"), RECORDING),
    ]


@pytest.mark.parametrize(
    ("others", "said"),
    [
        (["x"], "x: no {} of numbers"),
        (list("abcd"), "a, b, c, d: no {} of numbers"),
        (list("abcdef"), "a, b, c, d and 2 more: no {} of numbers"),
    ],
)
def test_what_holds_no_numbers_is_named(
    others: list[str], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    given(monkeypatch, columnar_reader, arrays(others, t=[0.0, 1.0]))
    assert ColumnarSource(Path("a.npz"), "NPZ").elsewhere == said.format("columns")
    assert RecordingSource(Path("a.log"), "log").elsewhere == said.format("signals")


# -- MAT
def test_arrays_of_a_mat_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.mat"
    answer = {**arrays([], i=[2.0, 3.0]), "objects": np.array([("x", "timetable")])}
    asked = given(monkeypatch, mat_reader, answer)
    with pytest.raises(DataError, match=r"a\.mat: cannot be read: there is no such file"):
        MatSource(path)
    path.touch()
    source = MatSource(path)
    assert source.read(["i"]).values["i"].tolist() == [2.0, 3.0]
    assert source.elsewhere.startswith("x is a timetable, which only MATLAB reads")
    assert source.layout == "MAT file"
    assert [(Path(order[0]).name, *order[1:]) for order in asked] == [("mat_child.py", path, MAT)]


# -- sheets
def sheet(text: str, others: list[str]) -> Mapping[str, Any]:
    return {
        "text": np.frombuffer(text.encode(), dtype=np.uint8), "sheet": np.array(["log"]),
        "others": np.array(others, dtype=str),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("head", "lines"), [("", "0 header lines"), ("t\tv\n", "1 header line"),
                        ("by\thand\nt\tv\n", "2 header lines")],
)  # fmt: skip
@pytest.mark.parametrize("others", [[], ["a", "b"]])
def test_a_sheet_is_a_table_of_rows(
    head: str, lines: str, others: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = given(monkeypatch, sheet_reader, sheet(f"{head}0\t1,5\n1\t2,5\n", others))
    source = SheetSource(Path("a.xlsx"), ",")
    assert source.read(["column2"] if not head else ["v"]).rows == 2
    assert asked == [(sheet_child.__file__, Path("a.xlsx"), SHEET)]
    assert source.layout == f"sheet 'log', {lines}" + ("; not read: 'a', 'b'" if others else "")
    assert source.elsewhere == ("read was its sheet 'log', not 'a', 'b'" if others else "")
    assert source.place(1) == f"row {head.count(chr(10)) + 2}"


def test_a_sheet_with_marks_that_were_told(monkeypatch: pytest.MonkeyPatch) -> None:
    given(monkeypatch, sheet_reader, sheet("t\tv\n0\t1.234,5\n1\t2,5\n", []))
    source = SheetSource(Path("a.xlsx"), None, ".")
    assert source.read(["v"]).values["v"].tolist() == [1234.5, 2.5]


@pytest.mark.parametrize(
    ("module", "read", "kind"),
    [
        (columnar_reader, lambda path: ColumnarSource(path, "Parquet"), "Parquet"),
        (mat_reader, MatSource, "a MAT file"), (sheet_reader, SheetSource, "a spreadsheet"),
    ],
)  # fmt: skip
def test_a_child_that_fails_is_one_sentence(
    module: Any, read: Any, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a"
    path.touch()
    given(monkeypatch, module, ChildFailedError("odd"))
    with pytest.raises(DataError) as caught:
        read(path)
    assert str(caught.value) == f"{path} cannot be read as {kind} (odd): is it damaged?"


def test_a_file_without_arrays_or_names_has_no_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given(monkeypatch, columnar_reader, arrays(["x"]))
    source = ColumnarSource(Path("a.npz"), "NPZ")
    assert (source.rows, list(source.names)) == (0, [])
    (tmp_path / "a.jsonl").write_text('{"a": 1}\n{"a": 2}\n')
    for one in (source, RecordSource(tmp_path / "a.jsonl", "JSON lines")):
        with pytest.raises(UsageError, match="no column 'b'"):
            one.read(["b"])


@pytest.mark.parametrize(
    ("limit", "good"), [({"file": 20}, False), ({"file": 21}, True), ({"rows": 2}, False),
                        ({"rows": 3}, True), ({"columns": 0}, False), ({"numbers": 2}, False)],
)  # fmt: skip
def test_records_beyond_the_limits_are_refused(
    limit: dict[str, int], good: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(record_reader, "RECORDS", replace(RECORDS, **limit))
    path = tmp_path / "a.jsonl"
    path.write_bytes(b'{"a":1}' + b"\n" + b'{"a":2}\n{}\n\n\n')
    if good:
        assert RecordSource(path, "JSON lines").rows == 3
    else:
        with pytest.raises(DataError, match=r"may have 20 B$|more than .* lines"):
            RecordSource(path, "JSON lines")
