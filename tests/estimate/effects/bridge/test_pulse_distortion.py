"""Pulses that are longer than commanded: volts below full duty, and a fit that finds them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import Capture
from motorid.estimate.effects.action import SourceVoltage
from motorid.estimate.effects.bridge.pulse_distortion import PULSE_DISTORTION, USUAL_S
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.program import Decay
from tests.estimate.effects.benches import record
from tests.estimate.effects.bridge.commanded import (
    PLAN,
    PWM_HZ,
    SUPPLY_V,
    commanded,
    longer_by,
)
from tests.exact_capture import FAULHABER
from tests.six_parameters import fit

LONGER_S = 2e-7


def of(capture: Capture) -> MotorRecord:
    return MotorRecord(capture, PARAMETERS, {})


def test_volts_have_the_drives_sign_and_full_duty_has_none() -> None:
    subject = of(commanded())
    (action,) = PULSE_DISTORTION.acts
    assert isinstance(action, SourceVoltage)
    volts = np.broadcast_to(action.shape(subject, 0), subject.timeline.count)
    driven = [part for part in subject.timeline.parts if not part.open]
    assert len(driven) == len(PLAN.volts)
    for part, level in zip(driven, PLAN.volts, strict=True):
        sign = 0.0 if abs(level) >= SUPPLY_V else np.sign(level)
        assert volts[part.slice] == pytest.approx(sign * SUPPLY_V * PWM_HZ)
    for part in subject.timeline.parts:
        if part.open:
            assert not volts[part.slice].any()


def test_it_is_there_where_one_half_bridge_switches_and_no_reading_shows_it() -> None:
    usual = PULSE_DISTORTION.prior(of(commanded()), 0)
    assert usual is not None
    assert (usual.sd, usual.mean) == (USUAL_S, 0.0)
    assert PULSE_DISTORTION.prior(record("commanded"), 0) is not None  # volts, of a stated supply
    for name in ("measured", "diodes", "log"):
        assert PULSE_DISTORTION.prior(record(name), 0) is None
    bare = commanded()
    unknown = replace(bare, wiring=replace(bare.wiring, pwm_hz=0.0))
    full = commanded(lambda volts: float(np.sign(volts)))
    for capture in (unknown, full, commanded(decay=Decay.FAST)):
        assert PULSE_DISTORTION.prior(of(capture), 0) is None


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [LONGER_S, 0.0])
def test_a_fit_finds_it_and_the_motor_beside_it(seconds: float) -> None:
    found = fit([longer_by(seconds)])
    size = found.nuisance[PULSE_DISTORTION.name]
    assert size.value == pytest.approx(seconds, abs=4.0 * size.total)
    assert size.total < LONGER_S / 4.0
    for name, truth in FAULHABER.items():
        p = found.parameters[name]
        assert p.value == pytest.approx(truth, abs=4.0 * p.total)
    assert [s.code for s in found.suspects if s.strength == "named"] == []
