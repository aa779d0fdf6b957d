"""What errors of the voltage do, against fits that were really driven by them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.estimate.fit import joint_fit
from motorid.estimate.fit.alternating_fit import again
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.uncertainty.errors_in_variables import hidden
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import load_rig

TIMES = 3.0  # an error of so many standard deviations: what a search leaves open is less


def captured(folder: Path, seed: int) -> Capture:
    """Two levels and a coast of a motor that neither drops volts nor warms up."""
    rig = load_rig("sim")
    drives = [Step(StepKind.DRIVE_VOLTS, 0.06, v, Decay.SYNCHRONOUS_SLOW) for v in (2.5, 6.0)]
    steps = (Step(StepKind.COAST, 0.03), *drives, Step(StepKind.COAST, 0.3))
    rig = replace(rig, port=f"{rig.port}&speed=max&heating=0&stiction=1&seed={seed}")
    return store.load(record(rig, Program(steps), folder / f"{seed}.h5"))


@pytest.mark.slow
def test_nuisances_and_parameters_follow_an_error_of_the_voltage(tmp_path: Path) -> None:
    (one,), solution = joint_fit.solved([captured(tmp_path, 1)], {}, ())
    driven = [k for k, part in enumerate(one.timeline.parts) if not part.open]
    error = np.zeros(one.timeline.count)
    part = one.timeline.parts[driven[-1]]
    error[part.slice] = one.sources[driven[-1]].tilt  # type: ignore[union-attr]
    said = hidden(solution, [one])[-1]
    start = dict(zip(PARAMETERS, solution.values.tolist(), strict=True))
    usual = again([one], PARAMETERS, start, replace(solution, derivatives=None), 1e-6)
    one.volts = one.volts + TIMES * error
    one.response.excite(one.volts, one.stretches)
    one.standing.at_hand.clear()
    moved = maximise(usual.unknowns, [one], enough=1e-6, before=replace(usual, derivatives=None))
    noise = np.sqrt(np.diag(usual.own_covariance[0]))
    own = (moved.own[0] - usual.own[0]) / TIMES
    np.testing.assert_allclose(own / noise, -said.own / noise, atol=0.05)
    shared = (moved.values - usual.values) / usual.slopes / TIMES
    sd = np.sqrt(np.diag(usual.covariance))
    np.testing.assert_allclose(shared / sd, -said.shared / sd, atol=0.05)
    assert np.abs(said.own / noise).max() > 0.2
