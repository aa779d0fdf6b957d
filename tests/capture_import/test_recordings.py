"""Logs of signals: each keeps its stamps, damage costs a sentence, a lacking package is named."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.capture import recording_child, wpilog
from motorid.capture.recording_reader import RecordingSource
from motorid.capture.table import read_table
from motorid.capture.table_options import TableOptions
from motorid.errors import DataError
from motorid.workflow.proposal.proposal import look, propose
from motorid.workflow.proposal.question import NOTHING
from tests.capture_import.corpus import recordings
from tests.capture_import.corpus.bench_log import log
from tests.capture_import.test_sheets import damaged

MAKERS = {
    "tdms": (recordings.tdms, "nptdms"),
    "mdf": (recordings.mdf, "asammdf"),
    "mcap": (recordings.mcap_json, "mcap.reader"),
}


@pytest.mark.parametrize("extra", MAKERS)
def test_without_its_package_it_says_what_to_install(
    extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, package = MAKERS[extra]
    path = tmp_path / "log.mf4"
    make(path)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(DataError, match=rf"pip install 'motorid\[{extra}\]'"):
        recording_child.main(str(path), str(tmp_path / "out.npz"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "files"),  # a library is loaded for each of them
    [(recordings.tdms, 8), (recordings.mdf, 3), (recordings.mcap_json, 8), (recordings.wpilog, 25)],
)
def test_damage_costs_a_sentence(make: recordings.Maker, files: int, tmp_path: Path) -> None:
    path = tmp_path / "log.mf4"
    make(path)
    damaged(path, lambda file: RecordingSource(file, "log"), files)


def test_signals_with_other_stamps_are_left_out_and_said(tmp_path: Path) -> None:
    """Two motors' logs at one rate, half a period apart: their readings are of no common rows."""
    path = tmp_path / "robot.wpilog"
    data = recordings.wpilog_of(
        {"/a/voltage_V": log()["voltage"], "/a/current_A": log()["current"]}
    )
    late = recordings.wpilog_of({"/b/speed_rpm": log()["speed"]}, first=4, late_us=1000)
    path.write_bytes(data + late[16:])  # without its header
    found = propose(look(path, TableOptions()), NOTHING)
    assert not found.questions
    assert "its time" in found.readings["/b/speed_rpm.value"]
    assert {m.partition("=")[0] for m in found.maps} == {"time", "voltage", "current"}


def test_what_holds_no_numbers_is_named(tmp_path: Path) -> None:
    path = tmp_path / "robot.wpilog"
    recordings.wpilog(path)
    source = RecordingSource(path, "WPILib log")
    assert "mode" in source.elsewhere
    with pytest.raises(Exception, match="mode: no signals of numbers"):
        read_table(path, ["current=mode:A"])


@pytest.mark.slow
@given(st.lists(st.floats(), min_size=1, max_size=8), st.integers(0, 60))
def test_a_log_that_is_cut_short_says_so(values: list[float], cut: int) -> None:
    data = recordings.wpilog_of({"x": np.array(values)}, last=False)
    (entry,), others = wpilog.entries(data, 100)
    np.testing.assert_array_equal(entry.values, values)
    assert others == ["mode"]
    record = 7 + 8  # the head of a record of a double, and its data
    if cut % record and cut < record * len(values):
        with pytest.raises(DataError, match="cut short"):
            wpilog.entries(data[:-cut], 100)


@pytest.mark.slow
@given(st.binary(max_size=200))
def test_any_bytes_are_a_log_or_a_sentence(data: bytes) -> None:
    for head in (b"", b"WPILOG\x00\x01\x00\x00\x00\x00"):
        with contextlib.suppress(DataError):
            found, _ = wpilog.entries(head + data, 1000)
            assert all(len(entry.stamps) == len(entry.values) for entry in found)


@pytest.mark.parametrize(
    ("columns", "rows", "numbers"), [(5000, 1, 1), (1, 10**8, 1), (1, 1, 10**9)]
)
def test_a_log_beyond_the_limits_is_refused(columns: int, rows: int, numbers: int) -> None:
    with pytest.raises(DataError, match="save a part of it"):
        recording_child.refuse(columns, rows, numbers)
    with pytest.raises(DataError, match="save a part of it"):
        wpilog.entries(recordings.wpilog_of({"x": np.zeros(600)}), 1000)
