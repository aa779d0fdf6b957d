"""Logs of a motor under levels of volts, by the exact solution of its law between two jumps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import FACTS, SPEED, VOLTAGE, Capture, Channel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Law:
    """τ dω/dt = g (v - c sign ω) - ω; without a drive dω/dt = -β ω - g c/τ where it ``coasts``."""

    tau_s: float = 0.08
    gain: float = 25.0
    friction_v: float = 1.1
    coasts: float | None = None

    @property
    def truth(self) -> dict[str, float]:
        """By the names of an estimate."""
        return {"JR/(K²+RB)": self.tau_s, "K/(K²+RB)": self.gain, "T0·R/K": self.friction_v}

    def after(self, speed: float, volts: float, times: Floats) -> Floats:
        """Speeds (n,) so long after one, one way."""
        rate, drop = 1.0 / self.tau_s, self.gain * self.friction_v / self.tau_s
        if not volts and self.coasts is not None:
            rate = self.coasts
        ends = (self.gain * volts / self.tau_s - drop) / rate
        return np.maximum(ends + (speed - ends) * np.exp(-rate * times), 0.0)


def logged(
    law: Law, levels: tuple[float, ...], rows: int = 50, period_s: float = 0.01, late: float = 0.4,
    noise: float = 0.3, fan: float = 0.0,
) -> Capture:  # fmt: skip
    """``rows`` of each level, which acts ``late`` periods after its row; rounded to 0.5 rad/s.

    ``fan``: of the friction's volts, by which one that grows with the square of speed adds at
    200 rad/s.
    """
    fine, speed, out = 40, 0.0, []
    step = period_s / fine
    volts = np.repeat(levels, rows)
    moved = np.r_[0.0, volts]
    for k in range(len(volts)):
        out.append(speed)
        for j in range(fine):
            v = float(moved[k + 1] if j >= late * fine else moved[k])
            more = fan * law.friction_v * (speed / 200.0) ** 2
            speed = float(law.after(speed, v - more if v else v, np.array([step]))[0])
    rng = np.random.default_rng(3)
    readings = np.rint((np.array(out) + rng.normal(0.0, noise, len(out))) / 0.5) * 0.5
    drive = Channel(VOLTAGE, "V", volts, sense="terminals", undeclared=FACTS)
    motion = replace(Channel(SPEED, "rad/s", readings, undeclared=FACTS), resolution=0.5)
    ticks = np.rint(1e9 * period_s * np.arange(len(volts))).astype(np.int64)
    return Capture(ticks, 1e9, {VOLTAGE: drive, SPEED: motion})
