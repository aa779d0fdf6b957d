"""What the readers of binary files make of a few arrays, in this process and at small limits."""

from __future__ import annotations

import struct
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from motorid import limits
from motorid.capture import columnar_child, mat_child, recording_child, sheet_child, wpilog
from motorid.capture.recording_child import Signal
from motorid.errors import DataError


def read(child: Any, source: Path) -> tuple[dict[str, list[float]], dict[str, str]]:
    """Columns by name, and what holds no numbers."""
    target = source.with_name("out.npz")
    child.main(str(source), str(target))
    with np.load(target) as found:
        names = found["names"].tolist()
        columns = {name: found[f"a{index}"].tolist() for index, name in enumerate(names)}
        return columns, dict(found["objects"].tolist())


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> limits.Limits:
    """Limits that a test reaches."""
    one = limits.RECORDING
    small = type(one)(**{**vars_of(one), "columns": 3, "rows": 4, "numbers": 6})
    for child, name in (
        (mat_child, "MAT"), (columnar_child, "COLUMNAR"), (recording_child, "RECORDING"),
        (sheet_child, "SHEET"),
    ):  # fmt: skip
        monkeypatch.setattr(child, name, small)
    return small


def vars_of(one: Any) -> dict[str, Any]:
    return {name: getattr(one, name) for name in one.__dataclass_fields__}


# -- limits
@pytest.mark.parametrize(
    ("shape", "good"),
    [((4,), True), ((5,), False), ((2, 3), True), ((3, 3), False), ((), True), ((1, 2, 3), True)],
)
@pytest.mark.parametrize("child", [mat_child, columnar_child])
def test_an_array_of_so_many_rows_and_numbers(
    child: Any, shape: tuple[int, ...], good: bool, few: limits.Limits
) -> None:
    if good:
        child.refuse_shape("x", shape)
    else:
        rows, numbers = max(shape), int(np.prod(shape))
        with pytest.raises(DataError, match=f"^x has {rows} rows and {numbers} numbers"):
            child.refuse_shape("x", shape)


@pytest.mark.parametrize(
    ("columns", "rows", "numbers", "good"),
    [(3, 4, 6, True), (4, 1, 1, False), (1, 5, 1, False), (1, 1, 7, False)],
)
def test_signals_of_so_many_readings(
    columns: int, rows: int, numbers: int, good: bool, few: limits.Limits
) -> None:
    if good:
        recording_child.refuse(columns, rows, numbers)
    else:
        with pytest.raises(DataError, match="more than 3 signals, 4 readings of one or 6 in all"):
            recording_child.refuse(columns, rows, numbers)


@pytest.mark.parametrize(
    ("rows", "columns", "good"), [(2, 3, True), (1, 4, False), (3, 2, True), (7, 1, False)]
)
def test_a_sheet_of_so_many_cells(rows: int, columns: int, good: bool, few: limits.Limits) -> None:
    if good:
        sheet_child.refuse_shape("s", rows, columns)
    else:
        with pytest.raises(DataError, match=f"'s' has {rows} rows of {columns} columns"):
            sheet_child.refuse_shape("s", rows, columns)


@pytest.mark.parametrize(("count", "good"), [(3, True), (4, False)])
def test_a_file_of_so_many_columns(
    count: int, good: bool, few: limits.Limits, tmp_path: Path
) -> None:
    arrays = {f"x{n}": np.array([1.0]) for n in range(count)}
    np.savez(tmp_path / "a.npz", **arrays)  # type: ignore[arg-type]
    savemat(tmp_path / "a.mat", arrays)
    for child, name in ((columnar_child, "a.npz"), (mat_child, "a.mat")):
        if good:
            assert len(read(child, tmp_path / name)[0]) == count
        else:
            with pytest.raises(DataError, match="more than 3"):
                read(child, tmp_path / name)


@pytest.mark.parametrize("kind", ["mat", "hdf5"])
def test_a_mat_file_is_refused_by_its_shapes_before_it_is_read(
    kind: str, few: limits.Limits, tmp_path: Path
) -> None:
    path = tmp_path / "a.mat"
    if kind == "mat":
        savemat(path, {"x": np.zeros((5, 1), np.complex128)})  # which would be passed over
    else:
        with h5py.File(path, "w") as file:
            file["x"] = np.zeros((5, 1), np.complex128)
    with pytest.raises(DataError, match="x has 5 rows"):
        read(mat_child, path)


# -- arrays
def test_an_npz_s_arrays_become_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    stamps = np.array(["NaT", "2026-01-01T00:00:01", "2026-01-01T00:00:02.5"], "datetime64[ms]")
    record = np.array([(1, 2.5), (3, 4.5)], dtype=[("i", "i4"), ("v", "f8")])
    np.savez(
        path, t=stamps, d=np.array([1500, -500], "timedelta64[ms]"), m=np.arange(6).reshape(3, 2),
        r=record, one=np.float64(7.0), text=np.array(["a"]), wide=np.zeros((1, 65)),
        edge=np.zeros((1, 64)), cube=np.zeros((1, 1, 1)), none=np.zeros(0),
        on=np.array([True, False]),
    )  # fmt: skip
    columns, others = read(columnar_child, path)
    assert np.isnan(columns["t"][0])
    assert columns["t"][1:] == [0.0, 1.5]
    assert columns["d"] == [1.5, -0.5]
    assert (columns["m[1]"], columns["m[2]"]) == ([0.0, 2.0, 4.0], [1.0, 3.0, 5.0])
    assert (columns["r.i"], columns["r.v"]) == ([1.0, 3.0], [2.5, 4.5])
    assert (columns["one"], columns["on"]) == ([7.0], [1.0, 0.0])
    assert {"edge[1]", "edge[64]"} < set(columns)
    assert others == dict.fromkeys(("text", "wide", "cube", "none"), "no numbers")


def test_an_npz_of_objects_is_refused_unread(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", x=np.array([{}], dtype=object))
    with pytest.raises(DataError, match=r"^x\.npy holds Python objects"):
        read(columnar_child, tmp_path / "a.npz")


def test_a_matrix_of_up_to_64_columns_or_rows_is_taken_apart(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    savemat(path, {"wide": np.zeros((2, 65)), "edge": np.zeros((2, 64)), "tall": np.zeros((65, 2))})
    columns, _ = read(mat_child, path)
    assert "edge[64]" in columns
    assert {"wide[2,:]", "edge[2,:]", "tall[2]"} < set(columns)
    assert not {"wide[1]", "tall[1,:]"} & set(columns)


# -- logs of signals
def start(number: int, name: str, kind: str) -> bytes:
    texts = b"".join(struct.pack("<I", len(t)) + t.encode() for t in (name, kind, "m"))
    return struct.pack("<BI", 0, number) + texts


def record(entry: int, stamp: int, data: bytes, widths: tuple[int, int, int] = (1, 1, 1)) -> bytes:
    head = widths[0] - 1 | (widths[1] - 1) << 2 | (widths[2] - 1) << 4
    numbers = zip((entry, len(data), stamp), widths, strict=True)
    return bytes([head]) + b"".join(n.to_bytes(w, "little") for n, w in numbers) + data


def log_of(*records: bytes, version: int = 0x0100, extra: bytes = b"") -> bytes:
    return b"WPILOG" + struct.pack("<HI", version, len(extra)) + extra + b"".join(records)


@pytest.mark.parametrize("widths", [(1, 1, 1), (2, 1, 3), (4, 2, 8), (3, 4, 5), (1, 3, 4)])
def test_a_record_s_numbers_are_of_any_width(widths: tuple[int, int, int]) -> None:
    records = [
        record(0, 9, start(7, "speed", "double"), widths),
        record(7, 200, struct.pack("<d", 2.5), widths),
        record(7, 250, struct.pack("<d", -1.5), widths),
    ]
    (entry,), others = wpilog.entries(log_of(*records, extra=b"abc"), 4)
    assert (entry.name, entry.kind, entry.metadata) == ("speed", "double", "m")
    assert entry.stamps.tolist() == pytest.approx([200e-6, 250e-6])
    assert entry.values.tolist() == [2.5, -1.5]
    assert others == []
    with pytest.raises(DataError, match="more than 3 numbers"):
        wpilog.entries(log_of(*records), 3)


@pytest.mark.parametrize(
    ("kind", "data", "value"),
    [
        ("float", struct.pack("<f", 0.5), 0.5),
        ("int64", struct.pack("<q", -3), -3.0),
        ("boolean", b"\1", 1.0),
    ],
)
def test_each_kind_of_number(kind: str, data: bytes, value: float) -> None:
    (entry,), _ = wpilog.entries(log_of(record(0, 0, start(1, "x", kind)), record(1, 5, data)), 9)
    assert entry.values.tolist() == [value]
    with pytest.raises(DataError, match="a record of x has a wrong size"):
        wpilog.entries(log_of(record(0, 0, start(1, "x", kind)), record(1, 5, data + b"0")), 9)


def test_an_entry_that_ended_or_never_began_takes_nothing() -> None:
    end = struct.pack("<BI", 1, 7)
    value = struct.pack("<d", 2.5)
    metadata = struct.pack("<BI", 2, 7) + struct.pack("<I", 1) + b"z"
    (entry,), others = wpilog.entries(
        log_of(
            record(0, 0, start(7, "x", "double")), record(0, 0, start(8, "mode", "string")),
            record(8, 0, b"auto"), record(0, 0, metadata), record(7, 1, value),
            record(0, 2, end), record(7, 3, value), record(9, 4, value),
        ),
        99,
    )  # fmt: skip
    assert entry.values.tolist() == [2.5]
    assert others == ["mode"]


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"WPILOG", "no WPILib data log"),
        (b"WPILOX" + bytes(6), "no WPILib data log"),
        (log_of(version=0x0200), "of version 2; 1 can be read"),
        (log_of(record(0, 0, b"\0\0\0\0")), "a control record has a wrong size"),
        (log_of(record(0, 0, start(1, "x", "double")[:-1])), "beginning of an entry is cut short"),
        (log_of(record(1, 0, b"1234"))[:-1], "record at byte 12 is cut short"),
    ],
)
def test_a_log_that_is_none(data: bytes, says: str) -> None:
    with pytest.raises(DataError, match=says):
        wpilog.entries(data, 99)
    assert wpilog.entries(log_of(version=0x0101), 0) == ([], [])


def test_signals_of_one_name_are_all_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    signals = [
        Signal("x", np.array([1, 2], np.int16), "V"), Signal("x", np.array([3.0])),
        Signal("x", [4.0], "A"), Signal("text", np.array(["a"])), Signal("none", np.zeros(0)),
        Signal("table", np.zeros((2, 2))), Signal("nothing", None),
    ]  # fmt: skip
    monkeypatch.setattr(recording_child, "KINDS", {b"LOG": lambda source: iter(signals)})
    (tmp_path / "a.log").write_bytes(b"LOG")
    columns, others = read(recording_child, tmp_path / "a.log")
    assert columns == {"x": [1.0, 2.0], "x_": [3.0], "x__": [4.0]}
    assert list(others) == ["text", "none", "table", "nothing"]
    with np.load(tmp_path / "out.npz") as found:
        assert found["units"].tolist() == ["V", "", "A"]


def test_a_message_s_members_have_dotted_names_and_its_lists_count_from_one() -> None:
    class Ros:
        __slots__ = ("flag", "name", "speed")

        def __init__(self) -> None:
            self.speed, self.name, self.flag = np.float32(1.5), "x", True

    value = {"a": 1, "b": [2.0, {"c": 3}], "s": "text", "n": None, "m": Ros(), "y": b"1"}
    assert dict(recording_child._members(value, "t", 0)) == {
        "t.a": 1.0, "t.b[1]": 2.0, "t.b[2].c": 3.0, "t.m.flag": 1.0, "t.m.speed": 1.5,
    }  # fmt: skip
    deep: Any = 5.0
    for _ in range(6):
        deep = {"d": deep}
    assert dict(recording_child._members(deep, "t", 0)) == {"t.d.d.d.d.d.d": 5.0}
    assert dict(recording_child._members([deep], "t", 0)) == {}


# -- sheets
def test_cells_become_text() -> None:
    row = [
        True, 3, 0.1, date(2026, 1, 2), datetime(2026, 1, 2, 3, 4, 5, 600_000),
        time(1, 2, 3, 500_000), timedelta(days=1, milliseconds=250), 'a\t"b"\n\0c ', None,
    ]  # fmt: skip
    text = sheet_child.as_text([row, [1e-20]])
    cells = ["1", "3", "0.1", "2026-01-02", "2026-01-02T03:04:05.600000", "3723.5", "86400.25"]
    assert text == "\t".join([*cells, "a 'b' c", "None"]) + "\n1e-20\n"
