"""The response that stands: what is at hand, and what is computed ahead, serve until it changes."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.model.extended_capture_model import WideRecord
from motorid.estimate.model.responses_at_hand import REMEMBERED, AtHand
from motorid.estimate.model.standing_response import Run, StandingResponse
from motorid.estimate.results.estimate import PARAMETERS
from motorid.motor.wide import LANES
from tests.estimate.model.test_wide_record import again, encoder, shared

Y = np.ones((2, 3))
needs_lanes = pytest.mark.skipif(LANES == 1, reason="this compiler knows no vectors")


def test_what_was_used_last_is_at_hand_and_costs_nothing() -> None:
    found = AtHand()
    for k in range(REMEMBERED):
        found.use((k,), k * Y)
    found.use((0.0,), 0.0 * Y)  # again: the second is the oldest now
    found.use((9.0,), 9.0 * Y)
    assert (1.0,) not in found
    assert found.take((1.0,)) == (None, 0)
    readings, worth = found.take((0.0,))
    assert readings is not None
    assert (readings.max(), worth) == (0.0, 0)
    found.clear()
    assert (0.0,) not in found


def test_what_is_ahead_is_paid_when_it_is_used_and_handed_out_once() -> None:
    found = AtHand()
    found.expect({(1.0,): (Y, 5)})
    found.expect({(2.0,): (Y, 7)})  # in its place
    assert found.take((1.0,)) == (None, 0)
    assert found.take((2.0,))[1] == 7
    assert found.take((2.0,)) == (None, 0)
    found.expect({(3.0,): (Y, 1)})
    found.clear()
    assert found.take((3.0,)) == (None, 0)


def points(one: WideRecord) -> list[tuple[np.ndarray, np.ndarray]]:
    """About a start: the motor moved, and each of its own unknowns."""
    motor, own = shared(one), np.array([u.start for u in one.unknowns])
    moved = [(motor * (1.0 + 1e-4 * np.eye(len(motor))[j]), own) for j in range(6)]
    steps = [own + 1e-6 * np.eye(len(own))[j] for j in range(len(own))]
    return moved + [(motor, x) for x in steps]


@needs_lanes
def test_residuals_that_were_foreseen_are_the_same_to_the_last_bit() -> None:
    one, other = again(), again()
    asked = points(one)
    one.plan(*asked[0])
    other.plan(*asked[0])
    one.foresee(asked)
    assert len(one.standing.at_hand._ahead) >= LANES
    for point in asked:
        for a, b in zip(one.residuals(*point), other.residuals(*point), strict=True):
            np.testing.assert_array_equal(a, b)
    assert one.simulated == other.simulated
    assert not one.standing.at_hand._ahead


@needs_lanes
def test_what_was_foreseen_is_forgotten_when_something_else_drives_the_motor() -> None:
    one, other = again(), again()
    asked = points(one)
    one.foresee(asked)
    for record in (one, other):
        record.excite(record.driving)
        record.standing.excite(0.9 * record.volts, record.stretches, record.first)
    for a, b in zip(one.residuals(*asked[1]), other.residuals(*asked[1]), strict=True):
        np.testing.assert_array_equal(a, b)


@needs_lanes
def test_runs_that_need_a_response_of_their_own_are_left_out() -> None:
    one = again()
    asked = points(one)
    one.plan(*asked[0])
    standing = StandingResponse(one.response, one.measured, one.outputs, one.first)
    runs = {}
    for k, (motor, own) in enumerate(asked[:3]):
        setup = one.setup(own)
        setup.clock += 1e-6 * (k == 2)
        runs[(float(k),)] = Run(setup, one.motor(motor), 0.0)
    found = standing.several(runs, lambda readings, _: 2.0 * readings)
    assert set(found) == {(0.0,), (1.0,)}
    for (k,), (readings, worth) in found.items():
        alone = standing.of(runs[(k,)].setup, 0.0)(runs[(k,)].motor, runs[(k,)].setup.initial)
        np.testing.assert_array_equal(readings, 2.0 * alone)
        assert worth == 1


def test_the_motor_of_six_parameters_is_quicker_one_by_one() -> None:
    one = encoder()
    assert not one.standing.takes_several
    before = one.simulated
    one.foresee([(shared(again()), np.array([u.start for u in one.unknowns]))])
    assert one.simulated == before


def test_other_volts_drive_it_only_in_between() -> None:
    one = again()
    motor, own = points(one)[0]
    usual = one.fitted(motor, own)
    less = one.fitted_with(motor, own, 0.5 * one.volts)
    count = one.simulated
    for a, b, c in zip(usual, one.fitted(motor, own), less, strict=True):
        np.testing.assert_array_equal(a, b)
        assert np.abs(c).max() < np.abs(a).max()
    assert one.simulated == count  # the usual ones were at hand all the time


def test_the_usual_volts_come_back_whatever_happens_in_between() -> None:
    one = again()
    motor, own = points(one)[0]
    usual = one.fitted(motor, own)
    absurd = motor * np.where(np.arange(len(motor)) == PARAMETERS.index("J"), -1.0, 1.0)
    with pytest.raises(ValueError, match="no response exists"):
        one.fitted_with(absurd, own, 0.5 * one.volts)
    one.standing.at_hand.clear()
    for a, b in zip(usual, one.fitted(motor, own), strict=True):
        np.testing.assert_array_equal(a, b)
