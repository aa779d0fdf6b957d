"""A disc of known inertia as a check of the whole chain, from readings to J."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

AGREES, DOUBTFUL = 2.0, 3.0  # zeta scores, ISO 13528


@dataclass(frozen=True)
class Disc:
    """A plain disc or ring. SI units; uncertainties standard. ``bore_m``: diameter of its hole."""

    mass_kg: float
    mass_uncertainty_kg: float
    diameter_m: float
    diameter_uncertainty_m: float
    bore_m: float = 0.0
    bore_uncertainty_m: float = 0.0

    @property
    def inertia(self) -> float:
        """m (D² + d²) / 8, in kg·m²."""
        return self.mass_kg * (self.diameter_m**2 + self.bore_m**2) / 8

    @property
    def uncertainty(self) -> float:
        """Its standard uncertainty, in kg·m²."""
        return math.hypot(
            self.inertia / self.mass_kg * self.mass_uncertainty_kg,
            self.mass_kg * self.diameter_m / 4 * self.diameter_uncertainty_m,
            self.mass_kg * self.bore_m / 4 * self.bore_uncertainty_m,
        )


@dataclass(frozen=True)
class Inertia:
    """J of one arrangement, as fitted: kg·m², with the two parts of its standard uncertainty."""

    value: float
    statistical: float
    instrument: float


@dataclass(frozen=True)
class DiscCheck:
    """What the disc added against what it should have added."""

    measured: float
    measured_uncertainty: float
    expected: float
    expected_uncertainty: float

    @property
    def zeta(self) -> float:
        """The difference in units of its standard uncertainty (ISO 13528)."""
        both = math.hypot(self.measured_uncertainty, self.expected_uncertainty)
        return (self.measured - self.expected) / both

    @property
    def outcome(self) -> str:
        """agrees, doubtful or fails."""
        size = abs(self.zeta)
        return "agrees" if size <= AGREES else "doubtful" if size < DOUBTFUL else "fails"

    def says(self, known: Mapping[str, float] | None = None) -> str:
        """The outcome in a sentence; ``known``: relative uncertainties of gains now in force.

        J follows from K i over the acceleration: a current gain or a voltage gain goes into it
        once, a figure of counts a turn twice.
        """
        ratio = self.measured / self.expected
        if self.outcome == "agrees":
            return (
                f"measured and computed agree to {abs(ratio - 1):.2%}: K, the current's gain and "
                "the counts a turn are right together within their uncertainties"
            )
        causes = {
            "current": ("the current's gain", ratio),
            "terminal_voltage": ("the voltage's gain (by way of K)", ratio),
            "encoder": (
                "wiring.counts_per_turn (larger than it is)",
                math.sqrt(ratio) if ratio > 0 else math.nan,
            ),
        }
        named = []
        for name, (what, factor) in causes.items():
            share = (known or {}).get(name)
            if share is not None and abs(factor - 1) > DOUBTFUL * share:
                continue  # it was calibrated better than that
            named.append(f"{what} by a factor {factor:.3g}")
        suspects = "; or ".join(named) or (
            "none of the calibrated gains, so look at the disc: its mass and diameter, whether it "
            "slips, and friction that changed with it"
        )
        return f"the disc adds {ratio:.3g} times what it should: suspect {suspects}"


def check_disc(without: Inertia, with_disc: Inertia, disc: Disc) -> DiscCheck:
    """Judges the difference of two fits.

    A gain moves both inertias by one share, and so their difference by the same share; what noise
    adds to each is independent.
    """
    difference = with_disc.value - without.value
    share = max(without.instrument / without.value, with_disc.instrument / with_disc.value)
    noise = math.hypot(without.statistical, with_disc.statistical)
    return DiscCheck(
        difference, math.hypot(noise, share * difference), disc.inertia, disc.uncertainty
    )
