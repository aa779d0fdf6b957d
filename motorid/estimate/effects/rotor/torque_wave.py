"""What a small torque that varies with the rotor's angle does to a run, by its straight lines.

    L d(di)/dt = -R di - K dw,    J d(dw)/dt = K di - B dw + cos(N th),    d(dth)/dt = dw

about the run of a motor, for every N at once and without a response. The torque of a tick is its
mean along the way that the rotor turns in it. A rotor at a stand keeps no change of its speed.
Where the motion turns round, it goes on with another acceleration, as friction helps before and
hinders after (a saltation: Filippov, Differential Equations with Discontinuous Righthand Sides,
1988).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

SAME = 1e-9  # rad of a period within a tick, that is no way


@dataclass(frozen=True)
class Run:
    """A run of a motor by ticks (count,): A, rad/s, rad; ``motor`` is (R, L, K, B, J, T0)."""

    motor: Floats
    period_s: float
    current: Floats
    speed: Floats
    angle: Floats

    def waves(self, orders: Sequence[int]) -> tuple[Complex, Complex, Complex]:
        """Change of current, speed and angle, (orders, count) each, by 1 N·m times e^(i N angle).

        The real part is what cos(N angle) does; the imaginary one what sin(N angle) does.
        """
        torque = self._torque(np.asarray(orders, dtype=np.float64))
        current, speed = np.zeros_like(torque), np.zeros_like(torque)
        steps, gain = self._steps()
        state = np.zeros((2, len(torque)), dtype=np.complex128)
        for first, last, kept in self._motions():
            state[1] *= kept
            driven = torque[:, first:last]
            current[:, first:last], speed[:, first:last] = _response(steps, gain, state, driven)
            state = np.array([current[:, last - 1], speed[:, last - 1]])
        return current, speed, self.period_s * np.cumsum(speed, axis=1)

    def _torque(self, orders: Floats) -> Complex:
        """Mean of e^(i N angle) over each tick that ends there; none where the rotor stands."""
        before = np.concatenate([self.angle[:1], self.angle[:-1]])
        way = np.outer(orders, self.angle - before)
        middle = np.exp(1j * np.outer(orders, 0.5 * (self.angle + before)))
        return np.where(np.abs(way) > SAME, np.sinc(way / (2.0 * np.pi)), 0.0) * middle

    def _steps(self) -> tuple[Floats, Floats]:
        """The matrix of a tick (2, 2), and what a torque in it adds (2,)."""
        R, L, K, B, J, _ = (float(x) for x in self.motor)
        least = R * self.period_s / 50.0  # of L: a quicker current follows at once
        rates = np.array([[-R / max(L, least), -K / max(L, least)], [K / J, -B / J]])
        values, vectors = np.linalg.eig(rates.astype(np.complex128))
        inverse = np.linalg.inv(vectors)
        grown = np.exp(values * self.period_s)
        flat = values == 0.0
        summed = np.where(flat, self.period_s, (grown - 1.0) / np.where(flat, 1.0, values))
        step = (vectors * grown) @ inverse
        gain = (vectors * summed) @ inverse @ np.array([0.0, 1.0 / J])
        return np.real(step), np.real(gain)

    def _motions(self) -> Iterator[tuple[int, int, float]]:
        """From one tick to another of one way or of a stand, and what of a change of the speed
        lives on into it.
        """
        signs = np.sign(self.speed)
        edges = np.flatnonzero(np.diff(signs)) + 1
        ends = [0, *edges.tolist(), len(signs)]
        for first, last in pairwise(ends):
            turned = first > 0 and signs[first] * signs[first - 1] < 0.0
            yield first, last, self._kept(first) if turned else 0.0

    def _kept(self, tick: int) -> float:
        """The acceleration after a turn of the motion over that before."""
        K, friction = float(self.motor[2]), float(self.motor[5])
        torque = abs(K * float(self.current[tick]))
        return max(torque - friction, 0.0) / max(torque + friction, 1e-300)


def _response(
    step: Floats, gain: Floats, state: Complex, torque: Complex
) -> tuple[Complex, Complex]:
    """Current and speed (orders, n) after each tick of torques, from a state (2, orders) on."""
    from scipy.signal import lfilter

    poles = np.array([1.0, -np.trace(step), np.linalg.det(step)])
    start = step @ state  # what the state adds to the first tick, as if by an impulse there
    out = []
    for one, other in ((0, 1), (1, 0)):
        more = step[one, other], -step[other, other]
        driven = lfilter([gain[one], more[0] * gain[other] + more[1] * gain[one]], poles, torque)
        impulse = np.zeros_like(torque)
        impulse[:, 0] = start[one]
        if torque.shape[1] > 1:
            impulse[:, 1] = more[0] * start[other] + more[1] * start[one]
        out.append(driven + lfilter([1.0], poles, impulse))
    return out[0], out[1]
