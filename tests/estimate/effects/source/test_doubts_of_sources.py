"""Priors, bounds and scales of sources and of how a run begins, on subjects made by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import POSITION, SPEED, VOLTAGE, Channel, Wiring
from motorid.estimate.effects import brush_and_heating as brushes
from motorid.estimate.effects import scales
from motorid.estimate.effects.influence_quantity import instances
from motorid.estimate.effects.source.brush_bend import BRUSH_BEND
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.effects.source.dead_time_diodes import DEAD_TIME_DIODES
from motorid.estimate.effects.source.dead_time_turn import DEAD_TIME_TURN
from motorid.estimate.effects.source.diode_drops import DIODE_DROPS
from motorid.estimate.effects.source.reference_drift import REFERENCE_DRIFT
from motorid.estimate.effects.source.source_level import SOURCE_LEVEL
from motorid.estimate.effects.source.voltage_offset import VOLTAGE_OFFSET
from motorid.estimate.effects.source.winding_warming import WINDING_WARMING
from motorid.estimate.effects.state.coast_start import COAST_START
from motorid.estimate.effects.state.initial_warmth import INITIAL_WARMTH
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind
from tests.estimate.effects.made_subjects import TOP_V, block, prior, subject

# sources


def test_a_voltages_zero_is_told_by_ten_readings_of_an_open_bridge() -> None:
    def of(readings: int, sd: float, emf: bool = True, shows: bool = True) -> Any:
        channel = Channel(VOLTAGE, "V", np.zeros(3), offset_uncertainty=sd)
        sensed = SimpleNamespace(channel=channel, shows_emf=shows)
        blocks = [block(EMF, np.zeros(readings))] if emf else []
        return prior(VOLTAGE_OFFSET, subject(*blocks, sensed=sensed))

    assert of(10, 0.0) == (math.inf, 0.0, None)
    assert of(9, 0.0) is of(10, 0.0, emf=False) is None
    assert of(9, 0.1) == of(10, 0.1) == of(0, 0.1, emf=False) == (0.1, 0.0, None)
    assert of(10, 0.1, shows=False) is None
    none = SimpleNamespace(channel=None, shows_emf=True)
    assert prior(VOLTAGE_OFFSET, subject(block(EMF, np.zeros(20)), sensed=none)) is None


@pytest.mark.parametrize(("step", "most"), [(0.01, 0.1), (0.0, math.inf)])
def test_no_converter_puts_a_level_off_by_more_than_ten_of_its_steps(
    step: float, most: float
) -> None:
    sensed = SimpleNamespace(resolution=step)
    assert SOURCE_LEVEL.bounds(subject(sensed=sensed)) == pytest.approx((-most, most))


def test_diodes_drop_what_they_do_where_they_carry_a_current() -> None:
    parts = (Part(0, 5), Part(5, 9, StepKind.DRIVE_DUTY, 0.5, Decay.DIODE))
    found = prior(DIODE_DROPS, subject(timeline=SimpleNamespace(parts=parts)))
    assert found is not None
    assert found[1:] == (0.0, None)
    assert prior(DIODE_DROPS, subject(timeline=SimpleNamespace(parts=parts[:1]))) is None
    assert DIODE_DROPS.scale(subject()) * DIODE_DROPS.step == pytest.approx(1e-3)  # a step of 1 mV


@pytest.mark.parametrize(("drift", "time_s"), [(1e-3, 0.0), (0.0, 5.0), (1e-3, 5.0)])
def test_a_reference_drifts_where_both_its_size_and_its_time_are_stated(
    drift: float, time_s: float
) -> None:
    wiring = Wiring(reference_drift=drift, reference_time_s=time_s)
    found = prior(REFERENCE_DRIFT, subject(capture=SimpleNamespace(wiring=wiring)))
    assert found == ((drift, 0.0, None) if drift and time_s else None)


def lossy(*names: str, **facts: Any) -> Any:
    loss = brushes.Loss(
        np.ones(2, bool), 1e-4, TOP_V, TOP_V, (0.4, 0.3), None, bridge=(2.0, 0.4),
        shapes=dict.fromkeys(names, np.zeros(2)), **facts,
    )  # fmt: skip
    return subject(loss=loss, losing={brushes.DROP: 0.2, brushes.BRIDGE: 0.1})


def test_what_brushes_drop_has_its_priors_and_bounds() -> None:
    """By what is declared; before a current is known, the bend by a third of what may drop."""
    one = lossy(brushes.DROP, brushes.BENT, brushes.WARMING, further=0.5, rise=(0.02, 0.004))
    assert prior(BRUSH_DROP, one) == (0.3, 0.4, None)
    # no brushes drop a third of the voltage; a little below none, for what else looks like it
    assert BRUSH_DROP.bounds(one) == pytest.approx((-0.01 * TOP_V, 0.3 * TOP_V + 0.4))
    sd, mean, _ = prior(BRUSH_BEND, one) or (0, 0, 0)
    assert (sd, mean) == (pytest.approx(0.7 * math.hypot(0.3, 0.003 * TOP_V)), pytest.approx(-0.15))
    assert BRUSH_BEND.bounds(one) == pytest.approx((-0.03 * TOP_V, 0.03 * TOP_V))
    one.judged_at = None
    expected = math.hypot(0.4 + 2.0, math.hypot(0.3, 0.4))
    assert prior(BRUSH_BEND, one) == (pytest.approx(expected / 3.0), 0.0, None)
    assert prior(WINDING_WARMING, one) == (0.004, 0.02, None)
    assert WINDING_WARMING.scale(one) * WINDING_WARMING.step == pytest.approx(1e-6)  # of R
    for quantity in (BRUSH_DROP, BRUSH_BEND, WINDING_WARMING, DEAD_TIME_DIODES, DEAD_TIME_TURN):
        assert prior(quantity, subject()) is prior(quantity, lossy("other")) is None
    for quantity in (BRUSH_DROP, BRUSH_BEND):
        assert quantity.bounds(subject()) == (0.0, 0.0)


def test_dead_time_is_unsure_in_each_part_that_has_it() -> None:
    part = Part(0, 2, StepKind.DRIVE_DUTY, 0.5)
    one = lossy(brushes.DIODES, turns={3: part, 5: part})
    assert [at.place for at in instances(DEAD_TIME_TURN, one)] == [3, 5]
    assert instances(DEAD_TIME_TURN, subject()) == []
    found = prior(DEAD_TIME_TURN, one, 5)
    assert found is not None
    assert found[1:] == (0.0, None)
    assert 0.0 < found[0] < 0.5
    assert DEAD_TIME_TURN.scale(one) == found[0]
    assert prior(DEAD_TIME_TURN, one, 4) is None
    assert DEAD_TIME_TURN.bounds(one) == (-0.5, 0.5)
    assert prior(DEAD_TIME_DIODES, one) is not None


# how a run begins


def test_a_coast_begins_as_its_source_left_it() -> None:
    """Of any speed before a motor is known; none is looked for where no motion was measured."""
    asked: list[Any] = []
    noise = SimpleNamespace(coasts=(2, 5), speed_deviation=lambda *of: asked.append(of) or 0.25)
    speed = block(SPEED, (3.0, -9.0, 1.0))
    one = subject(speed, noise=noise, sources=("a", "b", "c"))
    assert [at.place for at in instances(COAST_START, one)] == [2, 5]
    assert COAST_START.scale(one) == 9.0
    assert prior(COAST_START, one, 2) == (0.25, 0.0, None)
    assert asked == [(2, "b", one.judged_at)]
    assert instances(COAST_START, subject(noise=noise)) == []
    one.judged_at = None
    assert prior(COAST_START, one, 2) == (math.inf, 0.0, None)


def test_a_run_may_begin_a_tenth_warmer() -> None:
    assert prior(INITIAL_WARMTH, subject()) == (0.1, 0.0, None)
    assert INITIAL_WARMTH.scale(subject()) * INITIAL_WARMTH.step == pytest.approx(1e-7)  # of R


def test_scales_of_a_capture() -> None:
    """A top speed over a twentieth of the readings; a stall by the resistance of its judge."""
    turned = block(POSITION, np.r_[np.zeros(40), 0.5 * np.arange(60.0)])
    assert scales.speed(subject(turned)) == pytest.approx(0.5 / 1e-4)
    turned.keep = 2 * np.arange(100)
    assert scales.speed(subject(turned)) == pytest.approx(0.25 / 1e-4)
    few = block(POSITION, (0.0, 1.0, 4.0))
    assert scales.speed(subject(few)) == pytest.approx(3.0 / 1e-4)
    assert scales.speed(subject()) == 0.0
    assert scales.stall(subject()) == pytest.approx(4.0)
    assert scales.stall(subject(volts=np.zeros(3))) == pytest.approx(0.5)
    assert scales.top_speed(subject()) == pytest.approx(160.0)
    assert scales.top_volts(lossy("x")) == TOP_V
    assert scales.top_volts(subject(sensed=SimpleNamespace(volts=np.array([1.0, 4.0])))) == 3.0
    assert scales.period_s(subject()) == 5e-5
    assert scales.period_s(subject(pwm_period_s=0.0)) == 1e-4
