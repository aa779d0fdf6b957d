"""A channel that is late: what is tried, what is said, and what would declare it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Channel
from motorid.estimate.diagnosis.faults import channel_delay
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.timing.current_delay import CURRENT_DELAY
from tests.exact_capture import FAULHABER, clean_capture

PERIOD_S = 1e-4


def record(
    *channels: str, emf: bool = True, finer: float = 1.0, delay_s: float = 0.0, own: Any = ()
) -> Any:
    late = {
        name: SimpleNamespace(
            channel=Channel(name, "A", np.zeros(2), delay_s=delay_s),
            block=SimpleNamespace(name=name),
        )
        for name in channels
    }
    return SimpleNamespace(
        timeline=SimpleNamespace(period_s=PERIOD_S / finer),
        capture=SimpleNamespace(period_s=PERIOD_S),
        measured=list(late.values()),
        sensed=SimpleNamespace(channel="terminals", shows_emf=emf),
        instances=own,
        block=late.get,
    )


def codes(*records: Any) -> list[str]:
    return [h.code for h in channel_delay.hypotheses(records)]


def test_values_come_so_many_samples_later() -> None:
    ramp = np.arange(8.0)
    assert channel_delay.late(ramp, 2.0).tolist() == [0, 0, 0, 1, 2, 3, 4, 5]
    assert channel_delay.late(ramp, 0.5).tolist() == [0, 0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5]


def test_each_channel_that_is_read_may_be_late() -> None:
    assert codes(record(CURRENT, POSITION)) == ["current_lag", "position_lag", "voltage_lag"]
    assert codes(record(CURRENT, SPEED, emf=False)) == ["current_lag", "speed_lag"]
    assert codes(record(CURRENT), record(CURRENT, emf=False)) == ["current_lag"]


def test_sizes_are_of_the_grid_and_words_of_the_samples() -> None:
    late, *_ = channel_delay.hypotheses([record(CURRENT, finer=4.0)])
    grid = PERIOD_S / 4.0
    assert late.sizes == tuple((k * grid,) for k in channel_delay.SAMPLES)
    assert (late.lower, late.upper) == ((0.0,), (channel_delay.LATEST * grid,))
    said = late.words(np.array([3.5e-4]))
    assert said.evidence == "the current comes 350 µs later than it declares (3.5 samples)"
    assert said.where == "current"


def test_a_channel_may_come_before_its_declared_delay_but_not_before_its_instant() -> None:
    late, *_ = channel_delay.hypotheses([record(CURRENT, delay_s=0.5 * PERIOD_S)])
    assert late.lower == pytest.approx((-0.98 * 0.5 * PERIOD_S,))
    early = [size for (size,) in late.sizes[len(channel_delay.SAMPLES) :]]
    assert early == pytest.approx([-share * 0.98 * 0.5 * PERIOD_S for share in channel_delay.EARLY])
    said = late.words(np.array([-2e-5])).evidence
    assert said == "the current comes 20 µs earlier than it declares (0.2 samples)"
    two = [record(CURRENT, delay_s=delay) for delay in (3e-5, 2e-5)]
    assert channel_delay.hypotheses(two)[0].lower == pytest.approx((-0.98 * 2e-5,))
    assert late.least == pytest.approx(0.03 * PERIOD_S)
    vague = record(CURRENT, delay_s=3e-5)
    vague.measured[0].channel = replace(vague.measured[0].channel, delay_uncertainty_s=2e-6)
    assert channel_delay.hypotheses([vague])[0].least == pytest.approx(8e-6)
    known = record(CURRENT, delay_s=0.5 * PERIOD_S, own=(Instance(CURRENT_DELAY),))
    assert channel_delay.hypotheses([known])[0].lower == (0.0,)  # an unknown of the fit


def test_a_voltage_that_is_hardly_late_is_not_declared_to_come_before_its_sample() -> None:
    capture = clean_capture(FAULHABER)
    before = capture.channels[VOLTAGE].delay_s
    tried = channel_delay._declared_later(capture, 0.04 * capture.period_s)
    assert tried
    assert all(one.channels[VOLTAGE].delay_s >= before for one in tried)


def test_a_late_voltage_is_declared_later_by_about_that() -> None:
    capture = clean_capture(FAULHABER)
    before = capture.channels[VOLTAGE].delay_s
    h = capture.period_s
    tried = channel_delay._declared_later(capture, 2.4 * h)
    more = [one.channels[VOLTAGE].delay_s - before for one in tried]
    assert more[0] == pytest.approx(2.0 * h)  # whole samples first
    assert sorted(more[1:]) == pytest.approx([k * h for k in (2.1, 2.25, 2.4, 2.55, 2.7)])
    for one in tried:
        same = replace(one, channels={**one.channels, VOLTAGE: capture.channels[VOLTAGE]})
        assert same == capture


def test_a_size_of_whole_samples_is_tried_once() -> None:
    capture = clean_capture(FAULHABER)
    assert len(channel_delay._declared_later(capture, 3 * capture.period_s)) == 5
