"""A balance whose drive hardly changes while the motor turns: gain and friction are one there.

    drive = a dω/dt + b ω + c sign(ω)

If the drive is constant, a = b = 0 and c = drive is an exact solution, whatever the motor is: noise
of the speed draws b to 0 (an error in a variable), and c takes the whole drive, without a residual.
Volts that turn a motor are more than friction needs, so b is positive. If the data do not show
that it is, c is no friction either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import VOLTAGE
from motorid.errors import DataError
from motorid.estimate.partial.mechanical_results import FRICTION, GAIN, unknown
from motorid.estimate.partial.mechanical_signals import (
    COASTING,
    COMMAND,
    FEWEST_SAMPLES,
    Motion,
    noise,
)
from motorid.estimate.results.estimate import Diagnostic, Estimate

Floats = NDArray[np.float64]

VARIES = 0.05  # of its mean, rms beside noise: less is one level
CURRENT_VARIES = 0.01  # of a current or torque, which a constant source hardly sags by
WHOLE = "(K−T0·R/V)/(K²+RB)"
ONE = "friction and back-EMF cannot be separated: the log holds no two levels of the drive"
RUN = "record a start from rest at one level, and a second level beside it"


class OneLevelError(DataError):
    """The drive is at one level wherever the motor turns."""


def refuse(motions: Sequence[Motion]) -> None:
    """Raises OneLevelError where a drive is at one level wherever the motor turns."""
    if motions[0].drive_name == COASTING:
        return
    driven = [_in_motion(motion) for motion in motions]
    signed = np.concatenate(driven)
    if len(signed) < FEWEST_SAMPLES:
        return
    own = max(noise(motion.drive) for motion in motions)
    spread = float(np.sqrt(max(float(np.var(signed)) - own**2, 0.0)))
    volts = motions[0].drive_name in (VOLTAGE, COMMAND)
    if spread > (VARIES if volts else CURRENT_VARIES) * abs(float(np.mean(signed))):
        return
    name = motions[0].drive_name.replace("_", " ")
    raise OneLevelError(
        f"the {name} stays near one level while the motor turns ({_percent(spread, signed)} about "
        "its mean). Friction and back-EMF cannot be separated at one level. "
        f"To separate them, {RUN}; or leave friction out by --without T0: the gain is then "
        "the speed for the drive at this level"
    )


def _percent(spread: float, signed: Floats) -> str:
    return f"± {100.0 * spread / abs(float(np.mean(signed))):.2g} %"


def _in_motion(motion: Motion) -> Floats:
    """The drive in the direction of the motion, where the motor surely turns."""
    parts = [
        (np.abs(motion.drive[one.slice]) if motion.unsigned else one.sign * motion.drive[one.slice])
        for one in motion.stretches(FEWEST_SAMPLES * motion.period_s)
    ]
    return np.concatenate([np.zeros(0), *parts])


def settled(found: Estimate, drive: str) -> Estimate:
    """Without a friction where volts, or a command, show no gain beside it."""
    gain, friction = found.combinations.get(GAIN), found.combinations.get(FRICTION)
    if drive not in (VOLTAGE, COMMAND) or gain is None or friction is None:
        return found
    if gain.value is not None or friction.value is None:
        return found
    said = Diagnostic(
        "one_level", "warning",
        "the drive changes too little, or only with the speed, to separate friction from "
        f"back-EMF: the log determines neither. To separate them, {RUN}",
    )  # fmt: skip
    return replace(
        found,
        combinations={**found.combinations, FRICTION: unknown(FRICTION, friction.unit, ONE)},
        diagnostics=(said, *found.diagnostics),
        not_stated=_frictionless(found.not_stated),
    )


def as_one(frictionless: Estimate) -> Estimate:
    """A fit without friction for what it is: its gain is the speed for the drive at this level."""
    gain, friction = (frictionless.combinations[name] for name in (GAIN, FRICTION))
    said = Diagnostic(
        "one_level", "warning",
        "the drive stays near one level while the motor turns, where friction and back-EMF cannot "
        f"be separated: {WHOLE} is the speed for the drive at this level, and the time constant "
        f"takes small changes of the drive to act by it. To separate them, {RUN}",
    )  # fmt: skip
    told = {n: p for n, p in frictionless.combinations.items() if n not in (GAIN, FRICTION)}
    whole = replace(gain, name=WHOLE, note="steady speed for the drive")
    unknowns = {p.name: unknown(p.name, p.unit, ONE) for p in (gain, friction)}
    return replace(
        frictionless,
        combinations={**told, WHOLE: whole, **unknowns},
        free=tuple(WHOLE if name == GAIN else name for name in frictionless.free),
        diagnostics=(said, *frictionless.diagnostics),
        not_stated=_frictionless(frictionless.not_stated, WHOLE),
    )


def _frictionless(
    moves: Mapping[str, Mapping[str, float]], gain: str = GAIN
) -> dict[str, dict[str, float]]:
    """What gains nobody stated would do, without the friction, and the gain by another name."""
    return {
        cause: {gain if n == GAIN else n: move for n, move in each.items() if n != FRICTION}
        for cause, each in moves.items()
    }
