"""Readings behind an RC by SciPy alone: matrix exponentials, and a switched bridge integrated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from motorid.motor.reading import Output

CURRENT, SPEED, POSITION, FILTERED, CHARGE, VOLTS, STATES = range(7)


@dataclass
class Linear:
    """A motor without friction and one filter, ``tau_s``, behind the quantity of ``output``.

    ``volts[n]`` acts in the interval that ends at tick n. Its states (ticks, 6) are exact.
    """

    motor: tuple[float, ...]
    period_s: float
    volts: np.ndarray
    output: Output
    initial: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        R, L, K, B, J, _ = self.motor
        tau, seen = self.output.filter_s, int(self.output.quantity)
        self.rates = rates = np.zeros((STATES, STATES))
        rates[CURRENT, [CURRENT, SPEED, VOLTS]] = -R / L, -K / L, 1 / L
        rates[SPEED, [CURRENT, SPEED]] = K / J, -B / J
        rates[POSITION, SPEED] = rates[CHARGE, FILTERED] = 1.0
        rates[FILTERED, [seen, FILTERED]] = 1 / tau, -1 / tau
        x = np.array([*self.initial, self._settled(0.0), 0.0, 0.0])
        self.steps: dict[float, np.ndarray] = {}
        step = self._over(1.0)
        self.states = [x]
        for v in self.volts[1:]:
            x = step @ np.append(x[:VOLTS], v)
            self.states.append(x)

    def _settled(self, time: float) -> float:
        """The filter's output before tick 0, current and speed held."""
        held = [
            *self.initial[:2],
            self.initial[2] + self.initial[1] * (time - self.output.filter_s),
        ]
        return held[int(self.output.quantity)]

    def _at(self, time: float) -> np.ndarray:
        if time <= 0.0:
            y = self._settled(time)
            return np.array([0.0, 0.0, 0.0, y, y * time, 0.0])
        n = min(int(np.ceil(time / self.period_s - 1e-9)), len(self.volts) - 1)
        x = np.append(self.states[n - 1][:VOLTS], self.volts[n])
        return self._over(round(time / self.period_s - (n - 1), 9)) @ x

    def _over(self, part: float) -> np.ndarray:
        """The states' exponential over part of an interval; few different ones are asked for."""
        if part not in self.steps:
            self.steps[part] = expm(self.rates * part * self.period_s)
        return self.steps[part]

    def read(self) -> np.ndarray:
        """The readings of every tick."""
        o = self.output
        ends = np.arange(len(self.volts)) * self.period_s - o.delay_s
        end = np.array([self._at(t) for t in ends])
        if not o.aperture_s:
            return end[:, FILTERED]
        begin = np.array([self._at(t - o.aperture_s) for t in ends])
        return (end[:, CHARGE] - begin[:, CHARGE]) / o.aperture_s


class Bridge:
    """A winding at constant back-EMF, switched on and off for real, seen through some filters.

    The current may stop (``diodes``: it decays against ``off_v`` and never turns) or reverse.
    """

    def __init__(self, R: float, L: float, emf_v: float, taus_s: list[float]) -> None:
        self.R, self.L, self.emf_v, self.taus = R, L, emf_v, np.array(taus_s)
        self.now = np.zeros(2 + len(taus_s))  # current, charge, filters
        self.time = 0.0
        self.pieces: list[tuple[float, float, Any]] = []

    def _go(self, volts: float, seconds: float, flows: bool, stops: bool) -> float:
        """Integrate; returns the time that is left where the current stopped."""

        def rate(_: float, x: np.ndarray) -> np.ndarray:
            di = (volts - self.emf_v - self.R * x[0]) / self.L if flows else 0.0
            return np.concatenate([[di, x[0]], (x[0] - x[2:]) / self.taus])

        def out(_: float, x: np.ndarray) -> float:
            return x[0] if stops else 1.0

        out.terminal, out.direction = True, -1  # type: ignore[attr-defined]
        end = self.time + seconds
        solved = solve_ivp(
            rate, (self.time, end), self.now, method="DOP853", rtol=1e-10, atol=1e-12,
            dense_output=True, events=out,
        )  # fmt: skip
        self.pieces.append((self.time, solved.t[-1], solved.sol))
        self.time, self.now = solved.t[-1], solved.y[:, -1].copy()
        if solved.status == 1:
            self.now[0] = 0.0
            return float(end - self.time)
        return 0.0

    def period(self, on_v: float, off_v: float, on_s: float, off_s: float, diodes: bool) -> None:
        """One period of the PWM, the on part first."""
        self._go(on_v, on_s, flows=True, stops=False)
        left = self._go(off_v, off_s, flows=True, stops=diodes)
        if left > 1e-15:
            self._go(0.0, left, flows=False, stops=False)

    def at(self, times: np.ndarray) -> np.ndarray:
        """(current, charge, filters) at each time, (states, n); nothing flows before 0."""
        ends = np.array([end for _, end, _ in self.pieces])
        which = np.minimum(np.searchsorted(ends, times - 1e-15), len(ends) - 1)
        rows = [
            self.pieces[k][2](t) if t > 0 else 0 * self.now
            for k, t in zip(which, times, strict=True)
        ]
        return np.array(rows).T


class Behind:
    """What is read behind a filter of a motor that was ``Solved`` from rest."""

    def __init__(self, solved: Any, tau_s: float) -> None:
        self.solved, self.tau = solved, tau_s
        self.runs: dict[int, list[tuple[float, Any]]] = {}

    def _run(self, row: int) -> list[tuple[float, Any]]:
        """(end, solution) of each piece for the filter of a state and its integral."""
        pieces, now = [], np.zeros(2)
        for begin, end, states in self.solved.pieces:
            if end <= begin:
                continue

            def rate(t: float, y: np.ndarray, states: Any = states) -> list[float]:
                return [(states(t)[row] - y[0]) / self.tau, y[0]]

            run = solve_ivp(
                rate, (begin, end), now, method="DOP853", rtol=1e-11, atol=1e-13,
                dense_output=True,
            )  # fmt: skip
            pieces.append((end, run.sol))
            now = run.y[:, -1]
        return pieces

    def _at(self, row: int, times: np.ndarray) -> np.ndarray:
        if row not in self.runs:
            self.runs[row] = self._run(row)
        pieces = self.runs[row]
        ends = np.array([end for end, _ in pieces])
        which = np.minimum(np.searchsorted(ends, times - 1e-15), len(ends) - 1)
        seen = zip(which, times, strict=True)
        return np.array([pieces[k][1](t) if t > 0 else [0.0, 0.0] for k, t in seen])

    def read(self, output: Output, times: np.ndarray) -> np.ndarray:
        """The readings of ``output`` at ``times``."""
        row = {0: 0, 1: 1, 2: 3}[int(output.quantity)]
        end = self._at(row, times - output.delay_s)
        if not output.aperture_s:
            return end[:, 0]
        begin = self._at(row, times - output.delay_s - output.aperture_s)
        return (end - begin)[:, 1] / output.aperture_s
