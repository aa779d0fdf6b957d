"""A capture laid on the uniform grid that the response model walks along.

Interval n ends at grid tick n. A step that begins at tick t governs the intervals after it. Lost
samples keep their place on the grid and carry no reading. The grid of a log, whose voltage changed
when it liked and whose stamps may be irregular, is several times finer than its samples, which lie
between two ticks, and finer still where that voltage jumps; but not where every reading of the
voltage is the mean of a level since the one before.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import VOLTAGE, Capture
from motorid.errors import DataError
from motorid.estimate.signals import jumps_in_means
from motorid.estimate.signals.voltage_jumps import jumps
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]

JITTER = 0.25  # of a period, by which a time stamp may miss the grid
LARGEST_LOSS = 4.0  # grid ticks for one sample
IRREGULAR = 0.02  # of a period, beyond which a log's stamps are called so
FINER, QUICK = 4, 5.0  # ticks in a usual period of a log; percentile of periods that has two
FINEST, JUMPED_TICKS = 10, 64_000  # the same where the voltage jumps, in so many ticks altogether
ON_TICK = 1e-6  # of a grid period
MOST_TICKS = 400_000
TICKS_PER_SAMPLE = 100  # of a log, on average: the work that a reading may cost
FINER_GRID = "finer grid"  # provenance: how many times finer than usual a fit asks for a log's


@dataclass(frozen=True)
class Part:
    """Intervals ``start`` to ``stop`` (exclusive) under one command of the program.

    ``kind`` None: no program is known, and the motor is taken to be connected throughout.
    ``discontinuous``: the current stops within every PWM period. ``still``: the rotor stands.
    """

    start: int
    stop: int
    kind: StepKind | None = None
    level: float = 0.0
    decay: Decay = Decay.NONE
    discontinuous: bool = False
    still: bool = False

    @property
    def open(self) -> bool:
        """The bridge is open."""
        return self.kind == StepKind.COAST

    @property
    def slice(self) -> slice:
        """The part's intervals, which are also the readings that end in it."""
        return slice(self.start, self.stop)


@dataclass(frozen=True)
class Timeline:
    """``count`` grid ticks, one each ``period_s``; sample k of the capture sits on ``index[k]``.

    ``past`` (samples,): share of a period by which a sample lies after its tick; None: none does.
    ``lost`` samples are missing. ``coarser``: the period over what the stamps ask for.
    """

    period_s: float
    count: int
    index: NDArray[np.intp]
    parts: tuple[Part, ...]
    jitter: float  # largest miss of a time stamp, in usual periods
    lost: int = 0
    past: Floats | None = None
    coarser: float = 1.0

    @property
    def driven(self) -> NDArray[np.bool_]:
        """Intervals in which the bridge connects the motor, (count,)."""
        driven = np.ones(self.count, dtype=bool)
        for part in self.parts:
            driven[part.slice] = not part.open
        return driven

    @property
    def stopped(self) -> NDArray[np.bool_]:
        """Intervals in which the current stops within the PWM period, (count,)."""
        stopped = np.zeros(self.count, dtype=bool)
        for part in self.parts:
            stopped[part.slice] = part.discontinuous
        return stopped

    @property
    def complete(self) -> bool:
        """A sample on every tick."""
        return self.count == len(self.index)

    def spread(self, values: Floats) -> Floats:
        """Readings (samples,) on the grid (count,), NaN where none was taken."""
        if self.complete:
            return values
        grid = np.full(self.count, np.nan)
        grid[self.index] = values
        return grid


def lay(capture: Capture, continuous: bool = False, moving: bool = False) -> Timeline:
    """The capture's timeline; ``continuous``: of a log whose voltage is taken not to jump;
    ``moving``: whose voltage is taken to move within the time of a mean.

    Raises DataError for fewer than 16 samples or irregular stamps.
    """
    if len(capture) < 16:
        raise DataError(
            f"{capture.path or 'the capture'} holds {len(capture)} samples, too few to fit: "
            "capture a longer run"
        )
    period = capture.period_s
    if not period > 0:
        raise DataError("the capture's time stamps do not advance: check its time column")
    place = (capture.ticks - capture.ticks[0]) / (capture.clock_hz * period)
    index = np.rint(place).astype(np.intp)
    jitter = float(np.abs(place - index).max())
    level = jitter <= IRREGULAR and not moving
    if capture.program is None and not (level and _told_throughout(capture)):
        return _of_log(capture, jitter, continuous)
    if jitter > JITTER or np.diff(index).min() < 1:
        raise DataError(
            f"time stamps miss a uniform grid of {period:.6g} s by up to {jitter:.2f} periods: "
            "resample the data at its native rate, or cut it to its regular part"
        )
    count = int(index[-1]) + 1
    if count > LARGEST_LOSS * len(capture):
        raise DataError(
            f"{count - len(capture)} of {count} samples are missing: too many to fit across; "
            "cut the capture to an unbroken part"
        )
    lost = count - len(capture)
    return Timeline(period, count, index, _parts(capture, period, count), jitter, lost)


def _told_throughout(capture: Capture) -> bool:
    """Every reading of the voltage is its mean since the one before, by a stated delay, and none
    says that it jumped in that time: no finer grid tells more.
    """
    channel = capture.get(VOLTAGE)
    if channel is None or not np.isfinite(channel.values).all() or not channel.states("delay"):
        return False
    off = (abs(channel.window_s - capture.period_s), channel.delay_s)
    if max(off) > IRREGULAR * capture.period_s:
        return False
    return not len(jumps_in_means.within(channel.values))


def _of_log(capture: Capture, jitter: float, continuous: bool) -> Timeline:
    """The timeline of stamps as they come. Raises DataError where they do not advance."""
    steps = np.diff(capture.time_s)
    if steps.min() <= 0:
        raise DataError("the capture's time stamps do not advance: check its time column")
    finest = capture.period_s / _ticks(capture, continuous)
    if jitter > IRREGULAR:
        finest = min(finest, float(np.percentile(steps, QUICK)) / 2)
    finest /= capture.provenance.get(FINER_GRID, 1)
    most = min(MOST_TICKS, TICKS_PER_SAMPLE * len(capture))
    period = max(finest, float(capture.time_s[-1]) / most)
    place = capture.time_s / period
    index = np.floor(place + ON_TICK).astype(np.intp)
    count = int(index[-1]) + 2
    lost = sum(gap.samples for gap in capture.gaps)
    parts, past = (Part(0, count),), place - index
    return Timeline(period, count, index, parts, jitter, lost, past, period / finest)


def _ticks(capture: Capture, continuous: bool) -> int:
    """In a usual period of a log. A voltage that jumps within a tick drives the model by its mean
    there, and the current rises too early and too slowly, by up to V R/L² h²/8.
    """
    channel = capture.get(VOLTAGE)
    if channel is None or (continuous and channel.window_s <= capture.period_s / 2):
        return FINER  # means hold jumps whatever the voltage is taken for
    volts = channel.values[np.isfinite(channel.values)]
    if len(volts) < 2 or not len(jumps(volts)):
        return FINER
    return min(max(FINER, JUMPED_TICKS // len(capture)), FINEST)


def _parts(capture: Capture, period: float, count: int) -> tuple[Part, ...]:
    if capture.program is None or not capture.phases:
        return (Part(0, count),)
    steps = capture.program.steps
    starts, kept = [], []
    for phase in capture.phases:
        first = round((phase.tick - int(capture.ticks[0])) / (capture.clock_hz * period)) + 1
        if phase.index < len(steps) and first < count:
            starts.append(max(first, 1))
            kept.append(steps[phase.index])
    if not kept:
        return (Part(0, count),)
    starts[0] = 0
    return tuple(
        Part(a, b, step.kind, step.level, step.decay)
        for (a, b), step in zip(pairwise([*starts, count]), kept, strict=True)
        if b > a
    )
