"""What drives the motor in the fit: the measured voltage, freed of its noise where that is honest.

While the command is constant a bridge is a source behind a resistance: the voltage at the sense
point is ``v0 - r i``. Where the measured voltage departs from that line by no more than its own
noise, the fit is given the line (v0 as the voltage, r in series), and so none of that noise. Where
v0 wanders (a supply that sags, a duty that follows it), the departure is added, smoothed over the
widest window that leaves nothing but noise behind; and reading by reading just after a step. Where
no window does, the fit is given the readings themselves.

Through which window a reading saw, and what of it belongs to the command before, is window.py's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import SUPPLY, VOLTAGE, Capture, Channel
from motorid.estimate.algebra import dot, square
from motorid.estimate.timeline import Part, Timeline
from motorid.estimate.waveform import JOINED, Shape, Waveform, of_log
from motorid.estimate.window import Window
from motorid.program import StepKind

Floats = NDArray[np.float64]

SAME = 1e-5  # relative change of a source that a fit need not follow
HEAD = 8  # samples after a command that are too few to smooth, and no line is drawn through
FEWEST = 24  # samples that a line needs
EXCESS = 1.3  # variance about the line, in units of that between neighbours, still called noise
ODD_HEAD = 2.5  # the same of the few samples after a step
BLOCKS, SLOW = 8, 28.0  # stretches of a part, and chi-square of their means: 1 in 2,000 by noise
ODD_SAMPLE = 3.5  # standard deviations from the line of one of them
FAINT = 0.02  # of a part's largest change of current: one that tells nothing of what it does
MOST_SHARE = 1.5  # of a reading's departure that its interval may have
DOUBT = 0.25  # of the departure that an interval is taken to have more or less than its reading
NEAR = 32  # samples that tell where the source was just before them
WINDOWS = (64, 32, 16, 8, 4)  # half-widths in samples


@dataclass(frozen=True)
class Sense:
    """The voltage (count,) at the sense point, and what lies between there and the terminals.

    ``filled`` (count,): intervals without a reading of their own, whose voltage is a neighbour's.
    """

    volts: Floats
    filled: NDArray[np.bool_]
    series_ohm: float  # to be taken off the fitted resistance
    series_uncertainty_ohm: float
    shows_emf: bool  # the same channel shows K w while the bridge is open
    channel: Channel | None
    resolution: float = 0.0
    window: Window | None = None  # of the readings; ``volts`` are at the intervals they describe
    commanded: bool = False  # volts by the program, or duty times the supply
    lost: Floats | float = 0.0  # V that the readings lack of the source, for its dead time
    waveform: Waveform | None = None  # of a log whose program is not known

    @property
    def gain_uncertainty(self) -> float:
        """Relative, of the voltage. A supply stays where it is, so that its offset counts too."""
        if self.channel is None:
            return 0.0
        gain = self.channel.gain_uncertainty
        if not self.commanded:
            return gain
        rail = float(np.nanmedian(np.abs(self.channel.values)))
        return math.hypot(gain, self.channel.offset_uncertainty / rail) if rail else gain


@dataclass(frozen=True)
class Source:
    """One part's source: its voltage (V, one for each interval) behind a resistance (ohm)."""

    volts: Floats
    ohms: float
    noise: float  # standard deviation of a reading about it
    head: int = 0  # first intervals that follow the readings themselves, noise and all
    tilt: Floats | float = 0.0  # V (n,) that one standard deviation of its slope would add
    errors: tuple[Floats, ...] = ()  # V (head,): independent ones of what the head follows
    as_read: bool = False  # all of it follows the readings

    def near(self, other: Source) -> bool:
        """The two would drive a motor alike."""
        scale = float(np.abs(self.volts).max()) + 1e-12
        apart = float(np.abs(self.volts - other.volts).max())
        return apart < SAME * scale and abs(self.ohms - other.ohms) <= 1e-3 * self.ohms + 1e-9


def sense(capture: Capture, timeline: Timeline, shape: Shape = JOINED) -> Sense | None:
    """Where the voltage comes from, or None when nothing tells it. ``shape``: of a log's."""
    wiring, channel = capture.wiring, capture.get(VOLTAGE)
    leads = wiring.lead_resistance_ohm, wiring.lead_resistance_uncertainty_ohm
    bridge = wiring.bridge_resistance_ohm, wiring.bridge_resistance_uncertainty_ohm
    both = leads[0] + bridge[0], float(np.hypot(leads[1], bridge[1]))
    if channel is not None and np.isfinite(channel.values).any():
        where = channel.sense or "terminals"
        series = {"terminals": (0.0, 0.0), "bridge": leads}.get(where, both)
        emf = where in ("terminals", "bridge")
        waveform = of_log(capture, channel, shape)
        if waveform is not None:
            volts, none = waveform.means(timeline), np.zeros(timeline.count, dtype=bool)
            return Sense(volts, none, *series, emf, channel, channel.resolution, waveform=waveform)
        window = Window.of(channel, timeline.period_s)
        readings = window.readings(timeline.spread(channel.values), timeline)
        volts = _filled(readings, timeline.parts)
        return Sense(volts, np.isnan(readings), *series, emf, channel, channel.resolution, window)
    return _from_command(capture, timeline, both)


def _from_command(
    capture: Capture, timeline: Timeline, series: tuple[float, float]
) -> Sense | None:
    """Duty times the measured supply, or volts as commanded."""
    supply = capture.get(SUPPLY)
    driven = [p for p in timeline.parts if p.kind is not None]
    if not driven:
        return None
    if supply is None and any(p.kind == StepKind.DRIVE_DUTY for p in driven):
        return None
    volts, none = np.zeros(timeline.count), np.zeros(timeline.count, dtype=bool)
    rail, shown, window = None, None, None
    if supply is not None:
        window = Window.of(supply, timeline.period_s)
        shown = timeline.spread(supply.values)
        rail = _filled(window.readings(shown, timeline), timeline.parts)
    for part in driven:
        if part.kind == StepKind.DRIVE_VOLTS:
            volts[part.slice] = part.level * _given(rail, shown, part)
        elif part.kind == StepKind.DRIVE_DUTY and rail is not None:
            volts[part.slice] = part.level * rail[part.slice]
    return Sense(volts, none, *series, False, supply, window=window, commanded=True)


def _given(rail: Floats | None, shown: Floats | None, part: Part) -> Floats | float:
    """Share (n,) of the commanded volts that a part gets: its duty follows what the supply showed
    at the sample before, so that a sag comes through until the next.
    """
    if rail is None or shown is None:
        return 1.0
    before = np.concatenate([shown[:1], shown])[part.slice]
    known = np.isfinite(before) & (before > 0.0)
    return np.where(known, rail[part.slice] / np.where(known, before, 1.0), 1.0)


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


def source_resistance(
    sensed: Sense,
    current: Floats,
    parts: Sequence[Part],
    lost: NDArray[np.bool_],
    prior: tuple[float, float],
) -> float:
    """Ohm behind which the voltage at the sense point changes as fast as the current does.

    From differences between neighbours, which what wanders slowly (a sagging supply) leaves alone.
    ``current`` (count,) is the model's mean over the voltage's windows.
    """
    weight = cross = noise = 0.0
    count = 0
    for part in parts:
        if part.discontinuous or not _drawn(part, current, lost):
            continue
        dv = np.diff((sensed.volts + sensed.lost)[part.slice])
        di = np.diff(current[part.slice])
        known = ~lost[part.slice]
        good = np.isfinite(dv) & np.isfinite(di) & known[1:] & known[:-1]
        weight += square(di[good])
        cross -= dot(di[good], dv[good])
        noise += square(dv[good][HEAD:])
        count += int(good[HEAD:].sum())
    if not count:
        return prior[0]
    precision = (noise / count + 1e-300) / prior[1] ** 2
    total = weight + precision
    return max((cross + precision * prior[0]) / total, 0.0) if total > 0 else prior[0]


def sources(
    sensed: Sense,
    current: Floats,
    parts: Sequence[Part],
    lost: NDArray[np.bool_],
    ohms: float,
    mean: Floats | None = None,
) -> tuple[Source | None, ...]:
    """The source of every part behind ``ohms``; ``current`` as in ``source_resistance``.

    ``mean`` (count,): the current over the intervals; None: they are the voltage's windows.
    """
    good = np.isfinite(current) & ~lost
    mean = current if mean is None else mean
    return tuple(
        _source(sensed, current, mean, good, part, ohms) if _drawn(part, current, lost) else None
        for part in parts
    )


def _drawn(part: Part, current: Floats, lost: NDArray[np.bool_]) -> bool:
    """Enough readings under a known command that connects the motor."""
    if part.open or part.kind is None:
        return False
    late = slice(part.start + HEAD, part.stop)
    return bool((np.isfinite(current[late]) & ~lost[late]).sum() >= FEWEST)


def _source(
    sensed: Sense, current: Floats, mean: Floats, good: NDArray[np.bool_], part: Part, ohms: float
) -> Source | None:
    known = np.flatnonzero(good[part.slice])
    lost = np.broadcast_to(sensed.lost, len(current))[part.slice]
    open_circuit = (sensed.volts + ohms * current)[part.slice] + lost
    open_circuit = np.interp(np.arange(len(open_circuit)), known, open_circuit[known])
    level = float(open_circuit[HEAD:].mean())
    left = open_circuit - level
    between = np.diff(left[HEAD:])
    noise = square(between) / (2 * len(between))
    slope, flow, deviation = _slope(left, current[part.slice], noise)
    sag = slope * flow
    allowed = EXCESS * noise + sensed.resolution**2 / 12
    curve, head, quiet = _trend(left - sag, noise, allowed)
    if sensed.commanded and not quiet:  # it is what the dead time takes that jumps
        return None
    volts = level + sag + curve - lost
    steady = curve[:head] + _sure(slope, deviation) * flow[:head]
    departure = left[:head] - steady
    share = _shares(current, mean, known, part)[:head]
    if part.discontinuous:  # every period begins anew: nothing of it builds up with the current
        share = np.ones(head)
    volts[:head] = level + steady + share * departure - lost[:head]
    errors = _head_errors(known, share, departure, float(np.sqrt(noise)))
    tilt = deviation * flow
    return Source(volts, ohms, float(np.sqrt(noise)), head, tilt, errors, as_read=not quiet)


def _sure(slope: float, deviation: float) -> float:
    """The slope as far as it is more than noise: the head lies far from what told it."""
    return slope * max(1.0 - (deviation / slope) ** 2, 0.0) if slope else 0.0


def _shares(current: Floats, mean: Floats, known: NDArray[np.intp], part: Part) -> Floats:
    """Of a reading's departure from the line, what its interval has of it, (HEAD,).

    A supply gives way by the current, which has only begun to flow at a command: in the first
    interval it has sagged less than in a window at that interval's end, or than in the next
    interval, whose reading stands for a first one that shows the command before.
    """
    here = slice(part.start, part.start + HEAD)
    at_command = float(np.nan_to_num(mean[part.start - 1])) if part.start else 0.0
    seen = np.interp(np.arange(HEAD), known, current[part.slice][known]) - at_command
    grown = np.nan_to_num(mean[here]) - at_command
    tells = np.abs(seen) > FAINT * np.abs(seen).max()
    return np.clip(np.where(tells, grown, 1.0) / np.where(tells, seen, 1.0), 0.0, MOST_SHARE)


def _head_errors(
    known: NDArray[np.intp], share: Floats, departure: Floats, noise: float
) -> tuple[Floats, ...]:
    """V (head,): the noise of every reading that the head follows, and the doubt of its shares."""
    place = np.arange(len(share))
    own = known[: int(np.searchsorted(known, len(share))) + 1]
    reach = [np.interp(place, own, unit) for unit in np.eye(len(own))]
    return (*(noise * share * one for one in reach), DOUBT * (share - 1.0) * departure)


def _slope(left: Floats, current: Floats, noise: float) -> tuple[float, Floats, float]:
    """How the source follows the current after the head, the current about its mean (n,), and the
    standard deviation of that slope.

    A supply gives way more slowly than a bridge, and the bridge's resistance is known only so well.
    """
    flow = np.nan_to_num(current - np.nanmean(current[HEAD:]))
    weight = square(flow[HEAD:])
    if weight == 0.0:
        return 0.0, flow, 0.0
    return dot(flow[HEAD:], left[HEAD:]) / weight, flow, float(np.sqrt(noise / weight))


def _trend(left: Floats, noise: float, allowed: float) -> tuple[Floats, int, bool]:
    """What the source does beyond its line, (n,), how many samples of the head depart from it, and
    whether that is free of noise. It is as read when no window leaves only noise behind.
    """
    late = left[HEAD:]
    trend = np.zeros_like(left)
    quiet = True
    if square(late) / len(late) > allowed or _slow(late) > SLOW * noise:
        quiet = _wanders(late, allowed, trend[HEAD:])
        if not quiet:
            trend[HEAD:] = late
        trend[:HEAD] = _carried_back(late)
    odd = left[:HEAD] - trend[:HEAD]
    out = np.flatnonzero(np.abs(odd) > ODD_SAMPLE * np.sqrt(noise))
    head = int(out[-1]) + 1 if len(out) else 0
    if square(odd[head:]) > ODD_HEAD * noise * len(odd):
        head = HEAD
    return trend, head, quiet


def _slow(late: Floats) -> float:
    """Sum of squares of the means of BLOCKS stretches, times their length: noise alone has BLOCKS
    times its variance.
    """
    length = len(late) // BLOCKS
    sums: Floats = late[: BLOCKS * length].reshape(BLOCKS, length) @ np.ones(length)
    return square(sums) / max(length, 1)


def _wanders(late: Floats, allowed: float, trend: Floats) -> bool:
    """Writes the smoothest curve that leaves only noise; False when there is none."""
    for half in WINDOWS:
        if 4 * half > len(late):
            continue
        trend[:] = smoothed(late, half)
        rest = late - trend
        if square(rest) / len(rest) <= allowed:
            return True
    return False


def _carried_back(late: Floats) -> Floats:
    """The head (HEAD,) on the straight line through the samples that follow it."""
    near = late[:NEAR]
    place: Floats = np.arange(len(near), dtype=np.float64) - (len(near) - 1) / 2
    slope = dot(place, near) / square(place)
    return np.asarray(near.mean() + slope * (np.arange(-HEAD, 0) - (len(near) - 1) / 2))


def smoothed(values: Floats, half: int) -> Floats:
    """Mean over ``half`` samples on either side, fewer at the ends."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    place = np.arange(len(values))
    low, high = np.maximum(place - half, 0), np.minimum(place + half + 1, len(values))
    return np.asarray((total[high] - total[low]) / (high - low))
