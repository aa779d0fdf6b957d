"""Which inductances are held one after the other, and which is taken."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.estimate.fit import subsample_inductance
from motorid.estimate.fit.subsample_inductance import CLEAR, CLOSE, LARGEST, SMALLEST

PERIOD_S, OHMS = 250e-6, 1.2
TAU = OHMS * PERIOD_S  # H of one sample period


def searched(
    worse: Callable[[float], float], ohms: float = OHMS
) -> tuple[float | None, list[float]]:
    """What the search takes where ``worse(ln H)`` is chi-square, and all that it held."""
    record = SimpleNamespace(timeline=SimpleNamespace(period_s=PERIOD_S))
    of: Any = subsample_inductance._Search  # of a record that has nothing but its grid
    search = of([record], (), {}, {"R": ohms}, None)
    tried: list[float] = []

    def held(inductance_h: float) -> tuple[list[object], SimpleNamespace]:
        tried.append(inductance_h)
        return [], SimpleNamespace(objective=worse(math.log(inductance_h)))

    def by_noise_of(_: int, held: Callable[[int], Any]) -> Callable[[int], float]:
        return lambda place: float(held(place)[1].objective)

    object.__setattr__(search, "compared", held)
    object.__setattr__(search, "_by_noise_of", by_noise_of)
    return search.by_ripple(), tried


def valley(truth: float, steepness: float = 1e4) -> Callable[[float], float]:
    return lambda log_h: steepness * (log_h - math.log(truth)) ** 2


@pytest.mark.parametrize("truth", [0.03 * TAU, 0.11 * TAU, 0.3 * TAU, 0.77 * TAU])
def test_the_likeliest_is_found(truth: float) -> None:
    found, tried = searched(valley(truth))
    assert found is not None
    assert abs(math.log(found / truth)) <= CLOSE / 2 + 1e-9
    assert len(tried) == len(set(tried)) < 25


@pytest.mark.parametrize("ohms", [0.9 * OHMS, 1.001 * OHMS, 1.3 * OHMS])
def test_where_the_search_ran_off_to_before_changes_nothing(ohms: float) -> None:
    assert searched(valley(0.21 * TAU), ohms)[0] == searched(valley(0.21 * TAU))[0]


@pytest.mark.parametrize("truth", [5e-4 * TAU, 20.0 * TAU])
def test_one_beyond_those_that_are_held_is_not_given(truth: float) -> None:
    found, tried = searched(valley(truth))
    assert found is None
    assert SMALLEST * TAU * 0.99 < min(tried) < max(tried) < LARGEST * TAU * 1.01


@pytest.mark.parametrize(("part", "given"), [(0.9, False), (1.1, True)])
def test_neighbours_must_be_clearly_less_likely(part: float, given: bool) -> None:
    """A valley of which a step of the coarse search makes so many times ``CLEAR``."""
    step = subsample_inductance.COARSE * CLOSE
    centre = round(math.log(0.2 * TAU) / step) * step
    found, _ = searched(valley(math.exp(centre), part * CLEAR / step**2))
    assert (found is not None) is given


def test_what_trials_cost_is_counted_whenever_they_went_on() -> None:
    """A trial that is judged by another's noise goes on; the answer's own records count theirs."""
    first: Any = [SimpleNamespace(simulated=10), SimpleNamespace(simulated=7)]
    last: Any = [SimpleNamespace(simulated=20)]
    of: Any = subsample_inductance._Search
    search = of([], (), {}, {}, None, [first, last])
    assert search.spent() == 30
    first[1].simulated = 15
    assert (search.spent(), search.spent(last)) == (35, 15)
