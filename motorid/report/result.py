"""The page of one result: its verdict, the captures it rests on and their curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from motorid.capture.model import Capture
from motorid.quality.quantities import quantity
from motorid.report.line import result_rows, style
from motorid.report.numbers import NOTHING, scaled_unit, significant
from motorid.report.page import Link, figure, page, paragraph, section, table
from motorid.report.plot import Plot, axis, thin
from motorid.report.views import traces

COLUMNS = 600  # of a curve


@dataclass(frozen=True)
class Cited:
    """A capture that a result rests on; None: it cannot be read, and ``problem`` says why."""

    record: Any
    capture: Capture | None
    problem: str


def html(
    row: Any, measurements: Sequence[Any], cited: Sequence[Cited], others: Sequence[Any]
) -> str:
    """The whole page. ``others``: every result of the same motor."""
    word = row.outcome or row.kind
    motor = row.serial or "without a serial number"
    marginal = " MARGINAL" if row.marginal else ""
    reasons = [m for m in measurements if m.reason]
    listed = "".join(
        f'<li class="{"error" if m.outcome == "FAIL" else "warning"}">{escape(m.reason)}</li>'
        for m in reasons
    )
    limits = row.limits[:12] if row.limits else "none"
    facts = [
        ("time", f"{row.at:%Y-%m-%d %H:%M:%S} UTC"),
        ("station", row.station or NOTHING),
        ("product", f"{row.product or NOTHING}, limits {limits}"),
        ("kind", row.kind),
        ("motorid", str(row.versions.get("motorid", NOTHING))),
        ("note", row.note or NOTHING),
    ]
    said = "".join(f"<dt>{name}</dt><dd>{escape(value)}</dd>" for name, value in facts)
    parts = [
        style(),
        '<nav><p><a href="../">the line</a></p></nav>',
        f'<h1>Motor {escape(motor)}: <span class="{escape(row.outcome)}">{escape(word)}</span>'
        f"{marginal}</h1>",
        f'<ul class="findings">{listed}</ul>' if listed else "",
        f'<dl class="facts">{said}</dl>',
        section("Verdict", table(*_verdict(measurements))),
        section(
            "Captures", *(part for k, one in enumerate(cited) for part in _capture(row, k, one))
        ),
        section("All results of this motor", result_rows(others, "../")),
    ]
    return page(f"{motor}: {word}", [part for part in parts if part])


def _verdict(measurements: Sequence[Any]) -> tuple[list[str], list[Sequence[str | Link]]]:
    head = ["quantity", "meaning", "value", "u", "low", "high", "guard band", "unit", "outcome"]
    rows: list[Sequence[str | Link]] = []
    for m in measurements:
        sizes = [m.value, m.uncertainty, m.low, m.high, m.guard_band]
        unit, f = scaled_unit(m.unit, abs(m.value or m.high or m.low or 0.0))
        told = [NOTHING if s is None else significant(f * s, d) for s, d in zip(
            sizes, (6, 2, 4, 4, 2), strict=True)]  # fmt: skip
        found = quantity(m.name)
        meaning = found.meaning if found else m.name.replace("_", " ")
        outcome = m.outcome + (" MARGINAL" if m.marginal else "")
        rows.append([m.name, meaning, *told, unit, outcome or NOTHING])
    return head, rows


def _capture(row: Any, number: int, one: Cited) -> list[str]:
    about = f"{one.record.path}, {one.record.samples} samples, {one.record.end_reason}"
    parts = [paragraph(about), f'<p class="hash">SHA-256 {escape(one.record.sha256)}</p>']
    if one.capture is None:
        return [*parts, paragraph(f"Its curves cannot be shown: {one.problem}", "soft")]
    parts.append(paragraph("The file has the recorded SHA-256.", "soft"))
    parts.append(f'<p><a href="{row.id}/report/{number}">Fit it now, and show the report</a></p>')
    for trace in traces(one.capture):
        unit, f = scaled_unit(
            trace.unit,
            float(abs(trace.measured[trace.measured == trace.measured]).max(initial=0.0)),
        )
        shown = Plot(
            axis([trace.time_s], "time, s", margin=0.01), axis([trace.measured], unit, f),
            f"{trace.name} as it was read against time",
        )  # fmt: skip
        shown.line(*thin(trace.time_s, trace.measured, COLUMNS), "measured", trace.name)
        parts.append(figure(trace.name, shown.render()))
    return parts
