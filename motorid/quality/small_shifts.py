"""Charts that see a small and lasting shift sooner than a point beyond three sigma: EWMA, CUSUM.

EWMA (Roberts 1959): z = w x + (1 - w) z, with limits of L sigma √(w/(2 - w) (1 - (1 - w)^(2 i))).
Tabular CUSUM (Page 1954): C+ = max(0, x - (target + K) + C+), and C- likewise below the target.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError
from motorid.quality.charts import Chart
from motorid.quality.rules import Alarm

Floats = NDArray[np.float64]
WEIGHT, WIDTH = 0.2, 2.962  # an in-control run of 500 (Lucas and Saccucci 1990)
SLACK, DECISION = 0.5, 5.0  # sigma; an in-control run of 465 (Montgomery, table 9.3)


def ewma(
    values: Floats,
    target: float,
    sigma: float,
    *,
    weight: float = WEIGHT,
    width: float = WIDTH,
    baseline: int = 0,
) -> Chart:
    """The EWMA of ``values`` (n,) about ``target``.

    ``lower`` and ``upper`` are the limits of a long series; alarms are by those of each point,
    which are narrower at the start. Raises UsageError for a weight outside 0 to 1.
    """
    if not 0.0 < weight <= 1.0 or not width > 0.0:
        raise UsageError("an EWMA needs a weight above 0, at most 1, and limits wider than nothing")
    _refuse(values, sigma)
    points = np.empty(len(values))
    last = target
    for k, x in enumerate(values):
        last = weight * float(x) + (1.0 - weight) * last
        points[k] = last
    settled = (1.0 - weight) ** (2.0 * np.arange(1, len(values) + 1))
    long_run = sigma * float(np.sqrt(weight / (2.0 - weight)))
    half = width * long_run * np.sqrt(1.0 - settled)
    out = np.flatnonzero(np.abs(points - target) > half)
    found = tuple(Alarm(int(k), int(k), "EWMA", "the weighted mean beyond its limits") for k in out)
    reach = width * long_run
    return Chart("EWMA", points, target, target - reach, target + reach, long_run, baseline, found)


def cusum(
    values: Floats,
    target: float,
    sigma: float,
    *,
    slack: float = SLACK,
    decision: float = DECISION,
    baseline: int = 0,
) -> tuple[Chart, Chart]:
    """The upper and the lower CUSUM of ``values`` (n,), in their unit; ``lower`` counts down.

    ``slack`` K and ``decision`` H are in sigma. Raises UsageError where they are not positive.
    """
    if slack < 0.0 or not decision > 0.0:
        raise UsageError("a CUSUM needs a slack of 0 or more and a decision interval above 0")
    _refuse(values, sigma)
    k, h = slack * sigma, decision * sigma
    above, below = np.empty(len(values)), np.empty(len(values))
    up = down = 0.0
    for n, x in enumerate(values):
        up = max(0.0, float(x) - (target + k) + up)
        down = max(0.0, (target - k) - float(x) + down)
        above[n], below[n] = up, down
    return (
        Chart("CUSUM above", above, 0.0, 0.0, h, sigma, baseline, _beyond(above, h, "above")),
        Chart("CUSUM below", -below, 0.0, -h, 0.0, sigma, baseline, _beyond(below, h, "below")),
    )


def _beyond(sums: Floats, limit: float, side: str) -> tuple[Alarm, ...]:
    """``first``: where the sum that passes the limit left zero, which is when the shift began."""
    zeros = np.flatnonzero(sums == 0.0)
    return tuple(
        Alarm(int(k), int(max(zeros[zeros < k], default=-1)) + 1, "CUSUM",
              f"the process has shifted {side} its target")
        for k in np.flatnonzero(sums > limit)
    )  # fmt: skip


def _refuse(values: Floats, sigma: float) -> None:
    if len(values) < 2:
        raise DataError("a chart of small shifts needs two readings or more")
    if not sigma > 0.0:
        raise DataError("the baseline's readings are all equal: no limits follow from them")
