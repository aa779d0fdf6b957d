"""--nameplate: figures of a motor without a rig, read, refused, kept and compared."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import motorid
from motorid.capture import facts, store
from motorid.capture.model import CURRENT, Capture, Stated
from motorid.cli.main import run
from motorid.errors import MotoridError, RigError, UsageError
from motorid.estimate.results.estimate import Estimate
from motorid.rig_keys import SECTIONS
from motorid.rig_nameplate import KEYS, of_numbers, read_nameplate
from tests.exact_capture import FAULHABER, clean_capture, noisy

PLATE = """[nameplate]
resistance_ohm = 2.6
torque_constant_nm_a = 7.68e-3

[thermal]
winding_s = 5.0
"""
FOUND = Stated({"resistance_ohm": 2.6, "torque_constant_nm_a": 7.68e-3}, {"winding_s": 5.0})


def written(folder: Path, text: str) -> str:
    path = folder / "motor.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_file_with_the_tables_or_their_keys_alone(tmp_path: Path, repo_root: Path) -> None:
    assert read_nameplate([written(tmp_path, PLATE)]) == FOUND
    bare = PLATE.replace("[nameplate]", "").replace("[thermal]", "")
    assert read_nameplate([written(tmp_path, bare)]) == FOUND
    rig = motorid.load_rig(str(repo_root / "rigs" / "sim.toml"))
    assert read_nameplate([str(repo_root / "rigs" / "sim.toml")]) == rig.stated


def test_a_later_figure_stands_over_an_earlier(tmp_path: Path) -> None:
    found = read_nameplate([written(tmp_path, PLATE), "resistance_ohm = 2.7", "voltage_v=6"])
    assert found.nameplate == {**FOUND.nameplate, "resistance_ohm": 2.7, "voltage_v": 6.0}
    assert found.thermal == FOUND.thermal


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("resistance=2.6", "the nearest is resistance_ohm"),
        ("resistance_ohm=2.6ohm", "give a number in SI units"),
        ("resistance_ohm=-2.6", "must lie between 0.0001 and 100000"),
        ("voltage_v=nan", "must lie between"),
        ("=3", "no such key"),
        ("motor.toml", "there is no such file"),
        ("", "there is no such file"),
    ],
)
def test_what_is_no_figure_is_said(said: str, told: str) -> None:
    with pytest.raises(UsageError, match=told):
        read_nameplate([said])


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("resistance_ohm = [1]", "must be a number"),
        ("[nameplate]\nresistance = 2.6\n", "the nearest is resistance_ohm"),
        ("[nameplate]\n[plate]\n", "unknown key plate"),
        ("nameplate = 3", "must be tables"),
        ("", "states nothing of a motor"),
        ("[nameplate", "not valid TOML"),
    ],
)
def test_a_file_that_is_none_is_said(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(RigError, match=told) as caught:
        read_nameplate([written(tmp_path, text)])
    assert "motor.toml" in str(caught.value)


@pytest.mark.slow
@given(st.text(max_size=20) | st.builds("{}={}".format, st.sampled_from(list(KEYS)), st.text()))
def test_any_text_is_read_or_refused(said: str) -> None:
    try:
        found = read_nameplate([said])
    except MotoridError:
        return
    assert {**found.nameplate, **found.thermal}.keys() <= KEYS.keys()


def test_the_keys_are_those_that_a_capture_keeps() -> None:
    assert set(facts.NAMEPLATE) == set(SECTIONS["nameplate"])
    assert set(facts.THERMAL) == set(SECTIONS["thermal"])


def test_an_import_keeps_it(tmp_path: Path) -> None:
    log, out = tmp_path / "log.csv", tmp_path / "log.h5"
    rows = "".join(f"{k},{k % 7},{2 * k}\n" for k in range(40))
    log.write_text("t,i,n\n" + rows, encoding="utf-8")
    maps = ["--map", "time=t:ms", "--map", "current=i:A", "--map", "speed=n:rpm"]
    plate = ["--nameplate", written(tmp_path, PLATE), "--nameplate", "voltage_v=6"]
    assert run(["import", str(log), *maps, *plate, "-o", str(out)]) == 0
    capture = store.load(out)
    assert capture.stated.nameplate == {**FOUND.nameplate, "voltage_v": 6.0}
    assert capture.stated.thermal == FOUND.thermal
    assert run(["import", str(log), *maps, "--nameplate", "R=2", "-o", str(out), "--force"]) == 2
    assert store.load(out).stated == capture.stated


def test_what_an_import_states_may_be_damaged() -> None:
    assert facts.of_provenance({facts.IMPORTED: 3}).unread == f"{facts.SAID} is no table"
    odd = {"nameplate": {"resistance_ohm": "2"}, "thermal": []}
    assert "thermal, " not in (unread := facts.of_provenance({facts.IMPORTED: odd}).unread)
    assert "nameplate.resistance_ohm, thermal" in unread
    good = facts.of_provenance({facts.IMPORTED: facts.kept(FOUND), "rig": "[nameplate]\n"})
    assert good == FOUND


@pytest.fixture(scope="module")
def wrong_gain() -> Capture:
    """A current that reads five times what flows."""
    capture = noisy(clean_capture(FAULHABER), 1, 1e-3, 1e-4, 1e-3)
    assert capture.program is not None
    current = capture.channels[CURRENT]
    fivefold = replace(current, raw=5.0 * np.asarray(current.raw))
    *steps, coast = capture.program.steps
    left_s = capture.period_s * len(capture) - sum(step.duration_s for step in steps)
    return replace(
        capture,
        channels={**capture.channels, CURRENT: fivefold},
        program=replace(capture.program, steps=(*steps, replace(coast, duration_s=left_s))),
    )


def named(found: Estimate) -> list[str]:
    return [s.code for s in found.suspects if s.strength == "named"]


@pytest.mark.slow
def test_a_fit_compares_with_it(wrong_gain: Capture) -> None:
    plate = {"resistance_ohm": 2.6, "torque_constant_nm_a": 7.68e-3, "inertia_kg_m2": 3.9e-7}
    found = motorid.fit(wrong_gain, nameplate=plate, model="six")
    assert "current_scale" in named(found)
    assert found.options["nameplate"] == plate
    assert "current_scale" not in named(motorid.fit(wrong_gain, model="six"))
    with pytest.raises(UsageError, match="the nearest is"):
        motorid.fit(wrong_gain, nameplate={"resistance": 2.6})


@pytest.mark.slow
def test_the_command_compares_with_it(
    wrong_gain: Capture, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = store.save(wrong_gain, tmp_path / "run.h5")
    plate = [
        f"--nameplate={k}={v}" for k, v in (("resistance_ohm", 2.6), ("inertia_kg_m2", 3.9e-7))
    ]
    assert run(["fit", str(path), *plate, "--model", "six"]) == 0
    assert "nameplate" in capfd.readouterr().out
    assert run(["fit", str(path), "--nameplate", "none.toml"]) == 2
    many = ["fit", str(path), *plate, "--jobs", "1", "-o", str(tmp_path / "fits")]
    assert run(many) == 2
    assert "--nameplate goes with one fit" in capfd.readouterr().err


def test_figures_of_a_script_are_checked() -> None:
    assert of_numbers({"voltage_v": 6}) == Stated({"voltage_v": 6.0})
    with pytest.raises(UsageError, match="must be a number"):
        of_numbers({"voltage_v": "6"})
