"""What no bench has is refused before any fit, and what a bench may have is let pass."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import Capture, Channel, Wiring
from motorid.capture.plausible import insist
from motorid.errors import DataError

CONDITIONS = [
    ("clock_hz", 1e-6, 1e15),
    ("clock_uncertainty", 0.0, 1.0),
    ("ambient_c", -273.15, 1000.0),
    ("ambient_uncertainty_c", 0.0, 1000.0),
]
CHANNEL = [
    ("scale", -1e12, 1e12),
    ("offset", -1e15, 1e15),
    ("aperture_s", 0.0, 1e6),
    ("delay_s", 0.0, 1e6),
    ("resolution", 0.0, 1e9),
    ("noise", 0.0, 1e9),
    ("gain_uncertainty", 0.0, 1e3),
    ("offset_uncertainty", 0.0, 1e9),
    ("delay_uncertainty_s", 0.0, 1e3),
    ("filter_s", 0.0, 1e6),
    ("filter_damping", 0.1, 10.0),
    ("nonlinearity", 0.0, 1e3),
    ("full_scale", 0.0, 1e9),
    ("step_uncertainty", 0.0, 1e9),
    ("pwm_phase", 0.0, 1.0),
]
WIRING = [
    ("bridge_resistance_ohm", 0.0, 1e6),
    ("bridge_resistance_uncertainty_ohm", 0.0, 1e6),
    ("lead_resistance_ohm", 0.0, 1e6),
    ("lead_resistance_uncertainty_ohm", 0.0, 1e6),
    ("gear_ratio", 1e-6, 1e6),
    ("counts_per_turn", 0.0, 1e9),
    ("pwm_hz", 0.0, 1e9),
    ("dead_time_s", 0.0, 1.0),
    ("supply_voltage_v", 0.0, 1e6),
    ("bridge_drop_v", 0.0, 1e3),
    ("bridge_drop_uncertainty_v", 0.0, 1e3),
    ("brush_drop_v", 0.0, 1e3),
    ("pwm_alignment", 0.0, 1.0),
    ("brush_drop_uncertainty_v", 0.0, 1e3),
    ("encoder_eccentricity_rad", 0.0, 10.0),
    ("reference_drift", 0.0, 1.0),
    ("reference_time_s", 0.0, 1e9),
]


def of(raw: list[float], ticks: list[int] | None = None, **facts: Any) -> Capture:
    """A capture of a current alone: three samples a millisecond apart, or at these ticks."""
    moments = np.array([0, 1000, 2000] if ticks is None else ticks, np.int64)
    return Capture(moments, 1e6, {"current": Channel("current", "A", np.array(raw), **facts)})


def outside(low: float, high: float) -> list[float]:
    """A little below the least and above the most."""
    step = 1e-4
    return [low - step * (abs(low) or 1.0), high * (1.0 + step), nan]


@pytest.mark.parametrize(("name", "low", "high"), CONDITIONS)
def test_conditions_of_a_run(name: str, low: float, high: float) -> None:
    one = of([0.0], [5])  # a moment lasts nothing, by any clock
    for value in (low, high):
        insist(replace(one, **{name: value}))
    for value in outside(low, high):
        with pytest.raises(DataError, match=f"^the capture: {name} is "):
            insist(replace(one, **{name: value}))


@pytest.mark.parametrize(("name", "low", "high"), CHANNEL)
def test_facts_of_a_channel(name: str, low: float, high: float) -> None:
    for value in (low, high):
        insist(of([0.0, 0.0, 0.0], **{name: value} | ({} if name != "offset" else {"scale": 1e-9})))
    for value in outside(low, high):
        with pytest.raises(DataError, match=f"^the capture: current: {name} is "):
            insist(of([0.0, 0.0, 0.0], **{name: value}))


@pytest.mark.parametrize(("name", "low", "high"), WIRING)
def test_facts_of_the_wiring(name: str, low: float, high: float) -> None:
    capture = of([0.0, 0.0, 0.0])
    for value in (low, high):
        insist(replace(capture, wiring=Wiring(**{name: value})))
    for value in outside(low, high):
        with pytest.raises(DataError, match=f"^the capture: wiring: {name} is "):
            insist(replace(capture, wiring=Wiring(**{name: value})))


def test_a_scale_of_nothing_makes_all_readings_the_same() -> None:
    with pytest.raises(DataError, match=r"^run\.h5: current: scale is 0, so"):
        insist(replace(of([0.0, 1.0, 2.0], scale=0.0), path="run.h5"))


@pytest.mark.parametrize(
    ("ticks", "clock_hz", "good"),
    [
        ([0, 1], 1e6, True),
        ([0, 9], 1e13, False),  # 0.9 ps
        ([0, 11], 1e13, True),
        ([7, 7 + 999], 1e-6, True),  # 9.99e8 s
        ([7, 7 + 1001], 1e-6, False),
        ([5, 5], 1e6, True),  # stamps that stand are another's concern
        ([0, 2**62 - 1], 1e15, True),
        ([-1, 2**62 - 1], 1e15, False),  # of which no difference need be an integer
        ([2000, 1000, 0], 1e6, True),  # from the first to the last of time, not of the record
        ([5], 1e6, True),
        ([], 1e6, True),
    ],
)
def test_a_run_lasts_as_long_as_a_motors(ticks: list[int], clock_hz: float, good: bool) -> None:
    capture = replace(of([0.0] * len(ticks), ticks), clock_hz=clock_hz)
    if good:
        insist(capture)
    else:
        with pytest.raises(DataError, match=r"its time stamps span .* s, which is no run"):
            insist(capture)


@pytest.mark.parametrize(
    ("raw", "facts", "good"),
    [
        ([0.0, 0.0, 0.0], {}, True),
        ([nan, nan, nan], {}, True),
        ([nan, 1.01e9, 0.0], {}, False),
        ([nan, -0.99e9, 0.0], {}, True),
        ([-1.01e9, 0.0, 0.0], {}, False),
        ([0.0, 0.99e-15, nan], {}, False),
        ([0.0, 1.01e-15, nan], {}, True),
        ([0.0, 3e8, 0.0], {"scale": -4.0}, False),  # 1.2e9
        ([0.0, 3e9, 0.0], {"scale": -0.25}, True),  # 0.75e9
        ([0.0, 3e8, 0.0], {"offset": -8e8}, False),  # 1.1e9
        ([0.0, 1.5e9, 0.0], {"offset": -1e9, "scale": 0.5}, False),  # 1.25e9
        ([0.0, 1e3, 0.0], {"scale": 1e-19}, False),
    ],
)
def test_readings_are_a_motors(raw: list[float], facts: dict[str, float], good: bool) -> None:
    if good:
        insist(of(raw, **facts))
    else:
        with pytest.raises(DataError, match=r"current reads up to .* A, as no motor does"):
            insist(of(raw, **facts))


def test_infinite_readings_are_told_from_large_ones() -> None:
    with pytest.raises(DataError, match="current holds infinite readings"):
        insist(of([0.0, -inf, nan]))
