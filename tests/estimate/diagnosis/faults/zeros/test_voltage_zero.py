"""A log whose voltage reads something at no voltage."""

from __future__ import annotations

import numpy as np
import pytest

from bench.foreign.plant import Motor, turn
from motorid import fit
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.faults.zeros import voltage_zero
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.results.status import Status

MOTOR, OFFSET_V = Motor(), 0.2
NOISE = {VOLTAGE: 0.01, CURRENT: 5e-3, SPEED: 0.2}


def square(offset_v: float) -> Capture:
    """Six reversals at 6 V, of two levels only, at 1 kHz."""
    true = turn(MOTOR, lambda t, w: 6.0 if t % 0.2 < 0.1 else -6.0, 0.6)
    stamps, rng = np.arange(0.4e-3, 0.599, 1e-3), np.random.default_rng(3)
    shown = {VOLTAGE: true.volts, CURRENT: true.current, SPEED: true.speed}
    channels = {
        name: Channel(name, unit, true.at(y, stamps) + NOISE[name] * rng.standard_normal(599)
                      + (offset_v if name == VOLTAGE else 0.0))
        for (name, y), unit in zip(shown.items(), ("V", "A", "rad/s"), strict=True)
    }  # fmt: skip
    return Capture(np.rint(stamps * 1e6).astype(np.int64), 1e6, channels)


@pytest.mark.slow
@pytest.mark.parametrize("offset_v", [0.0, OFFSET_V])
def test_an_offset_of_the_voltage_is_named_and_nothing_that_looks_like_it(offset_v: float) -> None:
    found = fit(square(offset_v), model="six")
    named = {s.code for s in found.suspects if s.strength == "named"}
    assert named == ({"voltage_offset"} if offset_v else set())
    for name in PARAMETERS:
        p = found.parameters[name]
        if p.value is not None and p.total is not None:
            assert p.value == pytest.approx(getattr(MOTOR, name), abs=4.0 * p.total)
    assert found.parameters["R"].status is Status.ESTIMATED


def test_the_voltage_of_a_program_is_not_accused() -> None:
    (one,) = voltage_zero.hypotheses([MotorRecord(square(0.0), PARAMETERS, {})])
    assert "+0.2 V at no voltage" in one.words(np.array([0.2])).evidence
    assert one.lower[0] == -one.upper[0]
    assert voltage_zero.hypotheses([]) == []
