"""A motor by exact steps of its linear law; where it turns round, its friction does so too.

Matrices made once carry current, speed and angle on. A supply may have a resistance or a limit, a
bridge may open, a rotor may be locked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from bench.mistakes.plant import Motor

Floats = NDArray[np.float64]
CLAMP = 1.05, 1.4  # an open bridge holds the terminals at so many times the supply, and V more


@dataclass(frozen=True)
class Source:
    """Before the motor: ohms, and the most amperes; ``locked``: its rotor."""

    ohms: float = 0.0
    limit_a: float = math.inf
    locked: bool = False


@dataclass(frozen=True)
class Trace:
    """What happened at every tick; ``drawn``: A that a supply gives to a bridge."""

    asked: Floats
    terminal: Floats
    current: Floats
    speed: Floats
    angle: Floats
    drawn: Floats


def draw(rng: np.random.Generator) -> Motor:
    """A motor of 0.5 to 500 W, by its power, its speed and its time constants."""

    def between(low: float, high: float) -> float:
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    power = between(0.5, 500.0)
    volts = float(rng.choice((3, 6, 12) if power < 5 else (6, 12, 24) if power < 60 else (24, 48)))
    efficiency = min(max(0.55 + 0.11 * math.log10(power) + rng.normal(0, 0.05), 0.4), 0.9)
    stall_a = 4.0 * power / efficiency**2 * rng.uniform(0.8, 2.0) / volts
    top = rng.uniform(2500.0, 12_000.0) * math.pi / 30.0
    idle = rng.uniform(0.02, 0.12) * (1.0 - 0.15 * math.log10(power + 1.0))
    R, K, dry = volts / stall_a, volts * (1.0 - idle) / top, rng.uniform(0.3, 0.9)
    tau_s = between(7e-3, 0.08)
    rise_s, drag = min(between(5e-5, 2.5e-3), tau_s / 8.0), K * idle * stall_a
    J, B = tau_s * K**2 / R, (1.0 - dry) * drag / top
    return Motor(R, rise_s * R, K, B, J, dry * drag, volts)


def turn(m: Motor, wave: Floats, dt: float, source: Source) -> Trace:
    """The motor under ``wave`` (n,) V, one each ``dt`` s; NaN: the bridge is open."""
    ohms = m.R + source.ohms
    law = np.zeros((5, 5))  # of current, speed, voltage, friction, angle
    law[0, :3] = -ohms / m.L, -m.K / m.L, 1.0 / m.L
    law[1, :4] = m.K / m.J, -m.B / m.J, 0.0, -1.0 / m.J
    law[4, 1] = 1.0
    rows = expm(law * dt)[[0, 1, 4], :4].tolist()
    fades, decays = math.exp(-m.B / m.J * dt), math.exp(-ohms / m.L * dt)
    slows = (1.0 - fades) / m.B if m.B else dt / m.J
    clamp = CLAMP[0] * float(np.nanmax(np.abs(wave))) + CLAMP[1]
    shown, i, w, angle = np.zeros((4, len(wave))), 0.0, 0.0, 0.0
    for k, v in enumerate(wave.tolist()):
        opened, gone = math.isnan(v), i == 0.0
        if opened:
            v = m.K * w if gone else -math.copysign(clamp, i)
        elif abs(i) > source.limit_a:
            v = ohms * math.copysign(source.limit_a, i) + m.K * w
        shown[:, k] = v if opened else v - source.ohms * i, i, w, angle
        if source.locked:
            i = i * decays + v / ohms * (1.0 - decays)
            continue
        sticks = w == 0.0 and abs(m.K * i) <= m.T0
        drag = m.K * i if sticks else math.copysign(m.T0, w or i)
        if opened and gone:
            state = 0.0, 0.0 if sticks else w * fades - slows * drag, angle + w * dt
        else:
            before = (i, w, v, drag)
            i_, w_, more = (sum(a * x for a, x in zip(row, before, strict=True)) for row in rows)
            state = (0.0 if opened and i_ * i < 0.0 else i_), 0.0 if sticks else w_, angle + more
        if w * state[1] < 0.0:  # it turned round within the tick
            share = w / (w - state[1])
            torque = m.K * (i + share * (state[0] - i))
            net = max(abs(torque) - m.T0, 0.0)
            state = state[0], math.copysign(net / m.J * (1.0 - share) * dt, torque), state[2]
        i, w, angle = state
    asked = np.nan_to_num(wave)
    duty = asked / max(float(np.abs(asked).max()), 1e-9)
    return Trace(asked, shown[0], shown[1], shown[2], shown[3], duty * shown[1])
