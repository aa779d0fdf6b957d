"""The wider motor integrated by SciPy, friction and freewheel by events: no code of the fit's."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from tests.motor_reference import Solved

STATES = ("i", "w", "charge", "angle", "warmth", "load_speed", "twist", "eddy")


@dataclass
class WideReference(Solved):
    """``motor``: values by the names of ``motorid.motor.wide.NAMES``; those not named are 0."""

    motor: dict[str, float]
    method: str = "Radau"
    rtol: float = 1e-10
    phases: tuple[float, float] = (0.0, 0.0)  # of cogging and ripple
    pieces: list[tuple[float, float, Any]] = field(default_factory=list)

    rows = len(STATES)

    def __getitem__(self, name: str) -> float:
        return self.motor.get(name, 0.0)

    def run(self, period: float, v: np.ndarray, stretches: list[Any]) -> None:
        """``v[n]`` acts over interval n, which ends at n * period."""
        x, s = np.zeros(len(STATES)), 0
        for k, stretch in enumerate(stretches):
            first = max(stretch.start, 1)
            end = stretches[k + 1].start if k + 1 < len(stretches) else len(v)
            freewheels = bool(stretch.open and x[0] != 0 and stretch.clamp_v > 0)
            if stretch.open and not freewheels:
                x[0] = 0.0
            sign = math.copysign(1, x[0])
            for n in range(first, end):
                t, stop = (n - 1) * period, n * period
                while t < stop:
                    t, x, s, freewheels = self._piece(
                        t, stop, x, s, float(v[n]), stretch, freewheels, sign
                    )

    def constant(self, i: float) -> float:
        """K at a current."""
        bend = self["reaction_bend"]
        return self["K"] * (1 - self["reaction"] * (math.hypot(i, bend) - bend))

    def inductance(self, i: float) -> float:
        """Incremental, H."""
        if not self["saturation"]:
            return self["L"]
        lost = i * i / (i * i + self["saturation_current"] ** 2)
        return self["L"] * (1 - self["saturation"] * lost)

    def torque(self, y: np.ndarray) -> float:
        """N·m upon the rotor without the friction that has a direction."""
        i, w = y[0], y[1]
        wave = math.cos(self["ripple_per_turn"] * y[3] + self.phases[1])
        total = self.constant(i) * (1 + self["k_ripple"] * wave) * i - self["B"] * w
        total -= self["quadratic"] * w * abs(w)
        total -= self["cogging"] * math.sin(self["cogging_per_turn"] * y[3] + self.phases[0])
        if self["load_inertia"]:
            total -= self["stiffness"] * y[6] + self["damping"] * (w - y[5])
        return total

    def sliding(self, s: int, w: float, i: float, t: float) -> float:
        """N·m of Coulomb friction, the load's and Stribeck's excess, in the direction of motion."""
        friction = self["T0"] * (1 + self["asymmetry"] * s)
        friction += self["load_friction"] * abs(self.constant(i) * i)
        if self["stiction"]:
            friction += self["stiction"] * math.exp(-((w / self["stribeck"]) ** 2))
        if self["drift"]:
            rate, span = self["drift_rate"], self["drift_span"]
            left = math.exp(-rate * span)
            friction += self["drift"] * (math.exp(-rate * t) - left) / (1 - left)
        return friction

    def rate(
        self, t: float, y: np.ndarray, s: int, drive: float, ohms: float, electrical: bool
    ) -> list:
        """Time derivative of ``STATES``."""
        i, w = y[0], y[1]
        wave = math.cos(self["ripple_per_turn"] * y[3] + self.phases[1])
        di = de = shielded = 0.0
        share = self["eddy"]
        if share:
            shielded = share * self["L"] / self["eddy_time"] * (i - y[7])
            de = shielded / (share * self.inductance(y[7]))
        if electrical:
            drop = self["brush"] * i / math.hypot(i, self["brush_current"]) if self["brush"] else 0
            resistance = self["R"] * (1 + y[4] + self["r_ripple"] * wave) + ohms
            resistance += self["commutation"] * max(abs(w) - self["commutation_from"], 0.0)
            emf = self.constant(i) * (1 + self["emf"]) * (1 + self["k_ripple"] * wave) * w
            left = drive - resistance * i - emf - drop - shielded
            di = left / ((1 - share) * self.inductance(i))
        dw = (self.torque(y) - s * self.sliding(s, w, i, t)) / self["J"] if s else 0.0
        warming = self["warming"] * (1 + y[4]) * i * i - self["cooling"] * y[4]
        load = twist = 0.0
        if self["load_inertia"]:
            torque = self["stiffness"] * y[6] + self["damping"] * (w - y[5])
            load, twist = torque / self["load_inertia"], w - y[5]
        return [di, dw, i, w, warming, load, twist, de]

    def _piece(self, t, stop, x, s, v, stretch, freewheels, sign):
        electrical = not stretch.open or freewheels
        drive = -sign * stretch.clamp_v if freewheels else v
        direction = int(math.copysign(1, self.torque(x)))
        if s == 0 and abs(self.torque(x)) > self.sliding(direction, 0.0, x[0], t):
            s = direction

        def friction(t, y):
            if s:
                return s * y[1]
            torque = self.torque(y)
            return self.sliding(int(math.copysign(1, torque)), 0.0, y[0], t) - abs(torque)

        def current(_, y):
            return sign * y[0] if freewheels else 1.0

        for event in (friction, current):
            event.terminal, event.direction = True, -1
        solved = solve_ivp(
            lambda t, y: self.rate(t, y, s, drive, stretch.series_ohm, electrical),
            (t, stop), x, method=self.method, rtol=self.rtol, atol=1e-13, dense_output=True,
            events=(friction, current), max_step=(stop - t) / 3,
        )  # fmt: skip
        self.pieces.append((t, solved.t[-1], solved.sol))
        t, x = solved.t[-1], solved.y[:, -1].copy()
        if len(solved.t_events[0]):
            x[1], s = 0.0, 0 if s else int(math.copysign(1, self.torque(x)))
        if len(solved.t_events[1]):
            x[0], freewheels = 0.0, False
        return t, x, s, freewheels
