"""The resistance of what drove the motor of a log: a supply, a bridge and cables before the meter.

    v = u - r i

Between two jumps of the command u stays, so that the voltage follows the current. After a step the
current rises within a few samples, or within one, and what the terminals had meanwhile no line
between two readings tells. The source u is known there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.voltage_jumps import changes, jumps, level_jumps

Floats = NDArray[np.float64]

SKIPPED = 2  # readings after a jump, which may have come in its middle
FEWEST = 8  # others, of a stretch that tells
SURE = 10.0  # standard deviations by which a resistance is any


def source(volts: Floats, amperes: Floats) -> tuple[float, NDArray[np.intp]]:
    """Ohm before the terminals, by their readings (n,), 0: none is sure; and the readings before
    which the source jumped.

    Where it stays at levels, its jumps are clearer than those of the terminals, which follow the
    current of a quick winding from reading to reading.
    """
    known = np.nan_to_num(amperes)
    roughly = source_ohms(volts, amperes, changes(volts))
    steps = level_jumps(volts + roughly * known) if roughly else None
    if steps is None:
        steps = jumps(volts)
    ohms = source_ohms(volts, amperes, steps)
    found = level_jumps(volts + ohms * known) if ohms else None
    return ohms, steps if found is None else found


def source_ohms(volts: Floats, amperes: Floats, steps_off: NDArray[np.intp]) -> float:
    """Ohm before the terminals, by their readings (n,) between the jumps; 0: none is sure."""
    di, dv = [], []
    for v, i in zip(np.split(volts, steps_off), np.split(amperes, steps_off), strict=True):
        v, i = v[SKIPPED:], i[SKIPPED:]
        if len(v) >= FEWEST and np.isfinite(i).all():
            di.append(i - i.mean())
            dv.append(v - v.mean())
    if len(di) < 2:
        return 0.0
    currents, rises = np.concatenate(di), np.concatenate(dv)
    weight = float(currents @ currents)
    if not weight:
        return 0.0
    ohms = -float(currents @ rises) / weight
    left = rises + ohms * currents
    deviation = np.sqrt(float(left @ left) / len(left) / weight)
    return ohms if ohms > SURE * deviation else 0.0
