"""What a rig states and its board says otherwise, said before the program runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from motorid.acquire.guards import brown_out
from motorid.acquire.safety import program_volts
from motorid.capture.model import SUPPLY_OFF, VOLTAGE
from motorid.capture.pwm_window import HARM, MEND, beat_hz, largest_error, said
from motorid.program import Program
from motorid.rig import Rig
from motorid.wire.enums import ChannelKind


def contradictions(
    rig: Rig,
    program: Program,
    identity: Mapping[str, Any],
    descriptors: Mapping[str, Mapping[str, Any]],
    read_v: float | None,
    period: int,
) -> Iterator[str]:
    """A sentence for each. ``read_v``: the supply, as the board reads it; ``period``: in ticks."""
    if said_of_supply := brown_out(identity):
        yield said_of_supply
    stated = rig.supply_voltage_v
    if stated and read_v and abs(stated - read_v) > SUPPLY_OFF * read_v:
        yield (
            f"the rig states wiring.supply_voltage_v = {stated:g}, and the board reads "
            f"{read_v:.3g} V, which is used: correct the rig, or calibrate that channel"
        )
    fact, supply_v = descriptors.get(VOLTAGE), read_v or stated
    if fact and supply_v and VOLTAGE in rig.sampling.channels:
        yield from _window(fact, identity, program_volts(rig, program, supply_v), supply_v, period)


def _window(
    fact: Mapping[str, Any],
    identity: Mapping[str, Any],
    levels: list[float],
    supply_v: float,
    period: int,
) -> Iterator[str]:
    """A voltage that is read over part of a PWM period, in step with the samples."""
    pwm_hz = float(identity["pwm_hz"])
    beat = beat_hz(period / identity["clock_hz"], pwm_hz) if pwm_hz else None
    if beat is None:
        return
    mean = fact["kind"] == ChannelKind.MEAN
    periods = fact["aperture_ns"] * 1e-9 * pwm_hz if mean else 0.0
    slow = fact.get("filter_ns", 0) * 1e-9 * pwm_hz
    errors = [(largest_error(periods, v / supply_v, supply_v, slow), v) for v in levels if v > 0.0]
    error, level = max(errors, key=lambda row: row[0] / row[1], default=(0.0, 1.0))
    if error > HARM * level:
        yield f"{said(periods, pwm_hz, level, error, beat)}: {MEND}"
