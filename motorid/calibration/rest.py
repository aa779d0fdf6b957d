"""What a channel reads at rest: its offset, how well a run's own zero finds it, and its drift."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from motorid.errors import DataError

FEWEST = 4
DITHERED = 0.5  # counts of noise from which an average resolves less than a count
HIDDEN = 1 / math.sqrt(12)  # what a count hides without that


@dataclass(frozen=True)
class Zero:
    """One measurement of the offset: the mean of so many raw readings, at a time in seconds."""

    time_s: float
    mean: float
    noise: float
    samples: int


@dataclass(frozen=True)
class Rest:
    """Offset of a channel in counts. ``uncertainty`` is that of one run's own zero."""

    offset: float
    standard_error: float  # of the mean of all
    uncertainty: float
    noise: float  # of one reading
    drift_per_minute: float
    drift_uncertainty: float

    @property
    def drifts(self) -> bool:
        """Whether the offset clearly moved while it was measured."""
        return abs(self.drift_per_minute) > 3 * self.drift_uncertainty


def rest_of(zeros: Sequence[Zero]) -> Rest:
    """What several measurements of one offset say, spread over the time that they took.

    Raises DataError for fewer than four.
    """
    if len(zeros) < FEWEST:
        raise DataError(f"an offset's drift needs {FEWEST} measurements of it or more")
    times = np.array([z.time_s for z in zeros]) / 60
    means = np.array([z.mean for z in zeros])
    noise = math.sqrt(float(np.mean([z.noise**2 for z in zeros])))
    hidden = HIDDEN if noise < DITHERED else 0.0
    expected = noise / math.sqrt(min(z.samples for z in zeros))
    spread = float(means.std(ddof=1))
    centred = times - times.mean()
    sum_squares = float(centred @ centred)
    if sum_squares <= 0:
        raise DataError("the offset was measured at one moment only: measure it for longer")
    drift = float(centred @ means) / sum_squares
    residual = means - means.mean() - drift * centred
    scatter = math.sqrt(max(float(residual @ residual) / (len(means) - 2), expected**2))
    return Rest(
        offset=float(means.mean()),
        standard_error=math.hypot(max(spread, expected) / math.sqrt(len(means)), hidden),
        uncertainty=math.hypot(max(spread, expected), hidden),
        noise=noise,
        drift_per_minute=drift,
        drift_uncertainty=scatter / math.sqrt(sum_squares),
    )
