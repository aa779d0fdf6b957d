"""What the captures give to remark on: samples, stamps, converters, currents that stop."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic
from motorid.estimate.signals.neighbour_noise import neighbour_noise
from motorid.estimate.signals.source.discontinuous_current import unclear
from motorid.estimate.signals.time_grid import IRREGULAR

FEW, MANY = 50.0, 200.0  # steps to the highest reading: coarse, and coarse where noise is less
COARSER = 2.0  # times: a grid that leaves out what the stamps would tell


def of_capture(record: MotorRecord, where: str) -> list[Diagnostic]:
    """Samples, stamps and readings of one capture that are not as they should be."""
    out = []
    lost = record.timeline.lost - _slower(record.capture)
    if lost > 0:
        scattered = record.timeline.past is not None and record.timeline.jitter > IRREGULAR
        out.append(
            Diagnostic(
                "lost_samples", "info" if scattered else "warning",  # no period says what is due
                f"{lost} of {len(record.capture) + lost} samples are missing{where}; the fit "
                "passes over them, with the voltage taken from their neighbours",
            )
        )  # fmt: skip
    if record.timeline.past is not None and record.timeline.jitter > IRREGULAR:
        out.append(
            Diagnostic(
                "irregular_stamps", "info",
                f"the time stamps are irregular{where}: every reading is compared with the model "
                "at its own stamp",
            )
        )  # fmt: skip
    elif record.timeline.jitter > IRREGULAR:
        out.append(
            Diagnostic(
                "jitter", "warning",
                f"time stamps miss a uniform grid by up to {record.timeline.jitter:.2f} "
                f"periods{where}",
            )
        )  # fmt: skip
    if record.timeline.coarser > COARSER:
        out.append(
            Diagnostic(
                "coarse_grid", "info",
                f"some stamps follow each other {record.timeline.coarser:.0f} times more closely "
                f"than the fit computes{where}, to bound its work: cut the log to where it is "
                "sampled evenly",
            )
        )  # fmt: skip
    for name in (CURRENT, VOLTAGE):
        channel = record.capture.get(name)
        clipped = int(channel.saturated.sum()) if channel is not None else 0
        if clipped:
            out.append(
                Diagnostic(
                    "saturated", "warning",
                    f"{clipped} readings of the {name.replace('_', ' ')} are at the end of its "
                    f"converter's range{where} and are left out",
                )
            )  # fmt: skip
    raw = [
        p for p, s in zip(record.timeline.parts, record.sources, strict=True)
        if (s is None or s.as_read) and not p.open
    ]  # fmt: skip
    parts = "1 driven part" if len(raw) == 1 else f"{len(raw)} driven parts"
    if raw and record.sensed.resolution:
        out.append(
            Diagnostic(
                "voltage_readings", "info",
                f"in {parts}{where} the voltage does not follow a constant source "
                "behind a resistance: there the fit uses each reading of it",
            )
        )  # fmt: skip
    return out + coarse(record, where)


def coarse(record: MotorRecord, where: str) -> list[Diagnostic]:
    """Channels of which a few steps make up the highest reading, or whose noise is less than such
    a step, so that rounding does not average out.
    """
    said = []
    for name in (CURRENT, VOLTAGE, SPEED):
        channel = record.capture.get(name)
        if channel is None or not channel.resolution:
            continue
        known = channel.values[np.isfinite(channel.values)]
        steps = float(np.abs(known).max(initial=0.0)) / channel.resolution
        if steps < FEW or (steps < MANY and channel.resolution > neighbour_noise(known)):
            step = f"{channel.resolution:.3g} {channel.unit}"
            said.append(f"the {name.replace('_', ' ')} comes in {steps:.0f} steps of {step}")
    if not said:
        return []
    return [
        Diagnostic(
            "coarse_readings", "info",
            f"the resolution is coarse{where}: {', '.join(said)} to its highest reading; rounding "
            "may not average out: use a smaller range or more bits",
        )
    ]  # fmt: skip


def _slower(capture: Capture) -> int:
    """Samples that a log seems to lack because its logger went on at a slower pace.

    Sample after sample then follows a pause of one length.
    """
    if capture.program is not None or len(capture.gaps) < 2:
        return 0
    alike = [b.index == a.index + 1 and b.samples == a.samples for a, b in pairwise(capture.gaps)]
    beside = zip(capture.gaps, [False, *alike], [*alike, False], strict=True)
    return sum(gap.samples for gap, before, after in beside if before or after)


def stopping(records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """Where a diode's current stops, what that hides, and what to do about it."""
    driven = sum(int(record.driven.sum()) for record in records)
    stopped = sum(int(record.timeline.stopped.sum()) for record in records)
    if not stopped:
        return []
    parts = [part for record in records for part in record.timeline.parts]
    levels = sorted({part.level for part in parts if part.discontinuous})
    hidden = sum(
        int(unclear(channel, record.timeline, record.capture.wiring.pwm_hz).sum())
        for record in records
        if (channel := record.capture.get(CURRENT)) is not None
    )
    left_out = (
        f", and the {hidden} readings of a part of the PWM period that nobody knows are left out"
        if hidden
        else ""
    )
    return [
        Diagnostic(
            "discontinuous_current", "info",
            f"the diodes' current stops within the PWM period in {100 * stopped / driven:.0f} % of "
            f"the driven time (levels {', '.join(f'{level:.3g}' for level in levels)}): there "
            f"only the size of the current depends on L{left_out}. To determine L better, use a "
            "level at full duty, synchronous decay or a faster PWM",
        )
    ]  # fmt: skip


def standing(records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """Where the motor was driven and did not move."""
    parts = [part for record in records for part in record.timeline.parts if part.still]
    if not parts:
        return []
    levels = ", ".join(f"{level:.3g}" for level in sorted({part.level for part in parts}))
    return [
        Diagnostic(
            "standstill", "info",
            f"the motor stands still at levels {levels}, and the model holds the speed at zero: "
            "breakaway or cogging may resist more than T0. Such a part does not determine K, B, J "
            "and T0",
        )
    ]  # fmt: skip


def unseen_voltage(records: Sequence[MotorRecord]) -> list[Diagnostic]:
    """What a search does not know of a log's voltage, and the default method does."""
    if all(record.sensed.waveform is None for record in records):
        return []
    return [
        Diagnostic(
            "voltage_between_stamps", "warning",
            "the voltage of such a log between two stamps is unknown: this method takes it as a "
            "straight line and the stamps as exact, and the intervals do not cover that; the "
            "method ml tries other shapes and delays for the six parameters, which matters most "
            "for L",
        )
    ]  # fmt: skip
