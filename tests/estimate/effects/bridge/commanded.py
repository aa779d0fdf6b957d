"""Captures of a motor that is driven by duty of a supply which is read, made to be exact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture, Channel, Wiring
from motorid.program import Decay, Program, StepKind
from tests.exact_capture import FAULHABER, Plan, clean_capture, ended, noisy

PWM_HZ = 200e3  # its ripple is nothing beside the readings'
SUPPLY_V = 8.0
PLAN = Plan(volts=(2.0, 5.0, 8.0, -3.0, -6.5))  # one of them at full duty

Floats = NDArray[np.float64]


def commanded(
    duty: Callable[[float], float] = lambda volts: volts / SUPPLY_V,
    path_ohm: float = 0.0,
    decay: Decay = Decay.SYNCHRONOUS_SLOW,
) -> Capture:
    """By duty of the volts that the motor gets. The supply is read where ``path_ohm`` of it has not
    yet fallen, and is so high that the motor gets just these. Volts without pulses have no place
    of theirs in a period: they are stated to begin with it.
    """
    capture = ended(clean_capture(FAULHABER, PLAN))
    assert capture.program is not None
    steps = tuple(
        s if s.kind == StepKind.COAST
        else replace(s, kind=StepKind.DRIVE_DUTY, level=duty(s.level), decay=decay)
        for s in capture.program.steps
    )  # fmt: skip
    starts = [phase.tick for phase in capture.phases]
    now = np.searchsorted(starts, capture.ticks, side="left") - 1
    level = np.array([s.level for s in steps])[np.maximum(now, 0)]
    drawn = path_ohm * level * capture.channels[CURRENT].values
    supply = Channel(
        SUPPLY, "V", SUPPLY_V + drawn, kind="mean", aperture_s=capture.period_s, sense="supply"
    )
    kept = {n: c for n, c in capture.channels.items() if n != VOLTAGE}
    return replace(
        capture, channels={**kept, SUPPLY: supply}, program=Program(steps),
        wiring=Wiring(supply_voltage_v=SUPPLY_V, pwm_hz=PWM_HZ, pwm_alignment=0.0),
    )  # fmt: skip


def longer_by(seconds: float, seed: int = 1) -> Capture:
    """Whose pulses are so much longer than its duty says, with noise."""

    def duty(volts: float) -> float:
        full = abs(volts) >= SUPPLY_V
        return volts / SUPPLY_V - (0.0 if full else np.sign(volts) * seconds * PWM_HZ)

    return with_noise(commanded(duty), seed)


def with_noise(capture: Capture, seed: int = 1) -> Capture:
    """1 mA and .1 mrad of it."""
    volts = capture.channels[SUPPLY]
    noise = noisy(replace(capture, channels={**capture.channels, VOLTAGE: volts}), seed, 1e-3, 1e-4)
    return replace(capture, channels={n: c for n, c in noise.channels.items() if n != VOLTAGE})
