"""A motor integrated adaptively, friction and freewheel by events: shares nothing with motorid."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp


class Solved:
    """An integration piece by piece, and what channels read of it.

    The first rows of a state are current, speed, charge, angle.
    """

    pieces: list[tuple[float, float, Any]]
    rows = 4

    def states(self, times: np.ndarray) -> np.ndarray:
        """(rows, n) at ``times``; rest before time 0."""
        out = np.zeros((self.rows, len(times)))
        done = times <= 0
        for begin, end, solution in self.pieces:
            inside = ~done & (times > begin) & (times <= end + 1e-15)
            if inside.any():
                out[:, inside] = solution(times[inside])
            done |= inside
        if not done.all():
            out[:, ~done] = self.pieces[-1][2](times[~done])
        return out

    def read(self, output: Any, times: np.ndarray) -> np.ndarray:
        """What a channel (a response.Output) reads at ``times``."""
        end = times - output.delay_s
        row = {0: 0, 1: 1, 2: 3}[int(output.quantity)]
        if output.aperture_s:
            integral = {0: 2, 1: 3}[row]
            change = self.states(end)[integral] - self.states(end - output.aperture_s)[integral]
            return change / output.aperture_s
        return self.states(end)[row]


@dataclass
class Reference(Solved):
    """v = R i + L di/dt + K w and J dw/dt = K i - B w - T0 sign(w), from rest.

    ``motor`` is (R, L, K, B, J, T0). ``run`` integrates; ``read`` gives what a channel reads.
    """

    motor: tuple[float, ...]
    rtol: float = 1e-11
    max_step: float = np.inf
    pieces: list[tuple[float, float, Any]] = field(default_factory=list)

    def run(self, period: float, v: np.ndarray, stretches: list[Any]) -> None:
        """``v[n]`` acts over interval n, which ends at n * period; ``stretches`` as response.py."""
        x, s = np.zeros(4), 0  # i, w, q, theta
        for k, stretch in enumerate(stretches):
            first = max(stretch.start, 1)
            end = stretches[k + 1].start if k + 1 < len(stretches) else len(v)
            freewheels = bool(stretch.open and x[0] != 0 and stretch.clamp_v > 0)
            if stretch.open and not freewheels:
                x[0] = 0.0
            sign = math.copysign(1, x[0])
            cuts = [first, *(np.flatnonzero(np.diff(v[first:end])) + first + 1), end]
            for a, b in pairwise(cuts):
                t, stop = (a - 1) * period, (b - 1) * period
                while t < stop:
                    drive = -sign * stretch.clamp_v if freewheels else v[a]
                    t, x, s, freewheels = self._piece(
                        t, stop, x, s, drive, stretch, freewheels, sign
                    )

    def _piece(self, t, stop, x, s, drive, stretch, freewheels, sign):
        R, L, K, B, J, T0 = self.motor
        electrical = not stretch.open or freewheels
        if s == 0 and abs(K * x[0]) > T0:
            s = int(math.copysign(1, x[0]))

        def rate(_, y):
            i, w = y[0], y[1]
            di = (drive - (R + stretch.series_ohm) * i - K * w) / L if electrical else 0.0
            return [di, (K * i - B * w - s * T0) / J if s else 0.0, i, w]

        def friction(_, y):
            return s * y[1] if s else T0 - abs(K * y[0])

        def current(_, y):
            return sign * y[0] if freewheels else 1.0

        for event in (friction, current):
            event.terminal, event.direction = True, -1
        solved = solve_ivp(
            rate, (t, stop), x, method="DOP853", rtol=self.rtol, atol=1e-13, dense_output=True,
            events=(friction, current), max_step=min((stop - t) / 3, self.max_step),
        )  # fmt: skip
        self.pieces.append((t, solved.t[-1], solved.sol))
        t, x = solved.t[-1], solved.y[:, -1].copy()
        if len(solved.t_events[0]):
            x[1], s = 0.0, 0 if s else int(math.copysign(1, x[0]))
        if len(solved.t_events[1]):
            x[0], freewheels = 0.0, False
        return t, x, s, freewheels
