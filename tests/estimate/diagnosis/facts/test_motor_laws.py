"""Two laws of a motor as regressions, on columns that follow them by construction."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.estimate.diagnosis.facts.motor_laws import FEWEST, SHORTEST, left

Floats = NDArray[np.float64]

COUNT = 1200


def lawful() -> tuple[Floats, Floats, Floats]:
    """A speed, the current that accelerates and brakes it, and the voltage of both."""
    time = np.linspace(0.0, 6.0, COUNT)
    speed = np.sin(time) + 0.5 * np.sin(2.7 * time)
    rise = np.gradient(speed, time)
    current = 0.6 * rise + 0.2 * speed + 0.1 * np.sign(speed)
    return 0.4 * current + 0.9 * speed, current, speed


def test_columns_of_a_motor_leave_little() -> None:
    electrical, mechanical = left(*lawful())
    assert electrical < 1e-3
    assert mechanical < 0.02  # a block that holds a change of sign follows neither sign


@pytest.mark.parametrize("order", [(1, 0, 2), (2, 1, 0), (0, 2, 1)])
def test_columns_in_another_order_leave_more(order: tuple[int, int, int]) -> None:
    columns = lawful()
    assert sum(left(*(columns[k] for k in order))) > 5.0 * sum(left(*columns))


def test_too_few_whole_blocks_tell_nothing() -> None:
    rows = np.zeros(COUNT, dtype=bool)
    rows[: (FEWEST - 1) * SHORTEST] = True
    assert left(*lawful(), rows) == (1.0, 1.0)
