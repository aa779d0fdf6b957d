"""MAT files: read in a process of their own, whatever it does."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

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


def test_reader_that_hangs_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = as_child(monkeypatch, tmp_path, "import time\ntime.sleep(60)\n")
    monkeypatch.setattr(child, "PATIENCE_S", 0.5)
    began = time.monotonic()
    with pytest.raises(DataError, match=r"more than 0\.5 s"):
        MatSource(path)
    assert time.monotonic() - began < 50  # of the 60 that it sleeps


@pytest.mark.skipif(sys.platform != "linux", reason="memory limits are Linux's alone")
def test_reader_that_eats_memory_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"t": np.zeros(4_000_000)}, do_compression=True)
    monkeypatch.setattr(mat_reader, "MAT", replace(limits.MAT, memory=16 << 20))
    with pytest.raises(DataError, match="cannot be read as a MAT file"):
        MatSource(path)
