"""What is beyond the table of limits is refused in a sentence, and large tables stay in step."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st

from motorid import limits
from motorid.acquire.journal import MAGIC, parse_journal
from motorid.capture import csv_numbers, csv_reader, csv_text, mat_child
from motorid.capture.csv_marks import Marks
from motorid.capture.csv_numbers import NotPlainError, Parser
from motorid.capture.csv_text import Body, measure, opened
from motorid.capture.table import NOTES, read_table
from motorid.cli.main import run
from motorid.errors import DataError, RigError, UsageError
from motorid.json_seal import read as read_json
from motorid.toml_file import read_text

MAPS = ["time=t:s", "current=i:A"]


def log(path: Path, rows: int = 50, more: str = "") -> Path:
    """A small table."""
    path.write_text("t,i\n" + "".join(f"{k},{k % 7}.5\n" for k in range(rows)) + more)
    return path


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> limits.Limits:
    """Limits that a test's files exceed."""
    few = replace(limits.CSV, file=4000, rows=100, columns=20)
    for module in (csv_text, csv_reader):
        monkeypatch.setattr(module, "CSV", few)
    monkeypatch.setattr(csv_text, "BLOCK", 500)
    return few


def said(path: Path) -> str:
    """Why a table is refused."""
    with pytest.raises(DataError) as caught:
        read_table(path, MAPS)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)
    return str(caught.value)


def test_tables_beyond_each_limit(small: limits.Limits, tmp_path: Path) -> None:
    path = log(tmp_path / "log.csv", 100)
    assert len(read_table(path, MAPS)) == 100
    assert "101 rows" in said(log(path, 101))
    assert "more than 100 lines" in said(log(path, 250))
    assert "4.879 KiB; a file of its kind (CSV table)" in said(log(path, 2, " " * 4980))
    path.write_text(",".join(f"c{n}" for n in range(21)) + "\n" + "1," * 20 + "1\n")
    assert "21 columns" in said(path)
    path.write_text("t,i\n1,2\n" + "1" * 501 + ",2\n")
    assert "a line of more than 500 B" in said(path)


@pytest.mark.parametrize(
    "more",
    [
        {"separator": ";;"},
        {"separator": ""},
        {"separator": '"'},
        {"separator": "\n"},
        {"separator": "5"},
        {"separator": "€"},
        {"decimal": "x"},
        {"decimal": ""},
        {"separator": ",", "decimal": ","},
    ],
)
def test_a_separator_that_is_none_is_a_wrong_request(tmp_path: Path, more: dict[str, str]) -> None:
    with pytest.raises(UsageError, match=r"--(separator|decimal)"):
        read_table(log(tmp_path / "log.csv"), MAPS, **more)


def test_blank_lines_at_the_end_count_for_nothing(small: limits.Limits, tmp_path: Path) -> None:
    path = log(tmp_path / "log.csv", 50, " \n\t\n" * 300 + "\n")
    assert len(read_table(path, MAPS)) == 50


def test_what_is_no_regular_file_is_not_read(tmp_path: Path) -> None:
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.csv")
        with pytest.raises(DataError, match="is a pipe: name a file"):
            measure(tmp_path / "pipe.csv")
    with pytest.raises(DataError, match="a folder"):
        measure(tmp_path)


def test_a_sparse_file_of_two_gigabytes_costs_nothing(tmp_path: Path) -> None:
    for name in ("log.csv", "log.mat", "run.h5"):
        path = tmp_path / name
        with path.open("wb") as file:
            file.write(b"t,i\n")
            file.truncate(2 << 30)
        command = ["import", str(path), "--map", MAPS[0], "--map", MAPS[1], "-o", "x.h5"]
        assert run(["fit", str(path)] if name == "run.h5" else command) == 4


def test_documents_and_rigs_beyond_their_size(tmp_path: Path) -> None:
    path = tmp_path / "large"
    with path.open("wb") as file:
        file.truncate(limits.JSON.file + 1)
    with pytest.raises(DataError, match="has 64 MiB; a file of its kind"):
        read_json(path, "a verdict")
    with pytest.raises(RigError, match="larger than a rig file may be"):
        read_text(path, "a rig file", RigError)


def test_a_record_that_claims_gigabytes_is_no_record() -> None:
    with pytest.raises(DataError, match="header"):
        parse_journal(MAGIC + b"H" + bytes(8) + b"\xff\xff\xff\x7f" + bytes(100))


def test_arrays_beyond_the_limits(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(mat_child, "MAT", replace(limits.MAT, rows=1000, columns=3))
    path, target = tmp_path / "log.mat", str(tmp_path / "out.npz")
    scipy.io.savemat(path, {"t": np.zeros(1001)}, do_compression=True)
    with pytest.raises(DataError, match="t has 1,001 rows"):
        mat_child.main(str(path), target)
    scipy.io.savemat(path, {"s": {"t": np.zeros(1001)}})
    with pytest.raises(DataError, match=r"s\.t has 1,001 rows"):
        mat_child.main(str(path), target)
    scipy.io.savemat(path, {f"x{n}": np.zeros(5) for n in range(4)})
    with pytest.raises(DataError, match="more than 3 arrays"):
        mat_child.main(str(path), target)
    with h5py.File(path, "w") as file:
        file.create_dataset("t", (10**13,), "f8", chunks=(1024,))
    with pytest.raises(DataError, match="10,000,000,000,000 rows"):
        mat_child.main(str(path), target)


CELLS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.integers(-(10**25), 10**25).map(str),
    st.sampled_from(
        ["", "-", "nan", "inf", "-Infinity", "1e400", "1_0", "0x10", "1e5", "1E+05", " 1", "1 ",
         "+1", ".5", "5.", "1.5.2", "True", "1e", "--1", "\"1\"", "1d3", "٣", "1\u00a0", "N/A"]
    ),
)  # fmt: skip


@pytest.mark.slow
@given(rows=st.lists(st.tuples(CELLS, CELLS), min_size=1, max_size=6), comma=st.booleans())
def test_both_ways_of_parsing_agree(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[str, str]], comma: bool
) -> None:
    """Where the fast way has an answer, the careful one has none that is bad, and the same."""
    text = "".join(f"{a};{b}\n" for a, b in rows)
    text = text.replace(".", ",") if comma else text
    path = tmp_path_factory.getbasetemp() / "both.csv"
    path.write_text(text, encoding="utf-8")
    parser, wanted = Parser(";", Marks("," if comma else "."), 2), {"a": 0, "b": 1}

    def body() -> Body:
        return Body(opened(path, "utf-8"), 0, len(text))

    try:
        plain = parser.plain(body(), wanted, len(rows))
    except NotPlainError:
        return
    careful = parser.careful(body(), wanted, len(rows))
    assert careful.bad == ()
    for name in wanted:
        np.testing.assert_allclose(plain.values[name], careful.values[name], rtol=1e-15)


def test_pieces_join(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Bad cells have their line in whichever piece they are."""
    monkeypatch.setattr(csv_numbers, "PIECE", 7)
    path = log(tmp_path / "log.csv", 100)
    whole = read_table(path, MAPS)
    assert [len(whole), whole.channels["current"].raw[50]] == [100, 1.5]
    lines = path.read_text().splitlines()
    lines[60], lines[80] = "59,x", "79,"
    path.write_text("\n".join(lines))
    assert "line 61, column 'i' holds 'x'" in said(path)
    kept = read_table(path, MAPS, drop_bad=True)
    assert int(np.isnan(kept.channels["current"].raw).sum()) + 100 - len(kept) == 2
    assert "2 rows are bad" in kept.provenance[NOTES][0]


@pytest.mark.parametrize(
    ("count", "most", "refused"), [(3, 3, False), (4, 3, True), (4, None, False), (1, 0, True)]
)
def test_only_a_limit_refuses(count: int, most: int | None, refused: bool) -> None:
    assert limits.beyond(count, most) is refused
