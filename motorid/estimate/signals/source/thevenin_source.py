"""What drives the motor in the fit: the measured voltage, freed of its noise where that is honest.

While the command is constant a bridge is a source behind a resistance: the voltage at the sense
point is ``v0 - r i``. Where the measured voltage departs from that line by no more than its own
noise, the fit is given the line (v0 as the voltage, r in series), and so none of that noise. Where
v0 wanders (a supply that sags, a duty that follows it), the departure is added, smoothed over the
widest window that leaves nothing but noise behind; and reading by reading just after a step. Where
no window does, the fit is given the readings themselves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.source.smoothing import PLAIN, Form, trend_of
from motorid.estimate.signals.source.step_transient import HEAD, head_errors, shares
from motorid.estimate.signals.source.supply_sag import NO_SAG, NO_SAGS, Sag
from motorid.estimate.signals.time_grid import Part
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.estimate.solver.dense_products import dot, square

Floats = NDArray[np.float64]

FEWEST = 24  # samples that a line needs
EXCESS = 1.3  # variance about the line, in units of that between neighbours, still called noise


@dataclass(frozen=True)
class Source:
    """One part's source: its voltage (V, one for each interval) behind a resistance (ohm)."""

    volts: Floats
    ohms: float
    noise: float  # standard deviation of a reading about it
    form: Form = PLAIN
    tilt: Floats | float = 0.0  # V (n,) that one standard deviation of its slope would add
    errors: tuple[Floats, ...] = ()  # V (head,): independent ones of what the head follows

    @property
    def as_read(self) -> bool:
        """All of it follows the readings, noise and all."""
        return not self.form.quiet


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
        dv = np.diff((sensed.volts + sensed.lost_shown)[part.slice])
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
    sags: Mapping[int, Sag] = NO_SAGS,
    before: Sequence[Source | None] | None = None,
) -> tuple[Source | None, ...]:
    """The source of every part behind ``ohms``; ``current`` as in ``source_resistance``.

    ``mean`` (count,): the current over the intervals; None: they are the voltage's windows.
    ``sags``: what the supply takes from some of them. ``before``: sources whose forms are kept,
    None: the data decide.
    """
    forms = [None] * len(parts) if before is None else [s.form if s else None for s in before]
    good = np.isfinite(current) & ~lost
    mean = current if mean is None else mean
    return tuple(
        _source(sensed, current, mean, good, part, ohms, sags.get(k, NO_SAG), forms[k])
        if _drawn(part, current, lost) and (before is None or before[k] is not None)
        else None
        for k, part in enumerate(parts)
    )


def _drawn(part: Part, current: Floats, lost: NDArray[np.bool_]) -> bool:
    """Enough readings under a known command that connects the motor."""
    if part.open or part.kind is None:
        return False
    late = slice(part.start + HEAD, part.stop)
    return bool((np.isfinite(current[late]) & ~lost[late]).sum() >= FEWEST)


def _source(
    sensed: Sense,
    current: Floats,
    mean: Floats,
    good: NDArray[np.bool_],
    part: Part,
    ohms: float,
    sag: Sag,
    form: Form | None,
) -> Source | None:
    known = np.flatnonzero(good[part.slice])
    lost = np.broadcast_to(sensed.lost, len(current))[part.slice]
    open_circuit = (sensed.volts + sensed.lost_shown + ohms * current)[part.slice] - sag.shown
    open_circuit = np.interp(np.arange(len(open_circuit)), known, open_circuit[known])
    seen = np.interp(np.arange(len(open_circuit)), known, current[part.slice][known])
    level = float(open_circuit[HEAD:].mean())
    left = open_circuit - level
    between = np.diff(left[HEAD:])
    noise = square(between) / (2 * len(between))
    slope, flow, deviation = _slope(left, seen, noise)
    if part.discontinuous:  # its current follows the source without delay: it would follow itself
        slope = deviation = 0.0
    allowed = EXCESS * noise + sensed.resolution**2 / 12
    curve, form = trend_of(left - slope * flow, noise, allowed, sensed.noise**2, form)
    if part.discontinuous and not form.quiet:
        form = replace(form, head=HEAD)  # nothing builds up: a line would follow its own current
    head, quiet = form.head, form.quiet
    if sensed.commanded and not quiet:  # it is what the dead time takes that jumps
        return None
    own = flow
    if not part.discontinuous:  # there every period begins anew: nothing builds up with the current
        own = flow + np.nan_to_num(mean[part.slice] - seen)  # over intervals, not windows
    volts = level + slope * own + curve - lost
    sure = _sure(slope, deviation)
    departure = left[:head] - curve[:head] - sure * flow[:head]
    share = shares(current, mean, known, part)[:head]
    if part.discontinuous:
        share = np.ones(head)
        if _runs_out(mean, part):
            share[:1] = 0.0  # that reading shows the supply reversed for as long as it does
    volts[:head] = level + curve[:head] + sure * own[:head] + share * departure - lost[:head]
    volts += sag.taken
    own_noise = float(np.sqrt(noise if quiet else min(noise, sensed.noise**2 or noise)))
    errors = head_errors(known, share, departure, own_noise)
    tilt = deviation * flow
    return Source(volts, ohms, float(np.sqrt(noise)), form, tilt, errors)


def _runs_out(mean: Floats, part: Part) -> bool:
    """The part before leaves it a current (A) that is more than its own, and ends in the diodes."""
    before = float(abs(mean[part.start - 1])) if part.start else 0.0
    return before > float(np.nanmedian(np.abs(mean[part.slice])))


def _sure(slope: float, deviation: float) -> float:
    """The slope as far as it is more than noise: the head lies far from what told it."""
    return slope * max(1.0 - (deviation / slope) ** 2, 0.0) if slope else 0.0


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
