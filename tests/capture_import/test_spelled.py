"""Units, options and small texts: what each spelling means, by figures of the units themselves."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.capture import declared
from motorid.capture.csv_header import are_units, only_unit, unit_cell, without_mark
from motorid.capture.csv_settings import beside_readings, settings, settings_beside
from motorid.capture.declared import Aperture, LowPass
from motorid.capture.facts import of_provenance
from motorid.capture.model import BUTTERWORTH, Channel, Stated
from motorid.capture.table_options import TableOptions, as_stated, stated_options
from motorid.capture.unit_spellings import usual
from motorid.capture.units import alike, spelled, unit_of, units_of
from motorid.errors import UsageError

TURN, NAN = 2 * math.pi, float("nan")


@pytest.mark.parametrize(
    ("quantity", "written", "si", "scale"),
    [
        ("time", "ns", "s", 1e-9), ("time", "us", "s", 1e-6), ("time", "min", "s", 60.0),
        ("time", "h", "s", 3600.0), ("time", "Millisecond", "s", 1e-3),
        ("current", "kA", "A", 1e3), ("current", "uA", "A", 1e-6), ("current", "mA", "A", 1e-3),
        ("supply_voltage", "kV", "V", 1e3), ("terminal_voltage", "uV", "V", 1e-6),
        ("terminal_voltage", "mV", "V", 1e-3), ("command", "V", "V", 1.0),
        ("command", "%", "1", 0.01), ("command", "", "1", 1.0), ("command", "pwm", "1", 1.0),
        ("speed", "rpm", "rad/s", TURN / 60), ("speed", "krpm", "rad/s", 1e3 * TURN / 60),
        ("speed", "RPM", "rad/s", TURN / 60), ("speed", "rps", "rad/s", TURN),
        ("speed", "Hz", "rad/s", TURN), ("speed", "deg/s", "rad/s", TURN / 360),
        ("speed", "mm/s", "m/s", 1e-3), ("speed", "m/min", "m/s", 1 / 60),
        ("set_speed", "km/h", "m/s", 1000 / 3600), ("position", "mrad", "rad", 1e-3),
        ("position", "deg", "rad", TURN / 360), ("position", "turn", "rad", TURN),
        ("position", "cm", "m", 1e-2), ("position", "um", "m", 1e-6),
        ("set_position", "mm", "m", 1e-3), ("torque", "mNm", "N·m", 1e-3),
        ("torque", "uN·m", "N·m", 1e-6), ("torque", "Ncm", "N·m", 1e-2),
        # an ounce is 28.349523125 g, a pound 16 of them, an inch 25.4 mm, g 9.80665 m/s²
        ("torque", "ozin", "N·m", 28.349523125e-3 * 9.80665 * 25.4e-3),
        ("torque", "lb-in", "N·m", 16 * 28.349523125e-3 * 9.80665 * 25.4e-3),
        ("torque", "mN", "N", 1e-3), ("torque", "kN", "N", 1e3), ("ambient", "degC", "°C", 1.0),
    ],
)  # fmt: skip
def test_a_unit_s_size(quantity: str, written: str, si: str, scale: float) -> None:
    found = unit_of(quantity, written)
    assert (found.written, found.si, found.counts) == (written, si, False)
    assert found.scale == pytest.approx(scale, rel=1e-7)


@pytest.mark.parametrize(
    ("quantity", "written", "si", "whole"),
    [
        ("position", "counts", "rad", True), ("set_position", "ticks", "rad", True),
        ("speed", "counts/s", "rad/s", False), ("set_speed", "ticks/s", "rad/s", False),
    ],
)  # fmt: skip
def test_counts_are_of_an_encoder(quantity: str, written: str, si: str, whole: bool) -> None:
    found = unit_of(quantity, written, 400.0)
    assert (found.si, found.counts) == (si, whole)
    assert found.scale == pytest.approx(TURN / 400)
    for none in (0.0, -1.0, NAN):
        with pytest.raises(UsageError, match="needs --counts-per-turn"):
            unit_of(quantity, written, none)
    other = "counts" if written.endswith("/s") else "counts/s"
    for wrong in ((quantity, other), ("current", written)):
        with pytest.raises(UsageError, match="is not a unit of"):
            unit_of(*wrong, 400.0)


def test_units_that_lead_to_a_quantity() -> None:
    assert units_of("ambient") == {"°C": ("°C", 1.0)}
    assert units_of("position")["cm"] == ("m", 1e-2)
    assert units_of("position")["rad"] == ("rad", 1.0)
    assert alike("position", "m") == {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
    assert alike("position", "A") == {}


@pytest.mark.parametrize(
    ("written", "found"),
    [("MA", "MA"), ("ma", "ma"), ("SEC", "s"), ("Sec", "s"), ("Rpm", "rpm"), ("µs", "us")],
)  # fmt: skip
def test_the_case_of_short_spellings_counts(written: str, found: str) -> None:
    assert usual(written) == found


@pytest.mark.parametrize(
    ("cell", "unit"),
    [
        ("mA", "mA"), ("[mA]", "mA"), ("current (mA)", "mA"), ("CH1:V", "V"), ("1", None),
        ("current", None), ("", None), (" ( rpm ) ", "rpm"), ("counts", "counts"),
        ("a_name_too_long:V", None),
    ],
)  # fmt: skip
def test_a_header_s_cell_may_spell_a_unit(cell: str, unit: str | None) -> None:
    assert unit_cell(cell) == unit
    assert spelled("current[mA]") == "mA"


def test_a_cell_is_a_unit_alone_or_a_name_with_one() -> None:
    cells = ("mA", "(mA)", "[mA]", "i (mA)", "speed", "CH2:A", "-")
    assert [only_unit(cell) for cell in cells] == [
        True, True, True, False, False, True, True,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("row", "units"),
    [
        (["s", "mA"], True), (["Units", "V", "A"], True), (["Y_Unit_Label", "V"], True),
        (["Horizontal Units", "s"], False), (["Einheit", "V"], True), (["V", "-"], True),
        (["units"], False), ([], False), (["s", "speed"], False), (["united", "V"], False),
    ],
)  # fmt: skip
def test_a_row_of_units(row: list[str], units: bool) -> None:
    assert are_units(row) is units


def test_a_comment_s_mark_is_no_column() -> None:
    assert without_mark(["#", "t", "i"], 2) == ["t", "i"]
    assert without_mark(["#", "t"], 2) == ["#", "t"]
    assert without_mark(["a", "t", "i"], 2) == ["a", "t", "i"]


# -- what an instrument writes beside its readings
def test_settings_above_the_readings() -> None:
    first = ["1", "2", ""]
    header = [
        ["t0 = -5e-3s", "", ""],
        ["Increment", "", "Gain"],
        [
            "",
            "2.5E-4",
            "3",
        ],  # below the name of a column that has readings, and of one that has not
        ["Vertical Offset:", "0.5", "0.5"],
        ["Sample Rate", "1000", "2000"],
        ["Start", "7"],
        ["Huge = 1e999", "Big=1"],
        ["t0 = 9", ""],
    ]
    assert settings(header, first) == {
        "t0": -5e-3, "Gain": 3.0, "Vertical Offset": 0.5, "Start": 7.0, "Big": 1.0,
    }  # fmt: skip


def test_settings_left_of_the_readings() -> None:
    rows = [
        ["Samples", "1000", "0.0", "1.5"],
        ["Model", "TDS", "0.1", "1.6"],
        ["", "5", "0.2", "1"],
    ]
    first = ["", "", "0.3", "1.7"]
    assert beside_readings(rows, first)
    assert settings_beside([*rows, ["x"], ["Samples", "7"], ["Big", "1e999"]]) == {
        "Samples": 1000.0
    }
    assert settings_beside([["Samples", "1000"]]) == {"Samples": 1000.0}
    assert not beside_readings([], first)
    assert not beside_readings(rows, ["", "5", "0.3", "1.7"])  # one column is no setting
    assert not beside_readings([*rows, ["a", "b", "0.4"]], first)
    assert not beside_readings([["a", "b", "0.4", "x"]], first)


# -- what a person states
@pytest.mark.parametrize(
    ("given", "found"),
    [
        ("100ms", Aperture(0.1)), ("100ms,around", Aperture(0.1, "around")),
        ("100ms, after", Aperture(0.1, "after")), ("instant", Aperture(0.0)),
    ],
)  # fmt: skip
def test_an_aperture_lies_about_its_stamp(given: Any, found: Aperture) -> None:
    assert declared.aperture("current", given) == found
    share = {"before": 0.0, "around": 0.5, "after": 1.0}[found.place]
    assert found.ahead_s == pytest.approx(share * found.seconds)


@pytest.mark.parametrize(
    ("given", "time_s", "order", "damping"),
    [
        ("2kHz", 1 / (TURN * 2000), 1, 1.0), ("2MHz,1", 1 / (TURN * 2e6), 1, 1.0),
        ("20Hz, 2", 1 / (TURN * 20), 2, BUTTERWORTH), ("8ms,2", 8e-3, 2, 1.0),
        (0.004, 0.004, 1, 1.0),
        ("0", 0.0, 1, 1.0),
    ],
)  # fmt: skip
def test_a_low_pass(given: Any, time_s: float, order: int, damping: float) -> None:
    assert declared.low_pass("current", given) == LowPass(pytest.approx(time_s), order, damping)


def test_a_delay_of_a_million_seconds_is_the_longest() -> None:
    assert declared.duration("--delay", "x", "1e6") == 1e6
    assert declared.duration("--delay", "x", "-1e6s", negative=True) == -1e6
    for wrong in ("1.01e6", "-1.01e6"):
        with pytest.raises(UsageError, match="no capture is so long"):
            declared.duration("--delay", "x", wrong, negative=True)
    with pytest.raises(UsageError, match="give seconds, 0 or more"):
        declared.duration("--delay", "x", "-1us")


@pytest.mark.parametrize(
    ("given", "good"),
    [
        ("0.5,s,1e-9", True),
        ("0.51,s,20", False),
        ("0,bow,1", True),
        ("0.1,s,0", False),
        ("0.1,odd,20", False),
        ("-0.1,s,20", False),
        ("0.1,s,20A", False),
        ("0.1,s,", False),
    ],
)
def test_a_sensor_s_non_linearity(given: str, good: bool) -> None:
    if good:
        share, shape, full = given.split(",")
        found = declared.nonlinearity("current", given)
        assert (found.share, found.shape, found.full_scale) == (float(share), shape, float(full))
    else:
        with pytest.raises(UsageError, match="give a share of full scale"):
            declared.nonlinearity("current", given)


@pytest.mark.parametrize(
    ("given", "good"),
    [
        ("0.5,2s", True),
        ("0,1ms", True),
        ("0.51,2s", False),
        ("0.1,0s", False),
        ("-0.1,2s", False),
        ("x,2s", False),
    ],
)
def test_a_reference_s_drift(given: str, good: bool) -> None:
    if good:
        share, time = given.split(",")
        seconds = {"2s": 2.0, "1ms": 1e-3}[time]
        assert declared.drift(given) == {
            "reference_drift": float(share), "reference_time_s": pytest.approx(seconds),
        }  # fmt: skip
    else:
        with pytest.raises(UsageError, match="give a share and a time above 0"):
            declared.drift(given)


def test_all_channels_are_later_by_the_earliest_reading() -> None:
    channels = {
        "a": Channel("a", "", np.zeros(1), delay_s=-0.2),
        "b": Channel("b", "", np.zeros(1), delay_s=0.5, filter_s=0.1),
        "c": Channel("c", "", np.zeros(1), delay_s=0.1, filter_s=0.4),
    }
    found = declared.without_early_readings(channels)
    assert {n: c.delay_s for n, c in found.items()} == pytest.approx({"a": 0.1, "b": 0.8, "c": 0.4})
    fine = {"b": channels["b"]}
    assert declared.without_early_readings(fine)["b"] is channels["b"]
    assert declared.without_early_readings({}) == {}


def test_a_channel_as_options_state_it() -> None:
    chosen = TableOptions(
        aperture={"voltage": "4ms,around"}, delay={"terminal_voltage": "-1ms"},
        delay_uncertainty={"voltage": "20us"}, filter={"voltage": "3ms,2"},
        offset_uncertainty={"voltage": 0.0},
    )  # fmt: skip
    found = as_stated(Channel("terminal_voltage", "V", np.zeros(1)), chosen)
    assert (found.kind, found.aperture_s) == ("mean", 4e-3)
    # late by -1 ms, seen 2 ms ahead, and behind two stages of 3 ms
    assert found.delay_s == pytest.approx(-1e-3 - 2e-3 + 6e-3)
    assert (found.delay_uncertainty_s, found.filter_s, found.filter_order) == (
        pytest.approx(2e-5), pytest.approx(3e-3), 2,
    )  # fmt: skip
    assert (found.gain_uncertainty, found.offset_uncertainty) == (0.0, 0.0)
    assert found.undeclared == ("gain",)
    bare = as_stated(Channel("current", "A", np.zeros(1)), chosen)
    assert (bare.kind, bare.delay_s, len(bare.undeclared)) == ("instant", 0.0, 5)
    counted = as_stated(Channel("position", "rad", np.zeros(1)), chosen, counted=True)
    assert "gain" not in counted.undeclared
    bent = replace(
        chosen, nonlinearity={"current": "0.01,bow,20"}, gain_uncertainty={"current": 0.5}
    )
    found = as_stated(Channel("current", "A", np.zeros(1)), bent)
    assert (found.nonlinearity, found.nonlinearity_shape, found.full_scale) == (0.01, "bow", 20.0)
    assert found.gain_uncertainty == 0.5
    assert set(stated_options(bent)) == {
        "aperture", "delay", "delay_uncertainty", "filter", "gain_uncertainty",
        "offset_uncertainty", "nonlinearity",
    }  # fmt: skip
    assert stated_options(TableOptions(delay={"x": 1.0})) == {"delay": {"x": 1.0}}


def test_what_a_rig_s_text_and_an_import_state() -> None:
    rig = "[nameplate]\nresistance_ohm = 2\nvoltage_v = true\n[thermal]\nwinding_s = nan\n"
    stated = {"nameplate": {"resistance_ohm": 9, "inductance_h": 0.5}, "thermal": 3}
    found = of_provenance({"rig": rig, "stated": stated})
    assert (found.nameplate, found.thermal) == ({"resistance_ohm": 2.0, "inductance_h": 0.5}, {})
    assert found.unread.endswith("gives no number for nameplate.voltage_v, thermal.winding_s")
    assert of_provenance({"stated": stated}).unread.endswith("gives no number for thermal")
    assert of_provenance({"stated": 5}).unread == "what the import stated of the motor is no table"
    assert of_provenance({"rig": 5}).unread == "the rig's file kept in the capture is no text"
    assert "is no TOML" in of_provenance({"rig": "["}).unread
    assert of_provenance({}) == Stated()
