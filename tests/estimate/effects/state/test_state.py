"""How a run begins, and the states in which it does."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.effects.action import InitialState, Setup
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.state import initial_speed
from motorid.estimate.effects.state.coast_start import COAST_START
from motorid.estimate.effects.state.cogging_phase import COGGING_PHASE
from motorid.estimate.effects.state.initial_current import INITIAL_CURRENT
from motorid.estimate.effects.state.initial_speed import INITIAL_SPEED
from motorid.estimate.effects.state.initial_warmth import INITIAL_WARMTH
from motorid.estimate.effects.state.ripple_phase import RIPPLE_PHASE
from motorid.motor.wide import START
from tests.estimate.effects.benches import FAULHABER, moved, record, within
from tests.estimate.effects.made_subjects import block, subject


@pytest.mark.parametrize(
    ("quantity", "state"),
    [
        (INITIAL_CURRENT, "current"),
        (INITIAL_SPEED, "speed"),
        (INITIAL_WARMTH, "warmth"),
        (COGGING_PHASE, "cogging_phase"),
        (RIPPLE_PHASE, "ripple_phase"),
    ],
)
def test_each_begins_its_own_state(quantity: InfluenceQuantity, state: str) -> None:
    setup = Setup(3, [0.0] * len(START))
    for action in quantity.acts:
        assert isinstance(action, InitialState)
        action(setup, None, 0, 0.25)
    assert dict(zip(START, setup.initial, strict=True)) == {
        **dict.fromkeys(START, 0.0),
        state: 0.25,
    }


def test_a_state_that_a_model_lacks_is_left_alone() -> None:
    setup = Setup(3, [0.0] * 3)
    for action in COGGING_PHASE.acts:
        action(setup, None, 0, 0.25)
    assert setup.initial == [0.0] * 3


def test_a_faster_start_is_forgotten_with_the_mechanical_time_constant() -> None:
    """The voltage is given: dω decays by exp(−t/τ), τ = J R/(K² + B R) but for L."""
    R, _, K, B, J, _ = FAULHABER.values()
    change = moved("moving", INITIAL_SPEED)[SPEED]
    tau_s = J * R / (K**2 + B * R)
    expected = np.exp(-np.arange(len(change)) * 1e-4 / tau_s)
    assert change[:150] == pytest.approx(expected[:150], abs=0.02)


def test_a_first_current_is_gone_within_the_electrical_time_constant() -> None:
    change = moved("moving", INITIAL_CURRENT)[CURRENT]
    tau_s = FAULHABER["L"] / FAULHABER["R"]  # 0.7 of a sample
    assert change[0] > 0.0
    assert abs(change[20]) < 0.05 * change[0]  # what is left is the back-EMF of the kick
    assert tau_s < 1e-4


@pytest.mark.parametrize(("largest", "most"), [(-3.0, 30.0), (2.0, 20.0), (0.0, np.inf)])
def test_a_first_current_is_no_absurd_one(largest: float, most: float) -> None:
    of = subject(block(CURRENT, [0.0, largest, largest / 2]))
    assert INITIAL_CURRENT.bounds(of) == (-most, most)
    assert INITIAL_CURRENT.bounds(subject()) == (-np.inf, np.inf)


def log(volts: list[float], amperes: list[float], **facts: Any) -> Any:
    """A log without a motion, of 12 readings more that are not about nothing."""
    v, i = np.array([*volts, *[4.0] * 12]), np.array([*amperes, *[0.2] * 12])
    channels = {VOLTAGE: Channel(VOLTAGE, "V", v), CURRENT: Channel(CURRENT, "A", i)}
    return subject(block(CURRENT, i), **{
        "capture": Capture(np.arange(len(v)), 1e3, channels), "driven": np.ones(len(v), dtype=bool),
        "sensed": SimpleNamespace(volts=v), "held": {"K": 0.05}, **facts,
    })  # fmt: skip


def test_a_log_without_a_motion_begins_by_its_first_back_emf() -> None:
    turning = INITIAL_SPEED.prior(log([4.0] * 8, [0.1] * 8), 0)
    assert turning is not None
    assert turning.sd == np.inf
    ohms = initial_speed.USUAL * 4.0 / 0.2
    assert turning.start == pytest.approx((4.0 - ohms * 0.1) / 0.05)
    braking = INITIAL_SPEED.prior(log([0.0] * 8, [-0.2] * 8, held={}), 0)
    assert braking is not None
    assert braking.start is not None
    assert braking.start > 0.0
    assert INITIAL_SPEED.scale(log([0.0] * 8, [0.0] * 8)) == 4.0  # V: of K = 1


@pytest.mark.parametrize(
    "facts", [{}, {"held": {"B": 0.0, "J": 1.0, "T0": 9.0}}, {"driven": np.zeros(20, dtype=bool)}]
)
def test_one_that_shows_nothing_or_is_held_begins_at_rest(facts: dict[str, Any]) -> None:
    first = [1e-3, -1e-3] * 4 if not facts else [4.0] * 8
    assert INITIAL_SPEED.prior(log(first, first, **facts), 0) is None


@pytest.mark.parametrize(
    ("amperes", "triggered"),
    [
        ([0.1, 0.3], True),  # it had risen within the sample before
        ([-0.1, -0.3], True),
        ([0.3, 0.5], False),  # it had risen for longer
        ([0.1, -0.1], False),
        ([0.001, 0.02], False),  # a slow change of a running motor
    ],
)
def test_a_log_that_was_triggered_by_a_step_begins_at_rest(
    amperes: list[float], triggered: bool
) -> None:
    of = log([4.0] * 8, [*amperes, *[0.5] * 6])
    assert (INITIAL_SPEED.prior(of, 0) is None) is triggered


def test_a_coast_that_begins_faster_shows_it_from_there_on() -> None:
    subject = record("noisy_source")
    (coast,) = COAST_START.places(subject)  # type: ignore[misc]
    assert subject.timeline.parts[coast].open
    change = moved("noisy_source", COAST_START, coast)[POSITION]
    here = within("noisy_source", POSITION, coast)
    assert np.abs(change[~here & (np.arange(len(here)) < np.argmax(here))]).max() == 0.0
    inside = change[here]
    assert (np.diff(inside) > 0.0).all()  # rad: the angle runs ahead
    assert inside[20] - inside[10] == pytest.approx(10 * 1e-4, rel=0.05)  # by 1 rad/s
