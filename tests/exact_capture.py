"""Captures that obey the fit's own equations exactly, made without the fit's own code."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture, Channel, Phase
from motorid.motor.reading import Output, Quantity, Stretch
from motorid.program import Decay, Program, Step, StepKind
from tests.motor_reference import Reference

FAULHABER = {"R": 2.6, "L": 180e-6, "K": 7.68e-3, "B": 3e-7, "J": 3.9e-7, "T0": 3e-4}
CLOCK_HZ = 1e6


@dataclass(frozen=True)
class Plan:
    """Rest, two levels, coast: fractions of the run, volts of the drives."""

    volts: tuple[float, ...] = (6.0, 3.0)
    count: int = 2000
    period_s: float = 1e-4
    aperture_s: float = 5e-5
    delay_s: float = 2e-6


def clean_capture(motor: dict[str, float], plan: Plan = Plan()) -> Capture:
    """A noise-free capture of current, position and terminal voltage; its readings are read-only.

    Each is integrated once a process.
    """
    return _clean_capture(tuple(motor.items()), plan)


@cache
def _clean_capture(items: tuple[tuple[str, float], ...], plan: Plan) -> Capture:
    motor = dict(items)
    n, h = plan.count, plan.period_s
    rest = n // 20
    each = (n - 4 * rest) // (len(plan.volts) + 1)
    steps = [Step(StepKind.COAST, rest * h)]
    steps += [Step(StepKind.DRIVE_VOLTS, each * h, v, Decay.SYNCHRONOUS_SLOW) for v in plan.volts]
    steps.append(Step(StepKind.COAST, n * h))
    starts = [0, *(rest + k * each for k in range(len(plan.volts) + 1))]
    v, stretches = np.zeros(n), []
    for start, step in zip(starts, steps, strict=True):
        v[start + 1 :] = step.level
        stretches.append(Stretch(start + 1, step.kind == StepKind.COAST, 0.0, 1e9))
    reference = Reference(tuple(motor.values()), rtol=1e-10)
    reference.run(h, v, stretches)
    t = np.arange(n) * h
    speed = reference.read(Output(Quantity.SPEED, h), t)
    opened = np.zeros(n, dtype=bool)
    opened[: starts[1] + 1] = opened[starts[-1] + 1 :] = True
    channels = {
        CURRENT: Channel(
            CURRENT, "A",
            reference.read(Output(Quantity.CURRENT, plan.aperture_s, plan.delay_s), t),
            kind="mean", aperture_s=plan.aperture_s, delay_s=plan.delay_s,
        ),
        POSITION: Channel(POSITION, "rad", reference.read(Output(Quantity.POSITION), t)),
        VOLTAGE: Channel(
            VOLTAGE, "V", np.where(opened, motor["K"] * speed, v),
            kind="mean", aperture_s=h, sense="terminals",
        ),
    }  # fmt: skip
    ticks = (np.arange(n) * round(h * CLOCK_HZ)).astype(np.int64)
    for shared in (ticks, *(channel.raw for channel in channels.values())):
        shared.flags.writeable = False
    return Capture(
        ticks=ticks,
        clock_hz=CLOCK_HZ,
        channels=channels,
        program=Program(tuple(steps)),
        phases=tuple(Phase(k, round(s * h * CLOCK_HZ)) for k, s in enumerate(starts)),
    )


def noisy(
    capture: Capture, seed: int, current_a: float, angle_rad: float, volts: float = 0.0
) -> Capture:
    """White Gaussian noise of those standard deviations; ``volts`` only while the bridge is open.

    The voltage that drives the motor stays exact, as the model takes it to be.
    """
    rng = np.random.default_rng(seed)
    n = len(capture)
    channels = dict(capture.channels)
    open_ = np.zeros(n, dtype=bool)
    open_[: n // 20 + 1] = open_[capture.phases[-1].tick // round(1e6 * capture.period_s) + 1 :] = (
        True
    )
    for name, sd in ((CURRENT, current_a), (POSITION, angle_rad), (VOLTAGE, volts)):
        noise = sd * rng.standard_normal(n)
        if name == VOLTAGE:
            noise = np.where(open_, noise, 0.0)
        channels[name] = replace(channels[name], raw=channels[name].raw + noise)
    return replace(capture, channels=channels)


def ended(capture: Capture) -> Capture:
    """The capture whose program ends where its readings do: none is missing."""
    assert capture.program is not None
    *steps, last = capture.program.steps
    lasts = (capture.ticks[-1] - capture.phases[-1].tick) / capture.clock_hz
    return replace(capture, program=Program((*steps, replace(last, duration_s=float(lasts)))))
