"""From a descriptor's integers, the run's zero and the rig to a channel's facts, by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from motorid.acquire import channels
from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE
from motorid.errors import DataError
from motorid.rig import Calibration
from motorid.wire.enums import ChannelKind

RAW = np.array([7, 9, 4], np.int16)
FACT: dict[str, Any] = {
    "scale": -0.02,
    "offset": 100.0,
    "offset_uncertainty": 3.0,
    "noise": 1.5,
    "gain_uncertainty": 0.01,
    "raw_min": 10,
    "raw_max": 1000,
    "kind": int(ChannelKind.MEAN),
    "aperture_ns": 50_000,
    "delay_ns": 12_000,
    "filter_ns": 30_000,
    "pwm_phase_permille": 250,
}


def analogue(name: str = CURRENT, fact: dict[str, Any] | None = None, **known: Any) -> Any:
    facts, counts = FACT | (fact or {}), (100.0, 2.0, 1.5)
    return channels.analogue(name, RAW, facts, Calibration(**known), counts, "bridge")


def test_an_encoder_counts_radians_from_the_run_s_first_sample() -> None:
    found = channels.position(RAW, FACT | {"pwm_phase_permille": 65535}, -2000.0)
    count = 2 * math.pi / 2000.0
    assert (found.name, found.unit) == ("position", "rad")
    assert found.values == pytest.approx([0.0, -2 * count, 3 * count])
    assert found.resolution == pytest.approx(count)
    assert found.pwm_phase is None


def test_a_converter_s_facts_in_its_unit() -> None:
    found = analogue(gain=1.5, delay_uncertainty_s=1e-6)
    assert (found.scale, found.offset) == (pytest.approx(-0.03), 100.0)
    assert found.resolution == pytest.approx(0.03)
    assert found.noise == pytest.approx(1.5 * 0.03)
    assert found.gain_uncertainty == 0.01
    assert found.offset_uncertainty == pytest.approx(2.0 * 0.03)
    assert found.delay_uncertainty_s == 1e-6
    assert found.step_uncertainty == 0.0
    assert (found.raw_min, found.raw_max) == (10.0, 1000.0)
    assert (found.kind, found.pwm_phase) == ("mean", 0.25)
    assert found.aperture_s == pytest.approx(50e-6)
    assert found.delay_s == pytest.approx(12e-6)
    assert (found.filter_s, found.filter_order) == (pytest.approx(30e-6), 1)
    assert (found.nonlinearity, found.nonlinearity_shape, found.full_scale) == (0.0, None, 0.0)


def test_what_the_rig_knows_goes_before_what_the_board_says() -> None:
    found = analogue(gain_uncertainty=0.0, offset_uncertainty=0.0)
    assert (found.gain_uncertainty, found.offset_uncertainty) == (0.0, 0.0)
    found = analogue(gain_uncertainty=0.2, offset_uncertainty=0.3, gain=2.0)
    assert (found.gain_uncertainty, found.offset_uncertainty) == (0.2, 0.3)


def test_how_far_readings_jump_is_in_the_channel_s_unit() -> None:
    found = analogue(fact={"step_uncertainty": 0.5}, gain=3.0)
    assert found.step_uncertainty == pytest.approx(0.5 * 0.06)


@pytest.mark.parametrize(
    ("name", "unit", "sense"),
    [(CURRENT, "A", None), (VOLTAGE, "V", "bridge"), (SUPPLY, "V", "supply")],
)
def test_only_voltages_are_measured_somewhere(name: str, unit: str, sense: str | None) -> None:
    found = analogue(name)
    assert (found.name, found.unit, found.sense) == (name, unit, sense)


@pytest.mark.parametrize(
    ("known", "full_scale"),
    [
        ({}, 0.02 * 900.0),  # the end that is farther from the zero
        ({"full_scale": 5.0}, 5.0),
        ({"gain": 2.0}, 0.04 * 900.0),
    ],
)
def test_a_bent_sensor_s_full_scale(known: dict[str, float], full_scale: float) -> None:
    found = analogue(nonlinearity=0.003, nonlinearity_shape="s", **known)
    assert (found.nonlinearity, found.nonlinearity_shape) == (0.003, "s")
    assert found.full_scale == pytest.approx(full_scale)


@pytest.mark.parametrize(
    ("noise", "samples", "uncertainty"),
    [
        (2.0, 16, 0.5),
        (0.5, 25, 0.1),
        (0.4, 4, math.hypot(0.2, 1 / math.sqrt(12))),  # one count hides what is below it
        (3.0, 0, 3.0),
        (3.0, 1, 3.0),
    ],
)
def test_the_offset_is_that_of_the_run_s_own_zero(
    noise: float, samples: int, uncertainty: float
) -> None:
    zero = {"voltage_offset": 511.0, "voltage_noise": noise, "current_offset": 4.0}
    found = channels.offset_of(VOLTAGE, FACT, zero, samples, Calibration(offset=7.0))
    assert found == (511.0, pytest.approx(uncertainty), noise)


@pytest.mark.parametrize(
    ("known", "offset"), [(Calibration(), 100.0), (Calibration(offset=0.0), 0)]
)
def test_without_a_zero_the_offset_is_the_calibration_s_or_the_board_s(
    known: Calibration, offset: float
) -> None:
    assert channels.offset_of(SUPPLY, FACT, {"current_offset": 4.0}, 16, known) == (
        offset, 3.0, 1.5,
    )  # fmt: skip
    assert channels.offset_of(VOLTAGE, FACT, {"current_offset": 4.0}, 16, known)[0] == offset


def test_a_filter_of_second_order_has_its_time_and_damping() -> None:
    # 1 + 2 d t s + (t s)²: of 60 µs and (50 µs)², d is .6
    found = analogue(fact={"filter_ns": 60_000, "filter2_ns": 50_000})
    assert (found.filter_order, found.filter_s) == (2, pytest.approx(50e-6))
    assert found.filter_damping == pytest.approx(0.6)


@pytest.mark.parametrize(
    ("permille", "phase"), [(0, 0.0), (1000, 1.0), (65535, None), (65534, 65.534)]
)
def test_where_in_a_pwm_period_a_reading_is(permille: int, phase: float | None) -> None:
    assert analogue(fact={"pwm_phase_permille": permille}).pwm_phase == phase


def test_a_way_of_reading_that_nobody_knows_is_refused() -> None:
    with pytest.raises(DataError, match=r"in a way that this version does not know \(77\)"):
        analogue(fact={"kind": 77})
    assert analogue(fact={"kind": int(ChannelKind.INSTANT)}).kind == "instant"
