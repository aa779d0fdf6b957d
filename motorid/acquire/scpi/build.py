"""A recording becomes a capture: a log of measured voltage, whose program is not on its clock.

A supply reaches a level when it does, and a recorder's clock begins when it does. So the capture
carries no program; what was commanded stands in its provenance. The fit takes the measured voltage,
and every lag that nobody stated is an unknown of it.
"""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.scpi.recorder import Recording, Trace
from motorid.capture import table_checks as checks
from motorid.capture.declared import without_early_readings
from motorid.capture.facts import of_provenance
from motorid.capture.model import (
    CURRENT,
    HELD,
    NOTES,
    POSITION,
    QUANTITIES,
    VOLTAGE,
    Capture,
    Channel,
    Sense,
)
from motorid.capture.stamps import CLOCK_HZ
from motorid.capture.table import STATIC
from motorid.capture.table_options import TableOptions, as_stated
from motorid.errors import DataError, RigError
from motorid.rig import Rig
from motorid.version import __version__

LIMITING = 0.97  # of the limit that was set: a current above it was limited
SHORT = 0.95  # of the level: a voltage below it was not reached
LOW, HIGH = 0.1, 0.9  # of a level: between these it rises
STEP = 3  # samples: what takes longer to rise is no step
FEWEST = 2  # samples of a capture


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
    bench: str  # the instruments' file


def capture_of(rig: Rig, recording: Recording, told: Told) -> Capture:
    """The capture. Raises DataError where there are too few readings, RigError on a wrong fact."""
    time_s, traces = _advancing(recording)
    if len(time_s) < FEWEST:
        raise DataError("not two readings of the run arrived: there is nothing to keep")
    if recording.uniform:
        ticks, hz = np.arange(len(time_s), dtype=np.int64), 1.0 / float(time_s[1] - time_s[0])
    else:
        ticks, hz = np.rint(time_s * CLOCK_HZ).astype(np.int64), CLOCK_HZ
    channels = {trace.source.name: _channel(rig, trace) for trace in traces}
    notes = [*recording.notes, *_notes(rig, recording.uniform, channels, time_s, told)]
    provenance = _provenance(rig, told)
    run = Capture(
        ticks=ticks,
        clock_hz=hz,
        clock_uncertainty=recording.clock_uncertainty,
        channels=channels,
        wiring=rig.wiring,
        gaps=() if recording.uniform else checks.gaps(ticks, notes),
        end_reason=told.end_reason,
        ambient_c=rig.ambient_c,
        ambient_uncertainty_c=rig.ambient_uncertainty_c,
        stated=of_provenance(provenance),
    )
    held = checks.held_samples(channels)
    notes += checks.capture_notes(run, held, static=False)
    found = {NOTES: notes, HELD: held, STATIC: False}
    kept = without_early_readings(channels)
    return replace(run, channels=kept, provenance=provenance | found)


def _advancing(recording: Recording) -> tuple[NDArray[np.float64], list[Trace]]:
    """Rows whose stamp lies after the one before: a coarse clock may repeat itself."""
    later = np.r_[True, np.diff(recording.time_s) > 0.0][: len(recording.time_s)]
    if later.all():
        return recording.time_s, list(recording.traces)
    traces = [replace(one, raw=one.raw[later]) for one in recording.traces]
    return recording.time_s[later], traces


def _channel(rig: Rig, trace: Trace) -> Channel:
    source = trace.source
    name, scale, resolution = source.name, trace.scale, trace.resolution
    if name == POSITION:
        if not rig.wiring.counts_per_turn:
            raise RigError("wiring.counts_per_turn is missing: an encoder's edges need it")
        sign = -1.0 if rig.encoder_reversed else 1.0
        resolution = 2.0 * math.pi / rig.wiring.counts_per_turn
        scale = sign * resolution * math.copysign(1.0, scale)
    given: dict[str, Any] = {key: {name: value} for key, value in source.facts.items()}
    channel = Channel(
        name=name,
        unit=QUANTITIES[name],
        raw=trace.raw,
        scale=scale,
        offset=trace.offset,
        resolution=resolution,
        raw_min=trace.raw_min,
        raw_max=trace.raw_max,
        sense=cast(Sense, source.sense) if name == VOLTAGE else None,
    )
    return as_stated(channel, TableOptions(**given), counted=name == POSITION)


def _provenance(rig: Rig, told: Told) -> dict[str, Any]:
    return {
        "created": told.created,
        "motorid": __version__,
        "rig_name": rig.name,
        "rig": rig.text,
        "port": rig.port,
        "serial": told.serial,
        "note": told.note,
        "host": {"python": platform.python_version(), "system": platform.platform(terse=True)},
        **({"settings": dict(rig.settings)} if rig.settings else {}),
        "instruments": {
            "identities": dict(told.identities),
            "protection": dict(told.protection),
            "commanded": [dict(one) for one in told.commanded],
            "current_limited_steps": list(told.limited),
            "file": told.bench,
        },
    }


def _notes(
    rig: Rig,
    uniform: bool,
    channels: Mapping[str, Channel],
    time_s: NDArray[np.float64],
    told: Told,
) -> list[str]:
    """What a reader must know of such a run, in sentences."""
    notes = []
    if told.limited:
        steps = ", ".join(str(index) for index in told.limited)
        notes.append(
            f"the supply limited the current in step {steps} of the program (constant current): "
            "that was no step of the voltage; raise the limit or lower the level for a sharp L"
        )
    notes += _near_limit(channels, time_s, told)
    if uniform:
        notes += _slew(channels, time_s, told)
    else:
        notes.append(
            f"readings were asked for one by one, about every {np.median(np.diff(time_s)):.2g} s: "
            "when within that time each was measured is not known, and L hardly shows"
        )
    wiring = rig.wiring
    leads = wiring.lead_resistance_ohm or wiring.lead_resistance_uncertainty_ohm
    if channels[VOLTAGE].sense == "bridge" and not leads:
        notes.append(
            "the voltage was measured at the supply, and wiring.lead_resistance_ohm is not stated: "
            "R holds the leads"
        )
    return notes


def _near_limit(
    channels: Mapping[str, Channel], time_s: NDArray[np.float64], told: Told
) -> list[str]:
    """Readings at the current limit while no level that was commanded is reached."""
    limit = told.protection.get("current_limit", math.inf)
    levels = [abs(one["volts"]) for one in told.commanded if one.get("volts")]
    if not levels or told.limited:
        return []
    current, volts = np.abs(channels[CURRENT].values), np.abs(channels[VOLTAGE].values)
    short = volts < SHORT * min(levels)
    at = np.flatnonzero((current >= LIMITING * limit) & short)
    if not len(at):
        return []
    return [
        f"{len(at)} readings, from {time_s[at[0]]:.3f} s on, are at the current limit of "
        f"{limit:g} A below the voltage that was set: the supply limited the current there, which "
        "is no step of the voltage"
    ]


def _slew(channels: Mapping[str, Channel], time_s: NDArray[np.float64], told: Told) -> list[str]:
    """How long the first level took to rise, where that is no step."""
    levels = [one["volts"] for one in told.commanded if one.get("volts")]
    if not levels:
        return []
    volts = channels[VOLTAGE].values * math.copysign(1.0, levels[0])
    above = [np.flatnonzero(volts > share * abs(levels[0])) for share in (LOW, HIGH)]
    if not (len(above[0]) and len(above[1])):
        return []
    samples = int(above[1][0] - above[0][0])
    if samples <= STEP:
        return []
    period_s = float(time_s[1] - time_s[0])
    return [
        f"the supply took {samples * period_s:.3g} s from 10 to 90 % of its first level: a ramp, "
        "and no step; the fit takes the voltage as it was measured"
    ]
