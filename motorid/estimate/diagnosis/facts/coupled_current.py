"""A current that was measured through a capacitor: an oscilloscope's input set to AC.

Such an input blocks what does not change. With a time constant T it shows y of a current i,

    dy/dt = di/dt - y/T,    so that    i = y + (1/T) integral of y.

Where the current that is restored so follows a motor's laws and the logged one does not, there was
a capacitor in its way. The integral of any current looks like a speed, and so like friction: a
noisy speed, whose slope follows no current, suits it. The voltage has to speak for it as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.facts.motor_laws import columns, convinces, left
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic

Floats = NDArray[np.float64]

LEAST = 0.01  # that the logged one leaves: below it, nothing is worth a word
FEW, MANY = 20.0, 10.0  # time constants that are tried: from so many rows to so many whole logs
A_DECADE = 8  # of them
ELECTRICAL = 0.7  # of what the logged one leaves of the voltage, at most


def findings(capture: Capture, where: str = "") -> Iterator[Diagnostic]:
    """A log of such a current. ``where``: " in run 2", or nothing."""
    rows = found(capture)
    if rows is None:
        return
    hertz = 1.0 / (2.0 * math.pi * rows * capture.period_s)
    yield Diagnostic(
        "current_coupled", "error",
        f"the current is AC-coupled{where}: the readings follow a motor's laws only behind a "
        f"high-pass of about {hertz:.2g} Hz in the current's way. Set the input to DC, or use a "
        "probe that shows a steady current",
        dict.fromkeys(PARAMETERS, math.inf),
    )  # fmt: skip


def found(capture: Capture) -> float | None:
    """The time constant (rows) that restores a log's current; None: it needs none."""
    logged = columns(capture)
    if logged is None:
        return None
    volts, current, speed = logged
    as_it_is = left(volts, current, speed)
    if sum(as_it_is) < LEAST:
        return None
    constants = _constants(len(current))
    rests = [left(volts, restored(current, rows), speed) for rows in constants]
    best = int(np.argmin([sum(both) for both in rests]))
    if not 0 < best < len(rests) - 1:  # another fault, which any slope eases
        return None
    if rests[best][0] > ELECTRICAL * as_it_is[0]:  # only the second law, which a speed suits
        return None
    return float(constants[best]) if convinces(rests[best], as_it_is) else None


def restored(current: Floats, rows: float) -> Floats:
    """A current (n,) as it was before a high-pass of that time constant, from none on."""
    return np.asarray(current + np.cumsum(current) / rows)


def _constants(rows: int) -> Floats:
    decades = math.log10(MANY * rows / FEW)
    return np.geomspace(FEW, MANY * rows, max(int(A_DECADE * decades), 2))
