"""A terminal voltage that reads more than was commanded: levels, bounds and what it moves."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import VOLTAGE, Capture
from motorid.estimate.diagnosis.facts import commanded
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from motorid.program import Decay, Program, StepKind
from tests.exact_capture import FAULHABER, Plan, clean_capture


def reading(gain: float, volts: tuple[float, ...] = (6.0, 3.0), count: int = 800,
            step: dict[str, Any] | None = None, **facts: Any) -> Capture:  # fmt: skip
    """A capture whose voltage reads so many times the level of its steps."""
    made = clean_capture(FAULHABER, Plan(volts, count))
    assert made.program is not None
    steps = tuple(
        replace(one, **step) if step and one.kind == StepKind.DRIVE_VOLTS else one
        for one in made.program.steps
    )
    channel = made.channels[VOLTAGE]
    shown = replace(channel, raw=gain * channel.raw, **facts)
    channels = {**made.channels, VOLTAGE: shown}
    return replace(made, program=Program(steps), channels=channels)


def parameter(value: float | None) -> Parameter:
    return Parameter("", "", value, None, None, None, None, Status.ESTIMATED)


def said(capture: Capture) -> list[str]:
    return [one.message for one in commanded.findings(capture, {}, " in run 2")]


def test_levels_are_told_without_their_sign_by_their_later_half() -> None:
    found = list(commanded.settled(reading(1.1, (-6.0, 3.0))))
    assert found == [pytest.approx((6.0, 6.6)), pytest.approx((3.0, 3.3))]
    capture = reading(1.0)
    raw = capture.channels[VOLTAGE].raw.copy()
    raw[45:140] = 50.0  # of the first level, from 41 to 254, the earlier half
    raw[[200, 201]] = np.nan
    channel = replace(capture.channels[VOLTAGE], raw=raw)
    late = replace(capture, channels={**capture.channels, VOLTAGE: channel})
    assert next(commanded.settled(late)) == pytest.approx((6.0, 6.0))


def test_a_motor_that_brakes_adds_what_the_bridge_drops() -> None:
    """After a higher level; a tenth of it alone is held to itself."""
    assert said(reading(1.2, (0.6,))) != []
    capture = reading(1.0, (6.0, 0.6))
    channel = capture.channels[VOLTAGE]
    for add, accused in ((0.12, False), (0.5, True)):
        raw = np.where(np.abs(channel.raw - 0.6) < 0.1, channel.raw + add, channel.raw)
        more = replace(capture, channels={**capture.channels, VOLTAGE: replace(channel, raw=raw)})
        assert bool(said(more)) is accused


@pytest.mark.parametrize(
    ("step", "levels"),
    [
        ({}, 2), ({"decay": Decay.FAST}, 0), ({"decay": Decay.DIODE}, 0),
        ({"kind": StepKind.DRIVE_DUTY, "level": 0.5}, 0), ({"level": 0.0}, 0),
    ],
)  # fmt: skip
def test_a_level_is_of_volts_that_both_switches_hold(step: dict[str, Any], levels: int) -> None:
    assert len(list(commanded.settled(reading(1.0, step=step)))) == levels


@pytest.mark.parametrize(("count", "levels"), [(160, 2), (130, 0)])
def test_a_level_has_twenty_readings_of_its_later_half(count: int, levels: int) -> None:
    """Of a run of 160, 43 are of each level; of one of 130, 35."""
    assert len(list(commanded.settled(reading(1.0, count=count)))) == levels


def test_without_a_program_there_is_no_level() -> None:
    capture = replace(reading(1.5), program=None, phases=())
    assert list(commanded.settled(capture)) == []
    bare = {n: c for n, c in capture.channels.items() if n != VOLTAGE}
    assert said(replace(reading(1.5), channels=bare)) == []


@pytest.mark.parametrize(
    ("gain", "facts", "above"),
    [
        (1.049, {}, False),
        (1.051, {}, True),
        (0.5, {}, False),
        (1.10, {"gain_uncertainty": 0.018}, False),  # 3 u are 5.4 %
        (1.10, {"gain_uncertainty": 0.016}, True),
        (1.10, {"offset_uncertainty": 0.11}, False),  # .33 V beside .3 V
        (1.10, {"offset_uncertainty": 0.09}, True),
        (1.10, {"noise": 0.11}, False),
        (1.10, {"sense": "bridge"}, True),
        (1.10, {"sense": "supply"}, False),
        (1.10, {"sense": None}, False),
    ],
)
def test_a_twentieth_more_and_what_the_channel_is_unsure_of_is_allowed(
    gain: float, facts: dict[str, Any], above: bool
) -> None:
    assert bool(said(reading(gain, (6.0,), **facts))) is above


def test_the_first_level_is_named_with_what_it_moves() -> None:
    known = {"R": parameter(2.0), "K": parameter(-0.05), "L": parameter(None)}
    (found,) = commanded.findings(reading(1.2), known, " in run 2")
    assert (found.code, found.severity) == ("voltage_above_command", "warning")
    assert found.message.startswith(
        "the terminal voltage reads 7.2 V where the program commands 6 V in run 2, and nothing"
    )
    assert found.moves == pytest.approx({"R": 0.4, "K": 0.01})
