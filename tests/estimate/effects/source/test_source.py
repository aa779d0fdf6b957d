"""Which way each doubt about the voltage moves the readings, and by how much."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION
from motorid.estimate.effects.action import Bridge, MotorParameter
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.source.brush_bend import BRUSH_BEND
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.effects.source.dead_time_diodes import DEAD_TIME_DIODES
from motorid.estimate.effects.source.dead_time_turn import DEAD_TIME_TURN
from motorid.estimate.effects.source.diode_drops import DIODE_DROPS
from motorid.estimate.effects.source.duty_of_volts import DUTY_OF_VOLTS
from motorid.estimate.effects.source.held_inductance import HELD_INDUCTANCE
from motorid.estimate.effects.source.source_level import SOURCE_LEVEL
from motorid.estimate.effects.source.voltage_gain import VOLTAGE_GAIN
from motorid.estimate.effects.source.voltage_noise import VOLTAGE_NOISE
from motorid.estimate.effects.source.voltage_offset import VOLTAGE_OFFSET
from motorid.estimate.effects.source.winding_warming import WINDING_WARMING
from motorid.estimate.effects.source.wiring_resistance import WIRING_RESISTANCE
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Stretch
from motorid.program import Decay, StepKind
from tests.estimate.effects.benches import FAULHABER, POINT, moved, record, usual, within

SLOW = Part(0, 9, StepKind.DRIVE_VOLTS, 4.0, Decay.SYNCHRONOUS_SLOW)
DIODES = Part(0, 9, StepKind.DRIVE_DUTY, 0.5, Decay.DIODE)


@pytest.mark.parametrize(
    ("bench", "quantity"),
    [
        ("measured", BRUSH_DROP),
        ("commanded", DEAD_TIME_DIODES),
        ("measured", VOLTAGE_OFFSET),
        ("measured", VOLTAGE_GAIN),
        ("commanded", WIRING_RESISTANCE),
    ],
)
def test_what_takes_from_the_source_leaves_less_turned(
    bench: str, quantity: InfluenceQuantity
) -> None:
    change = moved(bench, quantity)[POSITION]
    assert change[-1] < 0.0
    driven = within(bench, POSITION, 1)
    assert (change[driven][5:] < 0.0).all()


def test_a_voltage_read_too_high_shows_more_of_an_emf_that_was_less() -> None:
    """Without friction they would cancel: speed follows the source. T0 slows it a little more."""
    change, now = moved("measured", VOLTAGE_GAIN)[EMF], usual("measured")[EMF]
    late = now > 0.5 * now.max()
    share = change[late] / now[late]
    assert (share < 0.0).all()
    assert (share > -0.5).all()


def test_an_offset_of_the_voltage_shows_in_an_open_bridge_as_it_is() -> None:
    change = moved("measured", VOLTAGE_OFFSET)[EMF]
    rest = within("measured", EMF, 0)
    assert change[rest] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("part", [1, 2])
def test_a_level_drives_from_its_own_part_on(part: int) -> None:
    change = moved("noisy_source", SOURCE_LEVEL, part)[POSITION]
    first = int(np.argmax(within("noisy_source", POSITION, part)))
    assert np.abs(change[:first]).max(initial=0.0) == 0.0
    assert (np.diff(change[first : first + 60])[2:] > 0.0).all()


def test_a_resistance_of_the_wiring_is_taken_off_r() -> None:
    step = 1e-4 * POINT[0]
    up, down = POINT.copy(), POINT.copy()
    up[0], down[0] = POINT[0] + step, POINT[0] - step
    change = moved("commanded", WIRING_RESISTANCE)
    for block in (CURRENT, POSITION):
        slope = (usual("commanded", up)[block] - usual("commanded", down)[block]) / (2 * step)
        assert change[block] == pytest.approx(slope, rel=1e-3, abs=1e-4 * np.abs(slope).max())


@pytest.mark.parametrize(("quantity", "name"), [(WIRING_RESISTANCE, "R"), (HELD_INDUCTANCE, "L")])
def test_a_parameters_own_quantity_names_it(quantity: InfluenceQuantity, name: str) -> None:
    assert [a.name for a in quantity.acts if isinstance(a, MotorParameter)] == [name]


def test_a_drop_takes_its_share_of_a_steady_current() -> None:
    """At a held speed dv = R di; the speed gives way, so the current falls by less than that."""
    change = moved("measured", BRUSH_DROP)[CURRENT]
    first = np.flatnonzero(within("measured", CURRENT, 1))[4]  # past L/R, before the speed follows
    assert change[first] == pytest.approx(-1.0 / FAULHABER["R"], rel=0.35)


def test_a_bend_is_the_slope_of_the_drop_by_the_logarithm_of_its_knee() -> None:
    """s = i/√(i² + b²), so ds/d ln b = −s (1 − s²): nothing where the drop is whole."""
    loss = record("measured").loss
    assert loss is not None
    drop, bend = loss.shapes[BRUSH_DROP.name], loss.shapes[BRUSH_BEND.name]
    assert np.abs(bend).max() > 0.1
    flat = 2.0 / 3.0**1.5  # the most of s (1 − s²); means over a period's ripple are less
    assert np.abs(bend).max() <= flat + 1e-9
    assert (bend * drop <= 1e-12).all()


def test_a_winding_that_warms_loses_less_than_its_mean_at_first() -> None:
    loss = record("measured").loss
    assert loss is not None
    lost = loss.shapes[WINDING_WARMING.name]
    flowing = np.flatnonzero(np.abs(lost) > 0.01 * np.abs(lost).max())
    assert lost[flowing[0]] < 0.0  # of a current that only flows forward at first


def test_a_turn_is_there_only_where_a_current_may_turn() -> None:
    loss = record("commanded").loss
    assert loss is not None
    for k in loss.turns:
        shape = loss.shapes[f"{DEAD_TIME_TURN.name} {k}"]
        part = record("commanded").timeline.parts[k]
        outside = np.ones(len(shape), dtype=bool)
        outside[part.slice] = False
        assert not shape[outside].any()


def test_diodes_that_drop_more_swing_and_clamp_by_as_much_more() -> None:
    (action,) = DIODE_DROPS.acts
    assert isinstance(action, Bridge)
    stretch = Stretch(0, swing_v=-9.4, clamp_v=9.4, duty=0.5)
    more = action.change(stretch, DIODES, 0.2)
    assert (more.swing_v, more.clamp_v) == pytest.approx((-9.6, 9.6))
    assert action.change(stretch, SLOW, 0.2).swing_v == -9.4  # no diode conducts in its off part
    assert action.change(replace(stretch, clamp_v=0.0), DIODES, 0.2).clamp_v == 0.0


def test_another_duty_makes_the_same_mean_voltage() -> None:
    """Slow decay: the mean is duty × swing. Fast decay: (2 duty − 1) of half the swing."""
    (action,) = DUTY_OF_VOLTS.acts
    assert isinstance(action, Bridge)
    stretch = Stretch(0, duty=0.5, swing_v=8.0)
    more = action.change(stretch, SLOW, 0.1)
    assert more.duty == pytest.approx(0.55)
    assert more.duty * more.swing_v == pytest.approx(0.5 * 8.0)
    fast = action.change(replace(stretch, duty=0.75), replace(SLOW, decay=Decay.FAST), 0.1)
    assert fast.duty - 0.5 == pytest.approx(1.1 * 0.25)
    for whole in (0.0, 1.0):  # no PWM, no ripple
        assert action.change(replace(stretch, duty=whole), SLOW, 0.1).duty == whole
    assert action.change(stretch, DIODES, 0.1) is stretch  # its duty was commanded


def test_what_others_size_has_no_prior_here() -> None:
    for quantity in (VOLTAGE_NOISE, HELD_INDUCTANCE):
        assert quantity.prior(record("measured"), 0) is None
