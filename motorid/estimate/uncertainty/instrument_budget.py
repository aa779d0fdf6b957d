"""What the instruments' own limits do to the parameters, cause by cause.

A gain, the clock or a lead's resistance that is wrong leaves no residual, so the fit cannot see it.
Each declared standard uncertainty is carried to the parameters linearly: the readings move as that
cause would move them, and the fit follows. Causes are independent of each other; one that several
captures share (their gains, their clock) moves them together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.signals.pwm_bridge import DIODE_DROPS_SD_V
from motorid.estimate.solver.dense_products import project
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.motor.response import Stretch
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]
Shift = Callable[[MotorRecord, Floats, Floats], list[Floats]]

SMALL = 1e-5  # relative change by which a cause is tried
UNITS_V = 1e-3  # V by which the source is tried
LATE_S = 1e-8  # by which a delay is tried
NOT_LATE: Mapping[str, float] = {}


def budget(solution: Solution, records: Sequence[MotorRecord]) -> dict[str, Floats]:
    """Shift (p,) of every parameter in search coordinates for one standard uncertainty of a cause.

    Causes that are declared to be exact are left out.
    """
    inverse = covariance_of(solution.information)
    causes: dict[str, Floats] = {}
    for name, shift in _CAUSES.items():
        pull = np.zeros(len(solution.values))
        for record, line, own in zip(records, solution.records, solution.own, strict=True):
            moved = shift(record, solution.values, own)
            parts = [d / s for d, s in zip(record.weighed(moved), line.sigmas, strict=True)]
            pull += project(line.orthogonal.T, np.concatenate(parts))
        if pull.any():
            causes[name] = inverse @ pull
    series = np.array([r.sensed.series_uncertainty_ohm for r in records])
    names = [u.name for u in solution.unknowns]
    if series.any() and "R" in names:
        k = names.index("R")
        causes["wiring resistance"] = np.zeros(len(names))
        causes["wiring resistance"][k] = float(series.mean()) / solution.values[k]
    told = records[0].foretold
    if told is not None:
        causes["PWM ripple"] = np.array([told.shift.get(name, 0.0) for name in names])
    if records[0].unsettled is not None:
        causes["source iteration"] = records[0].unsettled
    return causes


def _gain(names: tuple[str, ...]) -> Shift:
    def shift(record: MotorRecord, values: Floats, own: Floats) -> list[Floats]:
        """Measured readings scaled by one standard uncertainty of their gain."""
        fitted = record.fitted(values, own)
        return [
            m.channel.gain_uncertainty * y if m.block.name in names else np.zeros(len(y))
            for m, y in zip(record.measured, fitted, strict=True)
        ]

    return shift


def _voltage_gain(record: MotorRecord, values: Floats, own: Floats) -> list[Floats]:
    """The source is larger by the gain, and so is the measured back-EMF."""
    gain = record.sensed.gain_uncertainty
    base = record.fitted(values, own)
    if not gain:
        return [np.zeros(len(y)) for y in base]
    moved = _fitted_if(record, values, own, volts=1.0 + SMALL)
    return [
        (gain * y if m.block.name == EMF else 0.0) - gain / SMALL * (new - y)
        for m, y, new in zip(record.measured, base, moved, strict=True)
    ]


def _clock(record: MotorRecord, values: Floats, own: Floats) -> list[Floats]:
    uncertainty = record.capture.clock_uncertainty
    base = record.fitted(values, own)
    if not uncertainty:
        return [np.zeros(len(y)) for y in base]
    moved = _fitted_if(record, values, own, clock=1.0 + SMALL)
    return [uncertainty / SMALL * (new - y) for y, new in zip(base, moved, strict=True)]


def _delay(name: str) -> Shift:
    def shift(record: MotorRecord, values: Floats, own: Floats) -> list[Floats]:
        """As ``later``, but for a delay that is an unknown of the fit."""
        if name == CURRENT and record.delay_is_free:
            return [np.zeros(len(m.values)) for m in record.measured]
        return later(record, values, own, name)

    return shift


def later(record: MotorRecord, values: Floats, own: Floats, name: str) -> list[Floats]:
    """By how much the readings change, one kind of them later by one standard uncertainty."""
    base = record.fitted(values, own)
    late = max(
        (m.channel.delay_uncertainty_s for m in record.measured if m.block.name == name),
        default=0.0,
    )
    if not late:
        return [np.zeros(len(y)) for y in base]
    moved = _fitted_if(record, values, own, late_s={name: LATE_S})
    return [late / LATE_S * (new - y) for y, new in zip(base, moved, strict=True)]


def _source_level(record: MotorRecord, values: Floats, own: Floats) -> list[Floats]:
    """The mean of a step's readings is not known better than the converter's step, if at all."""
    base = record.fitted(values, own)
    resolution = record.sensed.resolution
    noise = max((s.noise for s in record.sources if s is not None), default=np.inf)
    if not resolution or noise > 0.3 * resolution:  # noise of a third of a step dithers it away
        return [np.zeros(len(y)) for y in base]
    size = resolution / np.sqrt(12.0)
    moved = _fitted_if(record, values, own, shift_v=UNITS_V)
    return [-size / UNITS_V * (new - y) for y, new in zip(base, moved, strict=True)]


def _duty(record: MotorRecord, values: Floats, own: Floats) -> list[Floats]:
    """A board makes volts by a supply that it has read: their mean is measured, their duty not."""
    base = record.fitted(values, own)
    parts = record.timeline.parts
    by_volts = any(p.kind == StepKind.DRIVE_VOLTS and p.decay != Decay.NONE for p in parts)
    gain = record.sensed.gain_uncertainty
    if not by_volts or not gain or record.capture.get(SUPPLY) is not None:
        return [np.zeros(len(y)) for y in base]
    moved = _fitted_if(record, values, own, duty=1.0 + SMALL)
    return [-gain / SMALL * (new - y) for y, new in zip(base, moved, strict=True)]


def _diode_drops(record: MotorRecord, values: Floats, own: Floats) -> list[Floats]:
    """Two diodes drop more: against the current in the off part of diode decay, and at a coast."""
    base = record.fitted(values, own)
    if not any(part.decay == Decay.DIODE for part in record.timeline.parts):
        return [np.zeros(len(y)) for y in base]
    moved = _fitted_if(record, values, own, drops_v=UNITS_V)
    return [-DIODE_DROPS_SD_V / UNITS_V * (new - y) for y, new in zip(base, moved, strict=True)]


def _fitted_if(
    record: MotorRecord,
    values: Floats,
    own: Floats,
    *,
    volts: float = 1.0,
    shift_v: float = 0.0,
    clock: float = 1.0,
    duty: float = 1.0,
    drops_v: float = 0.0,
    late_s: Mapping[str, float] = NOT_LATE,
) -> list[Floats]:
    """``fitted`` if the source gave ``volts`` times its voltage, or ticks lay ``clock`` apart.

    ``shift_v`` is added in the direction of the voltage, ``late_s`` to the delay of the blocks
    it names, ``drops_v`` to what two diodes drop; volts are made by ``duty`` times their duty. What
    drives the motor scales alike, and so does all that the board times.
    """
    usual = record.response
    outputs = [
        replace(o, aperture_s=clock * o.aperture_s, delay_s=clock * o.delay_s)
        for o in record.outputs
    ]
    for m in record.measured:
        late = late_s.get(m.block.name, 0.0)
        outputs[m.row] = outputs[m.row].delayed(late, usual.pwm_period_s)
    scaled = [
        replace(s, swing_v=volts * s.swing_v, clamp_v=volts * s.clamp_v)
        for s in _stretches_if(record, duty, drops_v)
    ]
    source = volts * record.volts + shift_v * np.sign(record.volts)
    moved = record.respond(
        clock * usual.period_s, source, outputs, scaled, clock * usual.pwm_period_s
    )
    return record.fitted_by(moved, values, own)


def _stretches_if(record: MotorRecord, duty: float, drops_v: float) -> list[Stretch]:
    """The record's stretches at ``duty`` times the duty of volts, and two diodes' larger drops."""
    out = []
    for s in record.stretches:
        part = next(p for p in reversed(record.timeline.parts) if p.start <= s.start)
        if part.kind == StepKind.DRIVE_VOLTS:
            s = _at_duty(s, part.decay, duty)
        more = np.copysign(drops_v, s.swing_v) if part.decay == Decay.DIODE and s.swing_v else 0.0
        clamp = s.clamp_v + drops_v if s.clamp_v else 0.0
        out.append(replace(s, swing_v=s.swing_v + more, clamp_v=clamp))
    return out


def _at_duty(s: Stretch, decay: Decay, duty: float) -> Stretch:
    """At so many times its duty, the mean voltage being the same."""
    if not 0.0 < s.duty < 1.0:
        return s
    if decay == Decay.FAST:  # half of the period for no volts
        return replace(s, duty=0.5 + duty * (s.duty - 0.5))
    swing = s.swing_v / duty if decay == Decay.SYNCHRONOUS_SLOW else s.swing_v
    return replace(s, duty=duty * s.duty, swing_v=swing)


_CAUSES: dict[str, Shift] = {
    "current gain": _gain((CURRENT,)),
    "voltage gain": _voltage_gain,
    "encoder or speed gain": _gain((POSITION, SPEED)),
    "clock": _clock,
    "current delay": _delay(CURRENT),
    "voltage delay": _delay(EMF),
    "voltage resolution": _source_level,
    "duty of volts": _duty,
    "diode drops": _diode_drops,
}
