"""Which reader takes a file, what nobody stated, and what an estimate cites of a capture."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture import formats, store, store_read
from motorid.capture.array_source import ArraySource
from motorid.capture.declared import LONGEST_S, aperture, duration, low_pass
from motorid.capture.formats import Format
from motorid.capture.model import Capture, Channel, Gap, Wiring
from motorid.capture.table import read_table
from motorid.capture.table_options import TableOptions
from motorid.errors import DataError, UsageError
from motorid.limits import CAPTURE


# -- kinds of files
@pytest.mark.parametrize(
    ("suffix", "head", "kind"),
    [
        (".mat", b"x", "MAT file"), (".x", b"MATLAB 5.0", "MAT file"),
        (".h5", b"\x89HDF\r\n", "MAT file"), (".x", b"PAR1", "Parquet"),
        (".parquet", b"a,b\n1,2\n", "text table"), (".npz", b"PK\3\4", "NPZ"),
        (".npz", b"1,2\n", "text table"), (".zip", b"PK\3\4", "text table"),
        (".xlsx", b"PK\3\4", "spreadsheet"), (".ods", b"PK\3\4", "spreadsheet"),
        (".xls", b"\xd0\xcf\x11\xe0", "spreadsheet"), (".xls", b"t\ti\n1\t2\n", "text table"),
        (".doc", b"\xd0\xcf\x11\xe0", "text table"), (".csv", b"WPILOG\0\1", "WPILib data log"),
        (".x", b"TDSm", "TDMS"), (".x", b"MDF     4.10", "MDF"), (".x", b"MDF 4.10", "text table"),
        (".x", b"\x89MCAP0\r\n", "MCAP"), (".x", b'{"a": 1}\n{"a": 2}\n', "JSON lines"),
        (".x", '{"a": 1}\n{"a": 2}\n'.encode("utf-16"), "JSON lines"),
        (".x", b"a:1 b:2\na:3 b:4\n", "labelled lines"), (".x", b"a,b\n1,2\n", "text table"),
        (".x", b"", "text table"), (".x", b"a:1\n" * 50 + b"1,2\n" * 90, "labelled lines"),
    ],
)  # fmt: skip
def test_a_file_s_reader_is_known_by_its_beginning(suffix: str, head: bytes, kind: str) -> None:
    assert next(one.name for one in formats.TABLE if one.takes(suffix, head)) == kind


def test_the_first_reader_that_takes_a_file_reads_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, options = tmp_path / "A.ODD", TableOptions()
    path.write_bytes(b"ab" * 10_000)
    asked: list[Any] = []

    def reads(name: str, takes: bool) -> Format:
        def ask(suffix: str, head: bytes) -> bool:
            asked.append((name, suffix, len(head)))
            return takes

        return Format(name, ask, lambda *order: (name, *order))  # type: ignore[arg-type, return-value]

    table = reads("one", False), reads("two", True), reads("three", True)
    monkeypatch.setattr(formats, "TABLE", table)
    assert formats.source_of(path, options) == ("two", path, options)
    assert asked == [("one", ".odd", 16384), ("two", ".odd", 16384)]


def test_columns_and_short_names_come_first(tmp_path: Path) -> None:
    arrays = {"k": np.array([7.0]), "g.v": np.array([1.0, 2.0]), "w": np.array([1.0, 2.0, 3.0])}
    source = ArraySource(tmp_path, arrays, "arrays")
    assert list(source.names) == ["v", "w", "g.v", "k"]
    assert [one.name for one in source.described] == ["v", "w"]


# -- what nobody stated
def test_a_rig_of_which_nobody_states_anything_changes_no_reading() -> None:
    known = vars(Wiring())
    assert known.pop("gear_ratio") == 1.0
    assert {name for name, value in known.items() if value is None} == {
        "brush_drop_v", "reference_drift", "pwm_alignment",
    }  # fmt: skip
    assert {value for value in known.values() if value is not None} == {0.0}


def test_a_channel_of_which_nobody_states_anything_is_exact() -> None:
    raw = np.array([-1e300, 2.0])
    channel = Channel("x", "V", raw)
    assert channel.values.tolist() == raw.tolist()
    assert not channel.saturated.any()
    assert (channel.kind, channel.filter_order, channel.filter_damping) == ("instant", 1, 1.0)
    unknown = ("pwm_phase", "sense", "nonlinearity_shape")
    assert [getattr(channel, name) for name in unknown] == [None] * 3
    assert (channel.unsigned, channel.ratiometric, channel.undeclared) == (False, False, ())
    zero = ("aperture_s", "delay_s", "resolution", "noise", "gain_uncertainty", "filter_s",
            "offset_uncertainty", "delay_uncertainty_s", "nonlinearity", "full_scale",
            "step_uncertainty")  # fmt: skip
    assert {getattr(channel, name) for name in zero} == {0.0}


def capture(**more: Any) -> Capture:
    return Capture(np.array([10, 20, 40]), 4.0, {}, **more)


def test_a_capture_of_which_nobody_states_anything() -> None:
    one = capture()
    assert (one.clock_uncertainty, one.ambient_c, one.ambient_uncertainty_c) == (0.0, None, 0.0)
    assert (one.program, one.phases, one.gaps, one.end_reason) == (None, (), (), "completed")
    assert (one.sha256, one.content_sha256, one.path) == ("", "", "")
    assert one.supply_v is one.supply_measured_v is None


def test_times_beyond_any_capture_are_none() -> None:
    assert duration("--delay", "x", f"{LONGEST_S:g}s") == LONGEST_S
    assert duration("--delay", "x", -LONGEST_S, negative=True) == -LONGEST_S
    assert low_pass("x", f"{LONGEST_S:g}s").time_s == LONGEST_S
    assert aperture("x", LONGEST_S).seconds == LONGEST_S
    for read in (low_pass, aperture, lambda name, text: duration("--delay", name, text)):
        with pytest.raises(UsageError, match="no capture is so long"):
            read("x", f"{1.01 * LONGEST_S:g}s")


@pytest.mark.parametrize(("unit", "good"), [("s", True), ("h", False)])
def test_a_time_column_of_centuries_has_a_wrong_unit(unit: str, good: bool, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,i\n0,1\n2e6,2\n4e6,3\n")  # ticks of a nanosecond are integers of 64 bits
    maps = [f"time=t:{unit}", "current=i:A"]
    if good:
        assert read_table(path, maps).time_s.tolist() == [0.0, 2e6, 4e6]
    else:
        with pytest.raises(DataError, match=r"spans 1\.44e\+10 s: is its unit right"):
            read_table(path, maps)


# -- what is cited
CITED = {"name": "c", "sha256": "s", "date": "d", "oldest": "2026-01-01T00:00:00+00:00",
         "oldest_part": "p", "max_age_days": 0}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "cited"),
    [
        ({}, True), ({"max_age_days": "7.5"}, True), ({"max_age_days": -1}, False),
        ({"max_age_days": None}, False), ({"max_age_days": "x"}, False),
        ({"oldest": "2026-01-01T00:00:00"}, False), ({"oldest": "long ago"}, False),
        *(({name: 5}, False) for name in ("name", "sha256", "date", "oldest", "oldest_part")),
    ],
)  # fmt: skip
def test_a_calibration_is_cited_by_all_that_a_reader_needs(change: Any, cited: bool) -> None:
    file = {**CITED, **change}
    said = store.describe(capture(provenance={"calibration_file": file}))
    assert said.get("calibration") == (file if cited else None)
    for name in CITED:
        rest = {key: value for key, value in CITED.items() if key != name}
        assert "calibration" not in store.describe(capture(provenance={"calibration_file": rest}))
    assert "calibration" not in store.describe(capture(provenance={"calibration_file": "c"}))


def test_what_an_estimate_cites_of_its_input() -> None:
    rig = "[rig]\nname = 'Ω'"
    provenance = {"serial": "M17", "created": "today", "rig_name": "bench", "rig": rig,
                  "reanalysed": {"by": "x"}, "note": "not cited"}  # fmt: skip
    gaps = Gap(1, 3, "lost"), Gap(2, 4, "lost")
    said = store.describe(
        capture(
            provenance=provenance, gaps=gaps, sha256="abc", path="a.h5", ambient_c=21.0,
            ambient_uncertainty_c=0.5, end_reason="stopped",
        )
    )  # fmt: skip
    assert said == {
        "path": "a.h5", "sha256": "abc", "samples": 3, "gaps": 7, "end_reason": "stopped",
        "ambient_c": 21.0, "ambient_uncertainty_c": 0.5, "serial": "M17", "duration_s": 7.5,
        "created": "today", "rig_name": "bench", "reanalysed": {"by": "x"},
        "rig_sha256": hashlib.sha256(rig.encode()).hexdigest(),
    }  # fmt: skip
    silent = store.describe(capture(provenance={"created": 5, "rig_name": None, "rig": ""}))
    assert not {"created", "rig_name", "rig_sha256", "reanalysed"} & set(silent)
    assert silent["serial"] == ""


# -- files of captures
def test_a_capture_is_not_saved_under_the_name_of_another_kind(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="says that it is a table"):
        store.save(capture(), tmp_path / "a.csv")
    assert list(tmp_path.iterdir()) == []


def test_a_capture_of_more_samples_than_are_read_is_refused() -> None:
    assert CAPTURE.rows is not None
    store.refuse_long(Path("a.h5"), CAPTURE.rows)
    with pytest.raises(DataError, match="50,000,001 samples are more than a capture may have"):
        store.refuse_long(Path("a.h5"), CAPTURE.rows + 1)


def test_the_content_of_an_own_file_is_not_looked_through_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(*_: Any) -> str:
        raise AssertionError("looked through")

    path = store.save(capture(), tmp_path / "a.h5")
    monkeypatch.setattr(store_read, "checked", none)
    found = store.load(path)
    assert found.ticks.tolist() == [10, 20, 40]
    assert len(found.content_sha256) == 64
    monkeypatch.setattr(store, "CAPTURE", replace(CAPTURE, file=99))
    with pytest.raises(DataError, match=r"a file of its kind \(capture\) may have 99 B"):
        store.load(path)
    assert found.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    with pytest.raises(AssertionError, match="looked through"):
        store_read.read(path.read_bytes(), str(path), found.sha256)
