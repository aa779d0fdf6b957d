"""Where the voltage of a capture was sensed, or by what it was commanded, on the fit's timeline.

Through which window a reading saw, and what of it belongs to the command before, is window.py's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import SUPPLY, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.signals.intersample_voltage import JOINED, Shape, Waveform, of_log
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.estimate.signals.voltage_window import Window
from motorid.program import StepKind

Floats = NDArray[np.float64]

LINEARITY = 0.5  # of a converter's step: how far a level lies off the straight line of its gain


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
    lost: Floats | float = 0.0  # V that the intervals lack of the source, for its dead time
    lost_shown: Floats | float = 0.0  # the same of the readings
    waveform: Waveform | None = None  # of a log whose program is not known

    @property
    def noise(self) -> float:
        """V, of one reading, as the channel declares it, rounding and all; 0: it does not."""
        channel = self.channel
        if channel is None or not channel.noise:
            return 0.0
        return math.hypot(channel.noise, channel.resolution / math.sqrt(12.0))

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

    @property
    def level_uncertainty(self) -> float:
        """V, standard, of a level however often it is read: its converter rounds, and leaves a
        straight line by about as much. Levels made of one supply share its error, as a gain.
        """
        return 0.0 if self.commanded or self.channel is None else LINEARITY * self.resolution


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
            series = series[0] + waveform.ohms, series[1]
            return Sense(volts, none, *series, emf, channel, channel.resolution, waveform=waveform)
        window = Window.of(channel, timeline.period_s)
        readings = window.readings(timeline.spread(channel.values), timeline)
        _refuse_hidden(window, readings, timeline.parts)
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
        readings = window.readings(shown, timeline)
        _refuse_hidden(window, readings, timeline.parts)
        rail = _filled(readings, timeline.parts)
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


def _refuse_hidden(window: Window, readings: Floats, parts: Sequence[Part]) -> None:
    """No step that drives lasts as long as a filter of the voltage remembers: nothing shows it."""
    driven = [part for part in parts if part.level]
    if driven and window.filter_s and all(np.isnan(readings[p.slice]).all() for p in driven):
        longest_s = max(p.stop - p.start for p in driven) * window.period_s
        raise DataError(
            f"the voltage's low-pass of {1e3 * window.filter_s:.3g} ms outlasts every step that "
            f"drives the motor, of {1e3 * longest_s:.3g} ms at most: take a smaller capacitor or "
            "longer steps"
        )


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
