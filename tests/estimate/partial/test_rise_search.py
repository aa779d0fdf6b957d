"""Where the search of a rise begins, within which bounds, and which of its ends is taken."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scipy.optimize
from numpy.typing import NDArray

from motorid.estimate.partial import exponential_fit as module
from motorid.estimate.partial.exponential_fit import Record, Start

Floats = NDArray[np.float64]
TIME = 0.02 + 4e-3 * np.arange(150)


def problem(*starts: Start, time: tuple[Floats, ...] = ()) -> module._Problem:
    stamps = time or tuple(TIME for _ in starts)
    return module._Problem([Record(t, np.arange(float(len(t)))) for t in stamps], starts)


class Refined:
    """A refinement that goes where it began, and costs what it is told."""

    def __init__(self, patch: pytest.MonkeyPatch, *costs: float) -> None:
        self.costs, self.begun, self.weighed = list(costs), [], 0
        patch.setattr(module._Problem, "_refined", lambda _, times, lags: self.refined(times, lags))
        patch.setattr(module._Problem, "_weigh", lambda *_: self.weigh())
        patch.setattr(module._Problem, "_rise", lambda _, times, lags: (times, lags))

    def refined(self, times: Floats, lags: int) -> tuple[Floats, float]:
        self.begun.append((np.exp(times[:lags]).tolist(), times[lags:].tolist()))
        return times, self.costs[len(self.begun) - 1] if len(self.begun) <= len(self.costs) else 0.0

    def weigh(self) -> None:
        self.weighed += 1


STARTS = Start(0.1, 0.2, True), Start(0.02, 0.0, False), Start(0.3, 0.4, True)


@pytest.mark.parametrize(("costs", "best"), [((2.0, 1.0), 0.02), ((1.0, 2.0), 0.1)])
def test_one_lag_begins_at_the_median_and_at_the_least(
    costs: tuple[float, ...], best: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of three records, two of which show an onset."""
    refined = Refined(monkeypatch, *costs)
    found: Any = problem(*STARTS).solved(1)
    assert [lags for lags, _ in refined.begun[:2]] == [
        pytest.approx([0.1]), pytest.approx([0.02]),
    ]  # fmt: skip
    assert all(onsets == [0.2, 0.4] for _, onsets in refined.begun)
    assert np.exp(found[0][0]) == pytest.approx(best)
    assert refined.weighed == module.WHITENINGS
    assert len(refined.begun) == 2 + module.WHITENINGS


@pytest.mark.parametrize(("costs", "second"), [((2.0, 1.0), 0.3), ((1.0, 2.0), 0.05)])
def test_two_lags_divide_the_one_that_is_known(
    costs: tuple[float, ...], second: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a twentieth, and by three tenths; onsets are where they were found."""
    refined = Refined(monkeypatch, *costs)
    near: Any = SimpleNamespace(lags=np.array([0.2]), onsets=(0.21, None, 0.43))
    found: Any = problem(*STARTS).solved(2, near)
    assert refined.begun[0] == (pytest.approx([0.19, 0.01]), [0.21, 0.43])
    assert refined.begun[1] == (pytest.approx([0.14, 0.06]), [0.21, 0.43])
    assert np.exp(found[0][:2]) == pytest.approx([0.2 * (1.0 - second), 0.2 * second])


def test_a_lag_stays_between_a_thousandth_of_a_period_and_a_thousand_lengths(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of the quickest record, and of the longest; onsets are free, in units of a period."""
    asked: dict[str, Any] = {}

    def searched(_: Any, begin: Floats, **how: Any) -> Any:
        asked.update(how, begin=begin)
        return SimpleNamespace(x=begin, cost=7.0)

    monkeypatch.setattr(scipy.optimize, "least_squares", searched)
    slow = 0.5 * np.arange(20.0)
    one = problem(Start(0.1, 0.2, True), Start(0.1, 1.0, True), time=(TIME, slow))
    low, high = np.log(1e-3 * 4e-3), np.log(1e3 * 9.5)
    times, cost = one._refined(np.array([-99.0, 99.0, 0.2, 1.0]), 2)
    assert cost == 7.0
    assert asked["bounds"][0] == pytest.approx([low, low, -np.inf, -np.inf])
    assert asked["bounds"][1] == pytest.approx([high, high, np.inf, np.inf])
    assert asked["x_scale"] == pytest.approx([1.0, 1.0, 4e-3, 4e-3])
    assert times == pytest.approx([low, high, 0.2, 1.0])
    assert asked["begin"] == pytest.approx(times)
    assert asked["args"] == (2,)


def test_wandering_is_of_residuals_over_their_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def excess(weighed: Any, weights: Any) -> float:
        asked.append((weighed, weights))
        return 5.0

    monkeypatch.setattr(module, "excess", excess)
    values = 1.0 - np.exp(-TIME / 0.1) + 0.3 * (-1.0) ** np.arange(150)
    one = module._Problem([Record(TIME, values)], [Start(0.1, 0.0, False)])
    one.roots = [np.full(150, 4.0)]
    found = one._rise(np.array([np.log(0.1)]), 1)
    ((weighed, weights),) = asked
    assert weighed[0] == pytest.approx(4.0 * (values - found.fitted[0]))
    assert weights[0].tolist() == [1.0] * 150
    assert found.wander == 5.0
    assert found.onsets == (None,)
