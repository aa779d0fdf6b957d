"""A PWM frequency that the board states and the currents contradict.

The current's swing within a period, what a bridge's dead time takes of it, and the stretch without
a current at a low duty all go with the period. A frequency that is wrong by a power of two, as a
divider of a timer is, leaves the readings far more than the right one does. Where the fit leaves
the current more than its noise, a rough search tries such frequencies, and the fit is made again
with the best of them. The answer is that of one that explains the readings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.errors import DataError
from motorid.estimate.results.estimate import Alternative, Curve, Estimate, Suspect
from motorid.estimate.results.status import Status
from motorid.estimate.signals.neighbour_noise import neighbour_noise

Floats = NDArray[np.float64]
Fit = Callable[[Sequence[Capture]], Estimate]
Glance = Callable[..., Sequence[Floats]]  # (captures, values, channels: all if left out)

CODE = "pwm_contradicted"
FACTORS = (0.25, 0.5, 2.0, 4.0)
MISFIT = 1.8  # residuals in units of their noise, from which it is looked for
EXPLAINED = 1.5  # chi-square for each degree of freedom up to which a wider model explains them
CLEAR = 1.0  # mean fall of the logarithm of the residuals, over all readings
LIKELY = 0.2  # of it at a glance, from which a supposition is worth a fit
SOME = 16  # readings of a curve


def corrected(
    captures: Sequence[Capture],
    estimate: Estimate,
    fit: Fit,
    glance: Glance,
) -> tuple[Sequence[Capture], Estimate]:
    """The captures with the frequency that explains the readings, and their estimate, which says
    so; both as they came where none does clearly better, where a wider model explains the readings,
    or where no motor does, since fits of what is no motor are slow.

    ``glance`` gives what a rough search from the estimate's values leaves of the readings; where
    R, K and J are known, only the frequency by which it leaves least is worth a fit.
    """
    if refused(estimate) or _explained(estimate.alternative):
        return captures, estimate
    stated = {capture.wiring.pwm_hz for capture in captures}
    if len(stated) != 1 or not all(stated) or not any(map(_misfits, estimate.curves)):
        return captures, estimate
    (pwm_hz,) = stated
    before = [left_of(curve) for curve in estimate.curves]
    best, found, gain = captures, estimate, CLEAR
    for tried in _worth_a_fit([_at(captures, factor * pwm_hz) for factor in FACTORS],
                              captures, estimate, glance):  # fmt: skip
        try:
            other = fit(tried)
        except DataError:  # at that frequency the readings have no fit
            continue
        if (better := _gain(before, [left_of(curve) for curve in other.curves])) > gain:
            best, found, gain = tried, other, better
    if best is captures:
        return captures, estimate
    said = _said(pwm_hz, best[0].wiring.pwm_hz, gain, estimate)
    return best, replace(found, suspects=(said, *found.suspects))


def _at(captures: Sequence[Capture], pwm_hz: float) -> Sequence[Capture]:
    return tuple(replace(c, wiring=replace(c.wiring, pwm_hz=pwm_hz)) for c in captures)


def _worth_a_fit(
    others: Sequence[Sequence[Capture]],
    captures: Sequence[Capture],
    estimate: Estimate,
    glance: Glance,
) -> Sequence[Sequence[Capture]]:
    """Of the suppositions: the best at a glance, if it is better than none; all where a glance from
    the estimate's values cannot be taken.
    """
    values = values_known(estimate)
    if values is None:
        return others
    try:
        before = glance(captures, values)
    except DataError:
        return others
    best, gain = None, LIKELY
    for other in others:
        try:
            better = _gain(before, glance(other, values))
        except DataError:
            continue
        if better > gain:
            best, gain = other, better
    return [] if best is None else [best]


def refused(estimate: Estimate) -> bool:
    return all(p.status is Status.NOT_SUPPORTED for p in estimate.parameters.values())


def _explained(wider: Alternative | None) -> bool:
    return wider is not None and wider.chi_square <= EXPLAINED * wider.degrees_of_freedom


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
    left = left_of(curve)
    if curve.channel != CURRENT or len(left) < SOME:
        return False
    return float(np.sqrt(np.mean(left**2))) > MISFIT * neighbour_noise(left, order=1)


def _gain(before: Sequence[Floats], after: Sequence[Floats]) -> float:
    """Mean fall of the logarithm of the residuals' size, each reading alike."""
    total = count = 0.0
    for one, other in zip(before, after, strict=False):
        total += len(one) * (size_of(one) - size_of(other))
        count += len(one)
    return total / count if count else 0.0


def values_known(estimate: Estimate) -> Mapping[str, float] | None:
    """The values found, where R, K and J are among them."""
    values = {n: p.value for n, p in estimate.parameters.items() if p.value is not None}
    return values if {"R", "K", "J"} <= {*values} else None


def size_of(left: Floats) -> float:
    """The logarithm of the residuals' root mean square."""
    return 0.5 * math.log(max(float(np.mean(left**2)) if len(left) else 0.0, 1e-300))


def left_of(curve: Curve) -> Floats:
    left = curve.measured - curve.fitted
    return np.asarray(left[np.isfinite(left)])
