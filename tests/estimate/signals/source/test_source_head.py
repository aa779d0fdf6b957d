"""What a source is made of, of a curve and a head that are told to it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.estimate.signals.source import thevenin_source as module
from motorid.estimate.signals.source.smoothing import AS_READ, LINE, Form
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.source.thevenin_source import EXCESS, Source
from tests.estimate.signals.source.test_thevenin_source import (
    COUNT,
    NONE,
    OHMS,
    WHOLE,
    current,
    sensed,
    source,
)

Floats = NDArray[np.float64]
CURVE = 0.1 * np.sin(np.arange(COUNT) / 9.0)
PULSES = replace(WHOLE, discontinuous=True)


def told(patch: pytest.MonkeyPatch, form: Form, curve: Floats = CURVE) -> list[tuple[Any, ...]]:
    """The form and the curve are these; what they were asked by is noted."""
    asked: list[tuple[Any, ...]] = []

    def trend_of(*how: Any) -> tuple[Floats, Form]:
        asked.append(how)
        return curve.copy(), form

    patch.setattr(module, "trend_of", trend_of)
    return asked


def line(one: Any, i: Floats) -> tuple[float, float, float, Floats, float]:
    """Level, slope, its deviation, current about its mean, and variance of a reading."""
    opened = one.volts + OHMS * i
    level = float(opened[HEAD:].mean())
    noise = float(np.mean(np.diff(opened[HEAD:]) ** 2)) / 2.0
    flow = i - i[HEAD:].mean()
    weight = float(flow[HEAD:] @ flow[HEAD:])
    slope = float(flow[HEAD:] @ (opened - level)[HEAD:]) / weight
    return level, slope, (noise / weight) ** 0.5, flow, noise


def test_a_curve_is_asked_of_what_the_line_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is allowed is the readings' scatter and their steps, of a twelfth of the square."""
    asked = told(monkeypatch, Form(LINE, 3))
    one, i = sensed(resolution=0.3, noise=0.2), current()
    level, slope, _, flow, noise = line(one, i)
    source(one, i)
    left, variance, allowed, declared, form = asked[0]
    assert left == pytest.approx(one.volts + OHMS * i - level - slope * flow)
    assert variance == pytest.approx(noise)
    assert allowed == pytest.approx(EXCESS * noise + 0.3**2 / 12.0)
    assert declared == pytest.approx(0.2**2)
    assert form is None


@pytest.mark.parametrize(
    ("pulses", "half", "head"),
    [(False, AS_READ, 3), (False, LINE, 3), (True, LINE, 3), (True, AS_READ, HEAD)],
)
def test_pulses_that_are_as_read_have_all_of_the_head(
    pulses: bool, half: int, head: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    told(monkeypatch, Form(half, 3))
    found = source(sensed(), current(), PULSES if pulses else WHOLE)
    assert found.form == Form(half, head)


def test_the_head_is_its_line_and_a_share_of_what_readings_depart_from_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A source that gives way more than was said, so that its slope counts; a current of which
    intervals have half as much more than windows."""
    told(monkeypatch, Form(LINE, 5))
    i = current()
    mean = i + 0.25 * (i - 1.0)
    one = sensed(sensed().volts - 0.3 * i)
    one.volts[:5] += [0.5, -0.4, 0.3, 0.2, -0.1]
    level, slope, deviation, flow, _ = line(one, i)
    found = source(one, i, mean=mean, lost=NONE)
    assert slope < -0.2
    sure = slope * (1.0 - (deviation / slope) ** 2)
    own = flow + mean - i
    departure = one.volts + OHMS * i - level - CURVE - sure * flow
    share = np.clip(mean / i, 0.0, 1.5)
    wanted = level + CURVE + sure * own + share * departure
    assert found.volts[:5] == pytest.approx(wanted[:5])
    assert found.volts[5:] == pytest.approx((level + CURVE + slope * own)[5:])


@pytest.mark.parametrize(
    ("half", "declared", "each"),
    [
        (LINE, 1e-3, None),  # the scatter of the readings
        (AS_READ, 1e-3, 1e-3),  # what comes and goes is no noise, where a channel says its own
        (AS_READ, 0.0, None),
        (AS_READ, 5.0, None),  # more than they scatter
    ],
)
def test_readings_of_the_head_are_unsure_by_their_noise(
    half: int, declared: float, each: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    told(monkeypatch, Form(half, 2), 0.0 * CURVE)
    one, i = sensed(noise=declared), current()
    found = source(one, i)
    noise = line(one, i)[-1] ** 0.5
    assert noise > 2e-3
    assert found.errors[0] == pytest.approx([each or noise, 0.0])
    assert found.errors[1] == pytest.approx([0.0, each or noise])
    assert found.errors[-1] == pytest.approx([0.0, 0.0])  # all of the departure is theirs
    assert found.noise == pytest.approx(noise)


@pytest.mark.parametrize(("before", "reversed_"), [(9.0, True), (0.01, False)])
def test_a_reversed_first_reading_of_pulses_is_left_and_no_other(
    before: float, reversed_: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    told(monkeypatch, Form(LINE, 3), 0.0 * CURVE[10:])
    part = replace(PULSES, start=10)
    one, i = sensed(), current()
    i[:10] = before
    one.volts[10:13] += 0.7
    opened = (one.volts + OHMS * i)[10:]
    found = source(one, i, part)
    level = opened[HEAD:].mean()
    assert found.volts[0] == pytest.approx(level if reversed_ else opened[0])
    assert found.volts[1:3] == pytest.approx(opened[1:3])


def test_nothing_runs_out_at_the_beginning_of_a_capture() -> None:
    assert not module._runs_out(np.full(COUNT, 0.2), WHOLE)


def test_a_current_that_stays_tells_no_slope() -> None:
    slope, flow, deviation = module._slope(np.arange(20.0), np.full(20, 3.0), 0.5)
    assert (slope, deviation) == (0.0, 0.0)
    assert flow.tolist() == [0.0] * 20


def test_a_reading_that_is_missing_tells_no_change() -> None:
    one, i = sensed(), current()
    whole = module.source_resistance(one, i, [WHOLE], NONE, (1.0, 1e6))
    one.volts[60] = np.nan
    i[90] = np.nan
    found = module.source_resistance(one, i, [WHOLE], NONE, (1.0, 1e6))
    assert found == pytest.approx(whole, abs=0.01)


def test_a_source_is_a_line_without_doubt_unless_it_is_told() -> None:
    plain = Source(np.zeros(3), 0.5, 0.1)
    assert (plain.tilt, plain.errors, plain.as_read) == (0.0, (), False)
