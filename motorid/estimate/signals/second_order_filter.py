"""A low-pass of second order, as it acts on a series that goes straight between ticks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Channel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SecondOrder:
    """1/(1 + 2 d s t + s² t²) sampled every ``period_s``: coefficients (3,) of both sums."""

    numerator: Floats
    denominator: Floats

    @classmethod
    def of(cls, channel: Channel, period_s: float) -> SecondOrder:
        """Of a channel; exact for what goes straight from tick to tick."""
        t = channel.filter_s
        return cls.by_coefficients(2.0 * channel.filter_damping * t, t * t, period_s)

    @classmethod
    def by_coefficients(cls, first_s: float, second_s2: float, period_s: float) -> SecondOrder:
        """1/(1 + ``first_s`` s + ``second_s2`` s²)."""
        return cls(*_sampled(first_s, second_s2, period_s))

    def __call__(self, series: Floats) -> Floats:
        """(n,) behind the filter, which has stood at the first value before."""
        from scipy.signal import lfilter

        return np.asarray(lfilter(self.numerator, self.denominator, series - series[0]) + series[0])


@lru_cache(maxsize=32)  # the derivatives of a fit leave it as it is, but for one
def _sampled(first_s: float, second_s2: float, period_s: float) -> tuple[Floats, Floats]:
    from scipy.signal import cont2discrete

    whole = (np.array([1.0]), np.array([second_s2, first_s, 1.0]))
    above, below = cont2discrete(whole, period_s, method="foh")[:2]
    return np.ravel(above), np.ravel(below)
