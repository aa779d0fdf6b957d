"""A decay that the program's steps say and the bridge does not have."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SUPPLY, VOLTAGE, Capture
from motorid.estimate.diagnosis.faults import decay_mode
from motorid.estimate.results.estimate import Estimate
from motorid.program import Decay, Program, StepKind
from tests.estimate.diagnosis.faults.rigs import DIRECTIONS, Bench
from tests.estimate.effects.benches import POINT, driven, record, start
from tests.six_parameters import fit

MOTOR = "dunkermotoren-gr42"
SLOW, FAST, DIODE = Decay.SYNCHRONOUS_SLOW, Decay.FAST, Decay.DIODE
SUPPLY_READ, MOTOR_READ = (CURRENT, SUPPLY, POSITION), (CURRENT, VOLTAGE, POSITION)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return Bench(MOTOR, 3, DIRECTIONS, tmp_path_factory.mktemp("decay"))


def named(estimate: Estimate) -> set[str]:
    return {s.code for s in estimate.suspects if s.strength == "named"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("real", "claimed", "channels"),
    [
        (SLOW, FAST, SUPPLY_READ),
        pytest.param(DIODE, FAST, MOTOR_READ, marks=pytest.mark.study),
    ],
)
def test_another_decay_is_named_and_the_fit_takes_the_one_that_the_current_shows(
    bench: Bench, real: Decay, claimed: Decay, channels: tuple[str, ...]
) -> None:
    capture = bench.capture(channels=channels, decay=real)
    right = fit([capture])
    assert decay_mode.CODE not in named(right)
    found = fit([decay_mode.with_decay(capture, claimed)])
    assert decay_mode.CODE in named(found)
    true = {"L": bench.preset.inductance_h, "J": bench.preset.inertia_kg_m2}
    for name, p in right.parameters.items():
        now = found.parameters[name]
        assert now.value == pytest.approx(p.value, rel=1e-3)
        assert now.interval_95 is not None
        assert now.interval_95[0] < true.get(name, now.value) < now.interval_95[1]


def told(capture: Capture, emf: bool = False) -> list[str]:
    """Evidence of what is tried of a capture, volts commanded, or else read at the motor."""
    sensed = SimpleNamespace(commanded=not emf, shows_emf=emf)
    record: Any = SimpleNamespace(capture=capture, sensed=sensed)
    return [h.words(np.ones(1)).evidence for h in decay_mode.hypotheses([record])]


def test_only_modes_that_the_readings_tell_apart_are_tried() -> None:
    slow, diode = driven(SLOW, StepKind.DRIVE_VOLTS), driven(DIODE, StepKind.DRIVE_VOLTS)
    (fast,) = told(slow)
    assert "as with fast decay" in fast
    assert "say slow" in fast
    (stops,) = told(slow, emf=True)
    assert "as with diode decay" in stops
    assert not told(diode)
    assert len(told(diode, emf=True)) == 2


def test_steps_of_two_modes_and_a_bridge_without_pwm_are_left_alone() -> None:
    capture = driven(SLOW, StepKind.DRIVE_VOLTS)
    assert capture.program is not None
    first, *rest = [s for s in capture.program.steps if s.level]
    mixed = replace(capture, program=Program((replace(first, decay=FAST), *rest)))
    assert not told(mixed)
    assert not told(replace(capture, wiring=replace(capture.wiring, pwm_hz=0.0)))
    assert not told(replace(capture, program=None))


def test_the_effect_is_that_of_the_other_mode_and_none_of_none() -> None:
    """As far as its size says."""
    subject = record("commanded")
    (one,) = decay_mode.hypotheses([subject])
    none, half, all_ = (
        np.concatenate(one.effect(subject, POINT, start(subject), np.array([size])))
        for size in (0.0, 0.5, 1.0)
    )
    assert not none.any()
    assert half == pytest.approx(all_ / 2.0)
    assert np.abs(all_).max() > 0.0
