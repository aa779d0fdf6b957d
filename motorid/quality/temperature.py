"""The temperature of a product's motors, by its own word or by the estimate."""

from __future__ import annotations

from dataclasses import dataclass

from motorid.estimate.effects.winding_temperature import Coefficients
from motorid.estimate.results.estimate import Rise


@dataclass(frozen=True)
class Temperature(Coefficients):
    """How R and K follow the temperature, and how warm the run makes the winding.

    ``rise_k``: of the winding over ambient, in the mean of the run; None: as the estimate has it.
    """

    magnet_per_k: float = 0.0
    rise_k: float | None = None
    rise_uncertainty_k: float = 0.5

    def rise(self, of_estimate: Rise | None) -> Rise | None:
        """The product's own word, else what the estimate found."""
        if self.rise_k is None:
            return of_estimate
        return Rise(self.rise_k, self.rise_uncertainty_k, 0.0, "by the product")
