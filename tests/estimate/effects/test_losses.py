"""What brushes and winding take from a source, by formula; of which captures it is an unknown."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel, Wiring
from motorid.estimate.effects import brush_and_heating as brushes
from motorid.estimate.effects.brush_and_heating import (
    BENT,
    BRIDGE,
    DIODES,
    DROP,
    WARMING,
    Bent,
    Loss,
    bridge_drop,
    brushes_made_for,
    expected_drop,
    lossless,
    turn_of,
)
from motorid.estimate.effects.source.bridge_drop import BRIDGE_DROP
from motorid.estimate.signals.source.ripple_average import Flow
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.program import Decay, StepKind
from tests.estimate.effects.benches import record

N, PERIOD_S, TOP, R = 60, 1e-3, 12.0, 2.0
COAST = Part(0, 20, StepKind.COAST)
DRIVEN = Part(20, N, StepKind.DRIVE_DUTY, 0.5, Decay.SYNCHRONOUS_SLOW)
MASK = np.arange(N) >= 20
AMPERES = np.where(MASK, 1.0 + 0.02 * np.arange(N), 7.0)  # when open it is not what is lost


def loss(**facts: Any) -> Loss:
    names = (DROP, BENT, WARMING)
    known = {"shapes": dict.fromkeys(names, np.zeros(N)), **facts}
    made_for = known.pop("brushes_v", TOP)
    return Loss(MASK, PERIOD_S, TOP, made_for, (0.1, 0.3), known.pop("capacity", None), **known)


def test_brushes_are_made_for_the_nameplates_voltage_or_more() -> None:
    plate = SimpleNamespace(nameplate={"voltage_v": 24.0})
    run: Any = SimpleNamespace(stated=plate)
    assert brushes_made_for(run, 3.0) == 24.0
    assert brushes_made_for(run, 30.0) == 30.0
    plate.nameplate = {}
    assert brushes_made_for(run, 3.0) == 3.0
    near = loss(brushes_v=2.0 * TOP).bend_a(R)
    assert near == pytest.approx(2.0 * loss().bend_a(R))


def follow(one: Loss, **values: float) -> Loss:
    return one.follow(Flow(AMPERES), R, values, np.full(N, 5.0), np.full(N, 6.0))


def test_the_shapes_are_what_a_unit_of_each_takes() -> None:
    found = follow(loss()).shapes
    bend = 0.05 * TOP / R  # the usual one
    s = AMPERES / np.hypot(AMPERES, bend)
    assert found[DROP] == pytest.approx(np.where(MASK, s, 0.0))
    up = AMPERES / np.hypot(AMPERES, bend * np.exp(1e-5))
    assert found[BENT] == pytest.approx(np.where(MASK, (up - s) / 1e-5, 0.0), abs=1e-4)
    charge = np.cumsum(np.where(MASK, AMPERES, 0.0) ** 2)
    warm = R * np.where(MASK, AMPERES, 0.0) * (charge / charge[-1] - 0.5)
    assert found[WARMING] == pytest.approx(warm)
    assert found[WARMING][25] < 0.0 < found[WARMING][-1]  # about its mean


def test_dead_time_is_taken_part_by_part() -> None:
    names = (DROP, turn_of(1), DIODES)
    one = loss(turns={1: replace(DRIVEN, start=30)}, shapes=dict.fromkeys(names, np.zeros(N)))
    found = follow(one).shapes
    assert set(found) == set(names)
    assert found[turn_of(1)] == pytest.approx(np.where(np.arange(N) >= 30, 5.0, 0.0))
    assert found[DIODES] == pytest.approx(6.0)


def test_what_is_lost_is_the_sum_of_all() -> None:
    one = loss(shapes={DROP: np.full(N, 2.0), BENT: np.arange(float(N))})
    assert one.volts({DROP: 0.5, BENT: 3.0}) == pytest.approx(1.0 + 3.0 * np.arange(N))


def test_the_bend_moves_as_far_as_a_clear_drop_asks_for() -> None:
    """δ = (W/V) of the logarithm, once a model's current was followed, within two deviations."""
    modelled = loss(modelled=True)
    assert follow(modelled, **{DROP: 0.1, BENT: 0.05}).further == pytest.approx(0.5)
    assert follow(modelled, **{DROP: 0.1, BENT: 9.0}).further == 1.0  # at most a factor of e
    assert follow(replace(modelled, further=1.0), **{DROP: 0.1, BENT: 9.0}).further == 1.4
    assert follow(modelled, **{DROP: 0.003 * TOP * 0.99, BENT: 0.05}).further == 0.0
    assert follow(modelled, **{DROP: 0.003 * TOP * 1.01, BENT: 0.01}).further > 0.0
    assert follow(loss(), **{DROP: 0.1, BENT: 0.05}).further == 0.0
    moved = follow(modelled, **{DROP: 0.1, BENT: 0.05})
    assert moved.bent == Bent(pytest.approx(0.5), pytest.approx(0.5))
    assert moved.modelled
    bend = 0.05 * TOP / R * np.exp(0.5)
    assert moved.bend_a(R) == pytest.approx(bend)
    s = AMPERES[MASK] / np.hypot(AMPERES[MASK], bend)
    assert moved.shapes[DROP][MASK] == pytest.approx(s)
    assert moved.drop_at(AMPERES, R, {DROP: 0.3}) == pytest.approx(
        0.3 * AMPERES / np.hypot(AMPERES, bend)
    )


@pytest.mark.parametrize(("share", "further"), [(0.9e-3, 0.0), (1.1e-3, -1.0)])
def test_a_drop_of_nothing_has_the_usual_bend(share: float, further: float) -> None:
    """Wherever a pass has moved it that saw a drop."""
    moved = replace(loss(), modelled=True, further=-1.0)
    assert follow(moved, **{DROP: share * TOP, BENT: 0.0}).further == further


@pytest.mark.parametrize(
    ("asked", "before", "by", "step"),
    [
        (0.4, 0.0, 0.0, 0.4), (3.0, 0.0, 0.0, 1.0), (-3.0, 0.0, 0.0, -1.0),
        (0.4, 0.8, 0.8, 0.4 * 1.0),  # the last step did half of what it should: go on
        (-0.4, 0.4, 0.4, -0.4 * 0.5),  # it went as far beyond: half of it back
        (-0.4, 0.1, 0.001, -0.4 * 0.1), (0.9, 0.4, 0.4, 0.9),
    ],
)  # fmt: skip
def test_a_step_is_shortened_by_what_the_last_one_did(
    asked: float, before: float, by: float, step: float
) -> None:
    assert Bent(before, by).step(asked) == pytest.approx(step)


def test_brushes_and_bridge_bend_together_and_take_the_same_for_a_volt() -> None:
    both = loss(modelled=True, shapes=dict.fromkeys((DROP, BRIDGE), np.zeros(N)))
    moved = follow(both, **{DROP: 0.04, BRIDGE: 0.06, BENT: 0.05})
    assert moved.further == pytest.approx(0.5)
    assert moved.shapes[BRIDGE] == pytest.approx(moved.shapes[DROP])
    assert moved.shapes[BRIDGE].any()
    assert moved.drop_at(AMPERES, R, {DROP: 0.3, BRIDGE: 9.0}) == pytest.approx(
        moved.drop_at(AMPERES, R, {DROP: 0.3})
    )  # of the motor's own brushes


def test_a_bend_is_known_to_a_factor_of_two_from_the_usual_one() -> None:
    sd, mean = loss(further=0.4).bending({DROP: 0.2})
    assert sd == pytest.approx(0.7 * np.hypot(0.2, 0.003 * TOP))
    assert np.exp(0.7) == pytest.approx(2.0, rel=0.01)
    assert mean == pytest.approx(-0.2 * 0.4)


def test_a_winding_warms_by_its_capacity_or_by_no_more_than_any_does() -> None:
    charge = float(np.sum(np.where(MASK, AMPERES, 0.0) ** 2)) * PERIOD_S
    rise, sd = follow(loss(capacity=3.0)).rise
    assert rise == pytest.approx(0.00393 * R * charge / 3.0)
    assert sd == pytest.approx(0.2 * rise)
    nothing, bound = follow(loss()).rise
    assert nothing == 0.0
    stall_w = TOP**2 / R  # that warms a motor by 150 K in a second at most
    assert bound == pytest.approx(0.00393 * 150.0 / 2 * R * charge / stall_w)
    cold = loss()
    assert cold.follow(Flow(np.zeros(N)), R, {}, np.zeros(N), np.zeros(N)).rise[1] >= 1e-6


def test_a_drop_that_nobody_declared_is_a_share_of_the_voltage() -> None:
    assert expected_drop(Wiring(), TOP) == pytest.approx((0.0, 0.03 * TOP))
    assert expected_drop(Wiring(brush_drop_v=0.5), TOP) == pytest.approx((0.5, 0.15))
    stated = Wiring(brush_drop_v=0.5, brush_drop_uncertainty_v=0.1)
    assert expected_drop(stated, TOP) == pytest.approx((0.5, 0.1))
    assert expected_drop(Wiring(brush_drop_v=0.0), TOP) == (0.0, 0.0)


def test_a_bipolar_bridge_adds_its_own_where_the_source_was_read() -> None:
    bridge = Wiring(brush_drop_v=0.5, brush_drop_uncertainty_v=0.3, bridge_drop_v=2.0,
                    bridge_drop_uncertainty_v=0.4)  # fmt: skip
    assert expected_drop(bridge, TOP) == pytest.approx((0.5, 0.3))
    assert bridge_drop(bridge) == pytest.approx((2.0, 0.4))
    vague = replace(bridge, bridge_drop_uncertainty_v=0.0)
    assert bridge_drop(vague) == pytest.approx((2.0, 0.6))
    assert bridge_drop(Wiring()) == (0.0, 0.0)


def test_a_motor_without_losses_declares_that() -> None:
    wiring = Wiring(brush_drop_v=0.5, brush_drop_uncertainty_v=0.3, bridge_drop_v=2.0,
                    bridge_drop_uncertainty_v=0.4, pwm_hz=2e4)  # fmt: skip
    one = lossless(replace(capture(), wiring=wiring))
    assert expected_drop(one.wiring, TOP) == bridge_drop(one.wiring) == (0.0, 0.0)
    assert one.wiring.pwm_hz == 2e4
    assert of(one) is None


# of which captures


def capture(**facts: Any) -> Capture:
    values = facts.pop("values", np.ones(N))
    channels = {CURRENT: Channel(CURRENT, "A", values, **facts)}
    return Capture(np.arange(N) * 1000, 1e6, channels)


def of(one: Capture, volts: float = TOP, parts: tuple[Part, ...] = (COAST, DRIVEN),
       commanded: bool = False) -> Loss | None:  # fmt: skip
    line = Timeline(PERIOD_S, N, np.arange(N), parts, 0.0)
    return Loss.of(one, line, MASK, np.where(MASK, volts, 99.0), commanded)


def test_every_capture_of_a_program_with_a_signed_current_has_losses() -> None:
    found = of(capture())
    assert found is not None
    assert set(found.shapes) == {DROP, BENT, WARMING}
    assert (found.top_v, found.drop) == (TOP, pytest.approx((0.0, 0.03 * TOP)))
    assert found.capacity_j_k is None
    assert not found.modelled
    assert of(capture(unsigned=True)) is None
    assert of(capture(), volts=0.0) is None
    assert of(replace(capture(), channels={})) is None
    assert of(capture(), parts=(Part(0, N),)) is None  # a log


def test_few_driven_readings_tell_none() -> None:
    for known, told in ((24, True), (23, False)):
        values = np.where(np.arange(N) < 20 + known, 1.0, np.nan)
        assert (of(capture(values=values)) is not None) is told


def test_what_is_declared_is_no_unknown() -> None:
    none = replace(capture(), wiring=Wiring(brush_drop_v=0.0))
    found = of(none)
    assert found is not None
    assert set(found.shapes) == {WARMING}
    stated = replace(none.stated, thermal={"winding_k_w": 5.0, "winding_s": 10.0})
    known = of(replace(none, stated=stated))
    assert known is not None
    assert known.capacity_j_k == pytest.approx(2.0)
    assert set(known.shapes) == {WARMING}


def test_where_a_source_is_commanded_dead_time_takes_its_part() -> None:
    bridge = replace(capture(), wiring=Wiring(dead_time_s=1e-6, bridge_drop_v=2.0))
    found = of(bridge, commanded=True)
    assert found is not None
    assert set(found.shapes) == {DROP, BENT, BRIDGE, WARMING, DIODES, turn_of(1)}
    assert list(found.turns) == [1]
    assert (found.drop[0], found.bridge[0]) == (0.0, 2.0)
    measured = of(bridge)
    assert measured is not None
    assert DIODES not in measured.shapes
    assert BRIDGE not in measured.shapes
    assert measured.bridge == (0.0, 0.0)
    volts = Channel(VOLTAGE, "V", np.ones(N), sense="supply")
    at_supply = of(replace(bridge, channels={**bridge.channels, VOLTAGE: volts}))
    assert at_supply is not None
    assert at_supply.bridge[0] == 2.0
    without = replace(bridge.wiring, brush_drop_v=0.0)
    alone = of(replace(bridge, wiring=without), commanded=True)
    assert alone is not None
    assert DROP not in alone.shapes
    assert {BRIDGE, BENT} < set(alone.shapes)
    assert brushes.TURN in turn_of(1)


def test_a_bridge_s_drop_is_an_unknown_with_the_prior_that_the_rig_declares() -> None:
    subject = record("bipolar")
    prior = BRIDGE_DROP.prior(subject, 0)
    assert prior is not None
    assert (prior.mean, prior.sd) == (0.5, pytest.approx(0.15))
    assert BRIDGE_DROP.bounds(subject) == (0.0, pytest.approx(1.5))
    assert BRIDGE_DROP.prior(record("commanded"), 0) is None
