"""The calibration file beside a rig: what it does to the rig, and what is refused."""

from __future__ import annotations

import tomllib
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.acquire.record import capture
from motorid.calibration.gain import Meter
from motorid.calibration.toml import render
from motorid.capture import store
from motorid.cli import main
from motorid.errors import RigError
from motorid.rig import load_rig
from motorid.rig_calibration import FORMAT, apply, parse_calibration
from motorid.workflow.calibrate.person import Resistor, disc_of, reference_of
from motorid.workflow.calibrate.steps import STEPS
from tests.acquire.rigs import SHORT
from tests.calibrate.benches import rig_file

NOW = datetime(2026, 11, 21, 12, tzinfo=UTC)


def calibration(date: datetime = NOW, **tables: dict[str, object]) -> str:
    """A file that calibrates the current, the supply and the clock of the board of seed 7."""
    return render(
        {
            "": {"format": FORMAT, "date": date},
            "board": {"name": "motorid-sim", "serial": "sim-7"},
            "current": {
                "date": date,
                "gain": 1.02,
                "gain_uncertainty": 0.001,
                "offset_uncertainty": 3e-4,
            },
            "supply_voltage": {
                "date": date,
                "gain": 0.99,
                "gain_uncertainty": 0.002,
                "offset_counts": 5.5,
            },
            "clock": {"date": date, "rate": 1.00002, "uncertainty": 2e-6},
            **tables,
        }
    )


def calibrated(folder: Path, text: str, *, more: str = "", seed: int = 7) -> Path:
    path = rig_file(folder, seed, more=more)
    path.with_name("bench.calibration.toml").write_text(text, encoding="utf-8")
    return path


def test_what_is_written_reads_back() -> None:
    text = calibration(disc={"says": 'a "quoted" word\nand a line', "zeta": -0.5})
    tables = parse_calibration(text, "x").tables
    assert tables["disc"] == {"says": 'a "quoted" word\nand a line', "zeta": -0.5}
    assert tables[""]["date"] == NOW


@pytest.mark.slow
def test_gains_offsets_and_clock_reach_the_capture(tmp_path: Path) -> None:
    path = rig_file(tmp_path)
    text = path.read_text("utf-8").replace('"position"]', '"position", "supply_voltage"]')
    path.write_text(text, "utf-8")
    plain = load_rig(str(path))
    first = store.load(capture(plain, SHORT, tmp_path / "plain.h5"))
    path.with_name("bench.calibration.toml").write_text(calibration(), "utf-8")
    rig = load_rig(str(path))
    assert rig.calibrated is not None
    second = store.load(capture(rig, SHORT, tmp_path / "calibrated.h5"))

    for name in first.channels:
        np.testing.assert_array_equal(first.channels[name].raw, second.channels[name].raw)
    before, after = first.channels["current"], second.channels["current"]
    assert after.scale == pytest.approx(1.02 * before.scale)
    assert after.gain_uncertainty == 0.001
    assert after.offset_uncertainty == 3e-4
    assert after.offset == before.offset  # the run's own zero
    assert second.channels["supply_voltage"].offset == 5.5
    assert second.channels["terminal_voltage"].scale == first.channels["terminal_voltage"].scale
    assert second.clock_hz == pytest.approx(1.00002 * first.clock_hz)
    assert second.clock_uncertainty == 2e-6
    assert second.provenance["calibration_file"]["sha256"] == rig.calibrated.sha256
    assert second.provenance["calibration_text"] == calibration()
    assert second.provenance["board_serial"] == "sim-7"
    assert "calibration_file" not in first.provenance


def test_another_board_is_refused_before_anything_moves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = calibrated(tmp_path, calibration(), seed=8)
    assert main.run(["capture", "--rig", str(path), "-o", str(tmp_path / "x.h5")]) == 3
    said = capsys.readouterr().err
    assert "serial number sim-7" in said
    assert "this board is serial number sim-8" in said
    assert not (tmp_path / "x.h5").exists()


def test_a_rig_file_may_name_the_serial_of_its_board(tmp_path: Path) -> None:
    path = calibrated(tmp_path, calibration())
    text = path.read_text("utf-8")
    path.write_text('board_serial = "B9"\n' + text, "utf-8")
    with pytest.raises(RigError, match=r"sim-7, and this board is serial number B9"):
        load_rig(str(path))


@pytest.mark.slow
def test_an_old_calibration_is_warned_of_and_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    old = datetime.now(UTC) - timedelta(days=400)
    path = calibrated(tmp_path, calibration(old))
    target = tmp_path / "run.h5"
    assert main.run(["capture", "--rig", str(path), "-o", str(target)]) == 0
    assert "400 days from this run" in " ".join(capsys.readouterr().err.split())
    assert main.run(["fit", str(target)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "bench.calibration.toml is old" in out
    assert "Taken with calibration bench.calibration.toml of" in out
    path.write_text(path.read_text("utf-8") + "\n[calibration]\nmax_age_days = 500\n", "utf-8")
    assert main.run(["capture", "--rig", str(path), "-o", str(tmp_path / "new.h5")]) == 0
    assert "warning" not in capsys.readouterr().err


def test_the_oldest_part_decides(tmp_path: Path) -> None:
    old = datetime.now(UTC) - timedelta(days=700)
    clock = {"date": old, "rate": 1.0, "uncertainty": 1e-6}
    file = parse_calibration(calibration(datetime.now(UTC), clock=clock), "x")
    assert file.oldest == ("clock", file.tables["clock"]["date"])


def test_a_rig_file_may_name_another_calibration_file(tmp_path: Path) -> None:
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab" / "may.toml").write_text(calibration(), "utf-8")
    path = rig_file(tmp_path, more='[calibration]\nfile = "lab/may.toml"\n')
    rig = load_rig(str(path))
    assert rig.calibration["current"].gain == 1.02
    (tmp_path / "lab" / "may.toml").unlink()
    with pytest.raises(RigError, match=r"may\.toml: cannot be read"):
        load_rig(str(path))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("gain = 1.02", "gian = 1.02"), "unknown key current.gian; the nearest is current.gain"),
        (("gain = 1.02", "gain = -1.0"), "current.gain must lie between"),
        (("gain = 1.02", 'gain = "1"'), "current.gain must be a number"),
        (("[clock]", "[clocks]"), "unknown table [clocks]; the nearest is [clock]"),
        ((FORMAT, "motorid calibration 9"), "format must be one of"),
        (("date = 2026-11-21T12:00:00+00:00", "by = ''"), "date is missing"),
        (("[clock]", "[clock"), "not valid TOML"),
    ],
)
def test_a_damaged_file_is_one_clear_sentence(
    tmp_path: Path, change: tuple[str, str], sentence: str
) -> None:
    path = calibrated(tmp_path, calibration().replace(*change, 1))
    with pytest.raises(RigError) as caught:
        load_rig(str(path))
    assert sentence in str(caught.value)
    assert "bench.calibration.toml" in str(caught.value)


def complaint(text: str) -> str:
    """What is said of such a calibration file; nothing where it is taken."""
    try:
        apply(load_rig("sim"), parse_calibration(text, "x"))
    except RigError as error:
        return str(error)
    return ""


@pytest.mark.slow
@given(st.integers(0, 2000), st.integers(0, 30), st.text(max_size=12))
def test_no_damage_is_worse_than_a_sentence(start: int, length: int, put: str) -> None:
    text = calibration(encoder={"date": NOW, "counts_per_turn": 2048.0, "uncertainty": 1.0})
    start %= len(text)
    spoilt = text[:start] + put + text[start + length :]
    assert "\n" not in complaint(spoilt)


def test_one_channel_is_calibrated_in_one_place(tmp_path: Path) -> None:
    path = calibrated(tmp_path, calibration(), more="[calibration.current]\ngain = 1.01\n")
    with pytest.raises(RigError, match=r"calibration\.current\.gain stands in the rig file and in"):
        load_rig(str(path))


def test_counts_that_were_counted_otherwise_are_refused(tmp_path: Path) -> None:
    encoder = {"date": NOW, "counts_per_turn": 8191.0, "uncertainty": 3.0}
    path = calibrated(tmp_path, calibration(encoder=encoder))
    with pytest.raises(RigError, match=r"counts_per_turn is 2048, and .* counted 8191\.0"):
        load_rig(str(path))


def test_the_answers_in_the_documentation_are_answers(repo_root: Path) -> None:
    page = (repo_root / "docs" / "calibrate.md").read_text(encoding="utf-8")
    answers = tomllib.loads(page.split("```toml\n")[1].split("```")[0])
    assert set(answers) <= set(STEPS)
    assert isinstance(reference_of(answers["terminal_voltage"], ""), Meter)
    assert isinstance(reference_of(answers["current"], ""), Resistor)
    assert disc_of(answers["disc"], "").inertia == pytest.approx(2e-5, rel=0.02)
    assert all(f"| `{name}` |" in page for name in STEPS)
