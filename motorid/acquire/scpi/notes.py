"""What a reader must know of a run of instruments: limits, ramps, wrong factors, unknown times."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE, Channel
from motorid.rig import Rig

Floats = NDArray[np.float64]
LIMITING = 0.97  # of the limit that was set: a current above it was limited
SHORT = 0.95  # of the level: a voltage below it was not reached
LOW, HIGH = 0.1, 0.9  # of a level: between these it rises
STEP = 3  # samples: what takes longer to rise is no step
FACTOR = 1.25  # between what was set and what is read: beyond it a factor is wrong
ENOUGH = 0.5  # of the largest level: readings above it are of a drive
HELD_BACK = 0.05  # of a run: what a recorder may lack at its end unsaid


@dataclass(frozen=True)
class Told:
    """What happened beside the readings."""

    end_reason: str
    created: str
    serial: str
    note: str
    identities: Mapping[str, str]  # of the instruments
    protection: Mapping[str, float]  # as it was read back
    commanded: Sequence[Mapping[str, Any]]
    limited: Sequence[int]  # steps in which the supply said that it limited the current
    planned_s: float  # of the program
    bench: str  # the instruments' file


def notes_of(
    rig: Rig, polled: bool, channels: Mapping[str, Channel], time_s: Floats, told: Told
) -> Iterator[str]:
    """Sentences for a capture. ``polled``: one query after another, and no recorder took it."""
    yield from _limited(channels, time_s, told)
    if polled:
        yield (
            f"readings were asked for one by one, about every {np.median(np.diff(time_s)):.2g} s: "
            "when within that time each was measured is not known, and L hardly shows"
        )
    else:
        yield from _slew(channels, time_s, told)
        yield from _cut(time_s, told)
    yield from _factor(channels, told)
    yield from _sign(channels, told)
    wiring = rig.wiring
    leads = wiring.lead_resistance_ohm or wiring.lead_resistance_uncertainty_ohm
    if channels[VOLTAGE].sense == "bridge" and not leads:
        yield (
            "the voltage was measured at the supply, and wiring.lead_resistance_ohm is not stated: "
            "R holds the leads"
        )


def _levels(told: Told) -> list[float]:
    return [float(one["volts"]) for one in told.commanded if one.get("volts")]


def _limited(channels: Mapping[str, Channel], time_s: Floats, told: Told) -> Iterator[str]:
    """Constant current, as the supply says it, or as its readings do."""
    if told.limited:
        steps = ", ".join(str(index) for index in told.limited)
        yield (
            f"the supply limited the current in step {steps} of the program (constant current): "
            "that was no step of the voltage; raise the limit or lower the level for a sharp L"
        )
        return
    limit, levels = told.protection.get("current_limit", math.inf), _levels(told)
    if not levels:
        return
    current, volts = np.abs(channels[CURRENT].values), np.abs(channels[VOLTAGE].values)
    short = volts < SHORT * min(map(abs, levels))
    at = np.flatnonzero((current >= LIMITING * limit) & short)
    if len(at):
        yield (
            f"{len(at)} readings, from {time_s[at[0]]:.3f} s on, are at the current limit of "
            f"{limit:g} A below the voltage that was set: the supply limited the current there, "
            "which is no step of the voltage"
        )


def _slew(channels: Mapping[str, Channel], time_s: Floats, told: Told) -> Iterator[str]:
    """How long the first level took to rise, where that is no step."""
    levels = _levels(told)
    if not levels:
        return
    volts = channels[VOLTAGE].values * math.copysign(1.0, levels[0])
    low, high = (np.flatnonzero(volts > share * abs(levels[0])) for share in (LOW, HIGH))
    if len(low) and len(high) and high[0] - low[0] > STEP:
        took_s = float(time_s[high[0]] - time_s[low[0]])
        yield (
            f"the supply took {took_s:.3g} s from 10 to 90 % of its first level: a ramp, and no "
            "step; the fit takes the voltage as it was measured"
        )


def _cut(time_s: Floats, told: Told) -> Iterator[str]:
    """A recorder whose memory was shorter than the run."""
    if told.end_reason == "completed" and time_s[-1] < (1.0 - HELD_BACK) * told.planned_s:
        yield (
            f"the recorder kept {time_s[-1]:.3g} s of a run of {told.planned_s:.3g} s: lower "
            "sampling.rate_hz, or give it more memory"
        )


def _factor(channels: Mapping[str, Channel], told: Told) -> Iterator[str]:
    """A probe's factor of ten, and the like: the largest voltage is the largest level."""
    levels = [abs(volts) for volts in _levels(told)]
    if not levels or told.end_reason != "completed":
        return
    values = np.abs(channels[VOLTAGE].values)
    seen, most = float(np.nanquantile(values, 0.99)), max(levels)
    driven = values[values > ENOUGH * seen]
    shown = float(np.median(driven)) if len(driven) else 0.0
    if (seen < most / FACTOR and not told.limited) or shown > most * FACTOR:
        yield (
            f"the voltage reads up to {seen:.3g} V where {most:g} V was set: is the probe's factor "
            f"in channels.{VOLTAGE}.scale, and the channel on the right input?"
        )


def _sign(channels: Mapping[str, Channel], told: Told) -> Iterator[str]:
    """A current probe the wrong way round: in a drive it flows with the voltage on the whole."""
    if not _levels(told):
        return
    volts, current = channels[VOLTAGE].values, channels[CURRENT].values
    known = np.isfinite(volts) & np.isfinite(current)
    power = float(np.sum(volts[known] * current[known]))
    if power < 0.0:
        yield (
            "the current flows against the voltage on the whole, as if the motor drove the supply: "
            f"turn the probe, or write channels.{CURRENT}.scale with the other sign"
        )
