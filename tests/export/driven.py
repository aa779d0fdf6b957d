"""One simulated log with its fit, and how well somebody else's program runs the motor of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.results.estimate import Estimate
from motorid.motor.reading import Output, Quantity, Stretch
from motorid.report.json_ import dumps
from tests.motor_reference import Reference
from tests.six_parameters import fit

MOTOR = {"R": 2.6, "L": 2.6e-3, "K": 0.0257, "B": 3e-6, "J": 1.2e-5, "T0": 2e-3}
PERIOD_S = 1e-3
LEVELS = ((50, 0.0), (200, 6.0), (150, 3.0), (200, -4.5), (200, 1.5))  # samples, V
ALLOWED = 1.1  # times the residual of the fit


@dataclass(frozen=True)
class Driven:
    """The estimate's file, the volts that act from each sample to the next, and the readings."""

    path: Path
    estimate: Estimate
    volts: np.ndarray
    current: np.ndarray
    speed: np.ndarray
    mean_current: np.ndarray  # A, of the fitted motor, over the period that ends at a sample

    @property
    def time_s(self) -> np.ndarray:
        return np.arange(len(self.volts)) * PERIOD_S

    def insist(self, current: np.ndarray | None, speed: np.ndarray) -> None:
        """What another program computed, (n,) each, misses the readings as little as the fit."""
        ran = {SPEED: (speed, self.speed)}
        if current is not None:
            ran[CURRENT] = (current, self.current)
        for curve in self.estimate.curves:
            if curve.channel in ran:
                computed, measured = ran.pop(curve.channel)
                own = float(np.sqrt(np.mean((curve.measured - curve.fitted) ** 2)))
                assert np.sqrt(np.mean((measured - computed) ** 2)) <= ALLOWED * own, curve.channel
        assert not ran


def run(motor: tuple[float, ...], volts: np.ndarray) -> Reference:
    """That motor under those volts, from rest, by an integrator that no target has."""
    reference = Reference(motor, rtol=1e-9)
    reference.run(PERIOD_S, np.append(0.0, volts[:-1]), [Stretch(0, False, 0.0, 1e9)])
    return reference


def made(folder: Path) -> Driven:
    """The log, fitted, with its estimate.json in ``folder``."""
    volts = np.concatenate([np.full(count, level) for count, level in LEVELS])
    n = len(volts)
    time = np.arange(n) * PERIOD_S
    reference = run(tuple(MOTOR.values()), volts)
    rng = np.random.default_rng(1)
    current, speed = (
        reference.read(Output(quantity), time) + sd * rng.standard_normal(n)
        for quantity, sd in ((Quantity.CURRENT, 5e-3), (Quantity.SPEED, 0.3))
    )
    capture = Capture(
        ticks=np.round(time * 1e6).astype(np.int64),
        clock_hz=1e6,
        channels={
            CURRENT: Channel(CURRENT, "A", current),
            SPEED: Channel(SPEED, "rad/s", speed),
            VOLTAGE: Channel(VOLTAGE, "V", volts, sense="terminals"),
        },
        provenance={"serial": "M17 -- */ '\"<&>"},
    )
    estimate = fit([capture], model="six")
    path = folder / "estimate.json"
    path.write_text(dumps(estimate), encoding="utf-8")
    found = run(tuple(p.value or 0.0 for p in estimate.parameters.values()), volts)
    mean = found.read(Output(Quantity.CURRENT, PERIOD_S), time)
    return Driven(path, estimate, volts, current, speed, mean)
