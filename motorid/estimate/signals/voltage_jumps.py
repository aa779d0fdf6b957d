"""Where a logged voltage jumps from a reading to the next, and how much its readings scatter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.neighbour_noise import of_differences

Floats = NDArray[np.float64]

CALM = 16  # stretches of a log, of which the calmer ones tell its noise
ENOUGH = 64  # readings of each
SAME = 1e-9  # of the range: readings that differ by less agree but for rounding
COARSE = 0.02  # of the range: larger steps are levels of a command, and no converter's
CLEAR, SHARE = 8.0, 0.05  # a jump in standard deviations of a reading, and of the range


def jumps(volts: Floats) -> NDArray[np.intp]:
    """Readings (n,) before which the voltage jumped."""
    return np.asarray(np.flatnonzero(np.abs(np.diff(volts)) > least_jump(volts)) + 1, dtype=np.intp)


def least_jump(volts: Floats) -> float:
    """V that readings (n,) differ by where the voltage jumped."""
    return max(CLEAR * scatter(volts), SHARE * float(np.ptp(volts)))


def scatter(volts: Floats) -> float:
    """Standard deviation of a reading by its neighbours, in the calmer quarter of the log."""
    if len(volts) < CALM * 8:
        return 0.0
    second = np.diff(volts, 2)
    stretches = min(max(len(second) // ENOUGH, CALM // 4), CALM)
    blocks = second[: len(second) // stretches * stretches].reshape(stretches, -1)
    return float(np.percentile(of_differences(blocks, 2, _count_of(volts)), 25))


def _count_of(volts: Floats) -> float:
    """V by which readings in coarse steps differ at least; 0: they change by whole levels."""
    apart, range_v = np.abs(np.diff(volts)), float(np.ptp(volts))
    apart = apart[apart > SAME * range_v]
    step = float(np.percentile(apart, 10)) if len(apart) else 0.0
    return step if step < COARSE * range_v else 0.0
