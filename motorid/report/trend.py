"""A trend for a terminal, for a script and as a page with its charts."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from motorid.quality.capability import NOT_NORMAL, Capability, Index
from motorid.quality.charts import Chart
from motorid.quality.trend import Trend
from motorid.report.gauge import columns
from motorid.report.json_ import plain
from motorid.report.numbers import scaled_unit, significant
from motorid.report.page import figure, page, paragraph, section, table
from motorid.report.plot import Plot, axis, legend

TREND_SCHEMA = "motorid-trend-1"
STYLE = "<style>path.dots.alarm{stroke:var(--error);stroke-width:9}</style>"


def headline(trend: Trend) -> str:
    """The answer in a sentence."""
    state = "in control" if trend.in_control else "OUT OF CONTROL"
    return f"{trend.quantity}: {len(trend.values)} readings, {state}"


def scale(trend: Trend) -> tuple[str, float]:
    """Unit of the readings as shown, and the factor to it."""
    return scaled_unit(trend.unit, float(np.max(np.abs(trend.values))))


def chart_rows(trend: Trend) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the charts' limits."""
    unit, f = scale(trend)
    head = ["chart", "points", f"centre, {unit}" if unit else "centre", "lower", "upper", "alarms"]
    return head, [
        [
            chart.name,
            str(len(chart.points)),
            *(significant(v * f, 6) for v in (chart.centre, chart.lower, chart.upper)),
            str(len(chart.alarms)),
        ]
        for chart in trend.charts
    ]


def index_rows(trend: Trend) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the indices."""
    able = trend.capability
    assert able is not None
    named = [("Cp", able.cp), ("Cpk", able.cpk), ("Pp", able.pp), ("Ppk", able.ppk)]
    skewed = able.shape != "normal"
    return ["index", "value", "95 % interval"], [
        [name, *_index(index, "of a normal shape" if skewed and name[0] == "C" else "one limit")]
        for name, index in named
    ]


def _index(index: Index, why: str) -> tuple[str, str]:
    if index.value is None or index.interval is None:
        return "—", why
    return f"{index.value:.3f}", f"{index.interval[0]:.3f} to {index.interval[1]:.3f}"


def sentences(trend: Trend) -> list[str]:
    """What the tables do not say."""
    said = []
    able = trend.capability
    if able is not None:
        said.append(
            f"outside the limits: {able.ppm_seen:.0f} ppm seen, {able.ppm_expected:.3g} ppm "
            "expected of the shape"
        )
        said.append(f"shape: {able.why}")
        said += _of_shape(trend, able)
    if trend.drift is not None:
        low, high = trend.drift.interval_95
        said.append(
            f"drift {trend.drift.per_day:.3g} {trend.unit} a day over {trend.drift.days:.1f} days, "
            f"95 % interval {low:.3g} to {high:.3g}"
        )
    return said


def _of_shape(trend: Trend, able: Capability) -> list[str]:
    said = []
    if able.percentiles is not None:
        unit, f = scale(trend)
        low, middle, high = (significant(value * f, 4) for value in able.percentiles)
        said.append(f"0.135 %, median, 99.865 %: {low}, {middle}, {high} {unit}".rstrip())
    if able.fit_p < NOT_NORMAL:
        said.append(
            f"the shape does not fit the readings (Shapiro-Wilk p = {able.fit_p:.2g} of their "
            "normal scores): indices and ppm mislead"
        )
    return said


def text(trend: Trend) -> str:
    """The trend as tables for a terminal."""
    lines = [headline(trend), *columns(*chart_rows(trend))]
    if trend.capability is not None:
        lines += ["", *columns(*index_rows(trend))]
    lines += sentences(trend)
    lines += [f"ALARM {alarm}" for alarm in trend.alarms]
    return "\n".join(lines)


def to_dict(trend: Trend) -> dict[str, Any]:
    """Plain data of the trend."""
    able = trend.capability
    return {
        "schema": TREND_SCHEMA,
        "quantity": trend.quantity,
        "unit": trend.unit,
        "readings": len(trend.values),
        "subgroup": trend.subgroup,
        "rules": trend.rules,
        "in_control": trend.in_control,
        "alarms": list(trend.alarms),
        "charts": [_chart(chart) for chart in trend.charts],
        "capability": None
        if able is None
        else plain(
            {**vars(able), **{n: vars(getattr(able, n)) for n in ("cp", "cpk", "pp", "ppk")}}
        ),
        "drift": None if trend.drift is None else plain(vars(trend.drift)),
    }


def _chart(chart: Chart) -> dict[str, Any]:
    kept = {k: plain(v) for k, v in vars(chart).items() if k != "alarms"}
    return kept | {"alarms": [vars(alarm) for alarm in chart.alarms]}


def html(trend: Trend) -> str:
    """The whole page."""
    title = f"Trend of {trend.quantity}"
    unit, _ = scale(trend)
    alarms = "".join(f'<li class="error">{escape(alarm)}</li>' for alarm in trend.alarms)
    parts = [STYLE, f"<h1>{escape(title)}</h1>", paragraph(headline(trend), "summary")]
    parts += [f'<ul class="findings">{alarms}</ul>'] if alarms else []
    plots = [plot(trend, chart, unit) for chart in trend.charts]
    parts.append(section("Control charts", table(*chart_rows(trend)), *plots))
    if trend.capability is not None:
        parts.append(section("Capability", table(*index_rows(trend)), _histogram(trend, unit)))
    parts += [paragraph(said) for said in sentences(trend)]
    return page(title, parts)


def plot(trend: Trend, chart: Chart, unit: str, links: Sequence[str] = ()) -> str:
    """One chart; ``links``: where each of its points leads."""
    factor = scale(trend)[1]
    at = np.arange(len(chart.points), dtype=np.float64) + 1.0 + chart.first
    levels = np.array([chart.lower, chart.upper])
    label = f"{trend.quantity}, {unit}" if unit else trend.quantity
    shown = Plot(
        axis([at], "point", margin=0.01),
        axis([chart.points, levels], label, factor),
        f"{chart.name} chart of {trend.quantity} with its control limits",
    )
    if chart.baseline < len(chart.points):
        shown.band(0.0, at[chart.baseline - 1] + 0.5, "steady", "baseline")
    shown.line(at, chart.points, "measured")
    if len(at) <= 400:
        shown.dots(at, chart.points, "measured")
    hit = sorted({alarm.index for alarm in chart.alarms})
    shown.dots(at[hit], chart.points[hit], "alarm")
    shown.rule(chart.centre, "zero")
    for level in (chart.lower, chart.upper):
        shown.rule(level)
    shown.links(at, chart.points, links)
    keys = legend([("measured", "point"), ("dots alarm", "completes a rule's pattern")])
    return figure(f"{chart.name} chart", keys, shown.render(), aside="dashed: control limits")


def _histogram(trend: Trend, unit: str) -> str:
    able, factor = trend.capability, scale(trend)[1]
    assert able is not None
    limits: Sequence[float] = [v for v in (able.lower, able.upper) if v is not None]
    counts, edges = np.histogram(trend.values, bins="auto")
    x = axis([edges, np.array(limits)], f"{trend.quantity}, {unit}", factor)
    top = np.array([0.0, float(counts.max())])
    plot = Plot(x, axis([top], "readings"), f"Histogram of {trend.quantity} with its limits")
    plot.bars(edges, counts.astype(float), "histogram")
    for limit in limits:
        plot.line(np.full(2, limit), top, "rule")
    return figure("Readings against the limits", plot.render(), aside="dashed: limits")
