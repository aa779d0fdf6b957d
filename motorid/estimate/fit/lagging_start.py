"""Start values where motion and current do not go together as they were read.

A speed that comes late rises after the current has fallen, and few readings of a motion show no
inertia. Neither is a reason to refuse: the search needs a start, and judges by the likelihood.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED, Capture
from motorid.errors import DataError
from motorid.estimate.fit.start_signals import Signals
from motorid.estimate.results.estimate import Diagnostic

Floats = NDArray[np.float64]
Mechanics = tuple[float, float, float]  # B, J, T0

TAKEN = "motion taken earlier"  # provenance: by how many seconds
LAGS = (1, 2, 3, 5, 8, 12, 16, 22, 30, 40, 52, 66, 84)  # intervals
RISEN = 0.63  # of the highest speed, after a time constant
HALF = 0.5  # of the torque of the usual current, that Coulomb friction takes


@dataclass(frozen=True)
class Doubt:
    """Why a start is a guess: ``reason`` refuses the captures if the fit from it fails as well.

    ``late_s``: by which the motion seems late; 0: it does not.
    """

    reason: DataError
    late_s: float = 0.0

    def refusal(self) -> DataError:
        """What to tell a person when no start leads to a fit."""
        if not self.late_s:
            return self.reason
        return DataError(
            f"{self.reason}; the motion follows the current best when it is taken "
            f"{1e3 * self.late_s:.3g} ms earlier: declare its delay (--delay), or check the stamps"
        )


def taken_earlier(capture: Capture, late_s: float) -> Capture:
    """The capture with its motion declared later by ``late_s``, to within a sample."""
    channels = dict(capture.channels)
    for name in (SPEED, POSITION):
        if name in channels:
            one = channels[name]
            unsure = max(one.delay_uncertainty_s, capture.period_s / np.sqrt(12.0))
            channels[name] = replace(
                one, delay_s=one.delay_s + late_s, delay_uncertainty_s=float(unsure)
            )
    facts = {**capture.provenance, TAKEN: late_s + capture.provenance.get(TAKEN, 0.0)}
    return replace(capture, channels=channels, provenance=facts)


def remarks(captures: Sequence[Capture]) -> list[Diagnostic]:
    """Of motions that were ``taken_earlier``."""
    late = {round(c.provenance[TAKEN], 9): c.period_s for c in captures if TAKEN in c.provenance}
    return [
        Diagnostic(
            "motion_late", "warning",
            f"the motion comes {1e3 * late_s:.3g} ms ({late_s / period_s:.0f} samples) after the "
            "current that makes it, which nobody declared: the fit takes it as that much earlier. "
            "Declare its delay (--delay), or stamp all channels by one clock",
        )
        for late_s, period_s in late.items()
    ]  # fmt: skip


def mechanics(
    data: Sequence[Signals],
    resistance_ohm: float,
    constant: float,
    fixed: Mapping[str, float],
    solve: Callable[[Sequence[Signals], float, Mapping[str, float]], tuple[Mechanics, float]],
    reason: DataError,
) -> tuple[Mechanics, Doubt]:
    """B, J, T0 (SI) and why they are doubtful: of a motion taken earlier or later, else a guess.

    ``solve`` is what failed for ``reason``.
    """
    found = []
    for lag in (*LAGS, *(-lag for lag in LAGS)):
        try:
            motor, explained = solve([_earlier(s, lag) for s in data], constant, fixed)
        except DataError:
            continue
        found.append((explained, lag, motor))
    if not found:
        return _guess(data, resistance_ohm, constant, fixed), Doubt(reason)
    _, lag, best = max(found)
    return best, Doubt(reason, lag * min(s.period_s for s in data))


def _earlier(s: Signals, intervals: int) -> Signals:
    """As if the motion were read so many intervals earlier."""

    def moved(values: Floats) -> Floats:
        place = np.clip(np.arange(len(values)) + intervals, 0, len(values) - 1)
        return values[place]

    speed = None if s.speed is None else moved(s.speed)
    return replace(s, angle=moved(s.angle), speed=speed)


def _guess(
    data: Sequence[Signals], resistance_ohm: float, constant: float, fixed: Mapping[str, float]
) -> Mechanics:
    """By how long the motor takes to its speed, and by what current it runs."""
    s = max(data, key=lambda one: float(np.ptp(one.angle)))
    speed = np.gradient(s.angle, s.period_s) if s.speed is None else s.speed
    top = float(np.abs(speed).max()) or 1.0
    risen = max(int(np.argmax(np.abs(speed) >= RISEN * top)), 1)
    begun = int(np.argmax(np.abs(s.volts) > 0.0))
    rise_s = s.period_s * max(risen - begun, 1)
    inertia = rise_s * constant**2 / resistance_ohm
    running = np.abs(s.current[np.abs(speed) >= RISEN * top])
    torque = constant * float(np.median(running)) if len(running) else 0.0
    found = {"B": HALF * torque / top, "J": inertia, "T0": HALF * torque, **fixed}
    return found["B"], found["J"], found["T0"]
