"""What a person may say beside the columns: ranges, names, and what a channel keeps of it."""

from __future__ import annotations

from math import inf, nan, pi
from typing import Any

import numpy as np
import pytest

from motorid.capture import table
from motorid.capture.mapping import Formula, parse_maps
from motorid.capture.model import Channel
from motorid.capture.table_options import (
    TableOptions,
    as_stated,
    insist_options,
    stated_options,
)
from motorid.capture.units import QUANTITIES, Unit, spelled, unit_of, units_of
from motorid.capture.wrapped_position import continued
from motorid.errors import UsageError

MAPPED = parse_maps(["time=t:s", "current=i:A", "voltage=v:V", "position=x:m"])
TURNING = parse_maps(["position=x:rad"])


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"gain_uncertainty": {"current": inf}}, "--gain-uncertainty current=inf: give a relative"),
        ({"gain_uncertainty": {"current": -0.1}}, "--gain-uncertainty current=-0.1: give a"),
        ({"gain_uncertainty": {"current": nan}}, "--gain-uncertainty current=nan"),
        ({"offset_uncertainty": {"current": inf}}, "give a standard uncertainty in SI units, 0 or"),
        ({"gain_uncertainty": {"speed": 0.1}}, "--gain-uncertainty speed: no such map"),
        ({"unsigned": ["speed"]}, "--unsigned speed: no such map"),
        *(({name: {"speed": "1ms"}}, f"--{name.replace('_', '-')} speed: no such map")
          for name in ("aperture", "delay", "delay_uncertainty", "filter", "nonlinearity")),
        ({"eccentricity": 0.1}, "no angle is mapped"),
        ({"separator": ""}, "give one ASCII character"),
        ({"separator": ";;"}, "give one ASCII character"),
        ({"separator": "§"}, "give one ASCII character"),
        ({"separator": "5"}, "give one ASCII character"),
        ({"decimal": ";"}, "--decimal ';' is neither"),
        ({"separator": ",", "decimal": ","}, "--separator and --decimal are both ','"),
        ({"separator": ";", "thousands": ";"}, "--thousands ';' is none of"),
        ({"thousands": ""}, "--thousands '' is none of"),
        ({"thousands": ".."}, "--thousands '..' is none of"),
        ({"separator": ",", "thousands": ","}, "--separator and --thousands are both ','"),
        ({"decimal": ".", "thousands": "."}, "--decimal and --thousands are both '.'"),
        ({"sense": "odd"}, "--sense 'odd' is none of terminals, bridge, supply, command"),
    ],
)  # fmt: skip
def test_what_is_no_option_is_refused(options: dict[str, Any], says: str) -> None:
    with pytest.raises(UsageError) as caught:
        insist_options(TableOptions(**options), MAPPED)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    "options",
    [
        {}, {"gain_uncertainty": {"current": 0.0, "voltage": 5.0}}, {"unsigned": ["current"]},
        {"delay": {"voltage": "1ms"}}, {"delay": {"terminal_voltage": "1ms"}},
        {"separator": ";", "decimal": ",", "thousands": "."}, {"separator": "\t"},
        {"separator": ",", "decimal": "."}, {"thousands": "'"}, {"sense": "command"},
    ],
)  # fmt: skip
def test_what_is_an_option(options: dict[str, Any]) -> None:
    insist_options(TableOptions(**options), MAPPED)


def test_only_an_angle_has_an_encoder_s_eccentricity() -> None:
    insist_options(TableOptions(eccentricity=0.1), TURNING)
    with pytest.raises(UsageError, match="no angle is mapped"):
        insist_options(TableOptions(eccentricity=0.1), parse_maps(["current=i:A"]))


def test_a_channel_keeps_what_is_stated_of_it() -> None:
    chosen = TableOptions(
        aperture={"voltage": "8ms,around"}, delay={"voltage": "3ms"}, filter={"voltage": "2ms,2"},
        delay_uncertainty={"voltage": "20us"}, gain_uncertainty={"voltage": 0.01},
        offset_uncertainty={"terminal_voltage": 0.5}, nonlinearity={"current": "0.003,s,20"},
    )  # fmt: skip
    volts = as_stated(Channel("terminal_voltage", "V", np.zeros(2)), chosen)
    assert (volts.kind, volts.aperture_s) == ("mean", pytest.approx(8e-3))
    # 4 ms of the aperture lie behind the stamp, and two stages of 2 ms delay by 4 ms
    assert volts.delay_s == pytest.approx(3e-3 - 4e-3 + 4e-3)
    assert (volts.filter_s, volts.filter_order, volts.filter_damping) == (pytest.approx(2e-3), 2, 1)
    assert volts.delay_uncertainty_s == pytest.approx(20e-6)
    assert (volts.gain_uncertainty, volts.offset_uncertainty, volts.undeclared) == (0.01, 0.5, ())
    assert volts.nonlinearity_shape is None
    amperes = as_stated(Channel("current", "A", np.zeros(2)), chosen)
    assert (amperes.kind, amperes.delay_s, amperes.aperture_s) == ("instant", 0.0, 0.0)
    assert (amperes.nonlinearity, amperes.nonlinearity_shape, amperes.full_scale) == (
        0.003,
        "s",
        20,
    )
    assert amperes.undeclared == ("gain", "offset", "delay", "filter", "aperture")
    counted = as_stated(Channel("position", "rad", np.zeros(2)), chosen, counted=True)
    assert counted.undeclared == ("offset", "delay", "filter", "aperture")
    assert counted.gain_uncertainty == 0.0
    assert set(stated_options(chosen)) == {
        "aperture", "delay", "delay_uncertainty", "filter", "gain_uncertainty",
        "offset_uncertainty", "nonlinearity",
    }  # fmt: skip
    assert stated_options(chosen)["delay"] == {"voltage": "3ms"}
    assert stated_options(TableOptions()) == {}


# -- units
@pytest.mark.parametrize(
    ("quantity", "written", "scale", "si"),
    [
        ("time", "ms", 1e-3, "s"), ("time", "h", 3600.0, "s"), ("current", "mA", 1e-3, "A"),
        ("voltage", "kV", 1e3, "V"), ("speed", "rpm", pi / 30, "rad/s"),
        ("speed", "krpm", 1e3 * pi / 30, "rad/s"), ("speed", "Hz", 2 * pi, "rad/s"),
        ("speed", "deg/s", pi / 180, "rad/s"), ("speed", "km/h", 1 / 3.6, "m/s"),
        ("speed", "m/min", 1 / 60, "m/s"), ("position", "deg", pi / 180, "rad"),
        ("position", "turn", 2 * pi, "rad"), ("position", "um", 1e-6, "m"),
        ("torque", "N·cm", 1e-2, "N·m"), ("torque", "oz·in", 0.028349523125 * 9.80665 * 0.0254,
         "N·m"), ("torque", "lb·in", 0.45359237 * 9.80665 * 0.0254, "N·m"),
        ("torque", "kN", 1e3, "N"), ("command", "%", 1e-2, "1"), ("command", "V", 1.0, "V"),
    ],
)  # fmt: skip
def test_how_many_si_units_make_one(quantity: str, written: str, scale: float, si: str) -> None:
    name = {"voltage": "terminal_voltage"}.get(quantity, quantity)
    found = unit_of(name, written)
    assert (found.written, found.si, found.counts) == (written, si, False)
    assert found.scale == pytest.approx(scale, rel=1e-7)


def test_counts_are_of_a_turn() -> None:
    found = unit_of("position", "counts", 0.5)
    assert (found.scale, found.si, found.counts) == (pytest.approx(4 * pi), "rad", True)
    speed = unit_of("speed", "counts/s", 400.0)
    assert (speed.scale, speed.si, speed.counts) == (pytest.approx(pi / 200), "rad/s", False)
    for turn in (0.0, -1.0):
        with pytest.raises(UsageError, match="position in counts needs --counts-per-turn"):
            unit_of("position", "counts", turn)
    with pytest.raises(UsageError, match="needs --counts-per-turn"):
        unit_of("set_speed", "counts/s")
    for quantity, unit in (("speed", "counts"), ("position", "counts/s"), ("current", "counts")):
        with pytest.raises(UsageError, match=f"'{unit}' is not a unit of {quantity}$"):
            unit_of(quantity, unit, 400.0)


@pytest.mark.parametrize(
    ("cell", "unit"),
    [("i [mA]", "mA"), ("(s)", "s"), ("V", "V"), ("i (rms) (A)", "A"), ("i", None), ("", None),
     ("()", None), ("1", None), ("counts", "counts"), ("[RPM]", "rpm")],
)  # fmt: skip
def test_the_unit_that_a_cell_spells(cell: str, unit: str | None) -> None:
    assert spelled(cell) == unit


# -- arithmetic and registers
@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a-b", [-2.0, -2.0]), ("a*b/k", [1.5, 4.0]), ("-a+b", [2.0, 2.0]), ("+a", [1.0, 2.0]),
        ("a/(b-b)", [inf, inf]), ("2", [2.0, 2.0]), ("row*10", [0.0, 10.0]), ("k", [2.0, 2.0]),
        ("a b", [7.0, 8.0]), ("a b-a", [6.0, 6.0]),
    ],
)  # fmt: skip
def test_arithmetic_of_columns(text: str, values: list[float]) -> None:
    columns = {"a": np.array([1.0, 2.0]), "b": np.array([3.0, 4.0]), "a b": np.array([7.0, 8.0])}
    formula = Formula(text, list(columns), {"k": 2.0})
    assert set(formula.columns) <= {*columns, "row"}
    assert formula.evaluate(columns, 2).tolist() == values


@pytest.mark.parametrize(
    "text",
    [
        "c",
        "a**b",
        "a.b",
        "a[0]",
        "f(a)",
        "a if a else b",
        "'a'",
        "a-",
        "quadrature(a,c)",
        "quadrature(c,b)",
        "quadrature(a)",
        "quadrature(a,b,x=1)",
    ],
)
def test_what_is_no_arithmetic_is_no_column(text: str) -> None:
    with pytest.raises(UsageError, match="the file has no column"):
        Formula(text, ["a", "b"], {})


def test_a_position_of_more_than_its_register_does_not_wrap() -> None:
    notes: list[str] = []
    position = np.r_[np.arange(0.0, 400.0, 10.0), np.arange(30.0, 200.0, 10.0)]
    assert np.ptp(position) > 360.0  # which jumps by 360
    assert continued(position, 0.0, notes) is position
    within = np.r_[np.arange(0.0, 360.0, 10.0), np.arange(0.0, 200.0, 10.0)]
    assert continued(within, 0.0, notes).tolist() == np.arange(0.0, 560.0, 10.0).tolist()
    assert len(notes) == 1
    assert "jumps by 360 at 1 places" in notes[0]


@pytest.mark.parametrize("number", ["1e999", "-1e999", "9" * 400])
def test_a_number_beyond_any_column_is_refused(number: str) -> None:
    with pytest.raises(UsageError, match=r"--map: the number .*\.\.\. is out of range"):
        Formula(f"a*{number}", ["a"], {})


PREFIXES = {"u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "": 1.0}
METRIC = ("s", "V", "A", "m", "N", "rad", "N·m", "m/s")


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_a_prefix_is_a_power_of_ten(quantity: str) -> None:
    known = units_of(quantity)
    assert all(unit_of(quantity, name) == Unit(name, *known[name]) for name in known)
    for si in METRIC:
        for prefix, scale in PREFIXES.items():
            found = known.get(f"{prefix}{si}")
            if found is not None and f"{prefix}{si}" not in ("min", "m"):
                assert found == (si, pytest.approx(scale, rel=1e-12))
            if not prefix and any(one == si for one, _ in known.values()):
                assert found == (si, 1.0)


@pytest.mark.parametrize(
    ("sensed", "options", "ambient"),
    [
        (None, {}, (None, 0.0)),
        (None, {"ambient_c": 20.0, "ambient_uncertainty_c": 0.5}, (20.0, 0.5)),
        ([30.0, 31.0], {"ambient_c": 20.0, "ambient_uncertainty_c": 0.5}, (20.0, 0.5)),
        ([20.0, nan, 26.0], {}, (23.0, 3.0)),  # 3 either way
        ([20.0, 26.0], {"ambient_uncertainty_c": 4.0}, (23.0, 5.0)),
        ([20.0, 26.0], {"offset_uncertainty": {"ambient": 4.0}}, (23.0, 5.0)),
        (
            [23.0],
            {"offset_uncertainty": {"ambient": 1.0}, "ambient_uncertainty_c": 2.0},
            (23.0, 2.0),
        ),
    ],
)
def test_the_room_is_as_stated_or_as_its_thermometer_says(
    sensed: list[float] | None, options: dict[str, Any], ambient: tuple[float | None, float]
) -> None:
    readings = None if sensed is None else np.array(sensed)
    found = table._ambient(readings, TableOptions(**options))
    assert found == (ambient[0], pytest.approx(ambient[1]))
