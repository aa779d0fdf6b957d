"""Single readings that stand alone: bit errors, loose contacts, sparks in a sensor's leads.

A spike leaves its neighbours and is back at the next reading. No motor does that within a sample,
but where its bridge is switched: an inductance that empties itself through the diodes takes the
voltage to the other rail and back. A fit does well without such readings, and badly with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.fault import short
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.neighbour_noise import running_median

Floats = NDArray[np.float64]

SCATTER = 20.0  # times the usual bend between neighbours
STEPS = 8.0  # of the converter, or counts, at least
ROUNDING = 1e-6  # of all that a channel spans: of readings without noise
SPAN, BULK = 0.03, (1.0, 99.0)  # of what most readings span, in per cent of them: less is noise
BACK = 0.25  # of a spike: its neighbours differ by less
AROUND = 5  # steps on either side, whose median is the motion's
EDGE = 8  # samples about a step of the program, in which a reading may stand alone
MOST = 0.02  # of the readings: more is no rare error
CHANNELS = (CURRENT, SPEED, POSITION, VOLTAGE)


def removed(captures: Sequence[Capture]) -> tuple[list[Capture], tuple[Suspect, ...]]:
    """The captures of a program without their spikes, and what is said of those; logs as they are,
    whose drop-outs their fit looks for.
    """
    out, said = [], []
    for k, capture in enumerate(captures):
        where = f" in run {k + 1}" if len(captures) > 1 else ""
        cleared = dict(capture.channels)
        for name in CHANNELS:
            places = find(capture, name)
            if len(places):
                said.append(_said(short(name), capture.channels[name], places, where))
                cleared[name] = without(capture.channels[name], places)
        spiked = any(cleared[n] is not capture.channels[n] for n in cleared)
        out.append(replace(capture, channels=cleared) if spiked else capture)
    return out, tuple(said)


def find(capture: Capture, name: str) -> NDArray[np.intp]:
    """Places of a channel's spikes; empty of more than are rare."""
    channel, none = capture.get(name), np.zeros(0, dtype=np.intp)
    if channel is None or capture.program is None or len(capture) < 4 * AROUND:
        return none
    steps = np.diff(channel.values)
    if name == POSITION:  # one that turns: lost counts do not come back
        steps = steps - running_median(steps, AROUND)
    alone = np.minimum(np.abs(steps[:-1]), np.abs(steps[1:]))
    with np.errstate(invalid="ignore"):
        back = np.abs(steps[:-1] + steps[1:]) < BACK * alone
        found = np.flatnonzero((alone > _least(channel, name, steps)) & back) + 1
    begins = np.searchsorted(capture.ticks, [phase.tick for phase in capture.phases])
    beside = np.abs(found[:, None] - begins[None, :]).min(axis=1, initial=len(capture))
    found = found[beside > EDGE]
    return found if len(found) <= MOST * len(capture) else none


def _least(channel: Channel, name: str, steps: Floats) -> float:
    """By how much (SI) a reading stands alone."""
    bend, known = np.abs(np.diff(steps)), channel.values[np.isfinite(channel.values)]
    if not len(known):
        return np.inf
    usual = float(np.median(bend[np.isfinite(bend)])) if np.isfinite(bend).any() else 0.0
    span = ROUNDING * float(np.ptp(known))
    if name != POSITION:  # which is exact, and goes on and on
        span = SPAN * float(np.ptp(np.percentile(known, BULK)))
    return max(SCATTER * usual, STEPS * channel.resolution, span)


def without(channel: Channel, places: NDArray[np.intp] | NDArray[np.bool_]) -> Channel:
    """The channel with no readings at some places."""
    raw = np.array(channel.raw, dtype=np.float64)
    raw[places] = np.nan
    return replace(channel, raw=raw)


def _said(word: str, channel: Channel, places: NDArray[np.intp], where: str) -> Suspect:
    values = channel.values
    off = np.abs(values[places] - 0.5 * (values[places - 1] + values[places + 1]))
    count = f"{len(places)} readings" if len(places) > 1 else "one reading"
    evidence = (
        f"{count} of the {word}{where} stand alone, off their neighbours by up to "
        f"{off.max():.3g} {channel.unit}; the fit leaves them out"
    )
    action = "look for a loose contact, for bit errors of the line, or for sparks in its leads"
    return Suspect("spikes", word, evidence, action, "named", allowed=True)


def behind(found: Sequence[Suspect], spiked: Sequence[Suspect]) -> tuple[Suspect, ...]:
    """Spikes, which are left out, stand behind what else is named."""
    if not spiked:
        return tuple(found)
    named = [one for one in found if one.strength == "named"]
    return (*named, *spiked, *(one for one in found if one not in named))
