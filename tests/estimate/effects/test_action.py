"""What actions do to a run: sizes add up, places stay apart, and nothing is nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.estimate.effects import action
from motorid.estimate.effects.action import Setup
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Stretch

SIZES = st.floats(-1.0, 1.0)


def setup() -> Setup:
    return Setup(4, [0.0, 0.0, 0.0])


@pytest.mark.slow
@given(SIZES, SIZES)
def test_two_sizes_are_their_sum(a: float, b: float) -> None:
    twice, once = setup(), setup()
    acts = (action.Delay("x"), action.LowPass("x"), action.MotorParameter("R"), action.Kick(),
            action.LogTime(), action.LogJump(), action.InitialState(1))  # fmt: skip
    for act in acts:
        act(twice, None, 2, a)
        act(twice, None, 2, b)
        act(once, None, 2, a + b)
    assert twice.late_s == pytest.approx(once.late_s)
    assert twice.filter_s == pytest.approx(once.filter_s)
    assert twice.motor == pytest.approx(once.motor)
    assert twice.kicks == pytest.approx(once.kicks)
    assert twice.log_late_s == pytest.approx(once.log_late_s)
    assert twice.early(3) == pytest.approx([0.0, 0.0, a + b])
    assert twice.initial == pytest.approx([0.0, a + b, 0.0])
    assert not twice.rebuilt


def test_gains_multiply_and_ask_for_another_response() -> None:
    run = setup()
    action.SourceGain(-1.0)(run, None, 0, 0.1)
    action.TimeBase()(run, None, 0, 0.2)
    assert (run.source_gain, run.clock) == pytest.approx((0.9, 1.2))
    assert run.rebuilt


def test_volts_are_added_everywhere_or_in_some_intervals() -> None:
    run = setup()
    run.add_volts(1.0)
    assert np.broadcast_to(run.volts, 4).tolist() == [1.0] * 4
    run.add_volts(0.5, slice(1, 3))
    run.add_volts(np.array([0.0, 0.0, 0.0, 2.0]))
    assert np.asarray(run.volts).tolist() == [1.0, 1.5, 1.5, 3.0]


def test_a_stretch_is_changed_with_the_part_that_it_lies_in() -> None:
    parts = [Part(0, 10), Part(10, 20)]
    stretches = [Stretch(0), Stretch(5), Stretch(10), Stretch(15)]
    seen: list[tuple[int, int]] = []

    def change(stretch: Stretch, part: Part, size: float) -> Stretch:
        seen.append((stretch.start, part.start))
        return replace(stretch, series_ohm=stretch.series_ohm + size)

    found = action.restretched(stretches, parts, [(change, 0.5), (change, 0.25)])
    assert [s.series_ohm for s in found] == [0.75] * 4
    assert [s.series_ohm for s in stretches] == [0.0] * 4
    assert seen[:4] == [(0, 0), (5, 0), (10, 10), (15, 10)]


def test_a_reading_leaves_the_run_alone() -> None:
    run = setup()
    shown = action.Reading("x", action.plus)
    shown(run, None, 0, 1.0)
    assert run == setup()
    assert not shown.simulated
    assert action.Kick().simulated


def test_what_takes_from_a_motor_leaves_some_of_what_no_motor_is_without() -> None:
    run, names = setup(), ("R", "K", "J")
    for name, size in (("R", -9.0), ("K", -9.0), ("J", -0.5)):
        action.MotorParameter(name)(run, None, 0, size)
    assert run.onto(np.array([2.0, 1.0, 3.0]), names).tolist() == [0.002, -8.0, 2.5]
    more = setup()
    action.MotorParameter("R")(more, None, 0, 0.5)
    assert more.onto(np.array([0.0]), ("R",)).tolist() == [0.5]
