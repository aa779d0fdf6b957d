"""Filters and worths of readings: one for all of a kind, none for what rounding leaves."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from motorid.estimate.model import prewhitening

N = 2000


def solution(runs: list[Any]) -> Any:
    return SimpleNamespace(values=np.zeros(0), own=[None for _ in runs])


def coloured(seed: int, rho: float) -> np.ndarray:
    return lfilter([1.0], [1.0, -rho], np.random.default_rng(seed).standard_normal(N))


class Record:
    """Blocks with residuals that are given; notes its filters and worths."""

    def __init__(
        self, blocks: dict[str, np.ndarray], floor: float = 1e-9, parts: tuple[bool, ...] = (False,)
    ) -> None:
        self.left = list(blocks.values())
        self.measured = [
            SimpleNamespace(
                block=SimpleNamespace(group=name, floor=floor), keep=np.arange(N),
                root_weights=None,
            )
            for name in blocks
        ]  # fmt: skip
        edges = np.linspace(0, N, len(parts) + 1).astype(int)
        self.timeline = SimpleNamespace(count=N, parts=[
            SimpleNamespace(start=a, stop=b, open=opened)
            for (a, b), opened in zip(pairwise(edges), parts, strict=True)
        ])  # fmt: skip
        self.filters: list[Any] = []
        self.worths: list[Any] = []

    def departures(self, *_: Any) -> Any:
        return self.left

    def weighed(self, parts: Any, filtered: bool = True) -> Any:
        return parts

    def whiten(self, filters: Any) -> None:
        self.filters = filters

    def thin(self, worths: Any) -> None:
        self.worths = worths


def test_a_kind_has_one_filter_in_all_records_and_white_readings_none() -> None:
    white = np.random.default_rng(9).standard_normal
    runs: Any = [
        Record({"current": coloured(1, 0.8), "position": white(N)}),
        Record({"current": coloured(2, 0.8), "position": white(N)}),
    ]
    assert prewhitening.whiten(runs, solution(runs))
    for run in runs:
        taps, none = run.filters
        assert none is None
        left = np.convolve(run.left[0], taps, "valid")
        assert abs(np.corrcoef(left[1:], left[:-1])[0, 1]) < 0.06
    assert runs[0].filters[0] is runs[1].filters[0]
    calm: Any = [Record({"position": white(N)})]
    assert not prewhitening.whiten(calm, solution(calm))
    assert calm[0].filters == [None]


@pytest.mark.parametrize(("share", "filtered"), [(0.9, True), (1.1, False)])
def test_what_is_below_the_converters_floor_has_no_colour(share: float, filtered: bool) -> None:
    """The larger floor of the records counts."""
    rms = float(np.sqrt(np.mean([coloured(k, 0.8) ** 2 for k in (1, 2)])))
    runs: Any = [
        Record({"current": coloured(1, 0.8)}, floor=1e-9),
        Record({"current": coloured(2, 0.8)}, floor=share * rms),
    ]
    assert prewhitening.whiten(runs, solution(runs)) is filtered


def test_readings_that_wander_are_worth_less_where_they_do() -> None:
    """A wander in the driven half only; a reading there is worth what its means scatter by."""
    rng = np.random.default_rng(4)
    wander = np.cumsum(rng.standard_normal(N)) / 10.0
    residual = np.where(np.arange(N) < N // 2, wander, 0.0) + rng.standard_normal(N)
    run: Any = Record({"position": residual}, parts=(False, True))
    assert prewhitening.thin([run], solution([run]))
    (roots,) = run.worths
    assert roots[N // 2 :] == pytest.approx(1.0)
    assert len(set(roots[: N // 2].tolist())) == 1
    half = residual[: N // 2]
    sums = half.reshape(8, -1).sum(axis=1) / np.sqrt(N // 16)
    assert roots[0] ** -2 == pytest.approx((sums**2).mean() / (half**2).mean(), rel=0.02)


def test_white_readings_are_worth_what_they_are() -> None:
    run: Any = Record(
        {"position": np.random.default_rng(5).standard_normal(N)}, parts=(False, True)
    )
    assert not prewhitening.thin([run], solution([run]))
    assert run.worths == [None]
