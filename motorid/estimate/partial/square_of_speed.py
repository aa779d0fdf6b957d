"""A load that grows with the square of the speed, as of a fan, in a balance.

The balance is solved once more with a term for it. Where its size stands out, the values stay, and
one finding says how far each is from what it is beside that term. Where it does not, what such a
load may be as it usually is, or as the data half support, is in the uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import VOLTAGE
from motorid.estimate.assembly.covering import covering_sides
from motorid.estimate.assembly.doubt import settled
from motorid.estimate.effects.friction.windage import USUAL
from motorid.estimate.partial.block_bootstrap_regression import Regression
from motorid.estimate.partial.further_terms import NEEDED, STANDS_OUT, gain, left_open, slope
from motorid.estimate.partial.mechanical_signals import COMMAND
from motorid.estimate.partial.modulating_functions import COASTING_PWM, COLUMNS, SQUARE
from motorid.estimate.results.estimate import Diagnostic, Estimate

Floats = NDArray[np.float64]

Regress = Callable[[Sequence[str]], Regression | None]


@dataclass(frozen=True)
class Square:
    """``wider``: the balance with such a load, where it stands out; else ``moves`` (4,) that one
    may make of the balance without.
    """

    wider: Regression | None
    moves: tuple[Floats, ...] = ()


def looked_for(drive: str, best: Regression, regress: Regress) -> Square:
    """``regress`` solves the balance with those terms, SQUARE the first of them."""
    wider = regress((SQUARE,))
    if wider is None:
        return Square(None)
    place = len(COLUMNS)
    size, deviation = float(wider.coefficients[place]), float(wider.sigma[place])
    if size > STANDS_OUT * deviation and gain(wider, place) > NEEDED:
        return Square(wider)
    left = left_open(max(size, 0.0), deviation, USUAL * _friction(drive, best))
    return Square(None, (left * slope(wider, place),))


def named(plain: Estimate, wider: Estimate, drive: str) -> Estimate:
    """The plain balance's values, doubtful where the ``wider`` one's intervals reach beyond theirs,
    and the finding.
    """
    values, others = ({**e.parameters, **e.combinations} for e in (plain, wider))
    moves, sides, told = {}, {}, []
    for name, p in values.items():
        other, found = others[name], covering_sides(p, others[name])
        if found is not None:
            sides[name], moves[name] = found, max(found)
            told.append(f"{name} {other.value:.4g} ± {other.total:.2g} {other.unit}")
        elif other.value is None and p.value:
            moves[name] = math.inf  # nothing says how far
            told.append(f"no {name}")
    if not moves:
        return plain
    said = Diagnostic(
        "better_model", "warning",
        f"the balance shows a load that grows with the square of speed, as a fan's{like(drive)}: "
        f"the values do without it and are biased. With it: {', '.join(told)}",
        moves, sides,
    )  # fmt: skip
    doubtful = settled(plain, [said])
    return replace(doubtful, diagnostics=(said, *doubtful.diagnostics))


def like(drive: str) -> str:
    """What else has that shape where the motor's own voltage may not be what was logged."""
    return COASTING_PWM if drive in (VOLTAGE, COMMAND) else ""


def _friction(drive: str, best: Regression) -> float:
    """Of the drive, at 1 rad/s: viscous friction, which in volts nobody tells from K; there what
    dry friction takes of the top speed.
    """
    if drive not in (VOLTAGE, COMMAND):
        return max(float(best.coefficients[1]), 0.0)
    speed = float(np.abs(best.rows.matrix[:, 1] / best.rows.weight).max())
    return max(float(best.coefficients[2]), 0.0) / speed if speed else 0.0
