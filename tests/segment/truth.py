"""A motor integrated by scipy, and captures of it: independent of the package's own physics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from motorid.capture.model import Capture, Channel

CLOCK_HZ = 1_000_000
OPEN = None  # the bridge: no current can flow


@dataclass(frozen=True)
class Motor:
    """SI units; the Faulhaber 2338S006S unless said otherwise."""

    R: float = 2.6
    L: float = 180e-6
    K: float = 7.68e-3
    B: float = 2e-7
    J: float = 3.9e-7
    T0: float = 2e-4


SMALL = Motor()
LARGE = Motor(R=1.2, L=340e-6, K=38.9e-3, B=1e-6, J=68.1e-7, T0=2e-3)  # maxon RE 35


@dataclass(frozen=True)
class Run:
    """True current, speed and position at each sample, and where each step began."""

    rate_hz: float
    current: NDArray[np.float64]
    speed: NDArray[np.float64]
    position: NDArray[np.float64]
    edges: tuple[int, ...]


def drive(motor: Motor, steps: list[tuple[float, float | None]], rate_hz: float) -> Run:
    """The exact course through steps of (duration in s, volts or OPEN), from rest."""
    state, columns, edges, done = np.zeros(3), [], [], 0
    for duration, volts in steps:
        edges.append(done)
        count = round(duration * rate_hz)
        times = np.arange(count + 1) / rate_hz
        if volts is OPEN:
            state = np.array([0.0, state[1], state[2]])
        out = _integrate(motor, state, volts, times)
        columns.append(out[:, :-1])
        state, done = out[:, -1], done + count
    current, speed, position = np.concatenate(columns, axis=1)
    return Run(rate_hz, current, speed, position, tuple(edges))


def _integrate(
    motor: Motor, state: NDArray[np.float64], volts: float | None, times: NDArray[np.float64]
) -> NDArray[np.float64]:
    out = np.empty((3, len(times)))
    begin, at = 0, 0.0
    while begin < len(times):
        side = _side(motor, state)
        event = _turning(motor, side)
        solution = solve_ivp(
            _slope(motor, volts, side), (at, times[-1] + 1e-12), state, method="LSODA",
            t_eval=times[begin:], events=event, rtol=1e-7, atol=1e-9, first_step=1e-7,
        )  # fmt: skip
        taken = solution.y.shape[1]
        out[:, begin : begin + taken] = solution.y
        begin += taken
        if solution.status != 1:
            break
        at, state = solution.t_events[0][0], solution.y_events[0][0].copy()
        state[1] = 0.0 if side else state[1]
    return out


def _side(motor: Motor, state: NDArray[np.float64]) -> float:
    if abs(state[1]) > 1e-9:
        return float(np.sign(state[1]))
    pull = motor.K * state[0]
    return float(np.sign(pull)) if abs(pull) >= motor.T0 * (1 - 1e-9) else 0.0


def _slope(motor: Motor, volts: float | None, side: float):
    def slope(_: float, x: NDArray[np.float64]) -> list[float]:
        current, speed, _position = x
        emf = motor.R * current + motor.K * speed
        rise = 0.0 if volts is OPEN else (volts - emf) / motor.L
        torque = motor.K * current - motor.B * speed - motor.T0 * side
        return [rise, torque / motor.J if side else 0.0, speed if side else 0.0]

    return slope


def _turning(motor: Motor, side: float):
    def turning(_: float, x: NDArray[np.float64]) -> float:
        return float(x[1] * side + 1e-9) if side else float(abs(motor.K * x[0]) - motor.T0)

    turning.terminal = True
    turning.direction = -1.0 if side else 1.0
    return turning


def record(
    run: Run,
    *,
    counts: int = 2048,
    noise: float = 1e-3,
    offset: float = 0.0,
    delay: int = 0,
    sign: float = 1.0,
    seed: int = 1,
    speed: bool = False,
) -> Capture:
    """A capture with a 12-bit current of the given relative noise, late by ``delay`` samples."""
    rng = np.random.default_rng(seed)
    full = 1.5 * np.abs(run.current).max()
    late = np.concatenate((np.zeros(delay), run.current[: len(run.current) - delay]))
    noisy = sign * (late + noise * full * rng.standard_normal(len(late))) + offset
    scale = full / 2048
    current = Channel("current", "A", np.round(noisy / scale), scale=scale, resolution=scale)
    step = 2 * np.pi / counts
    if speed:
        motion = sign * run.speed + 2e-3 * np.abs(run.speed).max() * rng.standard_normal(len(late))
        other = Channel("speed", "rad/s", motion)
    else:
        raw = sign * np.round(run.position / step)
        other = Channel("position", "rad", raw, scale=step, resolution=step)
    ticks = np.round(np.arange(len(late)) * CLOCK_HZ / run.rate_hz).astype(np.int64)
    return Capture(ticks, float(CLOCK_HZ), {c.name: c for c in (current, other)})
