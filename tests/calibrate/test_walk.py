"""The walk on simulated benches: what it finds against what the simulator hides."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire.record import capture
from motorid.api import fit
from motorid.cli import main
from motorid.rig import load_rig
from motorid.rig_calibration import read_calibration
from motorid.sim import truth
from motorid.workflow.calibrate import walk
from motorid.workflow.calibrate.bench import Settings
from motorid.workflow.calibrate.simulated import Simulated
from motorid.workflow.plan_file import with_program
from tests.acquire.rigs import SHORT
from tests.calibrate.benches import rig_file

QUICK = Settings(rest_s=2, zeros=6, hold_s=0.5, clock_s=3, clock_pairs=20, runs=1)
BRIEF = with_program("", SHORT, "this test")
GAINS = ("rest", "terminal_voltage", "current")


@dataclass
class Told(Simulated):
    """A simulated person who remembers what was said."""

    heard: list[str] = field(default_factory=list)

    def ready(self, step: str, what: str) -> bool:
        self.heard.append(f"ready {step}: {what}")
        return True

    def proceed(self, what: str) -> None:
        self.heard.append(f"next {what}")


def told(seed: int = 1) -> Told:
    heard: list[str] = []
    return Told(say=heard.append, seed=seed, heard=heard)


def gain_scores(seed: int, folder: Path) -> dict[str, float]:
    """How far each calibrated figure is from the truth, in its own standard uncertainties."""
    path, rig = walk.open_rig(str(rig_file(folder, seed, name=f"bench-{seed}")))
    walk.calibrate(path, rig, told(seed), steps=(*GAINS, "supply_voltage", "clock"), settings=QUICK)
    found = read_calibration(path.with_name(f"{path.stem}.calibration.toml")).tables
    hidden = truth(rig.port)["chain"]
    scores = {}
    for name in ("current", "terminal_voltage", "supply_voltage"):
        true = 1 / (1 + hidden[name]["gain_error"])
        table = found[name]
        scores[name] = (table["gain"] / true - 1) / table["gain_uncertainty"]
    offset = hidden["supply_voltage"]["offset_error"] - found["supply_voltage"]["offset_counts"]
    u = found["supply_voltage"]["offset_uncertainty"] / hidden["supply_voltage"]["scale"]
    scores["supply offset"] = offset / u
    true = 1 + hidden["clock_ppm"] * 1e-6
    scores["clock"] = (found["clock"]["rate"] - true) / found["clock"]["uncertainty"]
    return scores


@pytest.mark.slow
def test_gains_are_found_within_their_stated_uncertainty(tmp_path: Path) -> None:
    scores = [list(gain_scores(seed, tmp_path).values()) for seed in range(1, 6)]
    assert np.max(np.abs(scores)) < 3
    rms = np.sqrt(np.mean(np.square(scores)))
    assert 0.3 < rms < 1.4


@pytest.mark.slow
def test_a_calibrated_fit_is_nearer_the_truth_and_knows_it(tmp_path: Path) -> None:
    """Over four benches: errors and uncertainties both shrink, and keep their proportion."""
    before, after = [], []
    for seed in range(1, 5):
        file = rig_file(tmp_path, seed, name=f"bench-{seed}")
        path, rig = walk.open_rig(str(file))
        stored = capture(rig, SHORT, tmp_path / f"{seed}.h5")
        raw = fit(stored, model="six")
        walk.calibrate(path, rig, told(seed), steps=GAINS, settings=QUICK)
        better = fit(stored, rig=load_rig(str(file)), model="six")
        true = truth(rig.port)
        for name in ("K", "J", "T0"):
            for found, kept in ((raw, before), (better, after)):
                p = found.parameters[name]
                assert p.value is not None
                assert p.total is not None
                kept.append((p.value / true[name] - 1, p.total / p.value))
    errors = [np.sqrt(np.mean(np.square([e for e, _ in kept]))) for kept in (before, after)]
    stated = [np.median([u for _, u in kept]) for kept in (before, after)]
    assert errors[1] < 0.3 * errors[0]
    assert stated[1] < 0.2 * stated[0]
    scores = [error / u for error, u in after]
    assert np.mean(np.abs(scores) < 2) >= 0.9


@pytest.mark.slow
def test_the_motor_moves_only_after_it_was_said(tmp_path: Path) -> None:
    path, rig = walk.open_rig(str(rig_file(tmp_path)))
    person = told()
    walk.calibrate(path, rig, person, steps=("current", "terminal_voltage"), settings=QUICK)
    levels = [line for line in person.heard if line.startswith("next level")]
    pulses = [line for line in person.heard if "pulse of a tenth" in line]
    assert len(levels) == 8
    assert len(pulses) == 2
    assert all(" V for 0.5 s, about " in line for line in levels)
    largest = max(abs(float(line.split("about ")[1].split(" A")[0])) for line in levels)
    assert largest == pytest.approx(0.5 * rig.limits.current_a, rel=0.05)


def test_a_level_beyond_the_limits_is_refused_before_it_is_driven(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = rig_file(tmp_path)
    words = ["calibrate", str(file), "--simulated", "--step", "current", "--hold", "1"]
    assert main.run([*words, "--level", "1", "--level", "6.5"]) == 3
    assert "could draw" in capsys.readouterr().err
    assert not file.with_name("bench.calibration.toml").exists()


def test_an_encoder_that_counts_four_times_the_figure_is_named_and_refused(
    tmp_path: Path,
) -> None:
    file = rig_file(tmp_path)
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace("counts_per_turn = 2048", "counts_per_turn = 512"), "utf-8")
    path, rig = walk.open_rig(str(file))
    person = told()
    walk.calibrate(path, rig, person, steps=("encoder",), settings=QUICK)
    assert any("four edges a line; write 2048" in line for line in person.heard)
    with pytest.raises(walk.RigError, match="counts_per_turn is 512"):
        load_rig(str(file))
    file.write_text(text, encoding="utf-8")
    assert load_rig(str(file)).calibrated is not None


@pytest.mark.slow
def test_an_earlier_calibration_is_kept_and_its_other_parts_stay(tmp_path: Path) -> None:
    file = rig_file(tmp_path)
    path, rig = walk.open_rig(str(file))
    first = walk.calibrate(path, rig, told(), steps=("clock",), settings=QUICK)
    before = read_calibration(first.path)
    second = walk.calibrate(
        path, rig, told(), steps=("rest",), settings=QUICK, about={"by": "A. Volta"}
    )
    after = read_calibration(second.path)
    assert second.archived is not None
    assert second.archived.read_text(encoding="utf-8") == before.text
    assert after.tables[""]["replaces_sha256"] == before.sha256
    assert after.tables[""]["by"] == "A. Volta"
    assert after.tables["clock"] == before.tables["clock"]
    assert "rest_offset_counts" in after.tables["current"]


@pytest.mark.slow
def test_what_was_said_of_another_board_is_not_taken_over(tmp_path: Path) -> None:
    path, rig = walk.open_rig(str(rig_file(tmp_path, 7)))
    walk.calibrate(path, rig, told(), steps=("clock",), settings=QUICK)
    _, other = walk.open_rig(str(rig_file(tmp_path, 8)))
    person = told()
    written = walk.calibrate(path, other, person, steps=("rest",), settings=QUICK)
    assert "clock" not in read_calibration(written.path).tables
    assert any("none of it is taken over" in line for line in person.heard)


def test_a_failing_step_keeps_those_before_it(tmp_path: Path) -> None:
    path, rig = walk.open_rig(str(rig_file(tmp_path)))

    class Failing(Told):
        def turn(self, turns: float) -> None:
            raise KeyboardInterrupt

    heard: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        walk.calibrate(
            path,
            rig,
            Failing(say=heard.append, heard=heard),
            steps=("rest", "encoder"),
            settings=QUICK,
        )
    found = read_calibration(path.with_name("bench.calibration.toml"))
    assert "current" in found.tables
    assert "encoder" not in found.tables


@pytest.mark.slow
def test_a_known_resistor_needs_the_voltage_first_and_then_no_meter(tmp_path: Path) -> None:
    file = rig_file(tmp_path)
    answers = tmp_path / "answers.toml"
    answers.write_text(
        "[current]\nresistor_ohm = 2.6\nresistor_limit_ohm = 0.01\n", encoding="utf-8"
    )
    stalled = load_rig(str(file)).port + "&fault=stall&heating=0&copper=1&ambient=25"
    words = ["calibrate", str(file), "--answers", str(answers), "--port", stalled, "--hold", "1"]
    assert main.run(words) == 4  # DataError: the voltage is not calibrated
    path, rig = walk.open_rig(str(file), port=stalled)
    walk.calibrate(path, rig, told(), steps=("terminal_voltage",), settings=QUICK)
    assert main.run(words) == 0
    table = read_calibration(path.with_name("bench.calibration.toml")).tables["current"]
    true = 1 / (1 + truth(stalled)["chain"]["current"]["gain_error"])
    assert table["method"] == "known resistor"
    assert abs(table["gain"] / true - 1) < 3 * table["gain_uncertainty"]
    assert table["gain_uncertainty"] < 0.004


@pytest.mark.slow
def test_the_disc_passes_a_calibrated_chain_and_catches_a_wrong_gain(tmp_path: Path) -> None:
    file = rig_file(tmp_path, 3, more=BRIEF)
    path, rig = walk.open_rig(str(file))
    person = told(3)
    walk.calibrate(path, rig, person, steps=(*GAINS, "disc"), settings=QUICK)
    found = read_calibration(path.with_name("bench.calibration.toml"))
    assert found.tables["disc"]["outcome"] == "agrees"

    wrong = found.text.replace("gain = ", "gain = 1.05 #", 1)  # of the current
    path.with_name("bench.calibration.toml").write_text(wrong, encoding="utf-8")
    person = told(3)
    walk.calibrate(path, rig, person, steps=("disc",), settings=QUICK)
    failed = read_calibration(path.with_name("bench.calibration.toml")).tables["disc"]
    assert failed["outcome"] == "fails"


def test_it_is_told_what_it_cannot_do(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["calibrate", "sim"]) == 2
    assert "motorid rigs --show sim > bench.toml" in capsys.readouterr().err
    assert main.run(["rigs", "--show", "sim"]) == 0
    (tmp_path / "copy.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    assert load_rig(str(tmp_path / "copy.toml")) == load_rig("sim")
    file = rig_file(tmp_path, more="[calibration.current]\ngain = 1.01\n")
    assert main.run(["calibrate", str(file), "--simulated", "--step", "current"]) == 3
    assert "take it out" in capsys.readouterr().err
    assert main.run(["calibrate", str(file), "--simulated", "--step", "curent"]) == 2
    assert "did you mean 'current'" in capsys.readouterr().err
    answers = tmp_path / "answers.toml"
    answers.write_text("[terminal_voltage]\naccuracy = '0.1%'\n", encoding="utf-8")
    file = rig_file(tmp_path, name="other")
    words = ["calibrate", str(file), "--answers", str(answers), "--hold", "1"]
    stalled = load_rig(str(file)).port + "&fault=stall"
    assert main.run([*words, "--port", stalled]) == 2
    assert "needs readings" in capsys.readouterr().err


def typed(monkeypatch: pytest.MonkeyPatch, lines: list[str], *words: str) -> int:
    """The command's exit code with these lines typed."""
    monkeypatch.setattr("sys.stdin", io.StringIO("\n".join(lines) + "\n"))
    return main.run(["calibrate", *words, "--hold", "1", "--runs", "1"])


@pytest.mark.slow
def test_a_person_is_led_through_by_questions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Typed answers, one a line, as a script that reads a meter would give them."""
    file = rig_file(tmp_path)
    stalled = load_rig(str(file)).port + "&fault=stall"
    lines = ["y", "Fluke 87V", "12345", "0.05%+0.001"]
    lines += ["", "", "1.0", "", "2.0"]  # the pulse; two levels, and what the meter shows
    lines += ["n"]  # not again
    levels = ["--level", "1", "--level", "2", "--port", stalled]
    assert typed(monkeypatch, lines, str(file), "--step", "terminal_voltage", *levels) == 0
    out = capsys.readouterr().out
    assert "put a resistor in place of the motor" in " ".join(out.split())
    table = read_calibration(file.with_name("bench.calibration.toml")).tables["terminal_voltage"]
    assert table["instrument"] == "Fluke 87V"
    assert table["instrument_serial"] == "12345"
    assert len(table["points"]) == 2


@pytest.mark.slow
def test_a_step_that_fails_may_be_repeated_and_every_step_be_skipped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = rig_file(tmp_path)
    lines = ["y", "", "", "y", "y", "", "", "n"]  # a shaft that nobody turned, twice
    assert typed(monkeypatch, lines, str(file), "--step", "encoder") == 2
    said = capsys.readouterr()
    assert " ".join(said.out.split()).count("That did not work: the encoder counted nothing") == 2
    lines = ["y", "Meter", "", "0.1%", "2", "7.0", "7.0", "n"]  # the supply was left as it was
    assert typed(monkeypatch, lines, str(file), "--step", "supply_voltage") == 4
    assert "too alike to tell a gain" in capsys.readouterr().err
    assert typed(monkeypatch, ["n"] * 7, str(file)) == 2
    assert "no step was done" in capsys.readouterr().err


def test_a_shaft_that_is_not_clamped_stops_the_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = rig_file(tmp_path)
    lines = ["y", "meter", "Meter", "", "0.1%", "", "n"]
    assert typed(monkeypatch, lines, str(file), "--step", "current") == 3
    assert "the shaft turns: clamp it" in capsys.readouterr().err


@pytest.mark.slow
def test_a_disc_that_was_not_put_on_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = rig_file(tmp_path, more=BRIEF)
    lines = ["y", "0.0078", "1e-5", "0.02", "1e-5", "0", "0", "", "", "n"]
    assert typed(monkeypatch, lines, str(file), "--step", "disc") == 0
    assert "fails" in capsys.readouterr().out
    table = read_calibration(file.with_name("bench.calibration.toml")).tables["disc"]
    assert table["expected_kg_m2"] == pytest.approx(3.9e-7)
    assert abs(table["measured_kg_m2"]) < 0.02 * table["expected_kg_m2"]
