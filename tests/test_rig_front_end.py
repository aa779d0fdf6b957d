"""Front-end files: those that come with motorid, and what anybody may write into one."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motorid.capture.model import Wiring
from motorid.errors import RigError
from motorid.rig import Calibration, load_rig
from motorid.rig_front_end import load_front_end, parse, presets
from motorid.sim.front_end import is_sound
from motorid.wire.codec import Command, decode, encode_command

GOOD = """
name = "mine"
sensor = "hall"
ratiometric = true
[converter]
reference_v = 5.0
reference_uncertainty = 0.03
[current]
volts_per_ampere = 0.1
zero_v = 2.5
zero_uncertainty_v = 0.02
gain_uncertainty = 0.04
most_a = 12.5
filter_s = [22e-6, 10e-6]
[voltage]
divider = 8
lift_v = 0.25
gain_uncertainty = 0.04
"""


@pytest.mark.parametrize("name", presets())
def test_every_front_end_that_comes_with_motorid_can_be_stored(name: str) -> None:
    found = load_front_end(name)
    assert found.name == name
    assert is_sound(found.facts)
    sent = decode(encode_command("write_front_end", 1, **found.facts))
    assert isinstance(sent, Command)
    assert sent.fields["name"] == name
    assert "sources" in found.text


def test_what_follows_the_reference_has_not_its_error() -> None:
    facts = parse(GOOD).facts
    assert facts["current_gain_uncertainty"] == 4000  # of 1e-5
    assert facts["current_zero_uncertainty"] == 200  # of 100 uV
    assert facts["voltage_gain_uncertainty"] == 5000  # 3 % and 4 %
    fixed = parse(GOOD.replace("ratiometric = true", "ratiometric = false")).facts
    assert fixed["current_gain_uncertainty"] == 5000
    assert fixed["current_zero_uncertainty"] == round(1e4 * math.hypot(0.02, 0.03 * 2.5))


BENT = """[current]
nonlinearity = 0.002
nonlinearity_shape = "s"
"""
DRIFTS = """[converter]
reference_drift = 1e-3
reference_time_s = 4
"""


def test_what_no_board_holds_goes_to_the_rig_that_names_the_file() -> None:
    text = GOOD.replace("[current]\n", BENT).replace("[converter]\n", DRIFTS)
    found = parse(text)
    assert found.hash == parse(GOOD).hash  # the board holds the same
    rig = found.under(load_rig("sim"))
    current = rig.calibration["current"]
    assert (current.nonlinearity, current.nonlinearity_shape) == (0.002, "s")
    assert current.full_scale == 12.5  # of the sensor's range
    assert (rig.wiring.reference_drift, rig.wiring.reference_time_s) == (1e-3, 4.0)
    own = replace(
        load_rig("sim"),
        calibration={"current": Calibration(gain=1.1, nonlinearity=0.0)},
        wiring=Wiring(reference_drift=0.0),
    )
    assert found.under(own) == own
    assert parse(GOOD).under(own) == own


def test_a_rig_takes_them_from_the_file_that_it_names(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(GOOD.replace("[current]\n", BENT))
    (tmp_path / "bench.toml").write_text('front_end = "own.toml"\n' + load_rig("sim").text)
    rig = load_rig(str(tmp_path / "bench.toml"))
    assert rig.calibration["current"].full_scale == 12.5
    assert rig.wiring.reference_drift is None


def test_two_filters_one_behind_the_other_are_one_of_second_order() -> None:
    facts = parse(GOOD).facts
    assert (facts["current_filter"], facts["current_filter2"]) == (320, 148)  # of 100 ns
    assert (facts["voltage_filter"], facts["voltage_filter2"]) == (0, 0)
    assert facts["supply_divider"] == facts["voltage_divider"] == 8
    assert facts["max_current_ma"] == 12_500


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('sensor = "hall"', 'sensor = "halls"', "sensor must be one of shunt, hall, magnitude"),
        ('name = "mine"', 'name = ""', "name must be 1 to 16 plain letters"),
        ('name = "mine"', 'name = "Größe"', "name must be 1 to 16 plain letters"),
        ("zero_v = 2.5", "zero_v = 6", "current.zero_v lies above converter.reference_v"),
        ("zero_v = 2.5", "zero_v = 0", "one sign alone"),
        ("volts_per_ampere = 0.1", "volts_per_ampere = 0", "too near to 0"),
        (
            "volts_per_ampere = 0.1",
            "volts_per_amp = 0.1",
            "the nearest is current.volts_per_ampere",
        ),
        ("reference_v = 5.0", "reference_v = nan", "converter.reference_v must lie between"),
        ("lift_v = 0.25", "lift_v = 4.5", "leaves no range"),
        ("most_a = 12.5", "", "current.most_a is missing"),
        ("gain_uncertainty = 0.04", "gain_uncertainty = 4", "current.gain_uncertainty must lie"),
        ("filter_s = [22e-6, 10e-6]", "filter_s = [6e-3, 6e-3]", "larger than a board can hold"),
        ("[voltage]", "[volts]", "the nearest is voltage"),
        ("most_a", "nonlinearity = 0.1\nmost_a", "current.nonlinearity_shape go together"),
        ("[current]", "reference_time_s = 2\n[current]", "reference_time_s go together"),
    ],
)
def test_a_mistake_costs_one_sentence(old: str, new: str, said: str) -> None:
    assert old in GOOD
    with pytest.raises(RigError, match=r"^front end: .*") as caught:
        parse(GOOD.replace(old, new, 1))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_name_that_is_none_names_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="did you mean acs712-20"):
        load_front_end("acs712-2O")
    own = tmp_path / "own.toml"
    own.write_text(GOOD)
    assert load_front_end("own.toml", tmp_path).hash == parse(GOOD).hash


LINES = st.sampled_from(GOOD.strip().splitlines())
VALUES = st.one_of(
    st.floats(),
    st.integers(),
    st.booleans(),
    st.text(max_size=20),
    st.lists(st.floats(), max_size=3),
)


def toml_of(value: object) -> str:
    match value:
        case bool():
            return str(value).lower()
        case str():
            return '"' + "".join(f"\\U{ord(letter):08x}" for letter in value) + '"'
        case list():
            return f"[{', '.join(map(toml_of, value))}]"
    return str(value)


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(line=LINES, value=VALUES)
def test_whatever_stands_in_a_file_it_is_refused_or_a_board_takes_it(
    line: str, value: object
) -> None:
    key, equals, _ = line.partition(" = ")
    text = GOOD.replace(line, f"{key}{equals}{toml_of(value)}" if equals else toml_of(value), 1)
    facts, said = {}, ""
    try:
        facts = dict(parse(text).facts)
    except RigError as error:
        said = str(error)
    if said:
        assert "\n" not in said
        return
    assert is_sound(facts)
    encode_command("write_front_end", 1, **facts)
