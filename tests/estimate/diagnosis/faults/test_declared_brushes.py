"""A drop of the brushes that the rig declares and the readings contradict."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.faults import declared_brushes
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from tests.estimate.diagnosis.faults.cases import Runs
from tests.estimate.diagnosis.faults.rigs import DIRECTIONS, Bench
from tests.exact_capture import FAULHABER, clean_capture
from tests.six_parameters import fit


def declaring(capture: Capture, drop_v: float | None) -> Capture:
    wiring = replace(capture.wiring, brush_drop_v=drop_v, brush_drop_uncertainty_v=0.0)
    return replace(capture, wiring=wiring)


def test_only_a_declared_drop_is_contradicted() -> None:
    def found(*drops: float | None) -> int:
        captures = [declaring(clean_capture(FAULHABER), drop) for drop in drops]
        records = [MotorRecord(capture, PARAMETERS, {}) for capture in captures]
        return len(declared_brushes.hypotheses(records))

    assert (found(0.0), found(0.3, 0.4), found(0.3, None), found(None)) == (1, 1, 0, 0)


def test_what_was_declared_is_said_and_left_out() -> None:
    capture = declaring(clean_capture(FAULHABER), 0.2)
    (one,) = declared_brushes.hypotheses([MotorRecord(capture, PARAMETERS, {})])
    said = one.words(np.array([0.35])).evidence
    assert said == "the brushes drop about 0.55 V where the rig declares 0.2 V"
    assert one.remedy is not None
    (without,) = one.remedy(capture, 0.35)
    assert without.wiring.brush_drop_v is None


@pytest.mark.slow
def test_brushes_that_were_declared_to_drop_nothing_are_named_and_allowed_for(
    tmp_path: Path,
) -> None:
    runs = Runs(Bench("maxon-re35", 3, DIRECTIONS, tmp_path))
    capture = runs.bench.capture("&brush_drop=0.8")
    right, wrong = fit([declaring(capture, None)]), fit([declaring(capture, 0.0)])
    (said,) = [s for s in wrong.suspects if s.strength == "named"]
    assert (said.code, said.allowed) == ("brush_drop_contradicted", True)
    for name in PARAMETERS:
        before, after = right.parameters[name], wrong.parameters[name]
        assert before.value is not None
        assert after.value is not None
        assert before.total is not None
        assert abs(after.value - before.value) < before.total
