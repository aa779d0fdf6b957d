"""Where the bridge of a log was open: a current that is gone while voltage and motion go on.

Nobody logged when a bridge opens. A connected motor draws a current as soon as its voltage departs
from its back-EMF, so that no current, for a while, contradicts the voltage that the log shows: zero
of a commanded duty, a supply, a terminal that floats. Where the terminals show the back-EMF itself,
the current ends faster than the winding allows. Diodes may let it run out over several samples.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.estimate.signals.measurements import motion
from motorid.estimate.signals.voltage_jumps import scatter

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

FEWEST = 8  # samples without a current, of which fewer are a zero crossing
NEAR_ZERO = 0.15  # of the highest current, within which lies the reading of none
HIGHEST, LEAST = 98, 2  # percentiles that count as the highest and the least
BAND = 4.0  # standard deviations of a reading about a level
ROUNDED = 1.5  # quanta
DRAWS = 10.0  # bands of current that a connected motor would draw
EXPECTED = 0.2  # of the highest current: the same
DROP = 0.05  # of the highest current, from which its end is more than that of a small one
BLURS = (0, 2, 4)  # samples on either side over which a noisy current is averaged
SAME = 1e-6  # of the highest current: less is rounding
QUICK = 2  # samples in which a current ends that the winding does not let end
RUNS_OUT = 12  # samples, the most that diodes take
LATEST = 24  # samples by which a channel may lag behind another
RESTING = 16  # samples of a rest that a stretch under drive may begin with
STILL = 0.02  # of the highest speed or voltage, below which the motor rests
SLOWED = 0.02  # of the highest speed, by which a motor without a current slows down
SLOWER = 4.0  # standard deviations by which a coasting motor gets slower
EXPLAINED = 0.2  # of the current, rms, that voltage and speed may leave
CLOSE, OFFSET = 0.02, 0.1  # of the highest current: what they leave, and an offset, as expected
TRIMS, APART = 6, 4.0  # rounds of leaving out; times the median departure
COUNTS, COUNTED = 20.0, 32  # of an encoder that tell a speed; samples on either side, at most
SHORTEST = 32  # driven samples that tell a resistance and a back-EMF


@dataclass(frozen=True)
class Opening:
    """Samples ``start`` to ``stop`` (exclusive) in which no current can flow.

    ``rests`` is the first sample of a standstill in which it ends; ``stop`` where there is none.
    Where the terminals show the back-EMF of a motor that coasts, only the end of the current.
    """

    start: int
    stop: int
    rests: int


def openings(capture: Capture) -> list[Opening]:
    """Of a log without a program, in order of time; none where voltage or current is missing."""
    signals = _Signals.of(capture)
    if signals is None:
        return []
    found: list[Opening] = []
    for run in _idle(signals):
        if _lets_go(signals, run):
            begun = max(_decayed_from(signals, run.start) - 1, 0)
            found.append(Opening(begun, run.start + QUICK, run.start + QUICK))
        elif _is_open(signals, run):
            begun = max(_decayed_from(signals, run.start) - 1 - signals.blur, 0)
            if found and begun <= found[-1].stop + QUICK:
                begun = found.pop().start
            ended = min(run.stop + signals.blur, len(capture))
            found.append(Opening(begun, ended, min(_rest(signals, run), ended)))
    return found


@dataclass(frozen=True)
class Motor:
    """i = ``by_volts`` V - ``by_speed`` ω + ``offset_a`` in the steady state, as a log shows it."""

    by_volts: float
    by_speed: float
    offset_a: float

    def drawn(self, volts: Floats, speed: Floats) -> Floats:
        """A (n,) that a connected motor's channel would show."""
        return np.asarray(self.by_volts * volts - self.by_speed * speed + self.offset_a)


@dataclass(frozen=True)
class _Signals:
    """Readings (n,): V, A, and rad/s where a motion was measured.

    ``band`` (A) holds readings of one level; ``peak`` (A) is the highest current. ``blur``: samples
    on either side with which each was averaged. ``motor``: by the driven samples; None: they tell
    none.
    """

    volts: Floats
    current: Floats
    speed: Floats | None
    band: float
    peak: float
    blur: int = 0
    motor: Motor | None = None

    @classmethod
    def of(cls, capture: Capture) -> _Signals | None:
        channels = capture.get(VOLTAGE), capture.get(CURRENT)
        if capture.program is not None or channels[0] is None or channels[1] is None:
            return None
        volts, current = (_whole(channel.values) for channel in channels if channel is not None)
        if volts is None or current is None:
            return None
        level = max(BAND * scatter(current), ROUNDED * _quantum(current, channels[1].resolution))
        for blur in BLURS:
            read, width = _averaged(current, blur), 2 * blur + 1
            peak = float(np.percentile(np.abs(read), HIGHEST))
            band = max(level / np.sqrt(width), SAME * peak)
            if peak > DRAWS * band:
                found = cls(volts, read, _speed(capture), band, peak, blur)
                return replace(found, motor=_motor(found))
        return None


def _averaged(values: Floats, blur: int) -> Floats:
    """Each reading with so many on either side of it."""
    if not blur:
        return values
    whole = np.pad(values, blur, mode="edge")
    return np.convolve(whole, np.full(2 * blur + 1, 1.0 / (2 * blur + 1)), mode="valid")


def _whole(values: Floats) -> Floats | None:
    """Readings with the missing ones from their neighbours; None where hardly any was taken."""
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 2 * SHORTEST:
        return None
    return np.interp(np.arange(len(values)), known, values[known])


def _quantum(values: Floats, declared: float) -> float:
    """The step of readings that are rounded: declared, or the least between those that occur."""
    distinct = np.unique(values)
    if len(distinct) * 4 > len(values):
        return declared
    return max(declared, float(np.diff(distinct).min(initial=np.inf)) if len(distinct) > 1 else 0.0)


def _speed(capture: Capture) -> Floats | None:
    channel = motion(capture)
    values = None if channel is None else _whole(channel.values)
    if channel is None or values is None:
        return None
    if channel.name == SPEED:
        return values
    return _turning(values, capture.time_s, channel.resolution)


def _turning(angle: Floats, time_s: Floats, step: float) -> Floats:
    """Speed (n,) over as many samples as a fast motor takes for some counts of its encoder."""
    ahead = min(COUNTED, len(angle) - 1)
    fast = float(np.percentile(np.abs(angle[ahead:] - angle[:-ahead]), HIGHEST)) / ahead
    side = int(np.clip(np.ceil(COUNTS * step / max(2.0 * fast, 1e-300)), 1, COUNTED))
    at = np.arange(len(angle))
    last, first = np.minimum(at + side, len(angle) - 1), np.maximum(at - side, 0)
    return np.asarray((angle[last] - angle[first]) / (time_s[last] - time_s[first]))


def _motor(s: _Signals) -> Motor | None:
    """By the samples with a current, most of them; the rise of the current takes its share.

    At rest without a voltage the current is the offset, whatever the bridge does. Without such a
    rest one level in one direction does not separate the offset from the voltage: then the offset
    is small.
    """
    flows = np.abs(s.current) > max(NEAR_ZERO * s.peak, BAND * s.band)
    if s.speed is None or flows.sum() < SHORTEST:
        return None
    flows |= _at_rest(s.volts, s.speed)
    columns = np.column_stack([s.volts, -s.speed, np.gradient(s.current), np.full_like(s.speed, 1)])
    small = np.array([0.0, 0.0, 0.0, CLOSE / OFFSET])
    use, found = flows.copy(), np.zeros(columns.shape[1])
    for _ in range(TRIMS):
        rows = np.vstack([columns[use], small])
        scale = np.sqrt((rows**2).sum(axis=0)) + 1e-300
        right = np.append(s.current[use], 0.0)
        found = np.linalg.lstsq(rows / scale, right, rcond=1e-12)[0] / scale
        off = np.abs(s.current - columns @ found)
        use = flows & (off <= APART * float(np.median(off[flows])) + 1e-12)
    left = float(np.sqrt(np.mean(off[use] ** 2)))
    driven = float(np.sqrt(np.mean(s.current[use] ** 2)))
    by_volts, by_speed, _, offset = found.tolist()
    if not (by_volts > 0.0 and by_speed > 0.0 and left < EXPLAINED * driven):
        return None
    return Motor(by_volts, by_speed, offset)


def _at_rest(volts: Floats, speed: Floats) -> Bools:
    """Samples (n,) without a voltage and without a motion."""
    return _low(volts, float(np.abs(volts).max())) & _low(
        speed, float(np.percentile(np.abs(speed), HIGHEST))
    )


def _low(values: Floats, highest: float) -> Bools:
    """Readings (n,) that are no more than a rest's."""
    return np.asarray(np.abs(values) <= STILL * highest + BAND * scatter(values))


def _idle(s: _Signals) -> Iterator[slice]:
    """Stretches in which the current stays at one level near zero."""
    low = np.abs(s.current) <= NEAR_ZERO * s.peak
    if low.sum() < FEWEST:
        return
    levels = np.rint(s.current[low] / s.band).astype(np.int64)
    names, counts = np.unique(levels, return_counts=True)
    taken, found = np.zeros(len(low), dtype=bool), []
    for name in names[np.argsort(-counts, kind="stable")]:
        near = low & ~taken & (np.abs(s.current - name * s.band) <= s.band)
        near[1:-1] |= near[:-2] & near[2:] & ~taken[1:-1]  # one outlier is no current
        edges = np.flatnonzero(np.diff(near.astype(np.int8), prepend=0, append=0))
        for a, b in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
            if b - a >= FEWEST:
                taken[a:b] = True
                found.append((a, b))
    run: tuple[int, int] | None = None
    for a, b in sorted(found):
        if run is not None and a - run[1] <= QUICK and _alike(s, run, (a, b)):
            run = run[0], b
            continue
        if run is not None:
            yield slice(*run)
        run = a, b
    if run is not None:
        yield slice(*run)


def _alike(s: _Signals, run: tuple[int, int], other: tuple[int, int]) -> bool:
    """Both runs are at the same level."""
    apart = np.median(s.current[slice(*run)]) - np.median(s.current[slice(*other)])
    return abs(float(apart)) <= s.band / 2.0


def _is_open(s: _Signals, run: slice) -> bool:
    """No connected motor would do this."""
    enough = max(DRAWS * s.band, EXPECTED * s.peak)
    if s.motor is not None and s.speed is not None:
        late = min((run.stop - run.start) // 4, LATEST)  # a channel that lags is no open bridge
        here = slice(run.start + late, run.stop - late)
        off = np.abs(s.motor.drawn(s.volts[here], s.speed[here]) - s.current[here])
        if float(np.sort(off)[-FEWEST // 2]) > enough:
            return True
    if not _ends_at_once(s, run.start):
        return False
    return _slows(s, run) or (s.speed is None and _should_brake(s, run) > enough)


def _should_brake(s: _Signals, run: slice) -> float:
    """A that a connected motor, whose motion nobody measured, would draw back at no voltage: its
    back-EMF before that, with the largest resistance that its currents allow.
    """
    if float(np.abs(s.volts[run]).max()) > EXPECTED * float(np.abs(s.volts).max()):
        return 0.0
    flows = np.abs(s.current) > DROP * s.peak + s.band
    drives = flows & (s.volts * s.current > 0.0)
    if not drives.any():
        return 0.0
    most = float(np.percentile(s.volts[drives] / s.current[drives], LEAST))
    before = slice(max(run.start - RUNS_OUT, 0), max(run.start - QUICK, 1))
    emf = np.median(np.abs(s.volts[before]) - most * np.abs(s.current[before]))
    return float(emf) / most


def _ends_at_once(s: _Signals, start: int) -> bool:
    """Within so few samples as the current falls to nothing, from much more."""
    if start < QUICK + 1:
        return False
    level = float(np.median(s.current[start : start + FEWEST]))
    last = max(start - QUICK - 2 * s.blur, 1)
    before = np.abs(s.current[last - 1 : last + 1] - level)
    return bool(before.max() > max(2 * DROP * s.peak, BAND * s.band))


def _lets_go(s: _Signals, run: slice) -> bool:
    """A current ends, however small, and none flows while the motor slows down by much: diodes took
    its end, and what the terminals show then is the back-EMF. No voltage that drives a motor keeps
    its current at nothing.
    """
    if s.motor is None or s.speed is None or s.blur or run.start <= 2 * QUICK:
        return False
    level = float(np.median(s.current[run]))
    if abs(level - s.motor.offset_a) > max(s.band, CLOSE * s.peak):
        return False
    way = math.copysign(1.0, float(s.speed[run.start]))  # a current that drove the motor has it too
    flowing = way * (s.current[run.start - 2 * QUICK : run.start - 1] - level)
    ends = [run.start + QUICK, run.stop - 1]  # not while diodes hold the terminals
    fall, volts = np.abs(s.speed[ends]), np.abs(s.volts[ends])
    emf = s.motor.by_speed / s.motor.by_volts * (fall[0] - fall[1])
    top = float(np.percentile(np.abs(s.speed), HIGHEST))
    if flowing.min() <= 2.0 * s.band or fall[0] - fall[1] <= SLOWED * top:
        return False  # it does not end at once, or the motor hardly slows down
    return bool(volts[0] - volts[1] > emf / 2.0) and _slows(s, run)


def _slows(s: _Signals, run: slice) -> bool:
    """The motor, or where nobody measured it its voltage, falls throughout, and is not at rest."""
    shown = s.volts if s.speed is None else s.speed
    here = np.abs(shown[run])
    if s.speed is None and float(here[0]) < EXPECTED * float(np.abs(shown).max()):
        return False
    part = len(here) // 4  # two at least, of FEWEST
    spread = scatter(shown) or float(np.abs(np.diff(here, 2)).mean()) / 2
    fall = float(here[:part].mean() - here[-part:].mean())
    return bool(fall > SLOWER * spread / np.sqrt(part / 2))


def _decayed_from(s: _Signals, start: int) -> int:
    """The first sample of a current that runs out through diodes until ``start``."""
    level = float(np.median(s.current[start : start + FEWEST]))
    above = np.abs(s.current - level)
    first = start
    while first > max(start - RUNS_OUT, 1):
        if above[first - 1] - above[first] < max(above[first - 1] / RUNS_OUT, s.band / 2):
            break
        first -= 1
    return first


def _rest(s: _Signals, run: slice) -> int:
    """Where a rest begins that lasts to the end of the run, long enough to begin anew from."""
    if s.speed is None:  # no voltage, of an open bridge, does not show it
        return int(run.stop)
    moves = np.flatnonzero(~_at_rest(s.volts, s.speed)[run])
    rests = int(run.start) + (int(moves[-1]) + 2 if len(moves) else 0)
    return rests if run.stop - rests >= RESTING else int(run.stop)
