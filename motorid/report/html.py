"""The report that a person sends to a colleague: one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from html import escape
from typing import Any

import numpy as np

from motorid.estimate.results.estimate import Estimate, Parameter
from motorid.report import alternative, budget, curves, suspects, unstated
from motorid.report.numbers import (
    aligned,
    fixed,
    half_width,
    in_rpm,
    percent,
    relative,
    shown,
    significant,
)
from motorid.report.page import page, paragraph, section
from motorid.report.steady import steady_state
from motorid.report.words import (
    COVERAGE,
    STATUS_WORDS,
    decisive,
    doubts,
    file_name,
    fit_quality,
    instruments,
    name_of,
    one_run,
    others,
    reference,
    remarks,
    sentence,
    six,
    summary,
    traceability,
)

FIGURE_SPACE, DOT_SPACE = "\N{FIGURE SPACE}", "\N{PUNCTUATION SPACE}"
SEVERITY = {"error": "Error", "warning": "Warning", "info": ""}
LEAST_BAR, BAR = 1.0, 100.0
MOST_NAMED = 4  # files, dates or serials at the top


def render(estimate: Estimate) -> str:
    """The whole page as text. Needs nothing but a browser."""
    title = _title(estimate)
    body = [
        _head(estimate, title),
        section("Parameters", _first(estimate), _parameters(estimate), _notes(estimate)),
        alternative.as_html(estimate),
        section("Findings", _findings(estimate)),
        section("Derived figures", _figures(estimate.derived.values())),
        *(section(name, *parts, more=True) for name, parts in _details(estimate)),
        section("Where it comes from", _inputs(estimate), _record(estimate), more=True),
        "<footer>Made by motorid. Nothing on this page is loaded from elsewhere.</footer>",
    ]
    return page(title, body)


def _details(estimate: Estimate) -> list[tuple[str, Sequence[str]]]:
    """Sections after the summary, each with its parts."""
    residuals = (curves.by_segment(estimate), curves.spread(estimate))
    return [
        ("Combinations", [_figures(estimate.combinations.values()), _together(estimate)]),
        ("Suspects", [suspects.as_html(estimate)]),
        ("Measured against fitted", curves.captures(estimate)),
        ("Residuals", [paragraph(fit_quality(estimate)), *residuals]),
        ("Steady state", [steady_state(estimate)]),
        ("Found on the way", [_figures(estimate.nuisance.values())]),
        ("Budget", [budget.as_html(estimate)]),
        ("Correlation", [_correlation(estimate)]),
    ]


def _title(estimate: Estimate) -> str:
    serials = {str(i.get("serial") or "") for i in estimate.inputs} - {""}
    return f"Motor {serials.pop()}" if len(serials) == 1 else "Motor parameters"


def _head(estimate: Estimate, title: str) -> str:
    samples = [i.get("samples") for i in estimate.inputs]
    total = sum(s for s in samples if isinstance(s, int))
    runs = f"{len(estimate.inputs)} run{'s' if len(estimate.inputs) != 1 else ''}"
    kicker = f"Identification report · {runs} · {total:,} samples".replace(",", "\u202f")
    return (
        f'<header><p class="kicker">{escape(kicker)}</p><h1>{escape(title)}</h1>'
        f"{paragraph(summary(estimate), 'summary')}{_facts(estimate)}</header>"
    )


def _facts(estimate: Estimate) -> str:
    """When, by which rig and of which file each came; together where they share it."""
    names = {"captured": "created", "serial": "serial", "rig": "rig_name", "file": "path"}
    rows = []
    for name, key in names.items():
        known = dict.fromkeys(str(i.get(key) or "") for i in estimate.inputs)
        said = [_moment(one) if key == "created" else file_name(one) for one in known if one]
        if said:
            more = f" and {len(said) - MOST_NAMED} more" if len(said) > MOST_NAMED else ""
            words = ", ".join(said[:MOST_NAMED]) + more
            rows.append(f"<dt>{name}</dt><dd>{escape(words)}</dd>")
    return f'<dl class="facts">{"".join(rows)}</dl>' if rows else ""


def _moment(text: str) -> str:
    """2026-11-23T10:02:11+00:00 as a person reads it; any other text as it is."""
    try:
        return f"{datetime.fromisoformat(text):%Y-%m-%d %H:%M %Z}".strip()
    except ValueError:
        return text


def _parameters(estimate: Estimate) -> str:
    rows = six(estimate) + reference(estimate) + others(estimate)
    widest = max((_share(p) for p in rows), default=0.0)
    seen = [shown(p) for p in rows]
    values = aligned([s.value for s in seen], FIGURE_SPACE, DOT_SPACE)
    lines = []
    for p, s, value in zip(rows, seen, values, strict=True):
        half = f'<span class="half">± {escape(s.half)}</span> ' if s.half else ""
        unit = escape(s.unit) if p.value is not None else ""
        status = f'<span class="status {p.status}">{STATUS_WORDS[p.status]}</span>'
        lines.append(
            f'<tr><td class="name">{escape(p.name)}</td><td>{escape(name_of(p))}</td>'
            f'<td class="num value">{escape(value)}</td><td>{half}{unit}</td>'
            f"<td>{_bar(p, widest)}</td>"
            f'<td class="num">{percent(relative(p, p.statistical))}</td>'
            f'<td class="num">{escape(unstated.instrument(estimate, p))}</td><td>{status}</td></tr>'
        )
    scale = f"95 % interval (full width ± {percent(widest)})" if widest else ""
    head = (
        f'<th></th><th></th><th class="num">value</th><th>± 95 %</th><th>{scale}</th>'
        '<th class="num">statistical</th><th class="num">instrument</th><th></th>'
    )
    return (
        f'<div class="scroll"><table class="parameters"><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(lines)}</tbody></table></div>"
    )


def _share(p: Parameter) -> float:
    """Half the interval as a share of the value, at most all of it."""
    share = relative(p, half_width(p))
    return min(share, 1.0) if share is not None and np.isfinite(share) else 0.0


def _bar(p: Parameter, widest: float) -> str:
    """The interval about the value; the darker part is what statistics alone would give."""
    if not _share(p) or not p.total:
        return ""
    half = max(BAR * _share(p) / widest, LEAST_BAR)
    inner = half * min((p.statistical or 0.0) / p.total, 1.0)
    return (
        '<svg class="interval" viewBox="-104 -10 208 20" role="img" '
        f'aria-label="± {percent(_share(p))}"><path class="axis" d="M-104 0H104"/>'
        f'<rect class="total" x="{-half:.1f}" y="-6" width="{2 * half:.1f}" height="12" rx="2"/>'
        f'<rect class="statistical" x="{-inner:.1f}" y="-2" width="{2 * inner:.1f}" height="4"/>'
        '<path class="value" d="M0 -9V9"/></svg>'
    )


def _notes(estimate: Estimate) -> str:
    bars = (
        "Bars show the whole interval; the dark core is what the readings' noise alone "
        "would leave; the rest comes from the instruments and from few runs."
    )
    doubtful = _list(("warning", "Doubtful", text) for text in doubts(estimate, labelled=True))
    texts = [*remarks(estimate), *unstated.lines(estimate), f"{COVERAGE} {bars}"]
    return doubtful + "".join(paragraph(t, "note") for t in texts)


def _first(estimate: Estimate) -> str:
    """What stands above the table: findings that moved a value, or left none."""
    items = _items(_entries(estimate, first=True)) + suspects.items_as_html(estimate, first=True)
    return f'<ul class="findings">{items}</ul>' if items else ""


def _findings(estimate: Estimate) -> str:
    entries = _entries(estimate, first=False)
    if one_run(estimate):
        entries.append(("info", "", one_run(estimate)))
    none = "" if estimate.diagnostics else "No finding about the data or the fit."
    return _list(entries) or paragraph(none)


def _entries(estimate: Estimate, first: bool) -> list[tuple[str, str, str]]:
    """Findings above the table, or the others; the gravest first."""
    order = list(SEVERITY)
    found = [d for d in estimate.diagnostics if decisive(estimate, d) is first]
    found.sort(key=lambda d: order.index(d.severity))
    return [(d.severity, SEVERITY[d.severity], sentence(d.message)) for d in found]


def _list(entries: Iterable[tuple[str, str, str]]) -> str:
    items = _items(entries)
    return f'<ul class="findings">{items}</ul>' if items else ""


def _items(entries: Iterable[tuple[str, str, str]]) -> str:
    return "".join(
        f'<li class="{kind}">{f"<b>{word}</b>" if word else ""}{escape(text)}</li>'
        for kind, word, text in entries
    )


def _figures(parameters: Iterable[Parameter]) -> str:
    """Two columns of name and value."""
    known = [p for p in parameters if p.value is not None]
    rows = [(name_of(p), shown(p).text, in_rpm(p)) for p in known]
    half = (len(rows) + 1) // 2
    tables = "".join(_plain(part) for part in (rows[:half], rows[half:]) if part)
    return f'<div class="figures">{tables}</div>' if rows else ""


def _plain(rows: Iterable[tuple[str, str, str]]) -> str:
    lines = "".join(
        f'<tr><td>{escape(n)}</td><td class="num">{escape(v)}'
        f"{f'<br><span class=soft>{escape(rpm)}</span>' if rpm else ''}</td></tr>"
        for n, v, rpm in rows
    )
    return f"<table><tbody>{lines}</tbody></table>"


def _together(estimate: Estimate) -> str:
    words = "Ratios that these data settle even where a parameter by itself is not known."
    return paragraph(words, "soft") if estimate.combinations else ""


def _correlation(estimate: Estimate) -> str:
    """A table whose colours show the sign and the size."""
    matrix = np.atleast_2d(estimate.correlation)
    names = estimate.free
    if len(names) < 2 or matrix.shape != (len(names), len(names)):
        return ""
    top = "".join(f'<th class="top">{escape(n)}</th>' for n in names)
    lines = "".join(
        f"<tr><th>{escape(n)}</th>{''.join(_cell(float(r)) for r in row)}</tr>"
        for n, row in zip(names, matrix, strict=True)
    )
    words = (
        "How the errors of two estimates go together, from noise alone: near 1 or −1, "
        "the data determine one combination well and the other badly."
    )
    return (
        f'<div class="scroll"><table class="heat"><tr><th></th>{top}</tr>{lines}</table></div>'
        + paragraph(words, "soft")
    )


def _cell(r: float) -> str:
    if not np.isfinite(r):
        return "<td></td>"
    colour = "positive" if r >= 0 else "negative"
    return f'<td style="background:rgb(var(--{colour})/{0.65 * r * r:.2f})">{fixed(r, 2)}</td>'


def _inputs(estimate: Estimate) -> str:
    rows = [
        f'<tr><td class="num">{k + 1}</td><td class="wrap">{escape(str(i.get("path") or "—"))}</td>'
        f'<td class="num">{escape(str(i.get("samples", "—")))}</td>'
        f"<td>{escape(str(i.get('serial') or '—'))}</td>"
        f'<td class="wrap hash">{escape(str(i.get("sha256") or "not stored"))}</td></tr>'
        for k, i in enumerate(estimate.inputs)
    ]
    head = (
        '<th class="num">capture</th><th>file</th><th class="num">samples</th>'
        "<th>serial</th><th>SHA-256</th>"
    )
    taken = dict.fromkeys(sentence(instruments(i)) for i in estimate.inputs if instruments(i))
    meant = [*taken, traceability(estimate)]
    return (
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>{''.join(map(paragraph, meant))}"
        if rows
        else ""
    )


def _record(estimate: Estimate) -> str:
    entries = {"model": estimate.model, "method": estimate.method}
    entries |= {f"option {k}": _words(v) for k, v in estimate.options.items()}
    entries |= {k: _words(v) for k, v in estimate.versions.items()}
    items = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in entries.items())
    return f"<dl>{items}</dl>"


def _words(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{k} = {_words(v)}" for k, v in value.items()) or "none"
    if isinstance(value, list | tuple):
        return ", ".join(_words(v) for v in value) or "none"
    return significant(value, 6) if isinstance(value, float) else str(value)
