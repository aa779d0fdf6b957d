"""A quantity over time: charts, capability against its limits, a golden motor's drift, alarms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.quality.capability import Asked, Capability, capability
from motorid.quality.charts import Chart, Drift, drift, i_mr, xbar_r
from motorid.quality.rules import RuleSet
from motorid.quality.small_shifts import cusum, ewma

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Trend:
    """``charts``: of location, of spread, then of small shifts if asked.

    ``days`` (n,) from the first reading.

    ``alarms``: a sentence for each thing that is out of order; none: the process is in control.
    """

    quantity: str
    unit: str
    values: Floats
    days: Floats
    subgroup: int
    rules: RuleSet
    charts: tuple[Chart, ...]
    capability: Capability | None
    drift: Drift | None
    alarms: tuple[str, ...]

    @property
    def in_control(self) -> bool:
        """Nothing alarmed."""
        return not self.alarms


def trend(
    values: Floats,
    days: Floats,
    *,
    quantity: str = "value",
    unit: str = "",
    lower: float | None = None,
    upper: float | None = None,
    subgroup: int = 1,
    baseline: int | None = None,
    rules: RuleSet = "western-electric",
    golden: bool = False,
    least_ppk: float | None = None,
    small_shifts: bool = False,
    shape: Asked = "auto",
    power: float | None = None,
) -> Trend:
    """The trend of ``values`` (n,) in their order; ``days`` (n,) say when.

    ``subgroup`` readings make a point of the chart; ``baseline`` first points set its limits.
    ``small_shifts``: EWMA and CUSUM charts about the first chart's centre as well.
    ``shape``, ``power``: of the capability, see there.
    ``golden``: all readings are of one motor, so that a drift is the gauge's. Raises DataError for
    too few readings, UsageError for a baseline or limits that make no sense.
    """
    charts: tuple[Chart, ...]
    if subgroup > 1:
        whole = len(values) // subgroup * subgroup
        charts = xbar_r(values[:whole].reshape(-1, subgroup), baseline=baseline, rules=rules)
    else:
        charts = i_mr(values, baseline=baseline, rules=rules)
    if small_shifts:
        charts = (*charts, *_of_small_shifts(charts[0]))
    limited = lower is not None or upper is not None
    able = (
        capability(values, lower, upper, subgroup=subgroup, shape=shape, power=power)
        if limited
        else None
    )
    moved = drift(days, values) if golden else None
    alarms = [*_of_charts(charts), *_of_drift(moved, unit), *_of_index(able, least_ppk)]
    return Trend(quantity, unit, values, days, subgroup, rules, charts, able, moved, tuple(alarms))


def _of_small_shifts(chart: Chart) -> tuple[Chart, ...]:
    """Of a chart of location: about its centre, by the sigma of its points."""
    about = chart.points, chart.centre, chart.sigma
    return (ewma(*about, baseline=chart.baseline), *cusum(*about, baseline=chart.baseline))


def _of_charts(charts: tuple[Chart, ...]) -> list[str]:
    """One sentence a chart and rule, with the points that complete its pattern."""
    said = []
    for chart in charts:
        by_rule: dict[tuple[str, str], list[int]] = {}
        for alarm in chart.alarms:
            key = alarm.rule, alarm.meaning
            by_rule.setdefault(key, []).append(alarm.index + chart.first + 1)
        for (rule, meaning), points in by_rule.items():
            shown = ", ".join(map(str, points[:8])) + (", …" if len(points) > 8 else "")
            said.append(f"{chart.name} chart, rule {rule}: {meaning}, at point {shown}")
    return said


def _of_drift(found: Drift | None, unit: str) -> list[str]:
    if found is None or not found.significant:
        return []
    low, high = found.interval_95
    return [
        f"the golden motor drifts by {found.per_day:.3g} {unit} a day "
        f"(95 %: {low:.3g} to {high:.3g}): calibrate the station"
    ]


def _of_index(found: Capability | None, least: float | None) -> list[str]:
    if found is None or least is None or (found.ppk.value or 0.0) >= least:
        return []
    return [f"Ppk is {found.ppk.value:.2f}, below the {least:g} that was asked for"]
