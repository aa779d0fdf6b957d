"""Fit and source in turn end at a point that more passes, or the last digits, do not move."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import motorid
from bench.coverage.rigs import draw_bench
from bench.coverage.runs import record
from motorid.capture import store
from motorid.capture.model import POSITION, Capture, Channel
from motorid.estimate.fit import alternating_fit
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Estimate
from tests.six_parameters import fit

SIX = ("R", "L", "K", "B", "J", "T0")
STAYS = 0.01  # of a total uncertainty
NOISE = 0.1  # of a statistical one
ROUNDING = 1e-13


def change(deviations: float) -> alternating_fit.Change:
    """Of one parameter of six, by so many of them."""
    return alternating_fit.Change(np.r_[0.0, 0.3 * deviations, np.zeros(4)], np.full(6, 0.3))


@pytest.mark.parametrize(
    ("before", "now", "ratio"),
    [(2.0, 1.0, 0.5), (10.0, 1.0, 0.3), (1.0, 2.0, 0.95), (None, 1.0, 0.95)],
)
def test_what_is_left_is_the_sum_of_passes_that_shrink_alike(
    before: float | None, now: float, ratio: float
) -> None:
    """Neither quicker than by 0.3 nor slower than by 0.95, whatever two passes seem to say."""
    first = None if before is None else change(before)
    left = change(now).left(first)
    assert left == pytest.approx(sum(now * ratio**k for k in range(1, 1000)), rel=1e-9)


@pytest.fixture(scope="module")
def turning(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    """Of the default rig: the ripple turns its current round within the dead time."""
    path = tmp_path_factory.mktemp("fixed") / "run.h5"
    motorid.record("sim", path)
    return store.load(path)


def moved(one: Estimate, other: Estimate) -> tuple[float, float]:
    """The farthest that a parameter moves, in total and in statistical uncertainties."""
    total, noise = [], []
    for name in SIX:
        a, b = one.parameters[name], other.parameters[name]
        assert a.status == b.status
        total.append(abs(a.value - b.value) / b.total)  # type: ignore[operator]
        noise.append(abs(a.value - b.value) / b.statistical)  # type: ignore[operator]
    return max(total), max(noise)


def rounded(capture: Capture, seed: int) -> Capture:
    """Its readings as another processor might have them; counts of an encoder are whole numbers."""
    rng = np.random.default_rng(seed)

    def other(channel: Channel) -> Channel:
        error = ROUNDING * rng.standard_normal(len(channel.raw))
        return replace(channel, raw=channel.raw * (1.0 + error))

    channels = {n: c if n == POSITION else other(c) for n, c in capture.channels.items()}
    return replace(capture, channels=channels)


@pytest.mark.slow
def test_more_passes_move_nothing(turning: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = fit([turning], model="six")
    monkeypatch.setattr(alternating_fit, "SETTLED", 0.0)
    many = fit([turning], model="six")
    assert many.evaluations > usual.evaluations
    total, noise = moved(usual, many)
    assert total < STAYS
    assert noise < NOISE
    assert all("source iteration" not in causes for causes in usual.budget.values())


@pytest.mark.slow
def test_what_passes_leave_is_a_cause(turning: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(alternating_fit, "MOST_PASSES", 3)
    cut = fit([turning], model="six")
    assert max(causes.get("source iteration", 0.0) for causes in cut.budget.values()) > 0.0


@pytest.mark.slow
def test_what_is_only_compared_is_as_likely_as_at_the_end(turning: Capture) -> None:
    """For a fraction of the responses, where its inductance is a wrong one."""
    found = fit([turning], model="six")
    known = {name: float(found.parameters[name].value or 0.0) for name in SIX}
    for part in (0.5, 1.0, 2.0):
        likely, spent = [], []
        for how in (alternating_fit.with_inductance, alternating_fit.near_inductance):
            records = [MotorRecord(turning, SIX, {})]
            near = alternating_fit.with_sources(records, SIX, known)
            before = records[0].simulated
            one = how(records, SIX, known, near, part * known["L"])
            assert dict(zip(SIX, one.values, strict=True))["L"] == pytest.approx(part * known["L"])
            likely.append(one.objective)
            spent.append(records[0].simulated - before)
        assert likely[1] == pytest.approx(likely[0], abs=3.0 * alternating_fit.ROUGH)
        assert spent[1] < spent[0]


@pytest.mark.slow
def test_the_last_digits_of_readings_move_nothing(turning: Capture) -> None:
    usual = fit([turning], model="six")
    total, _ = moved(fit([rounded(turning, 7)], model="six"), usual)
    assert total < STAYS


@pytest.mark.study
def test_a_bend_that_goes_too_far_comes_to_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Diode decay and a drop that bends late: taken as asked for, it swung between two bends."""
    runs = record(draw_bench(111), tmp_path)
    usual = fit(runs.captures, model="six")
    assert all("source iteration" not in causes for causes in usual.budget.values())
    monkeypatch.setattr(alternating_fit, "SETTLED", alternating_fit.SETTLED / 10.0)
    total, _ = moved(usual, fit(runs.captures, model="six"))
    assert total < STAYS


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e3])
def test_a_source_is_the_same_where_it_moved_by_rounding_alone(scale: float) -> None:
    volts = scale * np.array([0.0, 5.0, -12.0])
    for part, same in ((5e-10, True), (2e-9, False)):  # of the highest
        record: Any = SimpleNamespace(volts=volts + 12.0 * scale * part)
        assert alternating_fit._same(volts, record) is same
    none: Any = SimpleNamespace(volts=np.zeros(3))
    assert alternating_fit._same(np.zeros(3), none)
    assert not alternating_fit._same(np.zeros(3), SimpleNamespace(volts=np.full(3, 1e-10)))  # type: ignore[arg-type]
