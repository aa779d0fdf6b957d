"""How a log's readings came, where nobody says so: means, low-passes of second order, jumps."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import bilinear, butter, lfilter

from bench.foreign.plant import STEP_S
from bench.stranger.logs import Log, answer
from bench.stranger.plant import draw
from motorid.capture.model import SPEED
from motorid.estimate.fit.joint_fit import solved
from motorid.identify import fit
from tests.estimate.fit.logs.test_log_fit import MOTOR, PERIOD_S, Floats, logged

EVERY = round(PERIOD_S / STEP_S)
TRUTH = {name: getattr(MOTOR, name) for name in ("R", "L", "K", "J")}
SAMPLES = 4.0  # of the low-pass


def counted(speed: Floats) -> Floats:
    """Turned since the reading before, over that time."""
    return np.asarray(lfilter(np.full(EVERY, 1.0 / EVERY), [1.0], speed))


def behind_butterworth(current: Floats) -> Floats:
    analogue = butter(2, 1.0 / (SAMPLES * PERIOD_S), analog=True)
    return np.asarray(lfilter(*bilinear(*analogue, 1.0 / STEP_S), current))


@pytest.mark.slow
def test_a_speed_of_counted_edges_is_a_mean(tmp_path: Path) -> None:
    records, _ = solved([logged(tmp_path, w=counted)], {}, ())
    assert records[0].capture.channels[SPEED].window_s == pytest.approx(PERIOD_S, rel=1e-6)


@pytest.mark.slow
def test_behind_a_counted_speed_a_ramp_is_held_from_row_to_row(tmp_path: Path) -> None:
    """A speed that is late by half a row speaks for a voltage that is: J was .8 % off at 10 u."""
    rng = np.random.default_rng(2)
    motor = draw(rng)
    log = Log("ramp", rate=40.0 / motor.tau_s, bits=14, noise=0.3, counts=4096)
    found = answer(log, motor, rng, tmp_path)
    assert found.estimate is not None
    assert not [s for s in found.estimate["suspects"] if s["strength"] == "named"]
    inertia = found.estimate["parameters"]["J"]
    low, high = inertia["interval_95"]
    assert low < motor.truth["J"] < high
    assert inertia["value"] == pytest.approx(motor.truth["J"], rel=2e-3)


@pytest.mark.slow
def test_a_current_behind_a_low_pass_of_second_order_tells_the_inductance(tmp_path: Path) -> None:
    found = fit([logged(tmp_path, i=behind_butterworth)])
    assert "current_filtered" in {s.code for s in found.suspects if s.strength == "named"}
    size = found.nuisance["current smoothing of second order"].value or 0.0
    assert size == pytest.approx(SAMPLES * PERIOD_S, rel=0.1)
    for name, true in TRUTH.items():
        one = found.parameters[name]
        assert one.value is not None
        assert one.total is not None
        assert abs(one.value - true) < 4.0 * one.total, name
        assert one.value == pytest.approx(true, rel=0.2 if name == "L" else 0.02), name
    assert (found.parameters["L"].total or 1.0) < 0.1 * MOTOR.L  # none worse is its rival


def over_samples(count: int) -> Callable[[Floats], Floats]:
    """Means over that many samples of the log, before each stamp."""
    width = count * EVERY
    return lambda current: np.asarray(lfilter(np.full(width, 1.0 / width), [1.0], current))


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, pytest.param(7, marks=pytest.mark.study)])
def test_a_current_that_is_a_mean_over_several_samples_is_known_as_one(
    tmp_path: Path, count: int
) -> None:
    found = fit([logged(tmp_path, i=over_samples(count))])
    (named,) = (s for s in found.suspects if s.code == "current_averaged")
    assert named.allowed
    assert f"({count} samples of the log)" in named.evidence
    for name in ("R", "K", "J"):
        one = found.parameters[name]
        assert one.value == pytest.approx(TRUTH[name], rel=0.01), name
    L = found.parameters["L"]
    if L.interval_95 is not None:
        low, high = L.interval_95
        assert low < TRUTH["L"] < high


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, pytest.param(4, marks=pytest.mark.study)])
def test_a_current_that_is_late_by_whole_samples_is_taken_earlier(
    tmp_path: Path, count: int
) -> None:
    """Its lag was found between samples, and the speed taken for a mean. Between two jumps of a
    held voltage little tells a part of a sample from a low-pass, or from a voltage that is early.
    """

    def late(current: Floats) -> Floats:
        return np.concatenate([np.full(count * EVERY, current[0]), current[: -count * EVERY]])

    found = fit([logged(tmp_path, i=late)])
    (named,) = (s for s in found.suspects if s.code == "current_lag" and s.strength == "named")
    assert named.allowed
    said = re.search(r"\((\S+) samples of the log\)", named.evidence)
    assert said is not None
    assert float(said[1]) == pytest.approx(count, abs=0.3)
    for name, true in TRUTH.items():
        one = found.parameters[name]
        assert one.interval_95 is not None
        assert one.interval_95[0] < true < one.interval_95[1], name
        assert one.value == pytest.approx(true, rel=0.01), name
