"""A motor behind a bridge whose pulses lie anywhere in their PWM periods, in small steps.

It shares nothing with fit or simulator: the current runs exponentially between edges, the speed by
the mean torque of each piece.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Channel, Phase, Wiring
from motorid.program import Decay, Program, Step, StepKind

MOTOR = {"R": 2.0, "L": 1.2e-3, "K": 0.02, "B": 4e-6, "J": 4e-6, "T0": 1.5e-3}
SUPPLY_V, PWM_HZ, CLOCK_HZ = 12.0, 10_000.0, 16e6
DUTIES = (0.0, 0.3, 0.6, -0.5, -0.8, 0.0, 0.4)  # 0: a brake
LENGTH = 300  # PWM periods at each, one sample a period
PIECES = 6  # of each on or off part
COUNTS = 4096


@cache
def capture_of(place: float, seed: int = 1, stated: float | None = None) -> Capture:
    """With so much of each period's off part before its pulse; the rig states ``stated``."""
    m, rng = MOTOR, np.random.default_rng(seed)
    levels = np.repeat(DUTIES, LENGTH)
    count = len(levels)
    amperes, angle = np.zeros(count + 1), np.zeros(count + 1)
    i = w = turned = 0.0
    for k, duty in enumerate(levels):
        off = (1.0 - abs(duty)) / PWM_HZ
        parts = ((0.0, place * off), (math.copysign(SUPPLY_V, duty), abs(duty) / PWM_HZ),
                 (0.0, (1.0 - place) * off))  # fmt: skip
        charge = 0.0
        for volts, seconds in parts:
            h = seconds / PIECES
            for _ in range(PIECES if seconds else 0):
                end = (volts - m["K"] * w) / m["R"]
                decay = math.exp(-m["R"] * h / m["L"])
                mean = end + (i - end) * (1.0 - decay) * m["L"] / (m["R"] * h)
                i = end + (i - end) * decay
                pull = m["K"] * mean - m["B"] * w
                rub = math.copysign(min(m["T0"], abs(pull)) if not w else m["T0"], w or pull)
                new = w + h / m["J"] * (pull - rub)
                new = 0.0 if new * w < 0.0 else new
                turned += h * (w + new) / 2.0
                w, charge = new, charge + mean * h
        amperes[k + 1], angle[k + 1] = charge * PWM_HZ, turned
    step = 16.0 / 4096
    shown = np.round(amperes / step + rng.standard_normal(count + 1)) * step
    volts = np.concatenate([[0.0], levels * SUPPLY_V]) + 0.01 * rng.standard_normal(count + 1)
    period = round(CLOCK_HZ / PWM_HZ)
    window = 1.0 / PWM_HZ
    steps = tuple(
        Step(StepKind.DRIVE_DUTY, LENGTH / PWM_HZ, d, Decay.SYNCHRONOUS_SLOW) if d
        else Step(StepKind.BRAKE, LENGTH / PWM_HZ)
        for d in DUTIES
    )  # fmt: skip
    return Capture(
        ticks=np.arange(count + 1, dtype=np.int64) * period,
        clock_hz=CLOCK_HZ,
        channels={
            CURRENT: Channel(CURRENT, "A", shown, kind="mean", aperture_s=window,
                             resolution=step, noise=1.1 * step, gain_uncertainty=1e-3),
            VOLTAGE: Channel(VOLTAGE, "V", volts, kind="mean", aperture_s=window, noise=0.01,
                             gain_uncertainty=1e-3, sense="terminals"),
            POSITION: Channel(POSITION, "rad", np.floor(angle * COUNTS / (2.0 * np.pi)),
                              2.0 * np.pi / COUNTS, resolution=2.0 * np.pi / COUNTS),
        },
        wiring=Wiring(counts_per_turn=COUNTS, pwm_hz=PWM_HZ, supply_voltage_v=SUPPLY_V,
                      pwm_alignment=stated),
        program=Program(steps),
        phases=tuple(Phase(k, k * LENGTH * period) for k in range(len(DUTIES))),
    )  # fmt: skip
