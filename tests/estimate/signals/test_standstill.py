"""A rotor that breakaway holds against more than T0, on the simulated rig."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import POSITION, Capture
from motorid.estimate.signals.standstill import with_standstill
from motorid.estimate.signals.time_grid import lay
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import load_rig
from motorid.sim import truth
from tests.six_parameters import fit


def captured(folder: Path) -> tuple[Capture, dict[str, float]]:
    """Half a level that T0 would let turn, then two that turn the motor, and a coast."""
    rig = load_rig("sim")
    rig = replace(rig, port=f"{rig.port}&speed=max&seed=5&stiction=3&cogging=0")
    true = truth(rig.port)
    low = 2.0 * true["T0"] / true["K"] * true["R"]
    levels = [(low, 0.1), (3.0, 0.1), (6.0, 0.1)]
    drives = [Step(StepKind.DRIVE_VOLTS, s, v, Decay.SYNCHRONOUS_SLOW) for v, s in levels]
    steps = (Step(StepKind.COAST, 0.03), *drives, Step(StepKind.COAST, 0.4))
    return store.load(record(rig, Program(steps), folder / "run.h5")), true


@pytest.mark.slow
def test_a_motor_that_stands_while_driven_is_told_to(tmp_path: Path) -> None:
    capture, true = captured(tmp_path)
    parts = with_standstill(capture, lay(capture)).parts
    assert [part.still for part in parts] == [False, True, False, False, False]
    estimate = fit([capture])
    said = [d.message for d in estimate.diagnostics if d.code == "standstill"]
    assert len(said) == 1
    assert f"stands still at levels {parts[1].level:.3g}," in said[0]
    for name, share in (("R", 0.01), ("J", 0.02), ("B", 0.05), ("T0", 0.05)):
        assert abs(estimate.parameters[name].value / true[name] - 1) < share, name  # type: ignore[operator]


@pytest.mark.slow
def test_a_slow_start_is_no_standstill(tmp_path: Path) -> None:
    """A part with some counts of motion at its end, and one without an encoder."""
    capture, _ = captured(tmp_path)
    place = capture.channels[POSITION]
    stirred = place.raw.copy()
    low = lay(capture).parts[1]
    stirred[low.stop - 3 :] += 2
    moved = replace(capture, channels={**capture.channels, POSITION: replace(place, raw=stirred)})
    assert not any(part.still for part in with_standstill(moved, lay(moved)).parts)
    blind = {name: c for name, c in capture.channels.items() if name != POSITION}
    line = lay(capture)
    assert with_standstill(replace(capture, channels=blind), line) is line
    assert np.isfinite(place.values).all()
