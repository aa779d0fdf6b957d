"""Lags and low-passes that nobody stated: what only differences between channels can show."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.effects.action import Setup
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.registry import UNSTATED
from motorid.estimate.effects.timing.motion_delay import MOTION_DELAY
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated import ahead, default
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from tests.estimate.effects.benches import POINT, record, start

STEP_S = 2e-5


def fitted(sizes: dict[InfluenceQuantity, float] | None = None) -> list[NDArray[np.float64]]:
    """Readings of the undeclared log with these quantities."""
    subject = record("unstated")
    more = {Instance(quantity): size for quantity, size in (sizes or {}).items()}
    return subject.fitted(POINT, start(subject), more)


def apart(a: list[NDArray[np.float64]], b: list[NDArray[np.float64]]) -> float:
    """Largest difference in shares of each block's extent; the ends are not the same."""
    ends = slice(20, -20)
    return max(float(np.abs(x - y)[ends].max() / np.ptp(x)) for x, y in zip(a, b, strict=True))


def test_each_has_a_prior_only_where_nobody_states_the_fact() -> None:
    subject, stated = record("unstated"), record("moving")
    for quantity in UNSTATED:
        unknown = Instance(quantity).unknown(subject)
        assert unknown is not None, quantity.name
        assert unknown.prior_sd == pytest.approx(default.SAMPLES * subject.capture.period_s)
        assert Instance(quantity).unknown(stated) is None, quantity.name


def test_captures_of_a_board_have_none() -> None:
    assert all(Instance(q).unknown(record("measured")) is None for q in UNSTATED)


def test_a_current_ahead_is_all_else_behind() -> None:
    early = fitted({CURRENT_LAG: -STEP_S})
    others = fitted({MOTION_DELAY: STEP_S, VOLTAGE_LATE: -STEP_S})
    assert apart(early, fitted()) > 1e-3
    assert apart(early, others) < 1e-4


def test_a_voltage_that_is_smoother_makes_the_others_keener() -> None:
    one = fitted({VOLTAGE_SMOOTHING: STEP_S})
    other = fitted({CURRENT_SMOOTHING: -STEP_S, SPEED_SMOOTHING: -STEP_S})
    assert apart(one, fitted()) > 1e-3
    assert apart(one, other) < 1e-9


def test_a_low_pass_moves_its_own_channel_only() -> None:
    subject = record("unstated")
    usual, behind = fitted(), fitted({CURRENT_SMOOTHING: STEP_S})
    changes = {
        m.block.name: float(np.abs(b - a).max())
        for m, a, b in zip(subject.measured, usual, behind, strict=True)
    }
    assert changes[CURRENT] > 0.0
    assert changes[SPEED] == 0.0


def test_a_setup_ahead_of_its_readings_is_told_from_later() -> None:
    subject = record("unstated")
    setup = Setup(subject.timeline.count, [0.0, 0.0, 0.0])
    setup.late_s[CURRENT], setup.filter_s[SPEED] = -3e-5, -1e-5
    ahead.let_be(setup, subject.measured)
    assert setup.late_s[CURRENT] == pytest.approx(0.0)
    assert setup.late_s[SPEED] == pytest.approx(3e-5)
    assert setup.log_late_s == pytest.approx(-3e-5)
    assert setup.filter_s[SPEED] == pytest.approx(0.0)
    assert (setup.filter_s[CURRENT], setup.log_filter_s) == pytest.approx((1e-5, 1e-5))


def test_a_size_is_rounded_to_whole_samples() -> None:
    subject = record("unstated")
    period = subject.capture.period_s
    assert default.whole(subject, 2.6 * period) == pytest.approx(3.0 * period)
    assert default.whole(record("measured"), 2.6e-4) == 2.6e-4
