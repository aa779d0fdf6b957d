"""The voltage of somebody else's log: readings at stamps, whatever the motor had in between.

Nobody says whether the voltage went straight from a reading to the next, was a smooth curve, or was
held until then (a controller's output), or whether a reading is the mean since the one before, of
a level or of a curve, nor by how much its stamps are off those of the other channels. The first is
tried in each way, the second is an unknown of the fit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel
from motorid.estimate.signals import curved_means, jumps_in_means
from motorid.estimate.signals.log_source import source
from motorid.estimate.signals.time_grid import IRREGULAR, Timeline
from motorid.estimate.signals.voltage_jumps import jumps, least_jump
from motorid.estimate.signals.voltage_smoothing import Windows, calm_windows, smoothed

Floats = NDArray[np.float64]
Shape = Literal[
    "joined", "curved", "held", "broken", "loose", "means", "curved means", "sourced",
    "loose source",
]  # fmt: skip

JOINED: Shape = "joined"
BROKEN: Shape = "broken"  # joined, but for jumps, before which a reading is held
LOOSE: Shape = "loose"  # the same, and no stamp says when in its sample the voltage jumped
SOURCED: Shape = "sourced"  # broken, of a source whose resistance the current shows
LOOSE_SOURCE: Shape = "loose source"  # of such a source, and no stamp says when it jumped
MEANS: Shape = "means"  # each over the time since the one before, of a level
CURVED_MEANS: Shape = "curved means"  # the same of a voltage that moves in that time
SHORTEST = 0.1  # usual periods: two readings that lie closer tell no slope
RAMP = 1e-4  # usual periods within which a jump is done, on either side of its time
LOOSE_RAMP = 5e-3  # the same where no stamp tells that time: readings tell it no better
REMEMBERED = 3  # means of it, of a search
MISSING = 1.5  # usual periods between two readings, of which none is missing
OFTEN, MOST_JUMPS = 0.5, 200  # share of stamps that makes a log irregular; unknowns for its jumps
SHAPES: tuple[Shape, ...] = ("joined", "curved", "held", BROKEN, SOURCED, MEANS)  # of a log
CONTINUOUS: tuple[Shape, ...] = (JOINED, "curved")  # that do not jump between two readings
UNTIMED: tuple[Shape, ...] = (LOOSE, LOOSE_SOURCE)  # that jump at moments which are unknowns
OF_SOURCE: tuple[Shape, ...] = (SOURCED, LOOSE_SOURCE)
LEVEL: tuple[Shape, ...] = ("held", MEANS)  # that stay between two moments
OF_MEANS: tuple[Shape, ...] = (MEANS, CURVED_MEANS)


@dataclass(frozen=True)
class Waveform:
    """Readings (n,) in V at ``time_s`` (n,) from the first tick; ``period_s`` is the usual one.

    ``shape``: they are joined by straight lines, or by a spline; or each is held until the next; or
    (broken) they are joined but where the voltage jumps, at its stamp or (loose) before it. Means
    are levels, or (curved means) those of parabolas, which begin at ``time_s``. ``window_s``: of a
    mean, as declared; 0: nobody says so. A source lies ``ohms`` before the terminals; else 0.
    ``windows``: over which readings were freed of noise; None: they were not.
    ``filter_s``: first, and ``filter_s2`` second time constant of the declared low-pass that they
    passed, 1/(1 + filter_s s + filter_s2 s²); s and s².
    """

    time_s: Floats
    volts: Floats
    shape: Shape
    period_s: float
    filter_s: float = 0.0
    filter_s2: float = 0.0
    window_s: float = 0.0
    ohms: float = 0.0
    windows: Windows | None = None

    def means(
        self,
        timeline: Timeline,
        late_s: float = 0.0,
        early: Sequence[float] = (),
        filter_s: float = 0.0,
        second_s2: float = 0.0,
    ) -> Floats:
        """Means (count,) over the grid's intervals, if what was logged came ``late_s`` later, and
        was what it is before a low-pass whose coefficients are ``filter_s`` (0 or more) and
        ``second_s2`` above the declared ones.

        ``early``: of every jump, the share of the time since the reading before that it came before
        its own.
        """
        grid = timeline.count, timeline.period_s
        return self._remembered(*grid, late_s, tuple(early), filter_s, second_s2)

    @cached_property
    def _remembered(self) -> Callable[..., Floats]:
        """``_means``: most derivatives of a fit leave the last as they are."""
        return lru_cache(maxsize=REMEMBERED)(self._means)

    def _means(
        self,
        count: int,
        period_s: float,
        late_s: float,
        early: tuple[float, ...],
        filter_s: float,
        second_s2: float,
    ) -> Floats:
        edges = np.arange(-1.0, count) * period_s - late_s
        filter_s, second_s2 = filter_s + self.filter_s, second_s2 + self.filter_s2
        moved = self._with_jumps(early) if any(early) else self
        straight = self.shape not in LEVEL or second_s2
        if filter_s and not straight:
            moved = replace(moved, volts=self._before_filter(filter_s))
        within = moved.within(edges)
        flux = moved._flux(within)
        if filter_s and straight:  # v + filter_s dv/dt + filter_s2 d²v/dt²
            volts = moved._value(within)
            flux = flux + filter_s * volts
            if second_s2:
                flux = flux + second_s2 * np.gradient(volts, period_s)
        return np.asarray(np.diff(flux) / period_s)

    def _before_filter(self, filter_s: float) -> Floats:
        """V (n,) held between readings, if each shows what a low-pass made of it by then."""
        steps = np.maximum(np.diff(self.time_s), SHORTEST * self.period_s)
        before = self.volts.copy()
        with np.errstate(over="ignore"):  # a time constant of next to nothing changes nothing
            before[1:] += np.diff(self.volts) / np.expm1(steps / filter_s)
        return before

    @cached_property
    def steps_off(self) -> NDArray[np.intp]:
        """Readings before which the voltage jumped, whichever shape it has."""
        return jumps(self.volts)

    @cached_property
    def wanders(self) -> bool:
        """Between its jumps the voltage moves as well, as behind a resistance or of an open motor.

        Where it does not, readings that are joined only mean their noise, which looks likelier.
        """
        least = least_jump(self.volts)
        return any(np.ptp(piece) > least for piece in np.split(self.volts, self.steps_off))

    @cached_property
    def jumps(self) -> NDArray[np.intp]:
        """Readings before which the voltage jumped at a moment that no stamp tells."""
        if self.shape in (*CONTINUOUS, *OF_MEANS):
            return np.zeros(0, dtype=np.intp)
        found, steps = self.steps_off - 1, np.diff(self.time_s)
        rises = np.abs(np.diff(self.volts))
        if self.shape not in UNTIMED:
            loose = np.abs(steps / self.period_s - 1.0) > IRREGULAR
            found = found[loose[found] | (np.mean(loose) > OFTEN)]
        largest = found[np.argsort(-(rises * steps)[found])[:MOST_JUMPS]]
        return np.asarray(np.sort(largest) + 1, dtype=np.intp)

    def _with_jumps(self, early: Sequence[float]) -> Waveform:
        time = self.time_s.copy()
        time[self.jumps] -= np.asarray(early) * (time[self.jumps] - self.time_s[self.jumps - 1])
        moved = replace(self, time_s=time)
        vars(moved).update(steps_off=self.steps_off, wanders=self.wanders)  # no time is in them
        return moved

    def within(self, grid_s: Floats) -> Moments:
        """The moments of a grid; those outside the log are moved to its ends."""
        at_s = np.clip(grid_s, self.time_s[0], self.time_s[-1])
        first = np.searchsorted(at_s, self.time_s)
        return Moments(grid_s, at_s, np.diff(first, append=len(at_s)))

    def _flux(self, within: Moments) -> Floats:
        """Integral (V·s) up to the grid's times; before and after the log the voltage stays."""
        flux = self._integral(within)
        first, last = self.time_s[0], self.time_s[-1]
        grid_s = within.grid_s
        begins, ends = np.searchsorted(grid_s, first), np.searchsorted(grid_s, last, side="right")
        flux[:begins] += (grid_s[:begins] - first) * self.volts[0]
        flux[ends:] += (grid_s[ends:] - last) * self.volts[-1]
        self._add_ramps(flux, within.at_s)
        return flux

    def _add_ramps(self, flux: Floats, at_s: Floats) -> None:
        """V·s more at times, since no jump takes no time: it is a ramp about its moment.

        Jumps that lie at the stamps of the current would give the likelihood of their lag a corner,
        at which no derivative holds.
        """
        if self.shape == "curved":
            return
        half = (LOOSE_RAMP if self.shape in UNTIMED else RAMP) * self.period_s
        steps = np.diff(self.time_s)
        starts, slopes, bends = self._courses
        rises = np.concatenate([[0.0], np.diff(starts) - slopes[:-1] * steps])
        if bends is not None:
            rises[1:] -= bends[:-1] * steps**2
        begins = np.searchsorted(at_s, self.time_s - half)
        many = np.searchsorted(at_s, self.time_s + half, side="right") - begins
        some = np.repeat(begins - np.cumsum(many) + many, many) + np.arange(many.sum())
        near = np.searchsorted(self.time_s[1:] - steps / 2, at_s[some], side="right")
        left = np.maximum(half - np.abs(at_s[some] - self.time_s[near]), 0.0)
        flux[some] += rises[near] * left**2 / (4.0 * half)

    @cached_property
    def _value(self) -> Callable[[Moments], Floats]:
        """V at times within the log, of a shape that does not stay between two moments."""
        if self.shape == "curved":
            from scipy.interpolate import CubicSpline

            curve = CubicSpline(self.time_s, self.volts)
            return lambda within: np.asarray(curve(within.at_s), dtype=np.float64)
        starts, slopes, bends = self._courses

        def value(within: Moments) -> Floats:
            past = within.at_s - within.each(self.time_s)
            volts = within.each(starts) + within.each(slopes) * past
            return volts if bends is None else volts + within.each(bends) * past**2

        return value

    @cached_property
    def _courses(self) -> tuple[Floats, Floats, Floats | None]:
        """V, V/s and V/s² (n,) from each reading on, until the next; the last None: all are 0."""
        if self.shape != CURVED_MEANS:
            return self.volts, self._slopes, None
        return curved_means.parabolas(self.time_s, self.volts, SHORTEST * self.period_s)

    @cached_property
    def _slopes(self) -> Floats:
        """V/s (n,) after each reading, until the next; after the last the voltage stays."""
        steps = np.maximum(np.diff(self.time_s), SHORTEST * self.period_s)
        slopes = np.append(np.diff(self.volts) / steps, 0.0)
        if self.shape in LEVEL or (self.shape in UNTIMED and not self.wanders):
            slopes[:] = 0.0
        elif self.shape != JOINED:
            slopes[self.steps_off - 1] = 0.0
        return slopes

    @cached_property
    def _integral(self) -> Callable[[Moments], Floats]:
        """Integral (V·s) from the first stamp to times within the log."""
        time, volts = self.time_s, self.volts
        if self.shape == "curved":
            from scipy.interpolate import CubicSpline

            flux = CubicSpline(time, volts).antiderivative()
            return lambda within: np.asarray(flux(within.at_s), dtype=np.float64)
        steps, (starts, slopes, bends) = np.diff(time), self._courses
        more = 0.0 if bends is None else bends[:-1] * steps**2 / 3
        rises = steps * (starts[:-1] + slopes[:-1] * steps / 2 + more)
        total = np.concatenate([[0.0], np.cumsum(rises)])

        def so_far(within: Moments) -> Floats:
            past = within.at_s - within.each(time)
            flux = within.each(slopes)  # total + past (starts + past / 2 (slopes + ..)), in place
            if bends is not None:
                flux += within.each(bends) * past * (2.0 / 3.0)
            for factor, more in ((past / 2, starts), (past, total)):
                flux *= factor
                flux += within.each(more)
            return flux

        return so_far


@dataclass(frozen=True)
class Moments:
    """Times (m,) of a grid, in order: ``grid_s``, ``at_s`` within a log, and how many of those are
    ``following`` each of its stamps (n,) until the next.
    """

    grid_s: Floats
    at_s: Floats
    following: NDArray[np.intp]

    def each(self, values: Floats) -> Floats:
        """Values (m,) of (n,) that belong to the stamps."""
        return np.repeat(values, self.following)


@dataclass(frozen=True)
class Rival:
    """An answer (p,) under another shape of the voltage, or with ``friction`` of another kind: its
    values, and the objective by which it is the less likely. ``late_s``: by how much the voltage
    comes later there; NaN: it has no lag.
    """

    values: Floats
    behind: float
    late_s: float = math.nan
    friction: bool = False


def of_log(
    capture: Capture, channel: Channel, shape: Shape, windows: Windows | None = None
) -> Waveform | None:
    """The waveform of a capture without a program. Declared means have no shape but of means.

    ``windows``: over which means are freed of noise; None: as they are found to be calm.
    """
    known = np.isfinite(channel.values)
    if (capture.program is not None and capture.phases) or known.sum() < 2:
        return None
    aperture = channel.window_s
    averaged = aperture > capture.period_s / 2
    if averaged or shape in OF_MEANS:
        found = _of_means(capture, channel, aperture if averaged else 0.0, windows)
        return replace(found, shape=shape) if shape == CURVED_MEANS else found
    filter_s = min(channel.filter_delay_s, channel.delay_s)
    stamps = capture.time_s[known] - (channel.delay_s - filter_s) - aperture / 2
    second = channel.filter_s**2 if channel.filter_order == 2 else 0.0
    read = Waveform(stamps, channel.values[known], shape, capture.period_s, filter_s, second)
    current = capture.get(CURRENT) if shape in OF_SOURCE else None
    if current is None:
        return _quieted(read)
    ohms, steps = source(read.volts, current.values[known])
    drops = ohms * np.nan_to_num(current.values[known])
    behind = _quieted(replace(read, volts=read.volts + drops, ohms=ohms))
    vars(behind).update(steps_off=steps)  # smaller ones than those of the terminals
    return behind


def source_ohms_of(capture: Capture) -> float:
    """Ohm before the terminals of a log that shows them; 0: it shows none."""
    channel = capture.get(VOLTAGE)
    found = of_log(capture, channel, SOURCED) if channel is not None else None
    return found.ohms if found is not None else 0.0


def _quieted(read: Waveform) -> Waveform:
    """Freed of noise, over windows that it keeps."""
    windows = calm_windows(read.volts)
    return replace(read, volts=smoothed(read.volts, windows), windows=windows)


def _of_means(
    capture: Capture, channel: Channel, window_s: float, windows: Windows | None
) -> Waveform:
    """Readings that are means over the time since the one before each; after a reading that is
    missing, over the channel's own window. Where it jumped in that time, its mean says when.
    """
    known = np.isfinite(channel.values)
    ends = capture.time_s[known] - channel.delay_s
    since = np.diff(ends, prepend=ends[0] - (window_s or capture.period_s))
    usual = window_s or capture.period_s
    begun = ends - np.where(since < MISSING * capture.period_s, since, usual)
    volts = channel.values[known]
    windows = windows or calm_windows(volts)
    begun, levels = jumps_in_means.split(begun, ends, volts, smoothed(volts, windows))
    return Waveform(begun, levels, MEANS, capture.period_s, window_s=window_s, windows=windows)
