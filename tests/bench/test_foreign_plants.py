"""Plants that are not ours: their traces obey the truth that is claimed of them, and the chain theirs."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.foreign import drawn, joint, spice
from bench.foreign.chain import Trace, capture, seconds
from bench.foreign.drawn import Iron, Rig
from bench.foreign.score import How, score, table
from motorid.capture.model import CURRENT, POSITION, VOLTAGE

BALANCE = 2e-3  # of the largest sum, which the integrators keep


def short(seed: int, **more: bool) -> Rig:
    return drawn.shortened(drawn.draw(seed, **more))


def balances(rig: Rig, trace: Trace, torque: np.ndarray, volts: np.ndarray) -> list[float]:
    """What is left of J dω and of the fluxes, over the largest of their sums, from rest to rest."""
    left = []
    for rate in (torque, volts):
        area = np.concatenate([[0.0], np.cumsum(np.diff(trace.time_s) * (rate[1:] + rate[:-1]) / 2)])
        left.append(area)
    spun = left[0] - rig.truth["J"] * trace.speed
    linked = left[1] - rig.truth["L"] * trace.current
    return [
        float(np.abs(spun).max() / np.abs(rig.truth["J"] * trace.speed).max()),
        float(np.abs(linked).max() / np.abs(rig.truth["L"] * trace.current).max()),
    ]


def plain_torque(rig: Rig, trace: Trace) -> np.ndarray:
    t, w = rig.truth, trace.speed
    return t["K"] * trace.current - t["B"] * w - t["T0"] * np.tanh(w / (1e-3 * rig.idle_rad_s))


@pytest.mark.slow
def test_a_netlist_obeys_the_motor_that_is_claimed(tmp_path: Path) -> None:
    """Seed 2 reads at the terminals, and has no ripple."""
    if not spice.available():
        pytest.skip("no ngspice")
    rig = short(2)
    assert rig.sense == "terminals"
    trace = spice.run(rig, tmp_path)
    assert trace.time_s[-1] == pytest.approx(seconds(rig))
    assert trace.speed.max() > 0.1 * rig.idle_rad_s
    assert trace.speed.min() < -0.05 * rig.idle_rad_s
    volts = trace.sensed - rig.truth["R"] * trace.current - rig.truth["K"] * trace.speed
    volts[trace.current == 0.0] = 0.0
    assert balances(rig, trace, plain_torque(rig, trace), volts)[0] < BALANCE
