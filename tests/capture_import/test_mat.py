"""MAT files: read in a process of their own, whatever it does."""

from __future__ import annotations

import struct
import sys
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import scipy.sparse

from motorid import limits
from motorid.capture import child, mat_child, mat_reader
from motorid.capture.mat_reader import MatSource
from motorid.capture.table import read_table
from motorid.errors import DataError, UsageError


def test_version_5_vectors_scalars_and_structs(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    t = np.arange(50) * 1e-3
    log = {"w": np.sin(t)[:, None], "deep": {"i": np.cos(t)[None, :]}}
    scipy.io.savemat(path, {"t": t[:, None], "gain": 3.0, "log": log, "name": "text"})
    capture = read_table(path, ["time=t:s", "torque=w*gain:N·m", "speed=log.deep.i:rad/s"])
    assert capture.channels["torque"].values == pytest.approx(3 * np.sin(t))
    assert capture.channels["speed"].values == pytest.approx(np.cos(t))


def test_linear_units_stay_linear(tmp_path: Path) -> None:
    path = tmp_path / "axis.mat"
    scipy.io.savemat(path, {"t": np.arange(9.0), "x": np.arange(9.0), "f": np.ones(9)})
    capture = read_table(path, ["time=t:s", "position=x:mm", "torque=f:kN"])
    assert capture.channels["position"].unit == "m"
    assert capture.channels["torque"].unit == "N"
    assert capture.channels["torque"].values[0] == 1000


def test_version_7_3_object_references(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        data = file.create_dataset("rec/X/Data", data=np.arange(20.0)[None, :] / 100)
        data.attrs["MATLAB_class"] = np.bytes_(b"double")
        cells = file.create_dataset("rec/Y/Data", (2, 1), dtype=h5py.ref_dtype)
        for k in range(2):
            target = file.create_dataset(f"#refs#/{k}", data=np.arange(20.0)[None, :] * (k + 1))
            cells[k, 0] = target.ref
    capture = read_table(path, ["time=X.Data:s", "speed=Y[2].Data:rpm"])
    assert capture.channels["speed"].raw[3] == 6


def test_links_to_other_files_are_not_followed(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["secret"] = np.arange(20.0)
    path = tmp_path / "run.mat"
    with h5py.File(path, "w") as file:
        file["t"] = np.arange(20.0)
        file["x"] = h5py.ExternalLink("other.h5", "secret")
        file["again"] = h5py.SoftLink("/t")
    assert set(MatSource(path).names) == {"t"}


def test_columns_of_different_length_are_named(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"t": np.arange(50.0), "i": np.arange(40.0)})
    with pytest.raises(DataError, match=r"t has 50, i has 40"):
        read_table(path, ["time=t:s", "current=i:A"])


def test_unknown_name_lists_what_there_is(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"t": np.arange(50.0), "cur": np.arange(50.0)})
    with pytest.raises(UsageError, match="cur"):
        read_table(path, ["time=t:s", "current=curr:A"])


def test_nan_is_named(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    values = np.ones(30)
    values[7] = np.nan
    scipy.io.savemat(path, {"t": np.arange(30.0), "i": values})
    with pytest.raises(DataError, match="element 8, column 'i'"):
        read_table(path, ["time=t:s", "current=i:A"])
    assert len(read_table(path, ["time=t:s", "current=i:A"], drop_bad=True)) == 29


@pytest.mark.parametrize("size", [0, 4, 128, 300, 600])
def test_truncated_files_are_one_sentence(tmp_path: Path, size: int) -> None:
    whole = tmp_path / "whole.mat"
    scipy.io.savemat(whole, {"t": np.arange(500.0), "i": np.arange(500.0)})
    path = tmp_path / "cut.mat"
    path.write_bytes(whole.read_bytes()[:size])
    with pytest.raises((DataError, UsageError)) as caught:
        read_table(path, ["time=t:s", "current=i:A"])
    assert "\n" not in str(caught.value)


def as_child(monkeypatch: pytest.MonkeyPatch, folder: Path, code: str) -> Path:
    """Replaces the reading program by another one."""
    program = folder / "child.py"
    program.write_text(code)
    monkeypatch.setattr(mat_child, "__file__", str(program))
    path = folder / "run.mat"
    path.write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    return path


def test_reader_that_crashes_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = as_child(monkeypatch, tmp_path, "import os\nos.abort()\n")
    with pytest.raises(DataError, match="cannot be read as a MAT file"):
        MatSource(path)


@pytest.mark.slow
def test_reader_that_hangs_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = as_child(monkeypatch, tmp_path, "import time\ntime.sleep(60)\n")
    monkeypatch.setattr(child, "PATIENCE_S", 0.5)
    began = time.monotonic()
    with pytest.raises(DataError, match=r"more than 0\.5 s"):
        MatSource(path)
    assert time.monotonic() - began < 50  # of the 60 that it sleeps


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="memory limits are Linux's alone")
def test_reader_that_eats_memory_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"t": np.zeros(4_000_000)}, do_compression=True)
    monkeypatch.setattr(mat_reader, "MAT", replace(limits.MAT, memory=16 << 20))
    with pytest.raises(DataError, match="cannot be read as a MAT file"):
        MatSource(path)


# -- what only MATLAB reads
def test_a_matrix_is_addressed_by_columns_and_by_rows(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    wide = np.stack([np.arange(80.0) / 100, np.arange(80.0) * 2, np.arange(80.0) ** 2])
    scipy.io.savemat(path, {"rec": wide, "log": wide.T, "few": wide[:, :5]})
    by_rows = read_table(path, ["time=rec[1,:]:s", "speed=rec[3,:]:rad/s", "current=rec[2,:]/2:A"])
    by_columns = read_table(path, ["time=log[1]:s", "speed=log[3]:rad/s", "current=log[2]/2:A"])
    for name in ("speed", "current"):
        assert np.array_equal(by_rows.channels[name].raw, by_columns.channels[name].raw)
    few = read_table(path, ["time=few[1,:]:s", "speed=few[3,:]:rad/s"])
    assert list(few.channels["speed"].raw) == [0, 1, 4, 9, 16]
    with pytest.raises(UsageError, match="no column 'rec"):
        read_table(path, ["time=rec[1]:s", "speed=rec[3,:]:rad/s"])


def test_samples_along_a_third_axis_are_rows_too(tmp_path: Path) -> None:
    path = tmp_path / "run.mat"
    data = np.arange(40.0).reshape(1, 2, 20)
    scipy.io.savemat(path, {"t": np.arange(20.0), "y": data, "cube": np.zeros((2, 3, 4))})
    capture = read_table(path, ["time=t:s", "speed=y[2,:]:rad/s"])
    assert capture.channels["speed"].raw[0] == 20
    assert not any(name.startswith("cube") for name in MatSource(path).names)


def version_7_3(path: Path) -> None:
    """As MATLAB stores a timeseries, a Simulink stream and its own bookkeeping."""
    with h5py.File(path, "w", userblock_size=512) as file:
        t = file.create_dataset("t", data=np.arange(20.0)[None, :])
        t.attrs["MATLAB_class"] = np.bytes_(b"double")
        ts = file.create_dataset("log/ts", data=np.array([[3707764736, 2, 1, 1, 1, 1]], "u4"))
        ts.attrs["MATLAB_class"] = np.bytes_(b"timeseries")
        ts.attrs["MATLAB_object_decode"] = np.int32(3)
        file["#sigstream#/blob"] = np.arange(20, dtype="u1")
        file["#subsystem#/MCOS"] = np.arange(20, dtype="u4")
        file["raw"] = np.arange(20, dtype="u1")
        duty = file.create_dataset("duty", data=np.arange(20, dtype="u1")[None, :])
        duty.attrs["MATLAB_class"] = np.bytes_(b"uint8")


@pytest.mark.slow
def test_no_raw_bytes_and_no_object_are_taken_for_readings(tmp_path: Path) -> None:
    path = tmp_path / "out.mat"
    version_7_3(path)
    assert set(MatSource(path).names) == {"t", "duty"}
    for column in ("ts", "log.ts.Data", "blob", "raw", "#sigstream#.blob"):
        with pytest.raises(UsageError, match="the file has no column") as caught:
            read_table(path, ["time=t:s", f"voltage={column}:V"])
        said = str(caught.value)
        assert "log.ts is a timeseries" in said
        assert "#sigstream# is a Simulink signal stream" in said
        assert "raw is a block of raw bytes" in said
        assert "save('plain.mat', 't', 'y')" in said
    own = read_table(path, ["time=t:s", "command=duty:1"])  # MATLAB's own numbers of 8 bits
    assert own.channels["command"].raw[19] == 19


def element(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def version_5(path: Path, what: bytes) -> None:
    """A file of version 5 with an object beside a vector."""
    scipy.io.savemat(path, {"t": np.arange(20.0)})
    numbers = struct.pack("<6I", 0xDD000000, 2, 1, 1, 1, 1)
    flags, shape = element(6, struct.pack("<II", 13, 0)), element(5, struct.pack("<ii", 6, 1))
    inner = element(14, flags + shape + element(1, b"") + element(6, numbers))
    names = element(1, b"speeds") + element(1, b"MCOS") + element(1, what)
    opaque = element(14, element(6, struct.pack("<II", 17, 0)) + names + inner)
    path.write_bytes(path.read_bytes() + opaque)


@pytest.mark.parametrize(
    ("what", "how"),
    [
        (b"timeseries", "y = speeds.Data"),
        (b"timetable", "writetimetable(speeds, 'plain.csv')"),
        (b"table", "writetable(speeds, 'plain.csv')"),
        (b"Simulink.SimulationData.Dataset", "speeds.getElement(1).Values"),
        (b"Simulink.SimulationOutput", "speeds.logsout{1}.Values"),
        (b"duration", "t = seconds(speeds)"),
        (b"string", "save its arrays as plain variables"),
    ],
)
def test_an_object_is_named_for_what_it_is(tmp_path: Path, what: bytes, how: str) -> None:
    path = tmp_path / "run.mat"
    version_5(path, what)
    with pytest.raises(
        UsageError, match=f"speeds is a {what.decode()}, which only MATLAB"
    ) as caught:
        read_table(path, ["time=t:s", "speed=speeds.Data:rad/s"])
    assert how in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(MatSource(path).names) == 1


def test_a_sparse_matrix_is_no_three_columns(tmp_path: Path) -> None:
    path = tmp_path / "old.mat"
    scipy.io.savemat(path, {"t": np.arange(20.0), "y": scipy.sparse.eye(20).tocsc()})
    new = tmp_path / "new.mat"
    with h5py.File(new, "w", userblock_size=512) as file:
        file["t"] = np.arange(20.0)
        group = file.create_group("y")
        group.attrs["MATLAB_sparse"] = np.uint64(20)
        group["data"], group["ir"] = np.ones(20), np.arange(20, dtype="u8")
    for file in (path, new):
        with pytest.raises(UsageError, match=r"y is a sparse matrix, .* y = full\(y\)"):
            read_table(file, ["time=t:s", "speed=data:rad/s"])
