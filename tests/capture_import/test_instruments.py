"""Tables as oscilloscopes and loggers write them: every row is there, at its time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.capture.csv_settings import beside_readings, settings
from motorid.capture.model import CURRENT
from motorid.capture.table import read_table

N = 40
STEP = 2e-4
AMPERES = np.round(np.cos(np.arange(N) / 7.0), 3)
LATER = [f"{value:.3f}" for value in AMPERES]


def tektronix() -> str:
    left = ["Record Length,4.000000e+01", "Sample Interval,2.000000e-04", "Trigger Point,0", ","]
    left += ["Source,CH1", "Vertical Units,V", "Note,"] + [","] * N
    rows = zip(left, range(N), LATER, strict=False)
    return "".join(f"{beside},,{k * STEP:013.9f},{value}\n" for beside, k, value in rows)


def iso(separator: str, between: str, zone: str = "") -> str:
    head = separator.join(["when", "amps", "state"])
    rows = [
        separator.join([f"2026-11-23{between}23:59:59.{k * 2 + 9900:04d}{zone}", value, "1"])
        for k, value in enumerate(LATER)
    ]
    return "\n".join([head, *rows[:50]])


def joined(*header: str, time: bool, tail: str = "") -> str:
    rows = [(f"{k * STEP:.6f}" if time else str(k)) + f",{v}{tail}" for k, v in enumerate(LATER)]
    return "\n".join([*header, *rows]) + "\n"


FILES = {
    "old Rigol": (
        joined("X,CH1,Start,Increment,", "Sequence,Volt,-1.0E-03,2.0E-04", time=False, tail=",,"),
        "Start+Increment*X",
        "CH1",
    ),
    "new Rigol": (
        "\n".join(["CH1(V),t0 =-1.0e-03s, tInc = 2.0e-04s,", *(f"{v},," for v in LATER)]),
        "t0+row*tInc",
        "CH1(V)",
    ),
    "Siglent": (
        joined(
            "Record Length,Analog:40",
            "Sample Interval,Analog:2.0E-04",
            "Vertical Units,CH1:V",
            "Source,CH1",
            "Second,Volt",
            time=True,
        ),
        "row*Sample Interval",
        "Volt",
    ),
    "Keysight": (joined("x-axis,1", "second,Volt", time=True), "second", "Volt"),
    "PicoScope": (joined("Time,Channel A", "(ms),(V)", "", time=True), "Time", "Channel A"),
    "Saleae": (joined("Time [s],Channel 0", time=True), "Time [s]", "Channel 0"),
    "Tektronix": (tektronix(), "column4", "column5"),
    "dates and times": (iso(",", "T", "Z"), "when", "amps"),
    "dates and times, a blank between": (iso(";", " "), "when", "amps"),
}


@pytest.mark.parametrize("name", FILES)
def test_every_row_is_there_at_its_time(name: str, tmp_path: Path) -> None:
    text, time, amperes = FILES[name]
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    capture = read_table(path, [f"time={time}:s", f"current={amperes}:A"])
    np.testing.assert_allclose(capture.channels[CURRENT].values, AMPERES)
    np.testing.assert_allclose(capture.time_s, np.arange(N) * STEP, atol=1e-9)


def test_a_bad_date_stops_the_import_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(iso(",", "T").replace("23:59:59.9910", "23:59:60.9910"), encoding="utf-8")
    with pytest.raises(Exception, match="line 7"):
        read_table(path, ["time=when:s", "current=amps:A"])


def test_a_column_with_readings_is_no_setting() -> None:
    assert settings([["t", "i"], ["0", "5"]], ["0", "1"]) == {}
    assert settings([["t", "i", "Start"], ["", "", "5"]], ["0", "1", ""]) == {"Start": 5.0}
    assert settings([["Rate", "1000"]], ["0", "1"]) == {"Rate": 1000.0}
    assert settings([["v", "t0 =-1e-3s"]], ["0", "1"]) == {"t0": -1e-3}
    assert settings([["Time", "0.5"], ["Time", "Volt"]], ["0", "1"]) == {}
    assert not beside_readings([["t", "i", ""]], ["", "1", "2"])


CELLS = st.lists(st.lists(st.text(max_size=8), max_size=6), max_size=6)


@pytest.mark.slow
@given(CELLS, st.lists(st.text(max_size=8), max_size=6))
def test_settings_of_any_cells_are_finite_numbers(
    header: list[list[str]], first: list[str]
) -> None:
    assert np.isfinite(list(settings(header, first).values())).all()
    beside_readings(header, first)
