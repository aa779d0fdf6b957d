"""A recording becomes a capture: a log of measured voltage, whose program is not on its clock.

A supply reaches a level when it does, and a recorder's clock begins when it does. So the capture
carries no program; what was commanded stands in its provenance. The fit takes the measured voltage,
and every lag that nobody stated is an unknown of it.
"""

from __future__ import annotations

import math
import platform
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.scpi.notes import Told, notes_of
from motorid.acquire.scpi.recorder import Recording, Trace
from motorid.capture import table_checks as checks
from motorid.capture.declared import without_early_readings
from motorid.capture.facts import of_provenance
from motorid.capture.model import (
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
from motorid.errors import DataError
from motorid.rig import Rig
from motorid.version import __version__

FEWEST = 2  # samples of a capture


def capture_of(rig: Rig, recording: Recording, told: Told) -> Capture:
    """The capture. Raises DataError where there are too few readings."""
    time_s, traces = _advancing(recording)
    if len(time_s) < FEWEST:
        raise DataError("not two readings of the run arrived: there is nothing to keep")
    if recording.uniform:
        ticks, hz = np.arange(len(time_s), dtype=np.int64), 1.0 / float(time_s[1] - time_s[0])
    else:
        ticks, hz = np.rint(time_s * CLOCK_HZ).astype(np.int64), CLOCK_HZ
    channels = {trace.source.name: _channel(rig, trace) for trace in traces}
    notes = [*recording.notes, *notes_of(rig, recording.polled, channels, time_s, told)]
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
        sign = -1.0 if rig.encoder_reversed else 1.0
        resolution = 2.0 * math.pi / rig.wiring.counts_per_turn
        scale = sign * resolution * math.copysign(1.0, scale)
    given = dict(source.options)
    late_s, late_uncertainty_s = trace.late or (0.0, 0.0)
    if trace.late is not None:
        given.setdefault("delay", {name: 0.0})  # beside when it was read nothing makes it late
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
    stated = as_stated(channel, TableOptions(**given), counted=name == POSITION)
    return replace(
        stated,
        delay_s=stated.delay_s + late_s,
        delay_uncertainty_s=math.hypot(stated.delay_uncertainty_s, late_uncertainty_s),
    )


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
