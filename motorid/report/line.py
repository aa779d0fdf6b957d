"""The page of a production line: yields, reasons, quantities, charts, stations, results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib import resources
from typing import Any

import numpy as np

from motorid.quality.agreement import Share
from motorid.quality.capability import NOT_NORMAL, Index
from motorid.quality.judge import RUNS
from motorid.quality.line import Line, Readings, Reason, Yield
from motorid.quality.quantities import quantity
from motorid.report.numbers import NOTHING, percent, scaled_unit, significant
from motorid.report.page import Link, figure, page, paragraph, section, table
from motorid.report.plot import Plot, axis, legend
from motorid.report.trend import chart_rows, headline, plot, scale

SHOWN_CHARTS = ("individuals", "moving range", "EWMA")
MOST_REASONS = 12
OUTCOMES = ("PASS", "FAIL", "INVALID")
SIDES = {"low": "too low", "high": "too high", "": ""}
INTERVAL = "95 %: "
Cells = Sequence[str | Link]


@dataclass(frozen=True)
class Choice:
    """What the reader may choose, and has chosen. ``link``: the address with some of it changed."""

    chosen: Mapping[str, str]
    products: Sequence[str]
    stations: Sequence[str]
    link: Callable[..., str]


def html(line: Line, choice: Choice, rows: Sequence[Any], where: str, older: str = "") -> str:
    """The whole page. ``rows``: the newest results; ``older``: where those before them are."""
    title = choice.chosen.get("product") or "all products"
    parts = [
        style(),
        f"<h1>Production line: {escape(title)}</h1>",
        paragraph(f"{where}. Times are UTC.", "soft"),
        _form(line, choice),
        _tiles(line.yields),
        section("Yield by day", _days(line.days)),
        section("Reasons, the most frequent first", _reasons(line.reasons, choice)),
        section("Quantities", *_quantities(line, choice)),
        section(f"Charts of {line.quantity}", *_charts(line)) if line.quantity else "",
        section("Stations side by side", *_stations(line, choice)),
        section("Results, the newest first", *_results(rows, older), more=True),
    ]
    return page(f"Line: {title}", [part for part in parts if part])


def style() -> str:
    """What these pages have beside the report's own style."""
    text = resources.files("motorid.report").joinpath("line.css").read_text("utf-8")
    return f"<style>{text}</style>"


# ---- what to look at


def _form(line: Line, choice: Choice) -> str:
    """Works without a script: a browser puts what was chosen into the address."""
    chosen = choice.chosen
    names = [one.name for one in line.quantities]
    fields = [
        _select("product", choice.products, chosen),
        _select("station", choice.stations, chosen),
        *(_input(name, f"{name} (UTC)", chosen, "2026-11-21T06:00") for name in ("from", "to")),
        _select("quantity", names, {"quantity": line.quantity}),
        _input("serial", "serial number", chosen, "D0001*"),
        _select("outcome", OUTCOMES, chosen),
    ]
    return (
        '<form class="filters" method="get" action="./" aria-label="Which results">'
        f'{"".join(fields)}<button type="submit">Show</button></form>'
    )


def _select(name: str, values: Sequence[str], chosen: Mapping[str, str]) -> str:
    now = chosen.get(name, "")
    every = values if now in values or not now else (now, *values)
    options = "".join(
        f'<option value="{escape(one)}"{" selected" if one == now else ""}>{escape(one)}</option>'
        for one in every
    )
    every_one = '<option value="">all</option>'
    return f'<label>{name}<select name="{name}">{every_one}{options}</select></label>'


def _input(name: str, word: str, chosen: Mapping[str, str], example: str) -> str:
    value = escape(chosen.get(name, ""))
    return (
        f'<label>{word}<input name="{name}" value="{value}" placeholder="{example}" '
        'autocomplete="off"></label>'
    )


# ---- counts


def _tiles(found: Yield) -> str:
    invalid = Share(found.tests["INVALID"], found.count)
    tiles = [
        ("tests", f"{found.count:,}", f"of {found.last.of:,} motors judged"),
        ("first-pass yield", *_share(found.first, "first tests")),
        ("yield", *_share(found.last, "motors")),
        ("FAIL", f"{found.tests['FAIL']:,}", "tests"),
        ("INVALID", f"{invalid.found:,}", f"{percent(invalid.value)} of the tests"),
    ]
    return '<dl class="tiles">' + "".join(
        f"<div><dt>{word}</dt><dd>{value}<span>{escape(more)}</span></dd></div>"
        for word, value, more in tiles
    ) + "</dl>"  # fmt: skip


def _share(share: Share, of: str) -> tuple[str, str]:
    if not share.of:
        return NOTHING, f"no {of}"
    low, high = share.interval_95
    return (
        _percent(share.value),
        f"{INTERVAL}{_percent(low)} to {_percent(high)} of {share.of:,} {of}",
    )


def _percent(value: float) -> str:
    return f"{100 * value:.2f} %"


def _days(days: Mapping[str, Yield]) -> str:
    """Both yields against the day."""
    if len(days) < 2:
        return paragraph("One day or less: its yields stand above.", "soft")
    first = next(iter(days))
    at = (np.array(list(days), "datetime64[D]") - np.datetime64(first, "D")).astype(float)
    lines = [
        ("measured", "first-pass yield", [one.first.value for one in days.values()]),
        ("last", "yield", [one.last.value for one in days.values()]),
    ]
    values = [100.0 * np.array(shares) for _, _, shares in lines]
    shown = Plot(
        axis([at], f"days since {first}", margin=0.01), axis(values, "%"),
        f"Yield and first-pass yield of {len(days)} days from {first}", height=10.0,
    )  # fmt: skip
    for (kind, name, _), value in zip(lines, values, strict=True):
        shown.line(at, value, kind, name)
    return figure("Yields of each day", legend([(k, n) for k, n, _ in lines]), shown.render())


def reason_words(name: str, side: str) -> str:
    """What a reason is called: the quantity in words, and the side of its limits."""
    if name == RUNS:
        return "the motor did not run"
    found = quantity(name)
    return " ".join(word for word in (found.meaning if found else name, SIDES[side]) if word)


def _reasons(reasons: Sequence[Reason], choice: Choice) -> str:
    if not reasons:
        return paragraph("Every test passed.")
    rows: list[Cells] = [
        [
            Link(reason_words(one.name, one.side), choice.link(quantity=one.name, before="")),
            one.outcome,
            f"{one.count:,}",
            Link(percent(one.share), picture=_bar(one.share / reasons[0].share)),
            percent(one.together),
        ]
        for one in reasons[:MOST_REASONS]
    ]
    left = sum(one.count for one in reasons[MOST_REASONS:])
    more = paragraph(f"{left:,} more, of other reasons.", "soft") if left else ""
    return table(["reason", "outcome", "verdicts", "share", "together"], rows) + more


def _bar(share: float) -> str:
    return (
        '<svg class="bar" viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true">'
        f'<rect width="{100 * share:.1f}" height="10"/></svg>'
    )


# ---- readings


def _quantities(line: Line, choice: Choice) -> list[str]:
    if not line.quantities:
        return [paragraph("No result here has measured anything.")]
    head = ["quantity", "unit", "readings", "mean", "sd", "low", "high", "Cp", "Cpk", "Ppk", ""]
    rows: list[Cells] = [
        [Link(one.name, choice.link(quantity=one.name)), *_numbers(one), *_indices(one)]
        for one in line.quantities
    ]
    newest = max(len(one.values) for one in line.quantities)
    return [
        table(head, rows),
        paragraph(f"Of the newest {newest} readings at most, as of a normal process.", "soft"),
    ]


def _numbers(one: Readings) -> list[str]:
    unit, f = scaled_unit(one.unit, float(np.max(np.abs(one.values))))
    able = one.capability
    sizes = [able.mean, able.sigma_overall] if able else [None, None]
    told = [
        NOTHING if size is None else significant(f * size) for size in (*sizes, one.low, one.high)
    ]
    return [unit, str(len(one.values)), *told]


def _indices(one: Readings) -> list[str]:
    able = one.capability
    if able is None:
        return [NOTHING, NOTHING, NOTHING, one.why]
    odd = "not normal" if able.normal_p < NOT_NORMAL else ""
    return [*(_index(index) for index in (able.cp, able.cpk, able.ppk)), odd]


def _index(index: Index) -> str:
    return NOTHING if index.value is None else f"{index.value:.2f}"


def _charts(line: Line) -> list[str]:
    found, of_it = line.trend, line.trend_of
    if found is None or of_it is None:
        return [paragraph(f"There are no charts: {line.why}.")]
    alarms = "".join(f'<li class="error">{escape(alarm)}</li>' for alarm in found.alarms)
    unit = scale(found)[0]
    plots = [
        plot(found, chart, unit, [f"result/{one}" for one in of_it.results[chart.first :]])
        for chart in found.charts
        if chart.name in SHOWN_CHARTS
    ]
    hit = sorted({a.index + c.first for c in found.charts for a in c.alarms})
    rows: list[Cells] = [
        [Link(f"point {k + 1}", f"result/{of_it.results[k]}"), f"{of_it.values[k]:.6g}", of_it.unit]
        for k in hit
    ]
    listed = table(["alarm at", "value", "unit"], rows) if rows else ""
    more = (
        f'<details class="more"><summary>{len(rows)} points that alarm</summary>{listed}</details>'
    )
    return [
        paragraph(headline(found), "summary"),
        f'<ul class="findings">{alarms}</ul>' if alarms else "",
        *plots,
        table(*chart_rows(found)),
        more if rows else "",
    ]


# ---- stations and results


def _stations(line: Line, choice: Choice) -> list[str]:
    unit = line.trend_of.unit if line.trend_of else ""
    head = ["station", "tests", "first-pass yield", "yield", "INVALID"]
    head += [f"mean {line.quantity}", "sd", "unit", "Cpk", "mean ± 3 sd within the limits"]
    rows: list[Cells] = []
    for one in line.stations:
        name = one.name or "without a name"
        counted = [
            f"{one.yields.count:,}",
            *(_percent(s.value) if s.of else NOTHING for s in (one.yields.first, one.yields.last)),
            f"{one.yields.tests['INVALID']:,}",
        ]
        able = one.readings.capability if one.readings else None
        told: list[str | Link] = [NOTHING, NOTHING, unit, NOTHING, ""]
        if one.readings is not None and able is not None:
            shown, f = scaled_unit(one.readings.unit, abs(able.mean))
            told = [
                significant(f * able.mean), significant(f * able.sigma_overall, 3), shown,
                _index(able.cpk), Link("", picture=_span(one.readings)),
            ]  # fmt: skip
        rows.append([Link(name, choice.link(station=one.name, before="")), *counted, *told])
    return [table(head, rows)] if rows else []


def _span(one: Readings) -> str:
    """Mean ± 3 sd on an axis from limit to limit, or from 0 where there is one limit."""
    able = one.capability
    assert able is not None
    ends = [end for end in (one.low, one.high) if end is not None]
    low, high = (ends[0], ends[1]) if len(ends) == 2 else sorted((0.0, ends[0]))
    if high == low:
        return ""
    at = [100 * (able.mean + k * able.sigma_overall - low) / (high - low) for k in (-3, 0, 3)]
    left, middle, right = (min(max(k, -10.0), 110.0) for k in at)
    kind = "" if at[0] >= 0 and at[2] <= 100 else ' class="out"'
    return (
        '<svg class="bar" viewBox="-10 0 120 10" preserveAspectRatio="none" aria-hidden="true">'
        '<rect class="limits" width="100" height="10"/>'
        f'<rect{kind} x="{left:.1f}" y="3" width="{max(right - left, 0.5):.1f}" height="4"/>'
        f'<path d="M{middle:.1f} 0V10"/></svg>'
    )


def result_rows(rows: Sequence[Any], before: str = "") -> str:
    """A table of results, each leading to its page; ``before`` stands before the address."""
    head = ["result", "time", "motor", "verdict", "kind", "product", "station"]
    cells: list[Cells] = [
        [
            Link(str(row.id), f"{before}result/{row.id}"), f"{row.at:%Y-%m-%d %H:%M:%S}",
            row.serial, row.outcome + (" MARGINAL" if row.marginal else ""), row.kind, row.product,
            row.station,
        ]
        for row in rows
    ]  # fmt: skip
    return table(head, cells)


def _results(rows: Sequence[Any], older: str) -> list[str]:
    if not rows:
        return [paragraph("There is no such result.")]
    nav = f'<nav><p><a href="{escape(older)}">older results</a></p></nav>' if older else ""
    return [result_rows(rows), nav]
