"""How a run begins, and the states in which it does."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.effects.action import InitialState, Setup
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.state.coast_start import COAST_START
from motorid.estimate.effects.state.cogging_phase import COGGING_PHASE
from motorid.estimate.effects.state.initial_current import INITIAL_CURRENT
from motorid.estimate.effects.state.initial_speed import INITIAL_SPEED
from motorid.estimate.effects.state.initial_warmth import INITIAL_WARMTH
from motorid.estimate.effects.state.ripple_phase import RIPPLE_PHASE
from motorid.motor.wide import START
from tests.estimate.effects.benches import FAULHABER, moved, record, within


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
