"""Methods by name on somebody else's log: they answer, or say in one sentence what they lack."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from bench.foreign.plant import Motor, Trace, turn
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from tests.six_parameters import fit

MOTOR = Motor()
NOISE = {VOLTAGE: 0.01, CURRENT: 5e-3, SPEED: 0.1}


def step_and_coast(t: float, w: float) -> float | None:
    if t > 0.3:
        return None
    return -6.0 if t > 0.03 else 0.0


@cache
def run() -> Trace:
    return turn(MOTOR, step_and_coast, 0.36)


def log(begins_s: float = 4e-4) -> Capture:
    """A step the other way, and a coast whose voltage reads zero."""
    true, rng = run(), np.random.default_rng(2)
    stamps = np.arange(begins_s, 0.355, 1e-3)
    volts = np.where(stamps > 0.3, 0.0, true.at(true.volts, stamps))
    series = {
        VOLTAGE: volts, CURRENT: true.at(true.current, stamps), SPEED: true.at(true.speed, stamps),
    }  # fmt: skip
    channels = {
        name: Channel(name, unit, y + NOISE[name] * rng.standard_normal(len(y)))
        for (name, y), unit in zip(series.items(), ("V", "A", "rad/s"), strict=True)
    }
    return Capture(np.rint(stamps * 1e6).astype(np.int64), 1e6, channels)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["cuckoo-m", "gwo-m", "jaya-m", "nls"])
def test_a_method_answers_on_a_log(method: str) -> None:
    found = fit([log()], method=method, budget=400)
    codes = {d.code for d in found.diagnostics}
    assert "bridge_open" in codes
    assert ("linear_model" in codes) == (method != "nls")
    for name in ("R", "K", "J"):
        p = found.parameters[name]
        if p.value is not None:
            assert p.value == pytest.approx(getattr(MOTOR, name), rel=1.5)
    if method == "nls":
        assert found.parameters["K"].value == pytest.approx(MOTOR.K, rel=0.02)
        assert found.parameters["R"].value == pytest.approx(MOTOR.R, rel=0.1)


def test_a_method_that_finds_no_motor_says_what_its_model_lacks() -> None:
    with pytest.raises(DataError, match=r"lacks Coulomb friction.*use the method ml"):
        fit([log()], method="steiglitz-mcbride")


@pytest.mark.parametrize("method", ["nls", "pso", "jaya-m"])
def test_a_log_that_begins_in_motion_is_no_search_s(method: str) -> None:
    with pytest.raises(DataError, match="begin at rest"):
        fit([log(0.08)], method=method, budget=100)
