"""How the figures of brushed permanent-magnet motors go together, from 0.5 W to 4.5 kW.

``MOTORS`` are catalogue figures of precision and servo motors, ``OTHERS`` of models', robots' and
vehicles'. A motor's V, R, L, K and J depend on its size and on its winding,
so that their logarithms lie near a plane. ``distance`` says how far a motor lies from them: a
chi-square, among the first, or (``wide``) among all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# V, ohm, H, N·m/A, kg·m². Each inductance that a data sheet bounds from above is taken at half.
# Compared again: 0816K with its data sheet, 2338S with the SRV02 manual; RE 35, RE 40 and GR 42
# (without J) with parameters that others publish. Diameters bear out coreless and disc motors.
MOTORS = {
    # Faulhaber 0816K..SR, data sheet: four windings of one motor, 0.5 W
    "Faulhaber 0816K003SR": (3.0, 5.4, 53e-6, 2.11e-3, 5.1e-9),
    "Faulhaber 0816K006SR": (6.0, 21.2, 217e-6, 4.12e-3, 5.2e-9),
    "Faulhaber 0816K009SR": (9.0, 47.0, 507e-6, 6.19e-3, 5.1e-9),
    "Faulhaber 0816K012SR": (12.0, 101.8, 1033e-6, 8.8e-3, 4.9e-9),
    # Quanser user manuals (SRV02, QUBE-Servo 2)
    "Faulhaber 2338S006S": (6.0, 2.6, 180e-6, 7.68e-3, 3.9e-7),
    "QUBE-Servo 2": (18.0, 8.4, 1.16e-3, 42e-3, 4.0e-6),
    # maxon catalogue: 6, 90 and 250 W
    "maxon A-max 22": (12.0, 5.53, 363e-6, 10.9e-3, 4.29e-7),
    "maxon RE 35": (30.0, 1.2, 340e-6, 38.9e-3, 68.1e-7),
    "maxon RE 65": (48.0, 0.365, 161e-6, 123e-3, 1.34e-4),
    # data sheets of Dunkermotoren GR 42 and Ametek Pittman 14204S004, iron rotors
    "Dunkermotoren GR 42": (24.0, 5.95, 8.9e-3, 51.4e-3, 7.1e-6),
    "Pittman 14204S004": (12.0, 0.253, 0.40e-3, 30.6e-3, 2.6e-5),
    # Printed Motors B and BR series, data sheet: disc rotors of 106 W to 4.5 kW
    "B9M4": (24.1, 0.85, 50e-6, 47.2e-3, 3.95e-5),
    "B12M4": (43.4, 0.75, 50e-6, 112.5e-3, 1.342e-4),
    "BR13": (65.0, 1.5, 40e-6, 158e-3, 2.35e-4),
    "BR17": (105.0, 1.6, 200e-6, 234e-3, 1.0e-3),
    "BR19": (83.0, 0.46, 50e-6, 239e-3, 1.0e-3),
    "BR19 HR": (164.0, 1.6, 200e-6, 488e-3, 1.0e-3),
    "B23": (172.0, 0.9, 125e-6, 506e-3, 2.3e-3),
    "BR24": (140.0, 0.285, 50e-6, 412e-3, 3.2e-3),
    "BR27": (150.0, 0.18, 50e-6, 461e-3, 7.4e-3),
}
# motors of few hundredths of an ohm, or of many ohms: nobody who has one is told that none has
OTHERS = {
    # maxon catalogue: coreless, of many ohms, and of a few hundredths of one
    "maxon DCX 10 S": (12.0, 74.9, 868e-6, 8.53e-3, 7.1e-9),
    "maxon DCX 22 L": (9.0, 0.168, 18e-6, 6.95e-3, 9.37e-7),
    "maxon RE 40": (24.0, 0.316, 80e-6, 30.2e-3, 1.34e-5),
    "maxon RE 50": (24.0, 0.104, 72e-6, 38.5e-3, 5.36e-5),
    # robots' and vehicles' motors of many amperes, as simulations of them state them
    "CIM": (12.0, 0.091, 59e-6, 18.5e-3, 7.5e-5),
    "hybrid vehicle, 48 V": (48.0, 22.5e-3, 23e-6, 150e-3, 23.6e-3),
}
NAMES = ("V", "R", "L", "K", "J")
# standard deviations of logarithms, of any motor about what these say of its size and winding
SCATTER = np.array([0.2, 0.4, 0.8, 0.3, 0.4])
LOADED = 1.5  # standard deviation of the logarithm of all the inertia over the rotor's
DRIVEN_BELOW, DRIVEN_ABOVE = 1.0, 0.2  # the same of the nominal voltage over the highest that drove
MOST = 4.0  # standard deviations that are tried
STEPS = 33


@dataclass(frozen=True)
class Figures:
    """A motor's figures in SI units. ``top_v`` is the highest voltage that drove it, ``L`` None:
    unknown.
    """

    top_v: float
    R: float
    K: float
    J: float
    L: float | None = None

    def scaled(self, powers: dict[str, float], factor: float) -> Figures:
        """As they are if a reading shows ``factor`` times what is true; ``powers`` by name."""

        def true(name: str, value: float) -> float:
            return float(value / factor ** powers.get(name, 0.0))

        L = None if self.L is None else true("L", self.L)
        return Figures(
            true("V", self.top_v), true("R", self.R), true("K", self.K), true("J", self.J), L
        )


MARGIN = 30.0  # by which a motor may lie beyond the catalogue's lowest and highest figures


@cache
def ranges() -> dict[str, tuple[float, float]]:
    """Plausible R, L, K and J (SI), and time constants in s: L/R, and JR/K² without its upper end,
    for a load has none.
    """
    _, R, L, K, J = np.array([*MOTORS.values(), *OTHERS.values()]).T
    figures = {"R": R, "L": L, "K": K, "J": J, "L/R": L / R, "JR/K²": J * R / K**2}
    found = {n: (float(x.min()) / MARGIN, float(x.max()) * MARGIN) for n, x in figures.items()}
    return found | {n: (found[n][0], np.inf) for n in ("J", "JR/K²")}


@cache
def _usual(wide: bool) -> tuple[Floats, Floats]:
    """Mean (5,) and covariance (5, 5) of the logarithms."""
    motors = [*MOTORS.values(), *(OTHERS.values() if wide else ())]
    table = np.log(np.array(motors))
    return table.mean(axis=0), np.cov(table.T) + np.diag(SCATTER**2)


def distance(motor: Figures, wide: bool = False) -> float:
    """Chi-square of a motor among those of the catalogue.

    The rotor may carry a load, and the motor may be driven below its nominal voltage, or a little
    above: both are chosen in its favour.
    """
    known = {"V": motor.top_v, "R": motor.R, "K": motor.K, "J": motor.J}
    return distance_of(known if motor.L is None else {**known, "L": motor.L}, wide)


def distance_of(figures: Mapping[str, float], wide: bool = False) -> float:
    """The same of whichever of ``NAMES`` are known (SI, above zero)."""
    mean, covariance = _usual(wide)
    known = [k for k, name in enumerate(NAMES) if name in figures]
    logarithms = np.log([figures.get(name, 1.0) for name in NAMES])
    shares = np.linspace(0.0, MOST, STEPS)
    volts, loads = np.meshgrid(np.concatenate([-shares[:0:-1], shares]), shares, indexing="ij")
    off = np.tile(logarithms - mean, (volts.size, 1))
    off[:, 0] += (np.where(volts > 0, DRIVEN_BELOW, DRIVEN_ABOVE) * volts).ravel()
    off[:, 4] -= LOADED * loads.ravel()
    inverse = np.linalg.inv(covariance[np.ix_(known, known)])
    off = off[:, known]
    among = np.einsum("ni,ij,nj->n", off, inverse, off)
    return float((among + (volts**2 + loads**2).ravel()).min())
