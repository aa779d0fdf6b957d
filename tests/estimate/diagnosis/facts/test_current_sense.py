"""A current without its sign, of one way alone, or of the supply; a motion that is held."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from motorid import api
from motorid.capture.model import CURRENT, HELD, POSITION, Capture
from motorid.estimate.diagnosis.facts.current_sense import at_supply, one_sided, turning_drive
from motorid.estimate.diagnosis.faults import lost_samples
from motorid.estimate.diagnosis.faults.readings import held_channels
from motorid.estimate.results.estimate import Estimate
from motorid.program import StepKind
from tests.centred_pulses import DUTIES, LENGTH, MOTOR, capture_of
from tests.exact_capture import FAULHABER, clean_capture

Floats = np.ndarray


@pytest.fixture(scope="module")
def healthy() -> Capture:
    return capture_of(0.0, stated=0.0)


def reading(capture: Capture, shown: Callable[[Floats], Floats]) -> Capture:
    """The same with another current in the converter's readings."""
    current = capture.channels[CURRENT]
    taken = replace(current, raw=shown(current.values) / current.scale)
    return replace(capture, channels={**capture.channels, CURRENT: taken})


def duties() -> Floats:
    return np.abs(np.concatenate([[0.0], np.repeat(DUTIES, LENGTH)]))


def named(estimate: Estimate) -> list[str]:
    return [s.code for s in estimate.suspects if s.strength == "named"]


def holds(estimate: Estimate) -> bool:
    return all(
        p.interval_95 is not None and p.interval_95[0] < MOTOR[n] < p.interval_95[1]
        for n, p in estimate.parameters.items()
    )


@pytest.mark.parametrize(
    ("shown", "code"),
    [(np.abs, "current_magnitude"), (lambda i: np.maximum(i, 0.0), "current_one_way")],
)
@pytest.mark.parametrize("reversed_", [False, True])
def test_a_current_of_one_sign_is_what_it_reads_backwards(
    healthy: Capture, shown: Callable[[Floats], Floats], code: str, reversed_: bool
) -> None:
    """Whichever way the encoder counts."""
    spoilt = reading(healthy, shown)
    if reversed_:
        position = spoilt.channels[POSITION]
        position = replace(position, scale=-position.scale)
        spoilt = replace(spoilt, channels={**spoilt.channels, POSITION: position})
    mended, said = one_sided.declared(spoilt)
    assert said is not None
    assert (said.code, said.allowed) == (code, True)
    current = mended.channels[CURRENT]
    assert current.unsigned is (code == "current_magnitude")
    assert current.saturated[spoilt.channels[CURRENT].values <= 0.0].all() is not np.bool_(
        current.unsigned
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shown", "code"),
    [(np.abs, "current_magnitude"), (lambda i: np.maximum(i, 0.0), "current_one_way")],
)
def test_the_fit_holds_without_the_sign(
    healthy: Capture, shown: Callable[[Floats], Floats], code: str
) -> None:
    found = api.fit(reading(healthy, shown))
    assert named(found) == [code]
    assert holds(found)


@pytest.mark.parametrize("shown", [lambda i: i, np.abs])
def test_a_current_in_the_supply_is_the_duty_times_the_motors(
    healthy: Capture, shown: Callable[[Floats], Floats]
) -> None:
    spoilt = reading(healthy, lambda i: shown(i * duties()))
    (said,) = at_supply.suspects(spoilt)
    assert (said.code, said.allowed) == ("supply_current", False)
    assert one_sided.declared(spoilt) == (spoilt, None)  # no magnitude of the motor's


@pytest.mark.parametrize(
    "shown",
    [
        lambda i: i,
        lambda i: -i,
        lambda i: np.clip(i, -1.0, 1.0),
        lambda i: np.where(i < 0.0, 0.8 * i, i),  # a gain of its own
        np.zeros_like,
        lambda i: i - i.min(),  # a wrong zero shows no sign either, and no magnitude
    ],
)
def test_others_are_no_such_current(healthy: Capture, shown: Callable[[Floats], Floats]) -> None:
    capture = reading(healthy, shown)
    said = one_sided.declared(capture)[1]
    assert said is None or capture.channels[CURRENT].values.min() >= 0.0
    assert not at_supply.suspects(capture)


def test_a_motor_driven_one_way_shows_no_negative_current_anyway(healthy: Capture) -> None:
    program = healthy.program
    assert program is not None
    steps = tuple(
        replace(s, level=abs(s.level)) if s.kind is StepKind.DRIVE_DUTY else s
        for s in program.steps
    )
    one_way = replace(reading(healthy, np.abs), program=replace(program, steps=steps))
    assert one_sided.declared(one_way) == (one_way, None)
    assert not at_supply.suspects(one_way)
    assert turning_drive.of(replace(healthy, program=None)) is None  # a log


@pytest.mark.slow
def test_a_position_renewed_now_and_then_is_fitted_by_its_renewals(healthy: Capture) -> None:
    position = healthy.channels[POSITION]
    held = position.raw[np.arange(len(healthy)) // 5 * 5]
    spoilt = replace(healthy, channels={**healthy.channels, POSITION: replace(position, raw=held)})
    marked, said = held_channels.declared(spoilt)
    assert said is not None
    assert "every 5 samples" in said.evidence
    assert marked.provenance[HELD] == {POSITION: 5}
    assert held_channels.declared(marked) == (marked, None)
    found = api.fit(spoilt)
    assert named(found) == ["readings_held"]
    assert holds(found)


def test_a_slow_motion_of_single_counts_is_not_held() -> None:
    capture = clean_capture(FAULHABER)
    position = capture.channels[POSITION]
    counts = np.arange(len(capture)) // 5.0
    slow = replace(position, raw=counts, scale=0.01, resolution=0.01)
    slow_one = replace(capture, channels={**capture.channels, POSITION: slow})
    assert held_channels.declared(slow_one) == (slow_one, None)
    assert lost_samples.POSITION == POSITION
