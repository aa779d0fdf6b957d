"""Whether a capture's facts and readings are such as a bench can have: asked before any fit.

A unit mistaken by nine orders, a damaged column or an infinite clock would overflow somewhere deep
in a fit. Here they cost one sentence. The ranges are wide: nothing that a motor does lies outside.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from motorid.capture.model import Capture, Channel
from motorid.errors import DataError

Range = tuple[float, float]

LEAST, MOST = 1e-15, 1e9  # of a channel's largest reading, SI; all of them may be 0
CLOCK_HZ: Range = (1e-6, 1e15)
LONGEST_S = 1e9
SHORTEST_S = 1e-12  # from the first sample to the last
TICKS = 2**62  # from the first to the last: their difference is still an integer
CHANNEL: Mapping[str, Range] = {
    "scale": (-1e12, 1e12),
    "offset": (-1e15, 1e15),
    "aperture_s": (0.0, 1e6),
    "delay_s": (0.0, 1e6),
    "resolution": (0.0, MOST),
    "noise": (0.0, MOST),
    "gain_uncertainty": (0.0, 1e3),
    "offset_uncertainty": (0.0, MOST),
    "delay_uncertainty_s": (0.0, 1e3),
    "filter_s": (0.0, 1e6),
    "filter_damping": (0.1, 10.0),
    "nonlinearity": (0.0, 1e3),
    "full_scale": (0.0, MOST),
    "step_uncertainty": (0.0, MOST),
}
WIRING: Mapping[str, Range] = {
    "bridge_resistance_ohm": (0.0, 1e6),
    "bridge_resistance_uncertainty_ohm": (0.0, 1e6),
    "lead_resistance_ohm": (0.0, 1e6),
    "lead_resistance_uncertainty_ohm": (0.0, 1e6),
    "gear_ratio": (1e-6, 1e6),
    "counts_per_turn": (0.0, 1e9),
    "pwm_hz": (0.0, 1e9),
    "dead_time_s": (0.0, 1.0),
    "pwm_alignment": (0.0, 1.0),
    "supply_voltage_v": (0.0, 1e6),
    "bridge_drop_v": (0.0, 1e3),
    "bridge_drop_uncertainty_v": (0.0, 1e3),
    "brush_drop_v": (0.0, 1e3),
    "brush_drop_uncertainty_v": (0.0, 1e3),
    "encoder_eccentricity_rad": (0.0, 10.0),
    "reference_drift": (0.0, 1.0),
    "reference_time_s": (0.0, 1e9),
    "terminal_load_ohm": (0.0, 1e12),
    "terminal_load_uncertainty_ohm": (0.0, 1e12),
}
CONDITIONS: Mapping[str, Range] = {
    "clock_hz": CLOCK_HZ,
    "clock_uncertainty": (0.0, 1.0),
    "ambient_c": (-273.15, 1e3),
    "ambient_uncertainty_c": (0.0, 1e3),
}


def insist(capture: Capture) -> None:
    """Raises DataError, in one sentence, where a fact or a reading is none of any bench."""
    for said in _doubts(capture):
        raise DataError(f"{capture.path or 'the capture'}: {said}")


def _doubts(capture: Capture) -> Iterator[str]:
    yield from _outside(capture, CONDITIONS, "")
    yield from _outside(capture.wiring, WIRING, "wiring: ")
    yield from _time(capture)
    for channel in capture.channels.values():
        yield from _outside(channel, CHANNEL, f"{channel.name}: ")
        yield from _readings(channel)


def _outside(facts: object, ranges: Mapping[str, Range], where: str) -> Iterator[str]:
    for name, (low, high) in ranges.items():
        value = getattr(facts, name)
        if value is not None and not low <= value <= high:
            yield f"{where}{name} is {value:g}, not within {low:g} to {high:g}: correct it"
    phase = getattr(facts, "pwm_phase", None)
    if phase is not None and not 0.0 <= phase <= 1.0:
        yield f"{where}pwm_phase is {phase:g}, not a share of a PWM period: correct it"
    if getattr(facts, "scale", 1.0) == 0.0:
        yield f"{where}scale is 0, so that every reading is the same: correct it"


def _time(capture: Capture) -> Iterator[str]:
    if len(capture) < 2:
        return
    ticks = capture.ticks
    span = int(ticks.max()) - int(ticks.min())
    seconds = span / capture.clock_hz
    if span and (span >= TICKS or not SHORTEST_S <= seconds <= LONGEST_S):
        yield (
            f"its time stamps span {seconds:g} s, which is no run of a motor: check the unit of "
            "time and the clock"
        )


def _readings(channel: Channel) -> Iterator[str]:
    raw = np.abs(np.asarray(channel.raw, dtype=np.float64))
    if not len(raw):
        return
    largest = float(np.fmax.reduce(raw))  # a NaN is a missing reading
    if not math.isnan(largest):
        largest = float(abs(channel.scale) * (largest + abs(channel.offset)))
    if math.isinf(largest):
        yield f"{channel.name} holds infinite readings: leave such fields empty"
    elif largest > MOST or 0.0 < largest < LEAST:
        yield (
            f"{channel.name} reads up to {largest:.3g} {channel.unit}, as no motor does: check "
            "its unit, scale and offset"
        )
