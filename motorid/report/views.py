"""Views of estimates and captures for Python and its notebooks; computes nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.errors import UsageError
from motorid.estimate.results.estimate import Estimate, Parameter
from motorid.report.numbers import scaled_unit, shown
from motorid.report.plot import thin
from motorid.report.words import STATUS_WORDS, name_of, summary
from motorid.visible import on_one_line, visible

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]
WIDE, HIGH, PAD = 640, 130, 4  # of a plot in a notebook
COLUMNS = 320  # of a line: more cannot be seen there
MOST_PLOTS = 6
MEASURED, FITTED = "#4878a8", "#c8502a"
CELL = 'style="text-align:left;padding:2px 10px"'
NO_PLOT = "plot() needs matplotlib: pip install matplotlib"


@dataclass(frozen=True)
class Trace:
    """One channel against time; ``fitted`` None: there is no model of it."""

    name: str
    unit: str
    time_s: Floats
    measured: Floats
    fitted: Floats | None = None


def brief(one: Estimate | Capture) -> str:
    """One line."""
    if isinstance(one, Estimate):
        values = ", ".join(_value(p) for p in one.parameters.values())
        runs = len(one.inputs) or len({curve.capture for curve in one.curves})
        return f"<Estimate {values}; {one.method}, {runs} capture{'s' * (runs != 1)}>"
    seconds = f", {one.time_s[-1]:.3g} s" if len(one) else ""
    label = str(one.provenance.get("serial") or "")
    motor = f"; motor {on_one_line(label)}" if label else ""
    ended = "" if one.end_reason == "completed" else f"; {on_one_line(one.end_reason)}"
    return f"<Capture {len(one):,} samples{seconds}: {', '.join(one.channels)}{motor}{ended}>"


def html(one: Estimate | Capture) -> str:
    """A table and plots in one piece of HTML, with its own colours and nothing loaded."""
    if isinstance(one, Estimate):
        head: Sequence[str] = ("", "", "value ± 95 %", "unit", "status")
        rows = [_row(p) for p in (*one.parameters.values(), *one.at_25.values())]
        title = summary(one)
    else:
        head = ("channel", "unit", "least", "mean", "most", "missing")
        rows = [_extent(trace) for trace in traces(one)]
        title = brief(one).strip("<>")
    plots = "".join(_svg(trace) for trace in traces(one)[:MOST_PLOTS])
    return visible(f"<div><p>{escape(title)}</p>{_table(head, rows)}{plots}</div>")


def frame(one: Estimate | Capture) -> pd.DataFrame:
    """See ``motorid.look.Look.to_dataframe``."""
    import pandas as pd

    if isinstance(one, Capture):
        columns = {name: channel.values for name, channel in one.channels.items()}
        made = pd.DataFrame(columns, index=pd.Index(one.time_s, name="time_s"))
        made.attrs["units"] = {name: channel.unit for name, channel in one.channels.items()}
        return made
    rows = [*one.parameters.values(), *one.at_25.values(), *one.combinations.values()]
    rows += one.derived.values()
    return pd.DataFrame([_record(p) for p in rows]).set_index("name")


def plot(one: Estimate | Capture) -> Any:
    """See ``motorid.look.Look.plot``."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise UsageError(NO_PLOT) from None
    drawn = traces(one)
    figure = Figure(figsize=(8.0, 1.0 + 2.0 * max(len(drawn), 1)), layout="constrained")
    for axes, trace in zip(
        np.ravel(figure.subplots(max(len(drawn), 1), 1, sharex=False)), drawn, strict=False
    ):
        axes.plot(trace.time_s, trace.measured, color=MEASURED, lw=0.8, label="measured")
        if trace.fitted is not None:
            axes.plot(trace.time_s, trace.fitted, color=FITTED, lw=0.8, label="fitted")
            axes.legend(loc="upper right")
        axes.set_ylabel(f"{trace.name}, {trace.unit}")
        axes.set_xlabel("time, s")
    return figure


def traces(one: Estimate | Capture) -> list[Trace]:
    """What there is to draw."""
    if isinstance(one, Capture):
        return [
            Trace(name.replace("_", " "), channel.unit, one.time_s, channel.values)
            for name, channel in one.channels.items()
        ]
    several = len({curve.capture for curve in one.curves}) > 1
    return [
        Trace(
            curve.channel.replace("_", " ") + (f" of run {curve.capture + 1}" if several else ""),
            curve.unit,
            curve.time_s,
            curve.measured,
            curve.fitted,
        )
        for curve in one.curves
    ]


def _value(p: Parameter) -> str:
    if p.value is None:
        return f"{p.name} unknown"
    view = shown(p)
    half = f" ± {view.half}" if view.half else ""
    return f"{p.name} = {view.value}{half} {view.unit}"


def _row(p: Parameter) -> Sequence[str]:
    view = shown(p)
    value = f"{view.value} ± {view.half}" if view.half else view.value
    return (p.name, name_of(p), value, view.unit, STATUS_WORDS[p.status])


def _record(p: Parameter) -> dict[str, Any]:
    low, high = p.interval_95 or (None, None)
    return {
        "name": p.name,
        "value": p.value,
        "unit": p.unit,
        "lower_95": low,
        "upper_95": high,
        "standard_uncertainty": p.total,
        "statistical": p.statistical,
        "instrument": p.instrument,
        "status": str(p.status),
        "note": p.note,
    }


def _extent(trace: Trace) -> Sequence[str]:
    there = trace.measured[np.isfinite(trace.measured)]
    missing = f"{len(trace.measured) - len(there):,}"
    if not len(there):
        return (trace.name, trace.unit, "", "", "", missing)
    least, mean, most = float(there.min()), float(there.mean()), float(there.max())
    unit, factor = scaled_unit(trace.unit, max(abs(least), abs(most)))
    sizes = (f"{factor * size:.4g}" for size in (least, mean, most))
    return (trace.name, unit, *sizes, missing)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th {CELL}>{escape(cell)}</th>" for cell in head)
    lines = "".join(
        "<tr>" + "".join(f"<td {CELL}>{escape(cell)}</td>" for cell in row) + "</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{top}</tr></thead><tbody>{lines}</tbody></table>"


def _svg(trace: Trace) -> str:
    """The trace in one frame, with its range in words."""
    lines = [(trace.measured, MEASURED)]
    lines += [(trace.fitted, FITTED)] if trace.fitted is not None else []
    finite = np.concatenate([values[np.isfinite(values)] for values, _ in lines])
    if not len(finite) or not len(trace.time_s):
        return ""
    low, high = float(finite.min()), float(finite.max())
    end = float(trace.time_s[-1]) or 1.0
    unit, factor = scaled_unit(trace.unit, max(abs(low), abs(high)))
    body = "".join(
        f'<path fill="none" stroke="{colour}" d="{_path(trace.time_s, values, end, low, high)}"/>'
        for values, colour in lines
    )
    said = f"{trace.name}: {factor * low:.4g} to {factor * high:.4g} {unit} in {end:.3g} s"
    colours = f' <span style="color:{MEASURED}">measured</span>'
    colours += f' <span style="color:{FITTED}">fitted</span>' if len(lines) > 1 else ""
    frame_ = f'<rect width="{WIDE}" height="{HIGH}" fill="none" stroke="#bbb"/>'
    return (
        f'<div>{escape(said)}{colours}<br><svg width="{WIDE}" height="{HIGH}" role="img" '
        f'aria-label="{escape(said)}">{frame_}{body}</svg></div>'
    )


def _path(time_s: Floats, values: Floats, end: float, low: float, high: float) -> str:
    """A missing reading lifts the pen."""
    x, y = thin(time_s, values, COLUMNS)
    across = PAD + (WIDE - 2 * PAD) * x / end
    down = PAD + (HIGH - 2 * PAD) * (high - y) / ((high - low) or 1.0)
    pen, words = "M", []
    for a, d in zip(across, down, strict=True):
        if np.isfinite(d):
            words.append(f"{pen}{a:.1f} {d:.1f}")
        pen = "L" if np.isfinite(d) else "M"
    return "".join(words)
