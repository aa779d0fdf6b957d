"""Logs with a channel that is late or smoothed, of which nobody says anything.

The motor is integrated in small steps by a program that shares nothing with the fit.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from bench.foreign.plant import STEP_S, Motor, Trace, turn
from motorid.capture.model import Capture
from motorid.capture.table import read_table
from motorid.estimate.results.estimate import Estimate
from tests.six_parameters import fit

Floats = NDArray[np.float64]
Spoil = Callable[[Floats], Floats]

MOTOR, PERIOD_S = Motor(), 1e-3
LEVELS, HELD_S = (0.0, 6.0, 3.0, -6.0, -3.0, 4.5), 0.15
SMOOTH = {"R": 0.02, "K": 0.01, "J": 0.01}  # relative errors that no such fault may leave


@cache
def truth() -> Trace:
    return turn(MOTOR, lambda t, w: LEVELS[min(int(t / HELD_S), 5)], 6 * HELD_S)


def smoothed(samples: float) -> Spoil:
    """Behind a low-pass of the first order."""
    kept = np.exp(-STEP_S / (samples * PERIOD_S))
    return lambda x: np.asarray(lfilter([1.0 - kept], [1.0, -kept], x - x[0]) + x[0])


def late(samples: int) -> Spoil:
    steps = round(samples * PERIOD_S / STEP_S)
    return lambda x: np.concatenate([np.full(steps, x[0]), x[:-steps]])


def logged(folder: Path, **spoilt: Spoil) -> Capture:
    """The log with some of its columns v, i, w spoilt."""
    true, rng = truth(), np.random.default_rng(4)
    stamps = np.arange(0.005, 6 * HELD_S - 0.01, PERIOD_S)
    at = np.rint(stamps / STEP_S).astype(int)
    table = [stamps]
    for name, series in (("v", true.volts), ("i", true.current), ("w", true.speed)):
        shown = spoilt[name](series) if name in spoilt else series
        noise = 2e-3 if name != "v" else 1e-3
        table.append(shown[at] + noise * np.abs(series).max() * rng.standard_normal(len(at)))
    rows = "\n".join(",".join(f"{x:.7g}" for x in row) for row in np.column_stack(table))
    path = folder / "log.csv"
    path.write_text(f"t,v,i,w\n{rows}\n", encoding="utf-8")
    return read_table(path, ["time=t:s", "voltage=v:V", "current=i:A", "speed=w:rad/s"])


def named(found: Estimate) -> set[str]:
    return {s.code for s in found.suspects if s.strength == "named"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "spoil", "code"),
    [
        ("i", smoothed(3.0), "current_filtered"),
        pytest.param("w", smoothed(20.0), "speed_filtered", marks=pytest.mark.study),
        pytest.param("v", smoothed(5.0), "voltage_filtered", marks=pytest.mark.study),
        pytest.param("i", late(10), "current_lag", marks=pytest.mark.study),
        pytest.param("w", late(10), "speed_lag", marks=pytest.mark.study),
        ("v", late(10), "voltage_lag"),
    ],
)
def test_it_is_named_and_the_motor_is_right(
    column: str, spoil: Spoil, code: str, tmp_path: Path
) -> None:
    found = fit([logged(tmp_path, **{column: spoil})])
    assert code in named(found)
    for name, most in SMOOTH.items():
        value = found.parameters[name].value
        assert value is not None
        assert abs(value / getattr(MOTOR, name) - 1.0) < most, name


@pytest.mark.slow
def test_a_sound_log_is_not_accused(tmp_path: Path) -> None:
    found = fit([logged(tmp_path)])
    assert not named(found)
    for name, p in found.parameters.items():
        assert p.interval_95 is not None
        low, high = p.interval_95
        reach = high - low  # twice the half-width: one log of many may be a little outside
        assert p.value is not None
        assert abs(p.value - getattr(MOTOR, name)) < reach, name


@pytest.mark.slow
def test_an_offset_that_nobody_stated_is_estimated(tmp_path: Path) -> None:
    shift = 0.01 * float(np.abs(truth().current).max())
    found = fit([logged(tmp_path, i=lambda x: x + shift)])
    assert found.nuisance["current offset"].value == pytest.approx(shift, rel=0.1)
    value, true = found.parameters["B"], MOTOR.B
    assert value.value is not None
    assert value.interval_95 is not None
    assert value.interval_95[0] - true < 0 < value.interval_95[1] - true


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "spoil", "stated"),
    [
        ("i", lambda x: smoothed(1.5)(smoothed(1.5)(x)), {"current": "1.5ms,2"}),
        ("w", lambda x: smoothed(10.0)(smoothed(10.0)(x)), {"speed": "10ms,2"}),
        ("v", smoothed(5.0), {"voltage": "5ms"}),
    ],
)
def test_a_declared_low_pass_is_modelled(
    column: str, spoil: Spoil, stated: dict[str, str], tmp_path: Path
) -> None:
    logged(tmp_path, **{column: spoil})
    maps = ["time=t:s", "voltage=v:V", "current=i:A", "speed=w:rad/s"]
    found = fit([read_table(tmp_path / "log.csv", maps, filter=stated)])
    for name, most in SMOOTH.items():
        value = found.parameters[name].value
        assert value is not None
        assert abs(value / getattr(MOTOR, name) - 1.0) < most, name
    assert not named(found)
