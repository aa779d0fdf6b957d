"""Files that are neither CSV nor MAT: each value comes back, and nothing is left out unsaid."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pyarrow import parquet

from motorid import limits
from motorid.capture import columnar_child, formats, record_reader
from motorid.capture.model import CURRENT, SPEED
from motorid.capture.record_lines import NoRecordError, json_record, labelled_record, moment
from motorid.capture.table import read_table
from motorid.capture.table_options import TableOptions
from motorid.cli import main
from motorid.errors import DataError, MotoridError

N = 50
TIME = np.arange(N) / 100.0
AMPERES = np.round(np.sin(TIME * 9.0), 4)
RPM = np.arange(N) * 7.5
MAPS = ["time=t:s", "current=i:A", "speed=n:rpm"]


def json_lines() -> bytes:
    rows = zip(TIME.tolist(), AMPERES.tolist(), RPM.tolist(), strict=True)
    return "".join(
        f"{json.dumps({'t': t, 'motor': {'i': i}, 'n': n})}\n" for t, i, n in rows
    ).encode()


def plotter(separator: str) -> bytes:
    rows = zip(TIME.tolist(), AMPERES.tolist(), RPM.tolist(), strict=True)
    return "".join(f"t:{t}{separator}i:{i}{separator}n:{n}\r\n" for t, i, n in rows).encode()


def npz() -> bytes:
    sink = io.BytesIO()
    np.savez_compressed(sink, t=TIME, i=AMPERES, n=RPM, label=np.array("run 7"))
    return sink.getvalue()


def table_file() -> bytes:
    sink = io.BytesIO()
    moments = np.datetime64("2026-11-23T00:00:00", "ns") + (TIME * 1e9).astype("timedelta64[ns]")
    parquet.write_table(pa.table({"t": moments, "i": AMPERES, "n": RPM, "who": ["x"] * N}), sink)
    return sink.getvalue()


FILES = {
    "log.jsonl": (json_lines, {"i": "motor.i"}),
    "plotter.txt": (lambda: plotter(","), {}),
    "plotter-tab.log": (lambda: plotter("\t"), {}),
    "plotter-blank.csv": (lambda: plotter(" "), {}),
    "arrays.npz": (npz, {}),
    "table.parquet": (table_file, {}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_every_reading_comes_back(name: str, tmp_path: Path) -> None:
    made, renamed = FILES[name]
    path = tmp_path / name
    path.write_bytes(made())
    maps = [one.replace("=i:", f"={renamed.get('i', 'i')}:") for one in MAPS]
    capture = read_table(path, maps)
    np.testing.assert_array_equal(capture.channels[CURRENT].values, AMPERES)
    np.testing.assert_array_equal(capture.channels[SPEED].raw, RPM)
    np.testing.assert_allclose(capture.time_s, TIME, atol=1e-9)


@pytest.mark.slow
def test_what_is_no_column_of_numbers_is_named(tmp_path: Path) -> None:
    path = tmp_path / "table.parquet"
    path.write_bytes(table_file())
    with pytest.raises(MotoridError, match="who: no columns of numbers"):
        read_table(path, ["current=who:A"])


def test_a_serial_monitors_stamps_count_on_past_midnight(tmp_path: Path) -> None:
    path = tmp_path / "monitor.txt"
    path.write_text(
        "23:59:59.900 -> i:1\n23:59:59.950 -> i:2\n00:00:00.000 -> i:3\n00:00:00.050 -> i:4\n"
    )
    capture = read_table(path, ["time=stamp:s", "current=i:A"])
    np.testing.assert_allclose(capture.time_s, [0.0, 0.05, 0.1, 0.15], atol=1e-6)


@pytest.mark.parametrize("zone", ["", "Z", "+01:00"])
def test_dates_and_times_keep_every_digit(zone: str, tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    step = 123_456_789
    stamps = [f"2026-11-23T12:00:00.{k * step:09d}{zone}" for k in range(8)]
    lines = [json.dumps({"t": stamp, "i": k}) for k, stamp in enumerate(stamps)]
    path.write_text("\n".join(lines))
    source = record_reader.RecordSource(path, "JSON lines")
    assert source.header_units == {"t": "s"}
    assert source.read(["t"]).values["t"] == pytest.approx(np.arange(8) * step * 1e-9, abs=1e-12)


def test_a_zone_counts() -> None:
    here, there = moment("2026-11-23T12:00:00+02:00"), moment("2026-11-23T10:00:00Z")
    assert here is not None
    assert there is not None
    assert here.since(there) == 0.0
    assert moment("2026-13-01T00:00:00") is moment("no date") is moment("12345678901") is None


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("i:1 n:2\ni:1 n:2\nBrown-out reset\ni:1 n:2\n" * 3, "line 3"),
        ("i:1 n:2\n\ni:1 n:2\ni:1\n" + "i:1 n:2\n" * 9, "line 4"),
        ('{"i": 1, "n": 2}\n{"i": 1, "n": "off"}\n' + '{"i": 1, "n": 2}\n' * 9, "line 2"),
        ('{"i": 1, "n": 2}\n{"i": 1, "n"\n' + '{"i": 1, "n": 2}\n' * 9, "line 2"),
        ('{"i": 1, "n": 2}\n{"i": 1, "n": null}\n' + '{"i": 1, "n": 2}\n' * 9, "line 2"),
    ],
)
def test_a_line_that_lacks_a_reading_stops_the_import_with_its_place(
    text: str, place: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "log.txt", tmp_path / "log.h5"
    path.write_text(text)
    line = ["import", str(path), "--map", "current=i:A", "--map", "speed=n:rpm", "-o", str(out)]
    assert main.run(line) == 4
    assert place in capsys.readouterr().err
    assert main.run([*line, "--drop-bad"]) == 0


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("a:1", {"a": 1.0}),
        ("Motor speed (rpm): -1.5e3, i[2]=.5", {"Motor speed (rpm)": -1500.0, "i[2]": 0.5}),
        ("12:00:01.5 -> a:1\tb:2", None),
        ("a:1 a:2", None),
        ("a:1 b", None),
        ("12:00", None),
        ("1,2,3", None),
        ("a:1.2.3", None),
        ("a" * 65 + ":1", None),
        ("", None),
    ],
)
def test_labelled_lines(text: str, found: dict[str, float] | None) -> None:
    if found is None and "->" not in text:
        with pytest.raises(NoRecordError):
            labelled_record(text)
    elif found is not None:
        assert labelled_record(text) == found


def test_arrays_of_json_are_columns() -> None:
    assert json_record('{"a": [1, true, {"b": 2}]}') == {"a[1]": 1.0, "a[2]": 1.0, "a[3].b": 2.0}


def test_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    few = replace(limits.RECORDS, rows=20, columns=5, numbers=60)
    monkeypatch.setattr(record_reader, "RECORDS", few)
    for text in (
        "i:1\n" * 21,
        " ".join(f"a{chr(98 + k)}:1" for k in range(6)),
        "i:1 n:1 u:1 w:1\n" * 16,
    ):
        (tmp_path / "log.txt").write_text(text)
        with pytest.raises(DataError, match="the most"):
            formats.source_of(tmp_path / "log.txt", TableOptions())
    monkeypatch.setattr(
        columnar_child, "COLUMNAR", replace(limits.COLUMNAR, rows=1000, numbers=1000)
    )
    for shape in ((1001,), (50, 50)):
        with pytest.raises(DataError, match="may have"):
            columnar_child.refuse_shape("a", shape)


def test_no_pickle_is_read(tmp_path: Path) -> None:
    path = tmp_path / "objects.npz"
    np.savez(path, a=np.array([{"b": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(DataError, match="Python objects"):
        formats.source_of(path, TableOptions())


def insist(path: Path, data: bytes) -> None:
    """The file is read, or refused in a sentence."""
    path.write_bytes(data)
    try:
        source = formats.source_of(path, TableOptions())
        columns = source.read(list(source.names)[:3])
        assert all(len(one) in (1, columns.rows) for one in columns.values.values())
    except MotoridError:
        return


@pytest.mark.slow
@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    st.sampled_from(["log.jsonl", "plotter.txt", "plotter-tab.log"]),
    st.lists(st.tuples(st.integers(0, 3000), st.binary(max_size=4)), max_size=4),
)
def test_changed_records(tmp_path: Path, name: str, changes: list[tuple[int, bytes]]) -> None:
    data = FILES[name][0]()
    for at, put in changes:
        data = data[:at] + put + data[at + len(put) :]
    insist(tmp_path / "spoilt.txt", data)


@pytest.mark.slow
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    st.sampled_from(["arrays.npz", "table.parquet"]),
    st.lists(st.tuples(st.floats(0, 1), st.binary(min_size=1, max_size=4)), min_size=1, max_size=4),
)
def test_changed_arrays(tmp_path: Path, name: str, changes: list[tuple[float, bytes]]) -> None:
    data = FILES[name][0]()
    for share, put in changes:
        at = 4 + int(share * (len(data) - 8))
        data = data[:at] + put + data[at + len(put) :]
    insist(tmp_path / name, data)
