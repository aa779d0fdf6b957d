"""What drives the motor in the fit: the measured voltage, freed of its noise where that is honest.

While the command is constant a bridge is a source behind a resistance: the voltage at the sense
point is ``v0 - r i``. Where the measured voltage departs from that line by no more than its own
noise, the fit is given the line (v0 as the voltage, r in series), and so none of that noise; else
the readings themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.timeline import Part, Timeline
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]

DIODE_DROPS_V = 1.4  # of the two diodes that carry a freewheeling current
SETTLING = 3  # samples after a command that no line is judged on
FEWEST = 24  # samples that a line needs
EXCESS = 1.3  # variance about the line, in units of that between neighbours, still called noise
RIDGE = 1e-4  # pulls the slope of a part whose current hardly varies to the others'


@dataclass(frozen=True)
class Sense:
    """The voltage (count,) at the sense point, and what lies between there and the terminals."""

    volts: Floats
    series_ohm: float  # to be taken off the fitted resistance
    series_uncertainty_ohm: float
    shows_emf: bool  # the same channel shows K w while the bridge is open
    channel: Channel | None
    resolution: float = 0.0


@dataclass(frozen=True)
class Source:
    """One part's source: its voltage (V) and resistance (ohm); None: the readings are used."""

    volts: float
    ohms: float
    noise: float  # standard deviation of a reading about the line


def sense(capture: Capture, timeline: Timeline) -> Sense | None:
    """Where the voltage comes from, or None when nothing tells it."""
    wiring, channel = capture.wiring, capture.get(VOLTAGE)
    leads = wiring.lead_resistance_ohm, wiring.lead_resistance_uncertainty_ohm
    bridge = wiring.bridge_resistance_ohm, wiring.bridge_resistance_uncertainty_ohm
    both = leads[0] + bridge[0], float(np.hypot(leads[1], bridge[1]))
    if channel is not None and np.isfinite(channel.values).any():
        where = channel.sense or "terminals"
        series = {"terminals": (0.0, 0.0), "bridge": leads}.get(where, both)
        volts = _filled(timeline.spread(channel.values), timeline.parts)
        emf = where in ("terminals", "bridge")
        return Sense(volts, *series, emf, channel, channel.resolution)
    supply = capture.get(SUPPLY)
    driven = [p for p in timeline.parts if p.kind is not None]
    if not driven:
        return None
    if supply is None and any(p.kind == StepKind.DRIVE_DUTY for p in driven):
        return None
    volts = np.zeros(timeline.count)
    for part in driven:
        if part.kind == StepKind.DRIVE_VOLTS:
            volts[part.slice] = part.level
        elif part.kind == StepKind.DRIVE_DUTY and supply is not None:
            rail = _filled(timeline.spread(supply.values), timeline.parts)
            volts[part.slice] = part.level * rail[part.slice]
    return Sense(volts, *both, False, supply, 0.0)


def _filled(grid: Floats, parts: Sequence[Part]) -> Floats:
    """Lost readings replaced by the nearest ones under the same command."""
    if not np.isnan(grid).any():
        return grid
    grid = grid.copy()
    for part in parts:
        piece = grid[part.slice]
        known = np.flatnonzero(np.isfinite(piece))
        if len(known):
            piece[:] = np.interp(np.arange(len(piece)), known, piece[known])
        else:
            piece[:] = 0.0
    return grid


def refuse_discontinuous(capture: Capture, timeline: Timeline, inductance_h: float) -> None:
    """Raises DataError where duty times supply is not the motor's voltage.

    Without synchronous decay the current stops for part of the PWM period when its mean is below
    half the ripple, and the motor's voltage is then its own back-EMF.
    """
    channel, current = capture.get(VOLTAGE), capture.get(CURRENT)
    if channel is not None and channel.sense in (None, "terminals", "bridge"):
        return
    if current is None:
        return
    amperes = timeline.spread(current.values)
    supply = capture.get(SUPPLY)
    for part in timeline.parts:
        chopped = part.kind in (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)
        if not chopped or part.decay in (Decay.NONE, Decay.SYNCHRONOUS_SLOW):
            continue
        rail = float(np.nanmean(supply.values)) if supply else 0.0
        duty = abs(part.level) if part.kind == StepKind.DRIVE_DUTY else 0.5
        pwm = capture.wiring.pwm_hz or np.inf
        boundary = rail * duty * (1 - duty) / (2 * inductance_h * pwm)
        settled = amperes[part.start + (part.stop - part.start) // 2 : part.stop]
        if len(settled) and abs(float(np.nanmean(settled))) < boundary:
            raise DataError(
                f"duty times supply is not the motor's voltage: with {part.decay.name.lower()} "
                f"decay the current is discontinuous at level {part.level:g}; measure the voltage "
                "at the terminals, or drive with synchronous decay"
            )


def clamp_voltage(capture: Capture, sensed: Sense) -> float:
    """V that turns a freewheeling current off when the bridge opens: the supply and two diodes."""
    supply = capture.get(SUPPLY)
    if supply is not None and np.isfinite(supply.values).any():
        rail = float(np.nanmedian(supply.values))
    else:
        rail = float(np.nanmax(np.abs(sensed.volts)))
        levels = [
            abs(s.level)
            for s in (capture.program.steps if capture.program else ())
            if s.kind == StepKind.DRIVE_DUTY and s.level
        ]
        rail /= max(levels, default=1.0)
    return rail + DIODE_DROPS_V


def source_lines(
    sensed: Sense, current: Floats, parts: Sequence[Part], gaps: NDArray[np.bool_]
) -> tuple[Source | None, ...]:
    """The source of every part; ``current`` (count,) is the mean over the voltage's windows."""
    fits = [_rows(sensed.volts, current, part, gaps) for part in parts]
    usable = [f for f in fits if f is not None]
    if not usable:
        return tuple(None for _ in parts)
    spread = sum(float(((i - i.mean()) ** 2).sum()) for _, i in usable)
    cross = sum(float(((i - i.mean()) * (v - v.mean())).sum()) for v, i in usable)
    common = -cross / spread if spread > 0 else 0.0
    return tuple(
        None if f is None else _line(*f, common, spread / len(usable), sensed.resolution)
        for f in fits
    )


def _rows(
    volts: Floats, current: Floats, part: Part, gaps: NDArray[np.bool_]
) -> tuple[Floats, Floats] | None:
    if part.open or part.kind is None:
        return None
    inside = slice(part.start + SETTLING, part.stop)
    good = np.isfinite(current[inside]) & ~gaps[inside]
    if good.sum() < FEWEST:
        return None
    if good.all():
        return volts[inside], current[inside]
    return volts[inside][good], current[inside][good]


def _line(v: Floats, i: Floats, common: float, typical: float, resolution: float) -> Source | None:
    di = i - i.mean()
    own, ridge = float(di @ di), RIDGE * typical
    slope = (-float(di @ (v - v.mean())) + ridge * common) / (own + ridge) if own + ridge else 0.0
    slope = max(slope, 0.0)
    level = float(v.mean() + slope * i.mean())
    left = v - level + slope * i
    between = np.diff(left)
    noise = float(between @ between) / (2 * len(between))
    if float(left @ left) / len(left) > EXCESS * noise + resolution**2 / 12:
        return None
    return Source(level, slope, float(np.sqrt(noise)))
