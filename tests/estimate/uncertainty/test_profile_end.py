"""Where the end of a profile's interval is sought: a fall that begins at once is bracketed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from motorid.estimate.uncertainty.profile_likelihood import NEAR, Profile

WANTED = 2.0


@dataclass(frozen=True)
class Kinked(Profile):
    """Its fall is gentle up to ``kink``, and steep from there on."""

    kink: float = 1.6
    steep: float = 100.0

    @property
    def best(self) -> float:
        return 1.0

    def root(self, value: float) -> float:
        away = abs(value - self.best)
        return 0.5 * away + self.steep * max(away - (self.kink - self.best), 0.0)


@pytest.mark.parametrize(("kink", "steep"), [(1.6, 100.0), (1.05, 1000.0), (9.0, 1.0), (1.3, 10.0)])
def test_the_end_is_not_short_of_where_the_likelihood_has_fallen(kink: float, steep: float) -> None:
    profile = Kinked(None, (), 0, kink, steep)  # type: ignore[arg-type]
    end = profile.end(2.0, WANTED)
    farthest = profile.root(end) >= (1.0 - NEAR) * WANTED
    assert farthest or end == pytest.approx(5.0)  # or as far as any end may lie
    assert end < max(kink, 5.0) + 0.5


@dataclass(frozen=True)
class Walled(Kinked):
    """Beyond ``kink`` no motor remains."""

    def root(self, value: float) -> float:
        return math.inf if value > self.kink else 0.5 * abs(value - self.best)


def test_an_end_lies_at_the_wall_beyond_which_no_motor_remains() -> None:
    end = Walled(None, (), 0, 2.5).end(4.0, WANTED)  # type: ignore[arg-type]
    assert end == pytest.approx(2.5, rel=0.1)
    assert end >= 2.5  # no bound is given up that the data left open
