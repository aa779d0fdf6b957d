"""A plan goes into the rig's own file, and the command that writes it."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.capture.model import CURRENT, POSITION, SUPPLY, VOLTAGE
from motorid.cli.main import run
from motorid.errors import UsageError
from motorid.estimate.diagnosis.identifiability import of_program
from motorid.plan.propose import Plan
from motorid.plan.skeleton import Bench
from motorid.program import Decay, Program, Step, StepKind
from motorid.quality.product import load_product, parse
from motorid.report.plan import explain
from motorid.rig_file import find, load
from motorid.workflow.plan_file import rig_text, with_program

PROGRAM = Program(
    (
        Step(StepKind.COAST, 0.01),
        Step(StepKind.DRIVE_VOLTS, 0.05, 3.25, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.BRAKE, 0.02),
        Step(StepKind.DRIVE_DUTY, 0.05, -0.5, Decay.FAST),
    )
)
LEVELS = [Step(StepKind.DRIVE_VOLTS, 0.5, v, Decay.SYNCHRONOUS_SLOW) for v in (2.0, 4.0, 6.0)]
CALIBRATION = """format = "motorid calibration 1"
date = 2026-11-20T08:00:00Z
rig = "sim"
by = "a test"
[current]
date = 2026-11-20T08:00:00Z
gain = 1.25
gain_uncertainty = 0.001
"""


@pytest.mark.parametrize(
    "own",
    [
        "",
        "[program]\nlevels_v = [[4.0]]  # three\ndrive_s = 0.6\n",
        '[[program.steps]]\nkind = "coast"\nduration_s = 0.1\n',
        '[program]\n[[program.steps]]\nkind = "coast"\nduration_s = 0.1\n',
    ],
)
def test_the_program_takes_the_place_of_the_file_s_own(tmp_path: Path, own: str) -> None:
    text = find("sim").read_text().replace("[conditions]", f"{own}\n[conditions]")
    path = tmp_path / "bench.toml"
    path.write_text(with_program(text, PROGRAM, "a test"))
    planned, before = load(str(path)), load("sim")
    assert planned.program == PROGRAM
    assert planned.limits == before.limits
    assert planned.ambient_c == before.ambient_c
    assert "levels_v" not in planned.text


def test_a_product_keeps_its_limits() -> None:
    product = load_product("sim-disc")
    planned = parse(with_program(product.text, PROGRAM, "a test"))
    assert planned.program == PROGRAM
    assert planned.limits == product.limits


@pytest.mark.slow
@pytest.mark.usefixtures("one_motor", "one_shape")
def test_planned_and_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """For the middle of the spread alone; tests/plan/test_plan.py plans for all of it."""
    target = tmp_path / "planned.toml"
    call = ["plan", "--rig", "sim", "--want", "R=2% K=2%", "-o", str(target)]
    assert run(call) == 0
    said = capsys.readouterr()
    assert "1 run of" in said.out
    assert "met" in said.out
    assert run(call) == UsageError.exit_code  # it exists
    whole = ["run", "--rig", str(target), "--speed", "max", "-o", str(tmp_path / "out")]
    assert run(whole) == 0
    assert load(str(target)).program.duration_s < 0.2


def test_a_calibration_stays_with_the_rig(tmp_path: Path) -> None:
    """Whether the plan is written over the rig file, beside it, or elsewhere."""
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    source = tmp_path / "a" / "bench.toml"
    source.write_text(find("sim").read_text())
    (tmp_path / "a" / "bench.calibration.toml").write_text(CALIBRATION)
    rig = load(str(source))
    assert rig.calibration["current"].gain == 1.25
    plan = Plan(PROGRAM, Bench({}, 16e6, 3200, rig.wiring), 1, (), (), 0)
    for target in (tmp_path / "b" / "bench.toml", tmp_path / "a" / "other.toml", source):
        target.write_text(rig_text(rig, source, plan, target))
        planned = load(str(target))
        assert planned.calibration == rig.calibration
        assert planned.program == PROGRAM
        assert planned.sampling.rate_hz == 5000


EXPLAINED = {
    "all": ((CURRENT, VOLTAGE, POSITION), (6.0, 3.0), True, "at best: R, L, K, B, J, T0."),
    "speed, driven only": (
        (SUPPLY, POSITION),
        (6.0, 4.0, 2.0),
        False,
        "at best: T0·R/K, K/(JL), R/L+B/J, (RB+K²)/(JL).",
    ),
    "coast only": ((POSITION,), (), True, "at best: B/J, T0/J."),
    "no voltage": ((CURRENT, POSITION), (6.0, 4.0, 2.0), False, "at best: J/K, B/K, T0/K."),
}


@pytest.mark.parametrize("case", EXPLAINED)
def test_what_channels_and_program_can_tell_is_explained(case: str) -> None:
    channels, levels, coast, words = EXPLAINED[case]
    drives = [Step(StepKind.DRIVE_VOLTS, 0.1, v, Decay.SYNCHRONOUS_SLOW) for v in levels]
    rest = [Step(StepKind.COAST, 0.1)]
    program = Program((*rest, *drives, *(rest if coast else [])))
    text = " ".join(explain(of_program(program, channels)).split())
    assert words in text
    assert ("They cannot determine" in text) == (case != "all")


def test_samples_too_coarse_for_a_start_show_steady_levels_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Then the steady equations are all there is, and they are singular at T0 = 0."""
    path = tmp_path / "bench.toml"
    text = find("sim").read_text().replace("rate_hz = 10000", "rate_hz = 50")
    path.write_text(with_program(text, Program(tuple(LEVELS)), "a test"))
    assert run(["plan", "--rig", str(path), "--explain"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "at best: R, K, B, T0." in said
    assert "no dry friction (T0 = 0), R, K, B would be lost too" in said
    assert "To determine L and J as well, add a run with a start" in said
