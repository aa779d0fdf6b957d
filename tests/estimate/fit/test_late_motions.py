"""A motion that is taken earlier: which lag is the best, how it is declared, and what is said."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.fit import lagging_start
from motorid.estimate.fit.lagging_start import LAGS, Doubt, mechanics, taken_earlier
from motorid.estimate.fit.start_signals import Signals

PERIOD_S = 2e-3
WHY = DataError("no inertia")


def run(period_s: float = PERIOD_S, speed: bool = True) -> Signals:
    at = np.arange(200.0)
    flat = np.zeros(200)
    return Signals(period_s, flat, flat, at, 3.0 * at if speed else None, (0, 200), (False,), 0.0)


def by_lag(explained: Mapping[int, float], seen: list[Signals] | None = None) -> Callable[..., Any]:
    """A search for friction and inertia that works with the motion so many samples earlier."""

    def solve(data: Sequence[Signals], K: float, fixed: Mapping[str, float]) -> Any:
        assert (K, fixed) == (0.05, {"B": 1.0})
        assert len(data) == 2
        if seen is not None:
            seen.append(data[0])
        lag = int(data[0].angle[100]) - 100
        if lag not in explained:
            raise DataError("no")
        return (1.0, float(lag), 2.0), explained[lag]

    return solve


@pytest.mark.parametrize(
    ("explained", "lag"), [({3: 5.0, 8: 9.0, 12: 7.0}, 8), ({-2: 4.0}, -2), ({84: 1.0, 1: 0.5}, 84)]
)
def test_the_lag_that_explains_most_of_the_torque_is_taken(
    explained: dict[int, float], lag: int
) -> None:
    """In periods of the finest record."""
    data = [run(3.0 * PERIOD_S), run()]
    found, doubt = mechanics(data, 2.0, 0.05, {"B": 1.0}, by_lag(explained), WHY)
    assert found == (1.0, lag, 2.0)
    assert doubt == Doubt(WHY, lag * PERIOD_S)


def test_a_motion_is_read_earlier_and_stays_at_its_ends() -> None:
    seen: list[Signals] = []
    mechanics([run(), run()], 2.0, 0.05, {"B": 1.0}, by_lag({1: 1.0}, seen), WHY)
    assert [int(s.angle[100]) - 100 for s in seen] == [*LAGS, *(-lag for lag in LAGS)]
    first, last = seen[0], seen[-1]
    assert first.angle.tolist() == [*range(1, 200), 199]
    assert last.angle.tolist() == [0] * 85 + list(range(1, 116))
    for s in seen:
        assert s.speed == pytest.approx(3.0 * s.angle)
    bare = lagging_start._earlier(run(speed=False), 5)
    assert bare.speed is None
    assert bare.angle[0] == 5.0


def test_the_refusal_names_the_lag_where_one_was_seen() -> None:
    assert Doubt(WHY).refusal() is WHY
    said = str(Doubt(WHY, 0.0125).refusal())
    assert said.startswith("no inertia; the motion follows the current best")
    assert "12.5 ms earlier" in said


def capture(**delays: float) -> Capture:
    channels = {
        n: Channel(n, "", np.zeros(4), delay_s=1e-3, delay_uncertainty_s=d)
        for n, d in delays.items()
    }
    return Capture(1000 * np.arange(4), 1e6, channels, provenance={"by": "hand"})


def test_a_motion_is_declared_later_to_within_a_sample() -> None:
    """A sample of 1 ms is as good as a deviation of 1/√12 ms; a larger one that is stated stays."""
    found = taken_earlier(capture(**{SPEED: 1e-4, POSITION: 5e-4, CURRENT: 1e-4}), 0.02)
    assert found.channels[SPEED].delay_s == pytest.approx(0.021)
    assert found.channels[SPEED].delay_uncertainty_s == pytest.approx(1e-3 / 12.0**0.5)
    assert found.channels[POSITION].delay_s == pytest.approx(0.021)
    assert found.channels[POSITION].delay_uncertainty_s == 5e-4
    assert found.channels[CURRENT].delay_s == 1e-3
    assert found.provenance == {"by": "hand", lagging_start.TAKEN: 0.02}
    again = taken_earlier(found, -0.005)
    assert again.provenance[lagging_start.TAKEN] == pytest.approx(0.015)


def test_each_lag_is_said_once_in_time_and_samples() -> None:
    late = taken_earlier(capture(**{SPEED: 0.0}), 0.02)
    later = taken_earlier(capture(**{SPEED: 0.0}), 0.03)
    said = lagging_start.remarks([late, capture(**{SPEED: 0.0}), late, later])
    assert [d.code for d in said] == ["motion_late"] * 2
    assert "comes 20 ms (20 samples) after" in said[0].message
    assert "comes 30 ms (30 samples) after" in said[1].message
    assert lagging_start.remarks([capture(**{SPEED: 0.0})]) == []


def test_a_motor_that_never_turns_has_a_guess_too() -> None:
    """A speed of one, and the current that flows while it is at it: none."""
    flat = np.zeros(50)
    still = Signals(PERIOD_S, flat + 3.0, flat + 0.4, flat, None, (0, 50), (False,), 0.0)
    viscous, inertia, dry = lagging_start._guess([still], 2.0, 0.05, {})
    assert (viscous, dry) == (0.0, 0.0)
    assert inertia == pytest.approx(PERIOD_S * 0.05**2 / 2.0)


def test_the_run_that_turns_farthest_is_the_one_to_guess_by() -> None:
    def turned(top: float, amperes: float) -> Signals:
        speed = np.where(np.arange(80) < 30, 0.0, top)
        angle = np.cumsum(speed) * PERIOD_S
        volts = np.where(np.arange(80) < 10, 0.0, 1.0)
        flat = np.full(80, amperes)
        return Signals(PERIOD_S, volts, flat, angle, speed, (0, 80), (False,), 0.0)

    data = [turned(20.0, 0.1), turned(-50.0, -0.3), turned(10.0, 0.2)]
    viscous, inertia, dry = lagging_start._guess(data, 2.0, 0.05, {})
    assert viscous == pytest.approx(0.5 * 0.05 * 0.3 / 50.0)
    assert dry == pytest.approx(0.5 * 0.05 * 0.3)
    assert inertia == pytest.approx(20 * PERIOD_S * 0.05**2 / 2.0)
