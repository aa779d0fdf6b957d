"""A low-pass before a board's voltage that nobody declared: seen where a brake shorts the motor.

A bridge that brakes takes the terminals' voltage V away within a dead time, but for what its own
resistance keeps of it. Behind a divider with a capacitor, of time constant T, the readings show

    v(t) = a + b t + V exp(-t/T)

A supply that sags or limits its current makes no such voltage. Over T of about a sample the fit
cannot see it either: it takes the voltage for one that rises so slowly, and L for less.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import VOLTAGE, Capture, Channel
from motorid.estimate.results.estimate import Suspect
from motorid.program import StepKind

Floats = NDArray[np.float64]

READINGS = 12  # of a brake, from the first that declares to see nothing of what was before it
BEFORE = 3  # readings before it
KEPT = np.exp(-1.0 / np.geomspace(0.4, 3.0, 61))  # of a reading in the next: T of .4 to 3 samples
LEAST = 0.08  # of V, in the first reading: less is what a bridge's resistance keeps
WHOLE = (0.6, 1.5)  # of V, that the exponential must come from: a bridge's keeps a tenth at most
ASTRAY = 0.02  # of V, rms, that readings may depart from it
AT_ONCE = 0.01  # of a sample, by which a window may begin before the switch
REMEDY = "take the capacitor off the voltage's divider, or let the board declare the filter"
UNSURE = 0.07  # of T, standard, at least: what the bridge keeps of V has a course of its own


@dataclass(frozen=True)
class Brake:
    """``readings`` (n,) at ``after_s`` (n,) from the switch on; ``volts`` before it."""

    readings: Floats
    after_s: Floats
    volts: float


def declared(capture: Capture) -> tuple[Capture, Suspect | None]:
    """The capture with that low-pass declared, and what is said of it; as it came: it has none."""
    found = time_constant(capture)
    if found is None:
        return capture, None
    volts, (size, unsure) = capture.channels[VOLTAGE], found
    late_s = float(np.hypot(volts.delay_uncertainty_s, unsure))
    filtered = replace(behind(volts, size), delay_uncertainty_s=late_s)
    said = Suspect(
        "voltage_filtered", "terminal voltage",
        f"the terminal voltage reads as behind {described(size)}: where the bridge brakes it falls "
        "no faster; the fit allows for it",
        REMEDY, "named", allowed=True,
    )  # fmt: skip
    return replace(capture, channels={**capture.channels, VOLTAGE: filtered}), said


def behind(volts: Channel, size_s: float) -> Channel:
    """The channel, declared to pass a low-pass of that time constant."""
    return replace(volts, filter_s=size_s, delay_s=volts.delay_s + size_s)


def described(size_s: float) -> str:
    """A low-pass by its time constant and its corner."""
    return f"a low-pass of {1e6 * size_s:.0f} µs ({1 / (2 * np.pi * size_s):.3g} Hz)"


def time_constant(capture: Capture) -> tuple[float, float] | None:
    """T in s, and its standard uncertainty; None: the voltage falls as one that nothing filters."""
    volts = capture.get(VOLTAGE)
    if volts is None or capture.program is None or volts.filter_s or volts.sense == "supply":
        return None
    found = [_of(brake, capture.period_s, volts) for brake in _brakes(capture, volts)]
    sizes = [one for one in found if one is not None]
    if not sizes or len(sizes) < len(found):
        return None
    size = float(np.median(sizes))
    return size, max(float(np.ptp(sizes)) / 2.0, UNSURE * size)


def _brakes(capture: Capture, volts: Channel) -> Iterator[Brake]:
    """Those that end a drive."""
    steps = () if capture.program is None else capture.program.steps
    kinds = {StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS}
    ends = [phase.tick for phase in capture.phases[1:]] + [int(capture.ticks[-1])]
    for phase, end in zip(capture.phases, ends, strict=False):
        if not 0 < phase.index < len(steps) or steps[phase.index].kind is not StepKind.BRAKE:
            continue
        if steps[phase.index - 1].kind not in kinds:
            continue
        after = (capture.ticks - phase.tick) / capture.clock_hz - volts.delay_s - volts.window_s
        last = np.searchsorted(capture.ticks, end)
        first = np.searchsorted(after, -AT_ONCE * capture.period_s)
        switched = int(np.searchsorted(capture.ticks, phase.tick))
        if first + READINGS > last or switched < BEFORE:
            continue
        here = slice(int(first), int(first) + READINGS)
        before = volts.values[switched - BEFORE : switched]
        yield Brake(volts.values[here], after[here] + volts.window_s / 2.0, float(before.mean()))


def _of(brake: Brake, period_s: float, volts: Channel) -> float | None:
    """T of one brake, by the readings' own course; None: they fall at once, or otherwise."""
    if not np.isfinite(brake.readings).all() or not np.isfinite(brake.volts):
        return None
    place = np.arange(READINGS)
    fits = []
    for kept in KEPT:
        shape = np.column_stack([np.ones(READINGS), place, kept**place])
        ended, _, _, _ = np.linalg.lstsq(shape, brake.readings, rcond=None)
        left = float(np.sqrt(np.mean((brake.readings - shape @ ended) ** 2)))
        fits.append((left, float(kept), float(ended[0]), float(ended[2])))
    left, kept, level, first = min(fits)
    size, fell = -period_s / np.log(kept), brake.volts - level
    if not abs(fell) > max(volts.noise, volts.resolution) / ASTRAY:
        return None
    whole = first / fell * np.exp(brake.after_s[0] / size)
    good = left < ASTRAY * abs(fell) and first / fell > LEAST and WHOLE[0] < whole < WHOLE[1]
    return size if good and KEPT[0] < kept < KEPT[-1] else None
