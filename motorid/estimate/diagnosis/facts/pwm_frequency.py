"""A PWM frequency that the board states and the currents contradict.

The current's swing within a period, what a bridge's dead time takes of it, and the stretch without
a current at a low duty all go with the period. A frequency that is wrong by a power of two, as a
divider of a timer is, leaves the readings far more than the right one does. Where the fit leaves
the current more than its noise, it is made again with such frequencies, and the answer is that of
one that explains the readings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.errors import DataError
from motorid.estimate.results.estimate import Curve, Estimate, Suspect
from motorid.estimate.results.status import Status

Floats = NDArray[np.float64]
Fit = Callable[[Sequence[Capture]], Estimate]

CODE = "pwm_contradicted"
FACTORS = (0.25, 0.5, 2.0, 4.0)
MISFIT = 2.0  # residuals in units of their noise, from which it is looked for
CLEAR = 1.0  # mean fall of the logarithm of the residuals, over all readings
SOME = 16  # readings of a curve


def corrected(
    captures: Sequence[Capture], estimate: Estimate, fit: Fit
) -> tuple[Sequence[Capture], Suspect | None]:
    """The captures with the frequency that explains the readings, and what is said of it; as they
    came and None where none does clearly better, or where no motor explains the readings, since
    fits of what is no motor are slow. ``fit`` fits six parameters.
    """
    if _refused(estimate):
        return captures, None
    stated = {capture.wiring.pwm_hz for capture in captures}
    if len(stated) != 1 or not all(stated) or not any(map(_misfits, estimate.curves)):
        return captures, None
    (pwm_hz,) = stated
    best, gain = captures, CLEAR
    for factor in FACTORS:
        tried = [replace(c, wiring=replace(c.wiring, pwm_hz=factor * pwm_hz)) for c in captures]
        try:
            other = fit(tried)
        except DataError:  # at that frequency the readings have no fit
            continue
        if _gain(estimate, other) > gain:
            best, gain = tried, _gain(estimate, other)
    if best is captures:
        return captures, None
    return best, _said(pwm_hz, best[0].wiring.pwm_hz, gain, estimate)


def _refused(estimate: Estimate) -> bool:
    return all(p.status is Status.NOT_SUPPORTED for p in estimate.parameters.values())


def _said(stated_hz: float, found_hz: float, gain: float, before: Estimate) -> Suspect:
    return Suspect(
        CODE, "PWM frequency",
        f"the board states a PWM frequency of {stated_hz / 1e3:.4g} kHz, and the current "
        f"contradicts it: at {found_hz / 1e3:.4g} kHz the fit leaves the readings "
        f"{math.exp(-gain):.0%} of what it leaves at the stated one; the fit takes that frequency",
        "measure the PWM frequency at the bridge, and correct it in the firmware", "named",
        allowed=True,
        without={n: p.value for n, p in before.parameters.items() if p.value is not None},
    )  # fmt: skip


def _misfits(curve: Curve) -> bool:
    """A current is left more than what its neighbouring residuals differ by."""
    left = _left(curve)
    if curve.channel != CURRENT or len(left) < SOME:
        return False
    noise = float(np.median(np.abs(np.diff(left)))) / 0.6745 / math.sqrt(2.0)
    return float(np.sqrt(np.mean(left**2))) > MISFIT * noise


def _gain(before: Estimate, after: Estimate) -> float:
    """Mean fall of the logarithm of the residuals' size, each reading alike."""
    total = count = 0.0
    for one, other in zip(before.curves, after.curves, strict=False):
        n = len(one.measured)
        total += n * (_size(one) - _size(other))
        count += n
    return total / count if count else 0.0


def _size(curve: Curve) -> float:
    """The logarithm of its residuals' root mean square."""
    left = _left(curve)
    return 0.5 * math.log(max(float(np.mean(left**2)) if len(left) else 0.0, 1e-300))


def _left(curve: Curve) -> Floats:
    left = curve.measured - curve.fitted
    return np.asarray(left[np.isfinite(left)])
