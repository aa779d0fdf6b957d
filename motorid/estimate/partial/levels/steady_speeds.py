"""Steady points of a drive and the speed that it leads to: a sweep of levels without a current.

    ω = K/(K² + RB) (V − T0 R/K)

A straight line over the points at which the motor turns gives its slope, the gain, and where it
meets standstill, the volts that friction and the bridge take. Many drives have no such line: if a
PWM lets the motor coast between its pulses, the speed bends towards its highest. Then the slopes of
the lower and the upper half of the points differ, and the gain is as uncertain as they are apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.capture.store import describe
from motorid.errors import DataError
from motorid.estimate.partial.mechanical_remarks import of_captures
from motorid.estimate.partial.mechanical_results import (
    FRICTION,
    GAIN,
    Judge,
    Quantity,
    fixed,
    unknown,
)
from motorid.estimate.partial.mechanical_signals import COMMAND, drive_of
from motorid.estimate.results.estimate import PARAMETERS, UNITS, Diagnostic, Estimate
from motorid.version import __version__

Floats = NDArray[np.float64]

FEWEST = 8  # points at which the motor turns
TURNS = 0.02  # of the highest speed: a point at which the motor turns
RISES = 1e-6  # of the highest speed: what rounding makes of a speed that is the same everywhere
APART = 4.0  # standard deviations by which the slopes of both halves differ: no straight line
WHY = (
    "steady points without a current show how fast the motor turns, and no more; a run from rest "
    "with voltage, current and speed, and a coast-down, would determine it"
)


def suits(captures: Sequence[Capture]) -> bool:
    """Whether these steady points hold a drive and a speed, and no current."""
    return all(
        CURRENT not in c.channels
        and SPEED in c.channels
        and drive_of(c.channels) in (VOLTAGE, COMMAND)
        for c in captures
    )


def fit(captures: Sequence[Capture], fix: Mapping[str, float]) -> Estimate:
    """Gain and friction. Raises DataError where the motor turns at too few points."""
    name = drive_of(captures[0].channels) or VOLTAGE
    drive = np.concatenate([np.abs(c.channels[name].values) for c in captures])
    speed = np.concatenate([np.abs(c.channels[SPEED].values) for c in captures])
    known = np.isfinite(drive) & np.isfinite(speed)
    turning = known & (speed > TURNS * float(np.max(speed[known], initial=0.0)))
    if int(turning.sum()) < FEWEST or not np.ptp(drive[turning]) > 0.0:
        raise DataError(
            f"steady points need at least {FEWEST} rows at which the motor turns, at several "
            f"levels of the {name.replace('_', ' ')}, or rows with a current: map more of the "
            "table, or map time if its rows follow each other"
        )
    order = np.argsort(drive[turning], kind="stable")
    x, y = drive[turning][order], speed[turning][order]
    (slope, at_zero), cov = _line(x, y)
    if not slope * float(np.ptp(x)) > RISES * float(y.max()):
        raise DataError(
            f"the steady speed does not rise with the {name.replace('_', ' ')}: check which "
            "columns are mapped"
        )
    low, high, bend_u = _halves(x, y)
    bend = high - low
    judge = Judge(len(x) - 2)
    volt = "1" if name == COMMAND else "V"
    friction, gradient = -at_zero / slope, np.array([at_zero / slope**2, -1.0 / slope])
    open_of = abs(bend) / np.sqrt(12.0)  # of a uniform distribution between both halves' slopes
    share = open_of / abs(slope)
    declared = _gains(captures, name)
    gain = judge.parameter(
        GAIN, f"rad/s/{volt}",
        Quantity(slope, float(cov[0, 0]), float(np.hypot(open_of, slope * declared))),
        "gain, speed for drive",
    )  # fmt: skip
    taken = judge.parameter(
        FRICTION, volt,
        Quantity(
            friction, float(gradient @ cov @ gradient),
            float(np.hypot(share * float(np.mean(x)), friction * declared)),
        ),
        "with what the bridge drops",
    )  # fmt: skip
    found = {one: unknown(one, UNITS[one], WHY) for one in PARAMETERS}
    said = [_bent(low, high, float(x[len(x) // 2]), name)] if abs(bend) > APART * bend_u else []
    return Estimate(
        model="ω = K/(K²+RB) (V − T0·R/K) (steady points)",
        method="least squares",
        parameters=found | {one: fixed(one, UNITS[one], value) for one, value in fix.items()},
        combinations={GAIN: gain, FRICTION: taken},
        derived={},
        nuisance={},
        free=(),
        correlation=np.zeros((0, 0)),
        chi_square=0.0,
        degrees_of_freedom=len(x) - 2,
        evaluations=1,
        diagnostics=(*said, *of_captures(captures)),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix)},
        versions={"motorid": __version__, "numpy": np.__version__},
    )


def _line(x: Floats, y: Floats) -> tuple[tuple[float, float], Floats]:
    """Slope and y at 0, and their covariance (2, 2), by the scatter about the line."""
    matrix = np.column_stack([x, np.ones(len(x))])
    found, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    scatter = float(((y - matrix @ found) ** 2).sum()) / max(len(x) - 2, 1)
    return (float(found[0]), float(found[1])), scatter * np.linalg.pinv(matrix.T @ matrix)


def _halves(x: Floats, y: Floats) -> tuple[float, float, float]:
    """Slopes of the lower and the upper half, and the standard deviation of their difference by
    their scatter.
    """
    middle = len(x) // 2
    halves = [_line(x[part], y[part]) for part in (slice(0, middle), slice(middle, None))]
    ((low, _), first), ((high, _), second) = halves
    return low, high, float(np.sqrt(first[0, 0] + second[0, 0]))


def _gains(captures: Sequence[Capture], name: str) -> float:
    """Relative standard uncertainty of the declared gains of both columns."""
    drive, speed = (max(c.channels[n].gain_uncertainty for c in captures) for n in (name, SPEED))
    return float(np.hypot(drive, speed))


def _bent(low: float, high: float, middle: float, name: str) -> Diagnostic:
    unit, per = ("", "") if name == COMMAND else (" V", "/V")
    return Diagnostic(
        "bent_line", "warning",
        f"the steady speed is no straight line of the {name.replace('_', ' ')}: its slope is "
        f"{low:.3g} rad/s{per} up to {middle:.3g}{unit} and {high:.3g} rad/s{per} above. "
        "Suspect a PWM that lets the motor coast between its pulses, a drive that saturates, or a "
        "load that grows with the square of speed. The gain is as uncertain as these are apart",
    )  # fmt: skip
