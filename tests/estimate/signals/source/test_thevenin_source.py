"""A source behind a resistance: its line, its head and what is known of it, against formulas."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.estimate.signals.source import thevenin_source as module
from motorid.estimate.signals.source.smoothing import AS_READ, LINE, Form
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.source.supply_sag import Sag
from motorid.estimate.signals.source.thevenin_source import Source, source_resistance, sources
from motorid.estimate.signals.time_grid import Part
from motorid.program import StepKind

Floats = NDArray[np.float64]
COUNT, OHMS, LEVEL, NOISE = 200, 0.4, 6.0, 0.01
WHOLE = Part(0, COUNT, StepKind.DRIVE_VOLTS, LEVEL)
NONE = np.zeros(COUNT, dtype=np.bool_)
VAGUE = (1.0, 1e6)  # ohm, and how sure


def current(seed: int = 3) -> Floats:
    """It decays to a level, and wanders about it."""
    wander = 0.2 * np.random.default_rng(seed).standard_normal(COUNT)
    return 1.0 + 2.0 * np.exp(-np.arange(COUNT) / 40.0) + wander


def sensed(volts: Floats | None = None, **facts: Any) -> Any:
    noise = NOISE * np.random.default_rng(1).standard_normal(COUNT)
    read = LEVEL - OHMS * current() + noise if volts is None else volts
    return SimpleNamespace(**{
        "volts": read, "lost_shown": 0.0, "lost": 0.0, "resolution": 0.0, "noise": 0.0,
        "commanded": False, **facts,
    })  # fmt: skip


def posterior(dv: Floats, di: Floats, late: Floats, prior: tuple[float, float]) -> float:
    """Of dv = -r di and a prior, by the scatter of what changes late."""
    variance = float(np.mean(late**2))
    weight = float(di @ di) / variance + prior[1] ** -2
    return (float(-di @ dv) / variance + prior[0] * prior[1] ** -2) / weight


@pytest.mark.parametrize("prior", [VAGUE, (1.0, 0.05), (0.4, 1e-3)])
def test_a_resistance_is_that_of_the_changes_and_what_was_known(prior: tuple[float, float]) -> None:
    one, i = sensed(), current()
    dv, di = np.diff(one.volts), np.diff(i)
    expected = posterior(dv, di, dv[HEAD:], prior)
    assert source_resistance(one, i, [WHOLE], NONE, prior) == pytest.approx(expected)
    assert source_resistance(one, i, [WHOLE], NONE, VAGUE) == pytest.approx(OHMS, abs=0.02)
    known = sensed(one.volts - 3.0 * i, lost_shown=3.0 * i)
    assert source_resistance(known, i, [WHOLE], NONE, prior) == pytest.approx(expected)


def test_changes_beside_a_lost_reading_do_not_count() -> None:
    one, i = sensed(), current()
    lost = NONE.copy()
    lost[[50, 120]] = True
    one.volts[[50, 120]] += 9.0
    keep = np.ones(COUNT - 1, dtype=bool)
    keep[[49, 50, 119, 120]] = False
    dv, di = np.diff(one.volts)[keep], np.diff(i)[keep]
    expected = posterior(dv, di, dv[HEAD:], VAGUE)
    assert source_resistance(one, i, [WHOLE], lost, VAGUE) == pytest.approx(expected)


def test_parts_that_drive_the_motor_tell_it_together() -> None:
    one, i = sensed(), current()
    halves = [replace(WHOLE, stop=100), replace(WHOLE, start=100)]
    dv = [np.diff(one.volts[part.slice]) for part in halves]
    di = [np.diff(i[part.slice]) for part in halves]
    late = np.concatenate([d[HEAD:] for d in dv])
    both = posterior(np.concatenate(dv), np.concatenate(di), late, VAGUE)
    assert source_resistance(one, i, halves, NONE, VAGUE) == pytest.approx(both)
    first = posterior(dv[0], di[0], dv[0][HEAD:], VAGUE)
    for other in (
        {"kind": StepKind.COAST}, {"kind": None}, {"discontinuous": True},
        {"stop": 100 + HEAD + 23},
    ):  # fmt: skip
        parts = [halves[0], replace(halves[1], **other)]
        assert source_resistance(one, i, parts, NONE, VAGUE) == pytest.approx(first)


def test_a_resistance_is_never_below_none_and_as_known_where_nothing_tells() -> None:
    i = current()
    assert source_resistance(sensed(LEVEL + 0.5 * i), i, [WHOLE], NONE, VAGUE) == 0.0
    assert source_resistance(sensed(), i, [], NONE, (0.7, 0.1)) == 0.7
    still = np.ones(COUNT)
    quiet = sensed(np.full(COUNT, LEVEL))
    assert source_resistance(quiet, still, [WHOLE], NONE, (0.7, 0.1)) == pytest.approx(0.7)
    assert source_resistance(sensed(), still, [WHOLE], NONE, (0.7, np.inf)) == 0.7


def source(one: Any, i: Floats, part: Part = WHOLE, **other: Any) -> Source:
    (found,) = sources(one, i, [part], other.pop("lost", NONE), OHMS, **other)
    assert found is not None
    return found


def test_a_steady_source_is_a_line_without_the_noise_of_its_readings() -> None:
    one, i = sensed(), current()
    found = source(one, i)
    opened = one.volts + OHMS * i
    level = opened[HEAD:].mean()
    noise = float(np.mean(np.diff(opened[HEAD:]) ** 2)) / 2.0
    flow = i - i[HEAD:].mean()
    weight = float(flow[HEAD:] @ flow[HEAD:])
    slope = float(flow[HEAD:] @ (opened - level)[HEAD:]) / weight
    assert found.form.half == LINE
    assert not found.as_read
    assert found.volts[HEAD:] == pytest.approx((level + slope * flow)[HEAD:])
    assert np.ptp(found.volts[HEAD:]) < 0.3 * np.ptp(one.volts[HEAD:] + OHMS * i[HEAD:])
    assert found.noise == pytest.approx(noise**0.5)
    assert found.tilt == pytest.approx((noise / weight) ** 0.5 * flow)
    assert found.ohms == OHMS


def test_what_a_sag_and_dead_time_take_is_put_back_over_the_intervals() -> None:
    one, i = sensed(), current()
    usual = source(one, i)
    at = np.arange(COUNT)
    sag = Sag(0.5 * np.exp(-at / 9.0), -0.3 * np.exp(-at / 7.0))
    with_sag = source(sensed(one.volts + sag.shown), i, sags={0: sag})
    assert with_sag.volts == pytest.approx(usual.volts + sag.taken)
    lossy = source(sensed(one.volts - 0.2, lost_shown=0.2, lost=0.3), i)
    assert lossy.volts == pytest.approx(usual.volts - 0.3)


def test_a_current_over_intervals_takes_the_place_of_one_over_windows() -> None:
    """The line follows the current; where it has no slope nothing changes."""
    one, i = sensed(LEVEL - (OHMS + 0.3) * current()), current()
    usual, moved = source(one, i), source(one, i, mean=i + 0.5)
    assert moved.volts[HEAD:] == pytest.approx(usual.volts[HEAD:] - 0.3 * 0.5)


def test_a_source_that_wanders_too_fast_for_any_window_is_as_read() -> None:
    rough = LEVEL - OHMS * current() + np.repeat(np.tile([0.5, -0.5], 40), 3)[:COUNT]
    found = source(sensed(rough), current())
    assert found.as_read
    assert found.form.half == AS_READ
    assert found.volts[HEAD:] == pytest.approx((rough + OHMS * current())[HEAD:])
    assert sources(sensed(rough, commanded=True), current(), [WHOLE], NONE, OHMS) == (None,)
    loud = source(sensed(rough, resolution=5.0), current())  # its steps explain it
    assert not loud.as_read


def test_the_head_follows_what_departs_from_the_line() -> None:
    one, i = sensed(), current()
    one.volts[:2] += 0.8
    found = source(one, i, mean=i)
    assert found.form.head >= 2
    share = np.ones(2)
    clear = source(sensed(), i).volts[:2]
    assert found.volts[:2] - clear == pytest.approx(0.8 * share, abs=0.05)
    assert len(found.errors) == found.form.head + 2  # a reading each, the next, and a doubt


def test_pulses_follow_their_source_without_delay() -> None:
    """Nothing is said by a slope of what would follow itself; a reversed first reading is left."""
    one, i = sensed(), current()
    pulses = replace(WHOLE, discontinuous=True)
    found = source(one, i, pulses)
    opened = one.volts + OHMS * i
    head = found.form.head
    assert found.volts[head:] == pytest.approx(opened[HEAD:].mean())
    assert not np.any(found.tilt)
    assert found.volts[:head] == pytest.approx(opened[:head])


def test_what_was_decided_of_a_form_is_kept() -> None:
    one, i = sensed(), current()
    decided = replace(source(one, i), form=Form(8, 5))
    kept = source(one, i, before=[decided])
    assert kept.form == Form(8, 5)
    assert sources(one, i, [WHOLE], NONE, OHMS, before=[None]) == (None,)


@pytest.mark.parametrize(
    ("part", "known"),
    [
        ({}, True), ({"kind": StepKind.COAST}, False), ({"kind": None}, False),
        ({"kind": StepKind.BRAKE}, True), ({"stop": HEAD + 23}, False), ({"stop": HEAD + 24}, True),
    ],
)  # fmt: skip
def test_a_source_is_of_a_command_that_connects_the_motor_for_long_enough(
    part: dict[str, Any], known: bool
) -> None:
    (found,) = sources(sensed(), current(), [replace(WHOLE, **part)], NONE, OHMS)
    assert (found is not None) is known
    lost = np.arange(COUNT) >= HEAD + 23
    assert sources(sensed(), current(), [replace(WHOLE, **part)], lost, OHMS) == (None,)


def test_a_larger_current_before_runs_out() -> None:
    mean = np.concatenate([np.full(10, -2.0), np.full(30, 1.0)])
    assert module._runs_out(mean, replace(WHOLE, start=10, stop=40))
    assert not module._runs_out(mean, replace(WHOLE, start=11, stop=40))  # as large
    assert not module._runs_out(mean, replace(WHOLE, start=0, stop=40))


@pytest.mark.parametrize(
    ("slope", "deviation", "sure"),
    [(2.0, 1.0, 1.5), (-2.0, 1.0, -1.5), (1.0, 2.0, 0.0), (0.0, 0.0, 0.0), (3.0, 0.0, 3.0)],
)
def test_a_slope_is_sure_as_far_as_it_is_more_than_noise(
    slope: float, deviation: float, sure: float
) -> None:
    assert module._sure(slope, deviation) == pytest.approx(sure)
