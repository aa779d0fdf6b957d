"""When the voltage of an opened bridge is the back-EMF: once its diodes carry no current any more.

The winding's current flows on through them after the bridge has opened, for a time that grows with
L and with the current, and holds the terminals at the supply. A current that is measured shows when
it stops. The voltage's own window and filter must lie behind that too.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture, Channel
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.estimate.signals.voltage_window import Window

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]

SAMPLES = 3  # of an opened bridge, at least, whose voltage is not yet the back-EMF
LONG = 32  # samples of a part whose second half shows the current's zero
QUIET = 5.0  # robust deviations of that half: a current within them may have stopped
SIGMA = 1.4826  # of a normal distribution, in median absolute deviations
EMPTIED = 7.0  # time constants, at least, after which a filter holds nothing of what it held
FAINT = 0.1  # of a reading's noise: what it may still hold then


def emf_shows(capture: Capture, timeline: Timeline, volts: Channel) -> Bools:
    """Grid ticks (count,) whose reading of ``volts`` is of an open bridge without current."""
    window, current = Window.of(volts, timeline.period_s), capture.get(CURRENT)
    emptied = replace(window, delay_s=window.delay_s - window.filter_s + _emptied_s(volts))
    shows = np.zeros(timeline.count, dtype=bool)
    for part in timeline.parts:
        if part.open:
            late = SAMPLES + emptied.lag if part.start else 0
            if current is not None and part.start:
                late = max(late, _stopped(current, timeline, part, volts))
            shows[part.start + late : part.stop] = True
    return shows


def _stopped(current: Channel, timeline: Timeline, part: Part, volts: Channel) -> int:
    """Samples after which the voltage's reading lies behind the end of the current; 0: unclear."""
    shown = timeline.spread(current.values)[part.slice]
    resting = shown[len(shown) // 2 :]
    if len(shown) < LONG or np.isnan(resting).all():
        return 0
    zero = np.nanmedian(resting)
    spread = max(SIGMA * float(np.nanmedian(np.abs(resting - zero))), current.resolution)
    amperes, quiet_a = np.abs(shown - zero), QUIET * spread
    flows = amperes > quiet_a  # not where there is no reading
    first = next((n for n in range(len(flows) - SAMPLES) if not flows[n : n + SAMPLES].any()), 0)
    if not first:
        return 0
    hidden_s = _hidden_s(amperes[:first], quiet_a, current.window_s, timeline.period_s)
    after_s = _oldest_s(volts) + _emptied_s(volts) - _oldest_s(current) + hidden_s
    return first + max(0, math.ceil(after_s / timeline.period_s))


def _hidden_s(falling: Floats, quiet_a: float, window_s: float, period_s: float) -> float:
    """How long after its window began a reading within ``quiet_a`` may still have had a current.

    It goes on falling as steeply as from half its peak: a ramp that ends in the window has a mean
    of slope t²/2 over the window.
    """
    peak = float(np.nanmax(falling))
    half = int(np.flatnonzero(falling >= peak / 2)[-1])
    slope = peak / 2 / ((len(falling) - half) * period_s)
    if quiet_a > slope * window_s / 2:
        return quiet_a / slope + window_s / 2
    return math.sqrt(2.0 * quiet_a * window_s / slope)


def _emptied_s(volts: Channel) -> float:
    """How long a filter takes to forget the largest change of its voltage, but for noise."""
    if not volts.filter_s:
        return 0.0
    noise = max(volts.noise, volts.resolution / math.sqrt(12.0))
    span = float(np.nanmax(volts.values) - np.nanmin(volts.values))
    if not noise or not span:
        return EMPTIED * volts.filter_s
    return volts.filter_s * max(EMPTIED, math.log(span / (FAINT * noise)))


def _oldest_s(channel: Channel) -> float:
    """How long before its tick a reading's window begins."""
    return channel.delay_s + channel.window_s
