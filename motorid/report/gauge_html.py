"""A gauge study as one HTML file, with the plots that the AIAG's form asks for."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from motorid.quality.gauge import GaugeResult
from motorid.quality.ranges import a2, range_limits
from motorid.report.gauge import (
    METHODS,
    anova_rows,
    claim,
    component_rows,
    design_of,
    headline,
)
from motorid.report.numbers import scaled_unit
from motorid.report.page import figure, page, paragraph, section, table
from motorid.report.plot import Axis, Plot, axis, legend

Floats = NDArray[np.float64]
HUES = (205, 25, 145, 280, 55, 340)  # far apart, also for most who see few colours
NO_TICKS = 1e9  # a step beyond any axis
STYLE = "rect.none{fill:none}" + "".join(
    f"path.o{k}{{stroke:hsl({hue} 65% 45%);stroke-width:1.6}}"
    f"path.dots.o{k}{{stroke:hsl({hue} 65% 45%);stroke-width:7}}"
    for k, hue in enumerate(HUES)
)


def render(results: Sequence[GaugeResult], title: str = "Gauge study") -> str:
    """The whole page: a section a quantity."""
    design = design_of(results[0])
    head = f"<style>{STYLE}</style><h1>{escape(title)}</h1>"
    answers = "".join(paragraph(headline(result), "summary") for result in results)
    return page(title, [head, paragraph(design, "kicker"), answers, *map(_section, results)])


def _section(result: GaugeResult) -> str:
    note = f"By {METHODS[result.method]}" + (
        ", the interaction pooled into EV." if result.pooled else "."
    )
    anova = table(*anova_rows(result.table)) if result.table else ""
    plots = (
        '<div class="pair">' + "".join(f"<div>{plot}</div>" for plot in _plots(result)) + "</div>"
    )
    return section(
        result.study.quantity,
        paragraph(headline(result), "summary"),
        table(*component_rows(result)),
        paragraph(note, "note"),
        paragraph(claim(result)),
        anova,
        plots,
    )


def _plots(result: GaugeResult) -> list[str]:
    unit, factor = scaled_unit(result.study.unit, float(np.abs(result.study.values).max()))
    values = result.study.values
    cells, ranges = values.mean(axis=2), np.ptp(values, axis=2)
    label = f"{result.study.quantity}, {unit}" if unit else result.study.quantity
    of_operators = [
        _components(result),
        _by_operator(
            result, ranges, "Ranges by operator", f"range of {label}", factor, spread=True
        ),
        _by_operator(result, cells, "Averages by operator", label, factor, spread=False),
    ]
    if result.method == "nested":
        return of_operators  # no part is measured by two operators
    return [
        *of_operators,
        _by_part(result, label, factor),
        _interaction(result, cells, label, factor),
    ]


def _components(result: GaugeResult) -> str:
    """Bars of each source's share: of the study, of the variance, of the tolerance."""
    symbols = [s for s in result.components if s != "TV"]
    sets = [("percent_study", "% of study variation"), ("percent_contribution", "% contribution")]
    sets += [("percent_tolerance", "% of tolerance")] if result.tolerance else []
    heights = {
        name: np.array([getattr(result.components[s], name) for s in symbols]) for name, _ in sets
    }
    top = max(100.0, *(float(np.max(h)) for h in heights.values())) * 1.04
    x = Axis(-0.5, len(symbols) - 0.5, NO_TICKS)
    plot = Plot(x, Axis(0, top, 20.0, "%"), "Components of variation, in percent")
    width = 0.8 / len(sets)
    for k, (name, _) in enumerate(sets):
        for at, height in enumerate(heights[name]):
            left = at - 0.4 + k * width
            edges = np.array([left, left + width * 0.9])
            plot.bars(edges, np.array([height]), f"histogram o{k}")
            plot.line(edges, np.full(2, height), f"o{k}")
    for at, symbol in enumerate(symbols):
        plot.band(at - 0.5, at + 0.5, "steady" if at % 2 else "none", symbol)
    keys = legend([(f"o{k}", word) for k, (_, word) in enumerate(sets)])
    return figure("Components of variation", keys, plot.render(x_ticks=False))


def _by_operator(
    result: GaugeResult, points: Floats, title: str, label: str, factor: float, *, spread: bool
) -> str:
    """A control chart with each operator's parts side by side."""
    parts, operators = points.shape
    repeats = result.study.repeats
    ranges = np.ptp(result.study.values, axis=2)
    mean = float(ranges.mean())
    if spread:
        low, high = (f * mean for f in range_limits(repeats))
        centre = mean
    else:
        centre = float(points.mean())
        low, high = centre - a2(repeats) * mean, centre + a2(repeats) * mean
    x = Axis(-0.5, parts * operators - 0.5, NO_TICKS)
    plot = Plot(x, axis([points, np.array([low, high])], label, factor), title)
    for o, name in enumerate(result.study.operators):
        at = np.arange(parts) + o * parts
        plot.band(o * parts - 0.5, (o + 1) * parts - 0.5, "steady" if o % 2 else "none", name)
        plot.line(at.astype(float), points[:, o], f"o{o % len(HUES)}")
        plot.dots(at.astype(float), points[:, o], f"o{o % len(HUES)}")
    plot.rule(centre, "zero")
    for limit in (low, high):
        plot.rule(limit)
    aside = "parts in their order; dashed: control limits"
    return figure(title, plot.render(x_ticks=False), aside=aside)


def _by_part(result: GaugeResult, label: str, factor: float) -> str:
    """Every reading of each part."""
    values = result.study.values
    parts = len(values)
    x = Axis(0.4, parts + 0.6, max(1.0, round(parts / 10)), "part, in the order of the study")
    plot = Plot(x, axis([values], label, factor), "Readings by part")
    at = np.arange(1.0, parts + 1)
    plot.dots(np.repeat(at, values[0].size), values.reshape(parts, -1).ravel(), "small")
    plot.line(at, values.mean(axis=(1, 2)), "fitted")
    return figure("Readings by part", plot.render(), aside="line: averages")


def _interaction(result: GaugeResult, cells: Floats, label: str, factor: float) -> str:
    """Each operator's averages over the parts: parallel lines are no interaction."""
    parts, operators = cells.shape
    x = Axis(0.4, parts + 0.6, max(1.0, round(parts / 10)), "part, in the order of the study")
    centred = cells - cells.mean(axis=1, keepdims=True)
    plot = Plot(x, axis([centred], f"deviation of {label}", factor), "Operator by part")
    at = np.arange(1.0, parts + 1)
    for o in range(operators):
        plot.line(at, centred[:, o], f"o{o % len(HUES)}")
        plot.dots(at, centred[:, o], f"o{o % len(HUES)}")
    plot.rule(0.0, "zero")
    keys = legend([(f"o{o % len(HUES)}", name) for o, name in enumerate(result.study.operators)])
    return figure("Operator by part", keys, plot.render(), aside="less the part's average")
