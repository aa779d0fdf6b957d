"""Runs of the wider motor side by side: the same bits as one by one, whatever sets them apart."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from motorid.motor._response import lib

from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.wide import LANES, NAMES, START, Posed, WideResponse
from tests.motor.test_wide_response import MOTOR, PERIOD_S
from tests.motor.test_wide_response import TERMS as WIDE_TERMS

TERMS = {"none": {}, **WIDE_TERMS}
VOLTS = np.concatenate(
    [np.zeros(5), np.full(75, 6.0), np.full(80, -4.0), np.zeros(60), np.full(40, 5.0)]
)
PLAN = [
    Stretch(0), Stretch(5, duty=0.8, swing_v=7.5), Stretch(80, kick_rad_s=2.0),
    Stretch(160, True, clamp_v=7.0), Stretch(220, still=True),
]  # fmt: skip
READINGS = [
    Output(Quantity.CURRENT, 0.5 * PERIOD_S, 0.2 * PERIOD_S),
    Output(Quantity.CURRENT, 0.0, 0.7 * PERIOD_S, 0.3),
    Output(Quantity.CURRENT, 0.0, 0.0, None, 3e-5),
    Output(Quantity.SPEED, 0.0, 0.3 * PERIOD_S),
    Output(Quantity.SPEED, PERIOD_S, 0.0, None, 2e-4),
    Output(Quantity.POSITION),
]


@pytest.fixture(autouse=True)
def _as_found() -> Iterator[None]:
    yield
    lib.mw_instructions(1)


def response(plan: list[Stretch] = PLAN) -> WideResponse:
    return WideResponse(PERIOD_S, VOLTS, READINGS, plan, PERIOD_S / 2)


def motors(term: str, count: int, spread: float = 1e-3) -> list[np.ndarray]:
    """About a motor with such terms."""
    rng = np.random.default_rng(3)
    usual = np.array([{**MOTOR, **TERMS[term]}.get(name, 0.0) for name in NAMES])
    return [usual * (1.0 + spread * rng.standard_normal(len(usual))) for _ in range(count)]


def beginning(k: int) -> tuple[float, ...]:
    return tuple(0.01 * k if name == "current" else 0.0 for name in START)


def agree(one: WideResponse, runs: list[tuple[np.ndarray, tuple[float, ...]]]) -> None:
    answers = one.several([one.pose(*run) for run in runs])
    for run, answer in zip(runs, answers, strict=True):
        alone = one(*run)
        assert answer is not None
        np.testing.assert_array_equal(answer[0], alone)
        assert answer[1] == one.worth


needs_lanes = pytest.mark.skipif(LANES == 1, reason="this compiler knows no vectors")


@needs_lanes
@pytest.mark.parametrize("term", TERMS)
@pytest.mark.parametrize("avx2", [0, 1])
def test_motors_side_by_side_give_the_bits_of_each_alone(term: str, avx2: int) -> None:
    lib.mw_instructions(avx2)
    one = response()
    some = [(motor, beginning(k)) for k, motor in enumerate(motors(term, LANES))]
    one.plan(*some[0])
    agree(one, some)


@needs_lanes
def test_motors_far_apart_stop_and_start_at_other_times() -> None:
    one = response()
    agree(one, [(m, beginning(0)) for m in motors("stribeck", LANES, spread=0.25)])


@needs_lanes
def test_a_current_that_stops_within_the_pwm_period_goes_alone() -> None:
    plan = [Stretch(0), Stretch(5, duty=0.2, swing_v=7.5, discontinuous=True), Stretch(90)]
    agree(response(plan), [(m, beginning(0)) for m in motors("brush", LANES)])


@needs_lanes
def test_runs_of_other_terms_are_not_mixed_and_each_keeps_its_place() -> None:
    one = response()
    some = [*motors("quadratic", LANES + 2), *motors("eddy", 3)]
    order = np.random.default_rng(1).permutation(len(some))
    agree(one, [(some[k], beginning(0)) for k in order])


@needs_lanes
def test_a_rotor_whose_angle_is_known_repeats_by_it() -> None:
    one = response()
    one.angle = np.linspace(0.0, 9.0, len(VOLTS))
    agree(one, [(m, beginning(0)) for m in motors("all", LANES)])


def test_a_run_keeps_what_it_was_posed_with() -> None:
    one = response()
    first, second = motors("quadratic", 2)
    runs: list[Posed] = []
    expected = []
    for k, motor in enumerate((first, second)):
        one.shift(0.3 * k)
        one.kick(2, 5.0 * k)
        one.delay(0, 1e-5 * k)
        one.filter(3, 2e-5 * k)
        runs.append(one.pose(motor, beginning(0)))
        expected.append(one(motor, beginning(0)))
    one.shift(2.0)
    one.kick(2, -9.0)
    for answer, alone in zip(one.several(runs), expected, strict=True):
        if LANES > 1:
            assert answer is not None
            np.testing.assert_array_equal(answer[0], alone)
    assert not (expected[0] == expected[1]).all()


def test_one_run_and_one_that_cannot_be_are_left_to_be_asked_alone() -> None:
    one = response()
    (usual,) = motors("brush", 1)
    assert one.several([one.pose(usual, beginning(0))]) == [None]
    absurd = usual.copy()
    absurd[NAMES.index("J")] = -1.0
    assert one.several([one.pose(m, beginning(0)) for m in (usual, absurd)]) == [None, None]
