"""The run that a report says to add: taken at its word, it tells what the first run did not."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire.record import capture
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.estimate.results.estimate import Estimate
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import load_rig
from tests.six_parameters import fit

STAGE = re.compile(r"([\d.]+) (ms|s) (?:at ([\d.]+) V|of coasting)")


def driven(path: Path, *levels: tuple[float | None, float]) -> Capture:
    """A run of the simulated rig: rest, then each level (None: coast) for so many seconds."""
    rig = load_rig("sim")
    rig = replace(rig, port=f"{rig.port}&speed=max&seed=5")
    steps = [
        Step(StepKind.COAST, s)
        if v is None
        else Step(StepKind.DRIVE_VOLTS, s, v, Decay.SYNCHRONOUS_SLOW)
        for v, s in ((None, 0.02), *levels)
    ]
    return store.load(capture(rig, Program(tuple(steps)), path))


def said(estimate: Estimate) -> str:
    return " ".join(d.message for d in estimate.diagnostics if d.code == "run_to_add")


@pytest.mark.slow
@pytest.mark.parametrize("levels", [((6.0, 0.006),), ((6.0, 0.02),)])
def test_the_run_that_is_named_tells_what_was_missing(
    tmp_path: Path, levels: tuple[tuple[float | None, float], ...]
) -> None:
    first = driven(tmp_path / "first.h5", *levels)
    before = fit([first])
    sentence = said(before)
    names = re.search(r"would determine ([^;]+);", sentence)
    assert names is not None
    missing = re.findall(r"T0|[RLKBJ]", names[1])
    assert missing
    stages = [
        (float(volts) if volts else None, float(size) * (1e-3 if unit == "ms" else 1.0))
        for size, unit, volts in STAGE.findall(sentence)
    ]
    assert len(stages) >= 2
    after = fit([first, driven(tmp_path / "added.h5", *stages)])
    assert said(after) == ""
    for name in missing:
        p, q = before.parameters[name], after.parameters[name]
        assert q.value is not None
        assert q.statistical is not None
        assert q.statistical < 0.05 * q.value
        assert p.statistical is None or q.statistical < 0.3 * p.statistical


@pytest.mark.slow
def test_a_complete_run_needs_no_other(tmp_path: Path) -> None:
    whole = driven(tmp_path / "run.h5", (3.0, 0.05), (6.0, 0.07), (None, 0.05))
    assert said(fit([whole])) == ""
