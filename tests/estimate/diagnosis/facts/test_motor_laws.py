"""Two laws of a motor as regressions, on columns that follow them by construction."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.facts.motor_laws import (
    FEWEST,
    SHORTEST,
    Shares,
    columns,
    convinces,
    left,
    non_negative,
)
from motorid.program import Program, Step, StepKind

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


def logged(count: int = COUNT, **changes: Any) -> Capture:
    """A log of such columns in volts, amperes and rad/s."""
    names, units = (VOLTAGE, CURRENT, SPEED), ("V", "A", "rad/s")
    given = {
        name: Channel(name, unit, scale * values[:count])
        for name, unit, scale, values in zip(
            names, units, (12.0, 3.0, 400.0), lawful(), strict=True
        )
    }
    return Capture(
        1000 * np.arange(count), 1e6, {**given, **changes.pop("channels", {})}, **changes
    )


def test_columns_are_shares_of_their_largest_where_all_were_read() -> None:
    gone = lawful()[2].copy()
    gone[7] = np.nan
    found = columns(logged(channels={SPEED: Channel(SPEED, "rad/s", gone)}))
    assert found is not None
    for column, whole in zip(found, lawful(), strict=True):
        kept = np.delete(whole, 7)
        assert column == pytest.approx(kept / np.abs(kept).max())
    assert sum(left(*found)) < 0.03


@pytest.mark.parametrize(
    "capture",
    [
        logged(channels={SPEED: Channel(SPEED, "rad/s", np.full(COUNT, 5.0))}),
        logged(channels={CURRENT: Channel(CURRENT, "A", np.abs(lawful()[1]), unsigned=True)}),
        logged(FEWEST * SHORTEST - 1), logged(program=Program((Step(StepKind.COAST, 1.0),))),
    ],
    ids=["constant", "unsigned", "short", "of a program"],
)  # fmt: skip
def test_what_tells_nothing_of_both_laws_has_no_columns(capture: Capture) -> None:
    assert columns(capture) is None
    lacking = logged()
    kept = {n: c for n, c in lacking.channels.items() if n != CURRENT}
    assert columns(replace(lacking, channels=kept)) is None
    assert columns(logged(FEWEST * SHORTEST)) is not None


def test_no_coefficient_is_below_zero_and_nothing_explains_nothing() -> None:
    one, other = np.array([1.0, 0.0, 2.0]), np.array([0.0, 1e6, 0.0])
    found, rest = non_negative([one, other], 3.0 * one + 2e-6 * other)
    assert found == pytest.approx([3.0, 2e-6])
    assert rest == pytest.approx(0.0, abs=1e-20)
    found, rest = non_negative([one, other], -3.0 * one + 2e-6 * other)
    assert found == pytest.approx([0.0, 2e-6])
    assert rest == pytest.approx(45.0 / 49.0)
    assert non_negative([one, other], np.zeros(3)) == ([0.0, 0.0], 1.0)


@pytest.mark.parametrize(
    ("mended", "logged", "yes"),
    [
        ((0.0, 0.049), (0.1, 0.9), True),
        ((0.0, 0.051), (0.1, 0.9), False),
        ((0.009, 0.01), (0.01, 0.09), True),
        ((0.009, 0.012), (0.01, 0.09), False),
        ((0.002, 0.01), (0.001, 0.9), False),
        ((0.01, 0.002), (0.9, 0.001), False),
    ],
)
def test_a_mended_current_convinces_by_itself_and_beside_the_logged_one(
    mended: Shares, logged: Shares, yes: bool
) -> None:
    """5 % of the squares, a fifth of what the logged one leaves, and neither law followed worse."""
    assert convinces(mended, logged) is yes
