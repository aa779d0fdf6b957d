"""Which channel is named late, or smoothed: only what they differ by is seen."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, VOLTAGE
from motorid.estimate.diagnosis import rank
from motorid.estimate.diagnosis.faults.unstated_channels import Size, _together, lags, smoothings
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.effects.unstated.speed_smoothing import SPEED_SMOOTHING
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from motorid.estimate.results.estimate import Suspect
from tests.estimate.effects.benches import record

U = 1e-5


@pytest.mark.parametrize(
    ("late", "lag", "odd"),
    [(0.0, 0.01, CURRENT), (-0.01, 0.0, VOLTAGE), (0.01, -0.01, SPEED)],
)
def test_the_odd_one_out_of_three_is_late(late: float, lag: float, odd: str) -> None:
    sizes = {VOLTAGE_LATE.name: (late, U), CURRENT_LAG.name: (lag, U)}
    found = {one.channel: one.seconds for one in lags(record("unstated"), sizes)}
    assert found[odd] == pytest.approx(0.01)
    assert all(seconds == pytest.approx(0.0) for name, seconds in found.items() if name != odd)


def test_what_all_have_in_common_is_nobodys() -> None:
    sizes = {
        CURRENT_SMOOTHING.name: (2e-3, U),
        SPEED_SMOOTHING.name: (-1e-3, U),
        VOLTAGE_SMOOTHING.name: (-1e-3, U),
    }
    found = {one.channel: one.seconds for one in smoothings(record("unstated"), sizes)}
    assert found == pytest.approx({CURRENT: 3e-3, SPEED: 0.0, VOLTAGE: 0.0})


def test_only_what_is_sure_and_long_is_said() -> None:
    period = 1e-3
    assert Size(CURRENT, 5e-4, 1e-5).worth_saying(period)
    assert not Size(CURRENT, 3e-4, 1e-5).worth_saying(period)
    assert not Size(CURRENT, 5e-4, 2e-4).worth_saying(period)
    # a speed of counts, the mean since the reading before, is behind by half of one
    assert not Size(SPEED, 5.2e-4, 1e-5).worth_saying(period)
    assert Size(SPEED, 5.4e-4, 1e-5).worth_saying(period)


@pytest.mark.parametrize(
    ("late_s", "smooth_s", "kind"), [(4e-3, 1e-4, "lag"), (1e-4, 4e-3, "filtered")]
)
def test_a_sure_sum_of_lag_and_low_pass_is_said_as_what_is_more_of_it(
    late_s: float, smooth_s: float, kind: str
) -> None:
    """Their shares are not told: each scatters by 3 ms against the other, their sum by 0.01 ms."""
    places = (VOLTAGE_LATE, CURRENT_LAG, CURRENT_SMOOTHING)
    one: Any = SimpleNamespace(instances=[Instance(quantity) for quantity in places])
    apart = np.array([0.0, 3e-3, -3e-3])
    covariance = np.outer(apart, apart) + 0.5 * U**2 * np.eye(3)
    ((named, size),) = _together(one, np.array([0.0, late_s, smooth_s]), covariance)
    assert (named, size.channel) == (kind, CURRENT)
    assert size.seconds == pytest.approx(4.1e-3)
    assert size.uncertainty_s == pytest.approx(U)
    without: Any = SimpleNamespace(instances=one.instances[:2])
    assert list(_together(without, np.zeros(2), np.eye(2))) == []


def test_what_the_fit_allows_for_spoils_nothing_and_the_same_fault_unallowed_does() -> None:
    lag = Suspect("current_lag", "current", "it comes late", "declare it", "named")
    assert rank.spoiling([lag])
    assert not rank.spoiling([replace(lag, allowed=True)])
