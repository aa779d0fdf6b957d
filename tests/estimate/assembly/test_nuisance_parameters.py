"""What was estimated on the way is reported where the readings tell it, and left out where not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.assembly.assemble import UNTOLD, nuisance_parameters
from motorid.estimate.uncertainty.budget import Carried

LIKE = 5.0  # A, the currents of the run


def said(value: float, deviation: float, listed: bool = True, instrument: float = 0.0) -> Any:
    quantity = SimpleNamespace(listed=listed, unit="A", scale=lambda record: LIKE)
    record: Any = SimpleNamespace(
        instances=[SimpleNamespace(name="initial current", quantity=quantity)]
    )
    solution: Any = SimpleNamespace(
        own=[np.array([value])], own_covariance=[np.array([[deviation**2]])]
    )
    carried = Carried({}, {"gain": (np.array([instrument]),)})
    found: Any = SimpleNamespace(solution=solution, hidden=(), carried=carried)
    return nuisance_parameters(found, [record]).get("initial current")


@pytest.mark.parametrize("deviation", [0.1, 0.99 * UNTOLD * LIKE])
def test_what_is_told_has_its_interval(deviation: float) -> None:
    found = said(2.0, deviation)
    assert (found.value, found.total) == (2.0, pytest.approx(deviation))
    low, high = found.interval_95
    assert (high - low) / 2 == pytest.approx(1.96 * deviation, rel=1e-3)


def test_what_instruments_leave_open_of_it_is_in_its_interval() -> None:
    found = said(2.0, 0.3, instrument=0.4)
    assert (found.statistical, found.instrument) == (0.3, 0.4)
    assert found.total == pytest.approx(0.5)
    assert found.interval_95 == pytest.approx((2.0 - 1.96 * 0.5, 2.0 + 1.96 * 0.5), rel=1e-3)


@pytest.mark.parametrize("deviation", [1.01 * UNTOLD * LIKE, 1170.0])
def test_ten_times_what_it_could_be_says_nothing_and_is_left_out(deviation: float) -> None:
    assert said(-200.0, deviation) is None


def test_what_is_of_no_interest_is_left_out() -> None:
    assert said(2.0, 0.1, listed=False) is None
