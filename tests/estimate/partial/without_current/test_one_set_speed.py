"""A controller's start to one set speed: how the drive begins counts."""

from __future__ import annotations

import numpy as np

from motorid.capture.model import Capture, Channel
from motorid.estimate.partial.levels.one_level import as_one
from motorid.estimate.partial.without_current import fit as module

TAU_S, GAIN, FRICTION, PERIOD_S = 0.08, 2.2, 30.0, 0.01


def log() -> Capture:
    """A feed-forward and a PI controller at 10 ms: the command stays near one level."""
    noise = np.random.default_rng(5)
    speed = total = 0.0
    rows = []
    for k in range(250):
        read = speed + 0.5 * noise.standard_normal()
        error = 200.0 - read if k >= 30 else 0.0
        total += error * PERIOD_S
        command = 112.0 + 0.1 * error + 0.4 * total if k >= 30 else 0.0
        rows.append((command, read))
        steady = GAIN * max(command - FRICTION, 0.0)
        speed = steady + (speed - steady) * np.exp(-PERIOD_S / TAU_S)
    command, speeds = np.array(rows).T
    channels = {
        "command": Channel("command", "1", command),
        "speed": Channel("speed", "rad/s", speeds),
    }
    return Capture(np.arange(len(rows)) * 10_000_000, 1e9, channels)


def test_a_drive_that_settles_while_the_motor_starts_is_no_single_step() -> None:
    """As one level its time constant was 72 ± 5 ms: a long record hides how the drive began."""
    found = module.fit([log()], {})
    for name, true in (("JR/(K²+RB)", TAU_S), ("K/(K²+RB)", GAIN), ("T0·R/K", FRICTION)):
        p = found.combinations[name]
        assert abs(p.value - true) < 2.0 * p.total
    shown = as_one(found)
    for name in ("K/(K²+RB)", "T0·R/K"):
        assert shown.combinations[name].value is None
    whole = shown.combinations["(K−T0·R/V)/(K²+RB)"]
    assert whole.value == found.combinations["K/(K²+RB)"].value
    assert shown.diagnostics[0].code == "one_level"
