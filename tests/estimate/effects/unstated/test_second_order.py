"""Low-passes of second order that nobody stated: what each does, and to which channel."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.effects.action import Setup
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.unstated.current_second_order import CURRENT_SECOND_ORDER
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_second_order import SPEED_SECOND_ORDER
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.effects.unstated.voltage_second_order import VOLTAGE_SECOND_ORDER
from motorid.estimate.fit.logs.log_unknowns import moved
from motorid.estimate.model.low_passes import LEAST_DAMPED, first_orders, low_passes
from tests.estimate.effects.benches import POINT, record, start

Sizes = dict[InfluenceQuantity, float]


def fitted(sizes: Sizes) -> list[NDArray[np.float64]]:
    subject = record("unstated")
    more = {Instance(quantity): size for quantity, size in sizes.items()}
    return subject.fitted(POINT, start(subject), more)


def row(block: str) -> int:
    return [m.block.name for m in record("unstated").measured].index(block)


@pytest.mark.parametrize(
    ("block", "first", "second"),
    [
        (CURRENT, CURRENT_SMOOTHING, CURRENT_SECOND_ORDER),
        (SPEED, SPEED_SMOOTHING, SPEED_SECOND_ORDER),
    ],
)
def test_the_second_order_bends_what_the_first_lets_through(
    block: str, first: InfluenceQuantity, second: InfluenceQuantity
) -> None:
    """The same mean delay, so the same ramp; a step's corner is rounder."""
    period = record("unstated").timeline.period_s
    a, b = 12.0 * period, 7.0 * period
    one, two = (fitted(sizes)[row(block)] for sizes in ({first: a}, {first: a, second: b}))
    least = fitted({first: a, second: 1e-3 * period})[row(block)]
    inside = slice(20, -20)
    bent = np.abs(two - one)[inside].max()
    assert bent > 3.0 * np.abs(two - one)[-60:-20].max()  # where nothing jumps
    assert np.abs(least - one)[inside].max() < 0.1 * bent
    other = next(k for k in range(len(fitted({}))) if k != row(block))
    assert np.array_equal(fitted({first: a})[other], fitted({first: a, second: b})[other])


def test_one_of_second_order_holds_what_there_is_of_first() -> None:
    subject = record("unstated")
    period = subject.timeline.period_s
    setup = Setup(10, [0.0] * 3, filter_s={CURRENT: 2 * period}, second_s={CURRENT: 3 * period})
    made = low_passes(subject.measured, subject.outputs, setup, period)
    assert set(made) == {subject.measured[row(CURRENT)].row}
    none = first_orders(subject.measured, subject.outputs, setup)
    assert none[CURRENT] <= 0.0  # it is part of the other
    assert none[SPEED] == 0.0
    assert 0.0 < LEAST_DAMPED < 1.0


def test_the_voltage_s_acts_on_the_log_alone() -> None:
    setup = Setup(10, [0.0] * 3)
    (act,) = VOLTAGE_SECOND_ORDER.acts
    act(setup, record("unstated"), 0, 3e-4)
    assert setup.log_second_s == 3e-4
    assert setup.second_s == {}


def test_a_log_without_lags_needs_no_unknown_for_them() -> None:
    subject = record("unstated")
    assert not moved(subject, np.array([u.start for u in subject.unknowns]))
