"""Logs whose current firmware averaged from reading to reading, by scipy's filters."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter

from bench.mistakes.logs import STATIONS, Floats, Station
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.smoothing_kernels import Smoothing
from motorid.estimate.fit.logs import log_averages
from motorid.estimate.fit.logs.log_unknowns import Fit
from motorid.estimate.results.status import Status
from tests.estimate.fit.logs.test_log_smoothed_afterwards import estimate, off
from tests.estimate.fit.made_fits import fit, known, record, solution

SMALL, MEDIUM = STATIONS[:2]  # windings of .8 and of 1.9 samples


def recursive(y: Floats, counts: float) -> Floats:
    """A new reading ``counts`` that share of it."""
    state = [y[0] * (1.0 - counts)]
    return np.asarray(lfilter([counts], [1.0, counts - 1.0], y, zi=state)[0])


def of_the_last(y: Floats, count: int) -> Floats:
    return np.asarray(uniform_filter1d(y, count, mode="nearest", origin=(count - 1) // 2))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("station", "averaged", "words"),
    [
        (SMALL, partial(recursive, counts=0.5), "a new reading counts 0.5)"),
        pytest.param(
            SMALL,
            partial(of_the_last, count=3),
            "a mean of the last readings (of 3)",
            marks=pytest.mark.study,
        ),
        pytest.param(
            MEDIUM,
            partial(recursive, counts=0.25),
            "a new reading counts 0.25)",
            marks=pytest.mark.study,
        ),
    ],
)
def test_it_is_named_and_allowed_for(
    tmp_path: Path, station: Station, averaged: Callable[[Floats], Floats], words: str
) -> None:
    found = estimate(tmp_path, "i", averaged, station)
    (named,) = (one for one in found.suspects if one.strength == "named")
    assert named.code == "current_smoothed"
    assert named.allowed
    assert words in named.evidence
    assert abs(named.without["L"] / station.motor.L - 1.0) > 0.05  # as it would be without
    inductance = found.parameters["L"]
    assert inductance.status is Status.ESTIMATED
    assert inductance.value == pytest.approx(station.motor.L, rel=0.02)
    assert max(map(abs, off(found, station).values())) < 3.0


RECURSIVE, MEAN = log_averages.WAYS


def averaged(objective: float, way: Smoothing, size: float) -> Fit:
    one, own = known((Instance(log_averages.WAYS[way]), size, 1.0))
    return [one], solution(objective, None, own.tolist())


def choosing(monkeypatch: pytest.MonkeyPatch, tried: list[Fit], beside: list[Fit]) -> list[Fit]:
    """The fit before, and the answer, where the searches end so."""
    before = fit(100.0)
    monkeypatch.setattr(log_averages, "_may_be", lambda _: True)
    monkeypatch.setattr(log_averages, "_tried", lambda *_: tried)
    monkeypatch.setattr(log_averages, "_beside", lambda *_: iter(beside))
    monkeypatch.setattr(log_averages, "readings", lambda _: 1000)
    return [before, log_averages.taken(before, (), ("R", "L", "K"), {}, {}, 100.0)]


@pytest.mark.parametrize(
    ("objective", "way", "size", "beside", "is_taken"),
    [
        (92.0, RECURSIVE, 1.0, 95.0, True),
        (94.0, RECURSIVE, 1.0, 95.0, False),  # by less than an unknown costs
        (92.0, RECURSIVE, 0.3, 95.0, False),  # shorter than matters
        (92.0, MEAN, 0.7, 95.0, False),  # late by half as many readings
        (92.0, MEAN, 1.0, 95.0, True),
        (92.0, RECURSIVE, 1.0, 91.0, False),  # a circuit, or means over a time, are likelier
    ],
)
def test_an_average_is_taken_where_it_pays_and_nothing_like_it_is_likelier(
    objective: float, way: Smoothing, size: float, beside: float, is_taken: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    worse = averaged(99.0, way, 5.0)
    best = averaged(objective, way, size)
    before, found = choosing(monkeypatch, [worse, best], [fit(beside)])
    assert found is (best if is_taken else before)


def test_without_any_such_fit_the_one_before_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    before, found = choosing(monkeypatch, [], [])
    assert found is before


@pytest.mark.parametrize(("first", "asked"), [(80.0, 2), (95.0, 1)])
def test_other_courses_of_the_voltage_are_tried_where_an_average_is_likelier_at_all(
    first: float, asked: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Than the likeliest fit of what was read, by what an unknown costs: all ways under one course
    of the voltage, and the likeliest way from its size under the others.
    """
    seen = list[tuple[list[str], int]]()

    class Search:
        def each(self, shapes: list[str], ways: list[object], near: object) -> list[Fit]:
            seen.append((list(shapes), len(ways)))
            return [averaged(99.0, MEAN, 2.0), averaged(first, RECURSIVE, 2.0)]

    log_averages._tried(fit(100.0, "broken"), Search(), {}, 90.0)  # type: ignore[arg-type]
    assert seen == [(["broken"], 4), (["held", "joined"], 3)][:asked]


@pytest.mark.parametrize(
    ("jitter", "moves", "unstated", "may"),
    [(0.0, True, True, True), (0.1, True, True, False), (0.0, False, True, False),
     (0.0, True, False, False)],
)  # fmt: skip
def test_a_log_that_may_have_one_is_even_turns_and_says_nothing_of_a_filter(
    jitter: float, moves: bool, unstated: bool, may: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(log_averages, "motion", lambda _: "speed" if moves else None)
    stated = SimpleNamespace(unknown=lambda _: "its prior" if unstated else None)
    monkeypatch.setattr(log_averages, "SMOOTHING", stated)
    one = record(capture="run", timeline=SimpleNamespace(jitter=jitter))
    assert log_averages._may_be(one) is may
