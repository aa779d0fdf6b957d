"""Rig files: every key known, typed, bounded; whatever the text, a Rig or one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.errors import RigError
from motorid.program import Decay, StepKind
from motorid.rig import load_rig
from motorid.rig_file import parse, presets
from motorid.rig_keys import REQUIRED, SECTIONS

MINIMAL = """
[wiring]
counts_per_turn = 2048
[limits]
current_a = 3.2
speed_rad_s = 1100
supply_min_v = 4
supply_max_v = 9
[nameplate]
voltage_v = 6
[sampling]
rate_hz = 10000
"""


def test_the_minimal_rig_takes_the_defaults() -> None:
    rig = parse(MINIMAL, "bench.toml")
    assert rig.name == "bench"
    assert rig.limits.run_time_s == 60
    assert rig.sampling.channels == ("current", "terminal_voltage", "position")
    assert rig.voltage_sense == "terminals"
    assert rig.text == MINIMAL
    assert max(step.level for step in rig.program.steps) == 6


@pytest.mark.parametrize("name", presets())
def test_every_preset_loads(name: str) -> None:
    rig = load_rig(name)
    assert rig.name == name
    assert rig.program.duration_s < rig.limits.run_time_s


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("current_a =", "curent_a =", "limits.curent_a; the nearest is limits.current_a"),
        ("[limits]", "[limit]", "unknown key limit; the nearest is limits"),
        ("3.2", "nan", "limits.current_a must lie between"),
        ("3.2", "inf", "limits.current_a must lie between"),
        ("3.2", "-1", "limits.current_a must lie between"),
        ("3.2", "true", "limits.current_a must be a number, not True"),
        ("3.2", '"3.2"', "limits.current_a must be a number, not '3.2'"),
        ("current_a = 3.2", "", "limits.current_a is missing"),
        ("supply_min_v = 4", "supply_min_v = 40", "supply_min_v must be below"),
        ("counts_per_turn = 2048", "", "wiring.counts_per_turn is missing"),
        ("voltage_v = 6", "", "needs nameplate.voltage_v"),
        ("[sampling]", "[sampling", "not valid TOML"),
        ("rate_hz = 10000", 'rate_hz = 1e4\nchannels = ["curent"]', "must be one of current"),
        ("rate_hz = 10000", 'rate_hz = 1e4\nchannels = ["current", "current"]', "twice"),
        ("rate_hz = 10000", "rate_hz = 1e4\n[calibration.volts]\ngain = 1", "the nearest is"),
        ("rate_hz = 10000", "rate_hz = 1e4\n[program]\nlevels_v = []", "a list of 1 to 200"),
        (
            "counts_per_turn",
            "reference_drift = 1e-3\ncounts_per_turn",
            "reference_time_s go together",
        ),
        (
            "counts_per_turn",
            "reference_time_s = 2\ncounts_per_turn",
            "reference_time_s go together",
        ),
        (
            "rate_hz = 10000",
            "rate_hz = 1e4\n[calibration.current]\nnonlinearity = 0.01",
            "nonlinearity_shape go together",
        ),
        (
            "rate_hz = 10000",
            'rate_hz = 1e4\n[calibration.current]\nnonlinearity_shape = "s"',
            "nonlinearity_shape go together",
        ),
        (
            "rate_hz = 10000",
            'rate_hz = 1e4\n[calibration.current]\nnonlinearity = 0.01\nnonlinearity_shape = "z"',
            "must be one of bow, cubic, s",
        ),
        (
            "rate_hz = 10000",
            "rate_hz = 1e4\n[calibration.terminal_voltage]\nfull_scale = 10",
            "is of the current alone",
        ),
        ("rate_hz = 10000", "rate_hz = 1e4\n[program]\ndrive_s = 1", "exactly one of levels_v"),
        ("rate_hz = 10000", "rate_hz = 1e4\n[program]\nsteps = [3]", "steps[0]] must be a table"),
    ],
)
def test_a_wrong_file_is_one_sentence_naming_it(old: str, new: str, says: str) -> None:
    with pytest.raises(RigError) as caught:
        parse(MINIMAL.replace(old, new), "bench.toml")
    assert says in str(caught.value)
    assert str(caught.value).startswith("bench.toml: ")


def test_a_stated_nothing_needs_no_time_and_no_shape() -> None:
    """It says that there is none, whatever a front end's file says."""
    text = MINIMAL.replace("counts_per_turn", "reference_drift = 0\ncounts_per_turn")
    rig = parse(text + "\n[calibration.current]\nnonlinearity = 0\n")
    assert rig.wiring.reference_drift == rig.calibration["current"].nonlinearity == 0.0


def test_programs_step_by_step() -> None:
    steps = """
[[program.steps]]
kind = "drive_volts"
volts = -3.5
duration_s = 0.2
decay = "fast"
[[program.steps]]
kind = "drive_duty"
duty = 0.25
duration_s = 0.1
[[program.steps]]
kind = "brake"
duration_s = 0.5
"""
    found = parse(MINIMAL + steps).program.steps
    assert [step.kind for step in found] == [
        StepKind.DRIVE_VOLTS,
        StepKind.DRIVE_DUTY,
        StepKind.BRAKE,
    ]
    assert [step.level for step in found] == [-3.5, 0.25, 0.0]
    assert [step.decay for step in found] == [Decay.FAST, Decay.SYNCHRONOUS_SLOW, Decay.NONE]


@pytest.mark.parametrize(
    ("step", "says"),
    [
        ('kind = "coast"', "duration_s is missing"),
        ('kind = "coast"\nduration_s = 1\nvolts = 3', "a coast step takes no volts"),
        ('kind = "drive_duty"\nduration_s = 1\nvolts = 3', "takes no volts"),
        ('kind = "drive_volts"\nduration_s = 1', "needs volts"),
        ('kind = "coast"\nduration_s = 1\ndecay = "fast"', "takes no decay"),
        ('kind = "coast"\nduration_s = -1', "must lie between"),
        ('kind = "fly"\nduration_s = 1', "must be one of coast"),
    ],
)
def test_wrong_steps_are_named(step: str, says: str) -> None:
    with pytest.raises(RigError, match=r"program\.steps") as caught:
        parse(f"{MINIMAL}[[program.steps]]\n{step}\n")
    assert says in str(caught.value)


def test_compact_programs_climb_and_coast() -> None:
    text = f"{MINIMAL}[program]\nlevels_duty = [[0.3, 0.6], [-0.9]]\ndrive_s = 0.2\ncoast_s = 1\n"
    steps = parse(text).program.steps
    assert [step.level for step in steps] == [0, 0.3, 0.6, 0, -0.9, 0]
    assert steps[3].duration_s == 1


def test_a_rig_without_a_program_brakes_once_and_stays_short() -> None:
    """Driving and coasting alone leave load friction open; a brake gives no current to a supply."""
    steps = load_rig("sim").program.steps
    (brake,) = (k for k, step in enumerate(steps) if step.kind is StepKind.BRAKE)
    assert steps[brake - 1].kind is StepKind.DRIVE_VOLTS
    assert steps[brake + 1].kind is StepKind.COAST
    total = sum(step.duration_s for step in steps)
    assert 0.0 < steps[brake].duration_s < 0.2 * (total - steps[brake].duration_s)


def test_absent_files_and_foreign_ones(tmp_path: Path) -> None:
    with pytest.raises(RigError, match="did you mean sim"):
        load_rig("simm")
    (tmp_path / "rig.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(RigError, match="not UTF-8"):
        load_rig(str(tmp_path / "rig.toml"))
    (tmp_path / "huge.toml").write_bytes(b"#" * ((1 << 20) + 1))
    with pytest.raises(RigError, match="larger than a rig file"):
        load_rig(str(tmp_path / "huge.toml"))


def test_a_path_with_spaces_and_other_scripts(tmp_path: Path) -> None:
    path = tmp_path / "мой стенд 電機.toml"
    path.write_text(MINIMAL, encoding="utf-8")
    assert load_rig(str(path)).name == "мой стенд 電機"


@given(st.text(max_size=200))
def test_any_text_is_a_rig_or_a_rig_error(text: str) -> None:
    with pytest.raises(RigError):
        parse(text)


KEYS = [(name, key) for name, keys in SECTIONS.items() for key in keys]
VALUES = st.one_of(
    st.integers(-(10**30), 10**30).map(str),
    st.floats().map(str),
    st.sampled_from(['""', '"sim"', "true", "[]", "[[1]]", "[[1e9]]", "{}", "1979-05-27", "[[]]"]),
)


@given(st.sampled_from(KEYS), VALUES)
def test_any_value_of_any_key_is_accepted_or_named(place: tuple[str, str], value: str) -> None:
    section, key = place
    lines = {("limits", name): "1" for name in REQUIRED["limits"]} | {
        ("limits", "supply_max_v"): "9",
        ("sampling", "rate_hz"): "1e4",
        ("wiring", "counts_per_turn"): "2048",
        ("nameplate", "voltage_v"): "6",
        place: value,
    }
    text = "".join(f"{name}.{inner} = {given}\n" for (name, inner), given in lines.items())
    try:
        rig = parse(text)
    except RigError as error:
        assert section in str(error) or key in str(error) or "TOML" in str(error)  # noqa: PT017
    else:
        assert rig.text == text
