"""A freewheeling current or a locked rotor, alone or beside a voltage and a dead speed sensor."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.partial import current_transient_alone
from tests.six_parameters import fit

R, L, FULL_A, AT_S = 2.0, 2e-3, 1.5, 4e-3
TIME = np.arange(0.0, 0.02, 1e-4)
NOISE = 4e-3 * np.random.default_rng(0).standard_normal(len(TIME))
SINCE = np.maximum(TIME - AT_S, 0.0)
DECAY = FULL_A * np.exp(-SINCE * R / L) + NOISE
RISE = FULL_A - DECAY + 2.0 * NOISE
ON = np.where(TIME < AT_S, 0.0, R * FULL_A)
UNITS = {CURRENT: "A", VOLTAGE: "V", SPEED: "rad/s"}


def log(**columns: np.ndarray) -> Capture:
    channels = {n: Channel(n, UNITS.get(n, "1"), y) for n, y in columns.items()}
    return Capture(np.rint(TIME * 1e9).astype(np.int64), 1e9, channels)


@pytest.mark.slow
@pytest.mark.parametrize(
    "capture",
    [
        log(current=DECAY),
        log(current=RISE),
        log(current=-DECAY, terminal_voltage=0.0 * TIME),
        log(current=DECAY, terminal_voltage=0.0 * TIME, speed=0.0 * TIME),
        log(current=RISE, command=0.25 * (ON > 0.0)),
    ],
    ids=["decay", "rise", "shorted", "locked", "commanded"],
)
def test_a_current_alone_gives_the_electrical_time_constant(capture: Capture) -> None:
    found = fit([capture])
    known = found.combinations["L/R"]
    assert known.interval_95[0] < L / R < known.interval_95[1]
    assert known.total < 0.02 * L / R
    assert {p.status for p in found.parameters.values()} == {"not_identifiable"}
    inductance = fit([capture], fix={"R": R}).parameters["L"]
    assert inductance.interval_95[0] < L < inductance.interval_95[1]


def test_it_takes_no_log_that_says_more() -> None:
    assert current_transient_alone.suits([log(current=DECAY)])
    more = {"terminal_voltage": ON, "speed": 100.0 * SINCE, "torque": ON}
    for name, readings in more.items():
        assert not current_transient_alone.suits([log(current=DECAY, **{name: readings})])
    assert not current_transient_alone.suits([])


@pytest.mark.slow
def test_a_rotor_that_a_dead_sensor_sees_standing_is_locked() -> None:
    volts = ON + 0.01 * np.random.default_rng(1).standard_normal(len(TIME))
    found = fit([log(current=RISE, terminal_voltage=volts, speed=0.0 * TIME)])
    assert "rotor_held" in {d.code for d in found.diagnostics}
    for name, true in (("R", R), ("L", L)):
        p = found.parameters[name]
        assert p.value == pytest.approx(true, abs=4.0 * p.total)


@pytest.mark.slow
def test_a_current_that_is_no_exponential_is_refused_or_doubted() -> None:
    with pytest.raises(DataError, match="never changes"):
        fit([log(current=NOISE)])
    with pytest.raises(DataError, match="no exponential"):
        fit([log(current=100.0 * TIME + NOISE)])
    two = DECAY + FULL_A * np.exp(-SINCE * 0.1 * R / L)
    assert "lack_of_fit" in {d.code for d in fit([log(current=two)]).diagnostics}


@pytest.mark.parametrize(
    ("lags", "wander", "lacks"),
    [((0.1,), 3.9, False), ((0.1,), 4.1, True), ((0.1, 0.02), 1.0, True)],
)
def test_a_second_lag_or_slow_residuals_are_no_single_exponential(
    lags: tuple[float, ...], wander: float, lacks: bool
) -> None:
    rise: Any = SimpleNamespace(lags=lags, wander=wander)
    said = [(d.code, d.severity) for d in current_transient_alone._said(rise)]
    first = [("lack_of_fit", "warning")] if lacks else []
    assert said == [*first, ("current_alone", "info")]
