"""A current that is an instant where the board says a mean, and the other way round."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis.faults.filters import aperture
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.results.status import Status
from tests.estimate.diagnosis.faults.rigs import DIRECTIONS, Bench
from tests.estimate.effects.benches import POINT, record, start
from tests.six_parameters import fit

SIX = ("R", "L", "K", "B", "J", "T0")


def test_the_effect_is_what_a_capture_with_the_other_kind_would_read() -> None:
    stated = record("measured")
    (one,) = aperture.hypotheses([stated])
    moved = one.effect(stated, POINT, start(stated), np.array([1.0]))
    other = MotorRecord(aperture.otherwise(stated.capture), PARAMETERS, {})
    other.excite(stated.driving)
    pairs = zip(
        stated.measured, stated.fitted(POINT, start(stated)), other.fitted(POINT, start(other)),
        moved, strict=True,
    )  # fmt: skip
    for m, before, after, change in pairs:
        if m.block.name != CURRENT:
            assert not change.any()
            continue
        assert np.abs(change).max() > 0.01  # A: the ripple, and the mean half a window later
        assert change == pytest.approx(after - before, abs=1e-3 * float(np.abs(change).max()))


def test_twice_otherwise_is_as_before_and_a_log_has_no_other_kind() -> None:
    stated = record("measured")
    current = stated.capture.channels[CURRENT]
    twice = aperture.otherwise(aperture.otherwise(stated.capture)).channels[CURRENT]
    assert (twice.kind, current.kind) == ("mean", "mean")
    assert twice.aperture_s == pytest.approx(1.0 / (stated.capture.wiring.pwm_hz or 0.0))
    (one,) = aperture.hypotheses([stated])
    assert "reads as an instant, and the board calls it a mean" in one.words(np.ones(1)).evidence
    log = record("measured").twin()
    log.capture = replace(log.capture, program=None, phases=())
    assert aperture.hypotheses([log]) == []


@pytest.mark.slow
def test_the_other_kind_is_named_and_taken(tmp_path: Path) -> None:
    bench = Bench("dunkermotoren-gr42", 3, DIRECTIONS, tmp_path)
    capture = bench.capture()
    right = fit([capture])
    assert not [s for s in right.suspects if s.strength == "named"]
    found = fit([aperture.otherwise(capture)])
    assert [(s.code, s.allowed) for s in found.suspects if s.strength == "named"] == [
        (aperture.CODE, True)
    ]
    for name in SIX:
        assert found.parameters[name].status is Status.ESTIMATED
        assert found.parameters[name].value == pytest.approx(right.parameters[name].value, rel=1e-3)
