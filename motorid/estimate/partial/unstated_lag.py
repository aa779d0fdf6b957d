"""When a drive acts, of which a log says only what it was at some moments, and nobody a delay.

A voltage may go straight from a reading to the next, or be held until the next, or since the one
before. A speed of counted edges is the mean since the row before, a sensor smooths, and the winding
takes its L/R. To smooth bumps each is a delay of the drive, or a lead, and that is an unknown of
the balance. Where the data tell it surely, the balance has it; where not, what the answer changes
by with what is left open of it is in the uncertainty.

What of a delay of volts is the winding's belongs to the mechanical time constant: the slow pole of
a motor is quicker by about L/R than JR/(K² + RB).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED, VOLTAGE, Capture
from motorid.estimate.partial.block_bootstrap_regression import Regression, at_least
from motorid.estimate.partial.further_terms import NEEDED, STANDS_OUT, gain, left_open, slope
from motorid.estimate.partial.mechanical_remarks import expected_rms
from motorid.estimate.partial.mechanical_signals import COASTING, COMMAND, Motion
from motorid.estimate.partial.modulating_functions import COLUMNS, LATE
from motorid.estimate.results.estimate import Diagnostic

Floats = NDArray[np.float64]

USUAL = 0.5  # samples: standard, of a drive that is held or a speed that is a mean
MOST = 8.0  # samples
LEAST = 0.1  # samples: less changes nothing
FOLLOWED = 40.0  # times the variance that is left: what jumps may be off by, at most
PASSES, NEAR = 4, 0.02  # of a search, which ends within so many samples
HELD = (0.3, 0.9)  # samples: as a drive that is held, a winding or so besides
WINDING = 0.03  # of the mechanical time constant: usual of L/R
SLACK = 0.02  # samples: of what makes a drive earlier

Regress = Callable[[Sequence[Motion], Sequence[str]], Regression | None]


@dataclass(frozen=True)
class Timing:
    """The ``motions`` with their drives when they act, the ``terms`` that the balance has for that,
    and what to say of it. ``late_s``: None where the balance takes the drives as stamped.
    """

    motions: Sequence[Motion]
    terms: tuple[str, ...] = ()
    late_s: float | None = None
    moves: tuple[Floats, ...] = ()  # (4,) each, of what is left open
    winding_s: tuple[float, float] = (0.0, 0.0)  # mean and standard deviation of L/R
    said: Diagnostic | None = None

    def of(self, found: Regression) -> Regression:
        """A balance with these terms as one without, what is left open in its covariance."""
        plain = (_as_jumps_scatter(self.motions, found) if self.terms else found).plain()
        mean, deviation = self.winding_s
        inertia = _inertia(plain)
        moved = replace(plain, coefficients=plain.coefficients + mean * inertia)
        return moved.widened(*self.moves, deviation * inertia)


@dataclass(frozen=True)
class _Found:
    """By how much drives act later (s), with its standard deviation, and the balance with that."""

    late_s: float
    deviation_s: float
    balance: Regression

    def sure(self, period_s: float) -> bool:
        """The data support it, and it is large enough to matter."""
        if not abs(self.late_s) > max(STANDS_OUT * self.deviation_s, LEAST * period_s):
            return False
        return gain(self.balance, len(COLUMNS), self.late_s) > NEEDED


def looked_for(
    captures: Sequence[Capture],
    drive: str,
    motions: Sequence[Motion],
    best: Regression,
    regress: Regress,
) -> Timing:
    """When the drives of ``captures`` act; ``best``: the balance that takes them as stamped."""
    as_stamped = Timing(motions)
    if drive == COASTING or any(motion.unsigned for motion in motions):
        return as_stamped
    if any(_stated(capture, drive) for capture in captures):
        return as_stamped
    period_s = max(motion.period_s for motion in motions)
    found = _sought(motions, period_s, regress)
    if found is None:
        return as_stamped
    volts = drive in (VOLTAGE, COMMAND)
    if found.sure(period_s):
        later = [replace(motion, drive_late_s=found.late_s) for motion in motions]
        most_s = found.late_s + (0.5 + SLACK) * period_s + 2.0 * found.deviation_s
        winding_s = _winding(found.balance, most_s) if volts else (0.0, 0.0)
        said = _said(drive, found.late_s / period_s, found.late_s)
        return Timing(later, (LATE,), found.late_s, winding_s=winding_s, said=said)
    open_s = left_open(found.late_s, found.deviation_s, USUAL * period_s)
    moves = [open_s * slope(found.balance, len(COLUMNS))]
    if volts:
        mean, deviation = _winding(best, open_s)
        moves.append(float(np.hypot(mean, deviation)) * _inertia(best))
    return Timing(motions, moves=tuple(moves))


def _sought(motions: Sequence[Motion], period_s: float, regress: Regress) -> _Found | None:
    """By straight lines, again and again from where they end."""
    late_s, found = 0.0, None
    for _ in range(PASSES):
        balance = regress([replace(m, drive_late_s=late_s) for m in motions], (LATE,))
        if balance is None:
            return None
        step_s = float(balance.coefficients[-1])
        late_s += step_s
        found = _Found(late_s, float(balance.sigma[-1]), balance)
        if not abs(late_s) <= MOST * period_s:
            return None
        if abs(step_s) < NEAR * period_s:
            break
    return found


def _as_jumps_scatter(motions: Sequence[Motion], found: Regression) -> Regression:
    """As uncertain as the unknown moments of jumps make it: a few jumps that a balance with a delay
    follows leave less than they are off by.
    """
    left = float(np.mean(found.residual**2))
    variance = min(expected_rms(motions, found) ** 2, FOLLOWED * left)
    part = found.rows.matrix[:, found.free]
    scale = np.maximum(np.sqrt((part**2).sum(axis=0)), 1e-300)
    each = np.zeros_like(found.covariance)
    inverse = np.linalg.pinv((part / scale).T @ (part / scale)) / np.outer(scale, scale)
    each[np.ix_(found.free, found.free)] = variance * inverse
    return replace(found, covariance=at_least(found.covariance, each))


def _winding(balance: Regression, most_s: float) -> tuple[float, float]:
    """Mean and standard deviation of L/R: positive, at most that, and small beside the mechanical
    time constant as it usually is (an exponential distribution, cut).
    """
    inertia, speed = map(float, balance.coefficients[:2])
    if not (most_s > 0.0 and inertia > 0.0 and speed > 0.0):
        return 0.0, 0.0
    usual_s = WINDING * inertia / speed
    reach = most_s / usual_s
    if reach < 1e-3:
        return most_s / 2.0, most_s / np.sqrt(12.0)
    beyond = float(np.exp(-reach) / -np.expm1(-reach))
    mean, variance = 1.0 - reach * beyond, 1.0 - reach**2 * beyond * (1.0 + beyond)
    return float(usual_s * mean), float(usual_s * np.sqrt(max(variance, 0.0)))


def _inertia(balance: Regression) -> Floats:
    """By how much (4,) the coefficients of volts change for each second of L/R."""
    out = np.zeros(len(COLUMNS))
    out[0] = max(float(balance.coefficients[1]), 0.0)
    return out


def _motion(capture: Capture) -> str:
    return SPEED if SPEED in capture.channels else POSITION


def _stated(capture: Capture, drive: str) -> bool:
    """Both delays are somebody's word, or the capture's own."""
    names = (_motion(capture), drive)
    return all(
        name in capture.channels and capture.channels[name].states("delay") for name in names
    )


def _said(drive: str, samples: float, seconds: float) -> Diagnostic:
    name = drive.replace("_", " ")
    if HELD[0] < samples < HELD[1]:
        how = "as if each reading held until the next"
    elif HELD[0] < samples + 1.0 < HELD[1]:
        how = "as if each reading had held since the one before"
    elif samples > 0.0:
        how = "as with means since the row before, a drive that is held, a filter of the motion "
        how += "or a slow winding"
    else:
        how = f"as with a {name} that is a mean, or filtered"
    side = "later" if samples > 0.0 else "earlier"
    return Diagnostic(
        "unstated_lag", "info",
        f"the {name} acts about {1e3 * abs(seconds):.2g} ms ({abs(samples):.2g} samples) {side} "
        f"than straight lines between its readings, {how}: so the fit takes it. To fix it, state "
        "--aperture and --delay, or sample faster",
    )  # fmt: skip
