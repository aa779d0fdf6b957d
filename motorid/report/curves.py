"""Figures of the fit: measured against fitted, residuals, their spread and their memory."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.results.estimate import Curve, Estimate, SegmentRow
from motorid.report.numbers import scaled_unit, significant
from motorid.report.page import figure, paragraph, table
from motorid.report.plot import Axis, Plot, axis, columns_for, legend, thin
from motorid.report.words import file_name

Floats = NDArray[np.float64]

POINTS = 26_000  # of all long curves together: some 300 kB of path text
OPEN_CAPTURES = 2  # further ones are folded away
DETAILS = 3  # close-ups of the steepest places of a capture
DETAIL_SAMPLES = 48
LAGS = 60
LIFTED = 8.0  # usual steps of time without a reading: no line is drawn over that
WEAK = 0.1  # correlation: the plot shows at least this much either way
HINT = (
    "Point at a plot to read both curves; drag to zoom, double-click for the whole. By keyboard: "
    "arrows, + and Esc."
)
KINDS = ("rest", "acceleration", "steady", "coast", "brake", "rejected")


def captures(estimate: Estimate) -> list[str]:
    """For each capture: every channel against its fit, the residual below it, and close-ups."""
    columns = columns_for(POINTS, 3 * len(estimate.curves))
    indices = sorted({curve.capture for curve in estimate.curves})
    out = []
    for place, index in enumerate(indices):
        curves = [c for c in estimate.curves if c.capture == index]
        segments = [s for s in estimate.segments if s.capture == index]
        title = _title(estimate, index)
        body = _legend(segments) + "".join(_response(c, segments, columns) for c in curves)
        body += _details(curves)
        state = " open" if place < OPEN_CAPTURES else ""
        out.append(f'<details class="run"{state}><summary>{title}</summary>{body}</details>')
    hint = paragraph(HINT, "soft hint") if out else ""
    return [hint, *out]


def _legend(segments: Sequence[SegmentRow]) -> str:
    kinds = [k for k in KINDS if any(s.kind == k for s in segments)]
    return legend(
        [("measured", "measured"), ("fitted", "fitted"), *((f"area {k}", k) for k in kinds)]
    )


def _title(estimate: Estimate, index: int) -> str:
    inputs = estimate.inputs
    name = file_name(inputs[index].get("path")) if index < len(inputs) else ""
    return escape(f"Capture {index + 1}: {name}" if name else f"Capture {index + 1}")


def _response(curve: Curve, segments: Sequence[SegmentRow], columns: int) -> str:
    """One channel: measured and fitted above, the residual on its own scale below."""
    word = curve.channel.replace("_", " ")
    unit, factor = _unit(curve.unit, curve.measured)
    time = _time_axis(curve.time_s)
    above = Plot(
        time,
        axis((curve.measured, curve.fitted), f"{word}, {unit}", factor),
        f"{word} measured and fitted against time",
    )
    for s in segments:
        above.band(s.start_s, s.end_s, s.kind, s.kind)
    above.line(*_pens(curve.time_s, curve.measured, columns), "measured")
    above.line(*_pens(curve.time_s, curve.fitted, columns), "fitted")
    residual = curve.measured - curve.fitted
    r_unit, r_factor = _unit(curve.unit, residual)
    below = Plot(
        time,
        axis((residual,), f"residual, {r_unit}", r_factor, count=4),
        f"residual of the {word} against time",
        height=5.5,
    )
    for s in segments:
        below.band(s.start_s, s.end_s, s.kind)
    below.rule(0.0, "zero")
    below.line(*_pens(curve.time_s, residual, columns), "residual")
    rms = float(np.sqrt(np.nanmean(residual**2))) if len(residual) else float("nan")
    aside = f"{len(residual)} samples; residual {significant(rms * r_factor, 3)} {r_unit} rms"
    return figure(word, above.render(x_ticks=False), below.render(), aside=aside)


def _pens(time_s: Floats, values: Floats, columns: int) -> tuple[Floats, Floats]:
    """Points of a line, thinned, and with the pen lifted where time jumps."""
    steps = np.diff(time_s)
    jumps = np.flatnonzero(steps > LIFTED * np.median(steps)) + 1 if len(steps) else steps[:0]
    runs = np.split(np.arange(len(time_s)), jumps.astype(np.int64))
    if len(runs) > columns // 4:
        return thin(time_s, values, columns)
    parts = [
        thin(time_s[r], values[r], max(columns * len(r) // len(time_s), 2)) for r in runs if len(r)
    ]
    lift = np.array([np.nan])
    x = [piece for a, _ in parts for piece in (a, lift)]
    y = [piece for _, b in parts for piece in (b, lift)]
    return (np.concatenate(x), np.concatenate(y)) if parts else (time_s, values)


def _unit(unit: str, values: Floats) -> tuple[str, float]:
    finite = np.abs(values[np.isfinite(values)])
    return scaled_unit(unit, float(finite.max()) if len(finite) else 0.0)


def _time_axis(time_s: Floats, count: int = 8) -> Axis:
    span = float(time_s[-1] - time_s[0]) if len(time_s) else 0.0
    unit, factor = scaled_unit("s", span)
    return axis((time_s,), f"time, {unit}", factor, count=count, margin=0.0)


def _details(curves: Sequence[Curve]) -> str:
    """Close-ups where the fitted current (or else the first channel) is steepest."""
    lead = next((c for c in curves if c.channel == "current"), curves[0])
    windows = [w for w in steepest(lead.fitted, DETAILS) if _unbroken(lead.time_s[w])]
    plots = "".join(f"<div>{_close_up(lead, w)}</div>" for w in windows)
    return f'<div class="trio">{plots}</div>' if plots else ""


def _unbroken(time_s: Floats) -> bool:
    steps = np.diff(time_s)
    return bool(np.max(steps, initial=0.0) <= LIFTED * np.median(steps))


def steepest(values: Floats, count: int) -> list[slice]:
    """Windows about the places of greatest change, apart from each other, in order of time."""
    n = len(values)
    if n < 4 * DETAIL_SAMPLES:
        return []
    change = np.abs(np.diff(np.where(np.isfinite(values), values, 0.0)))
    floor = 0.2 * float(change.max(initial=0.0))
    found: list[int] = []
    while len(found) < count and len(change):
        at = int(np.argmax(change))
        if change[at] <= floor or change[at] == 0:
            break
        found.append(at)
        change[max(at - DETAIL_SAMPLES, 0) : at + DETAIL_SAMPLES] = 0.0
    before = DETAIL_SAMPLES // 5
    return [slice(max(k - before, 0), min(k - before + DETAIL_SAMPLES, n)) for k in sorted(found)]


def _close_up(curve: Curve, window: slice) -> str:
    word = curve.channel.replace("_", " ")
    time, measured, fitted = (a[window] for a in (curve.time_s, curve.measured, curve.fitted))
    unit, factor = _unit(curve.unit, measured)
    begin = float(time[0])
    t_unit, t_factor = scaled_unit("s", float(time[-1] - begin))
    title = f"time after {begin:.4g} s, {t_unit}"
    x = axis((time - begin,), title, t_factor, margin=0.0)
    plot = Plot(x, axis((measured, fitted), f"{word}, {unit}", factor), f"{word}, close-up", 9.0)
    plot.dots(time - begin, measured, "measured small")
    plot.line(time - begin, fitted, "fitted")
    return figure(f"{word}, close up", plot.render())


def spread(estimate: Estimate) -> str:
    """Per channel, over all captures: a histogram of residual / sigma and its autocorrelation."""
    names = sorted({c.channel for c in estimate.curves})
    out = []
    for name in names:
        curves = [c for c in estimate.curves if c.channel == name and c.sigma > 0]
        scaled = [(c.measured - c.fitted) / c.sigma for c in curves]
        scaled = [r[np.isfinite(r)] for r in scaled]
        if sum(map(len, scaled)) < 10:
            continue
        word = name.replace("_", " ")
        out.append(figure(f"{word}: spread", _histogram(np.concatenate(scaled), word)))
        out.append(figure(f"{word}: autocorrelation", _autocorrelation(scaled, curves[0], word)))
    cells = "".join(f"<div>{o}</div>" for o in out)
    if not cells:
        return ""
    words = (
        "Bars: residuals in units of the noise that the fit settled on; line: what normal noise "
        "gives. Memory: the correlation of a residual with those after it; noise alone stays "
        "between the dashed lines 19 times in 20."
    )
    return f'<div class="pair">{cells}</div>{paragraph(words, "soft")}'


def by_segment(estimate: Estimate) -> str:
    """The rms residual on each kind of segment, in units of the channel's sigma."""
    kinds = [k for k in KINDS if any(s.kind == k for s in estimate.segments)]
    channels = sorted({c.channel for c in estimate.curves if c.sigma > 0})
    if not kinds or not channels:
        return ""
    rows = [(k, *(_rms(estimate, k, c) for c in channels)) for k in kinds]
    head = ("residual rms / sigma", *(c.replace("_", " ") for c in channels))
    return table(head, rows)


def _rms(estimate: Estimate, kind: str, channel: str) -> str:
    parts = []
    for curve in estimate.curves:
        if curve.channel != channel or curve.sigma <= 0:
            continue
        scaled = (curve.measured - curve.fitted) / curve.sigma
        for s in estimate.segments:
            if s.kind == kind and s.capture == curve.capture:
                inside = (curve.time_s >= s.start_s) & (curve.time_s <= s.end_s)
                parts.append(scaled[inside & np.isfinite(scaled)])
    pooled = np.concatenate(parts) if parts else np.zeros(0)
    return f"{np.sqrt(np.mean(pooled**2)):.2f}" if len(pooled) else "—"


def _histogram(scaled: Floats, word: str) -> str:
    edges = np.linspace(-4.5, 4.5, 46)
    counts, _ = np.histogram(np.clip(scaled, edges[0], edges[-1]), edges)
    density = counts / (len(scaled) * np.diff(edges))
    x = Axis(-4.5, 4.5, 1.0, "residual / sigma")
    normal_x = np.asarray(np.linspace(-4.5, 4.5, 91), dtype=np.float64)
    normal = np.asarray(np.exp(-(normal_x**2) / 2) / np.sqrt(2 * np.pi))
    top = 1.1 * max(float(density.max()), 0.4)
    plot = Plot(x, Axis(0.0, top, 0.1 if top < 0.7 else 0.5, "density"), f"{word} residuals", 8.0)
    plot.bars(edges, density, "histogram")
    plot.line(normal_x, normal, "fitted")
    return plot.render()


def _autocorrelation(scaled: Sequence[Floats], curve: Curve, word: str) -> str:
    lags = min(LAGS, max(len(r) for r in scaled) // 4)
    values = autocorrelation(scaled, lags)
    step = float(np.median(np.diff(curve.time_s))) if len(curve.time_s) > 1 else 1.0
    time = step * np.arange(lags + 1, dtype=np.float64)
    limit = 1.96 / np.sqrt(sum(map(len, scaled)))
    y = axis((values[1:], np.array([-WEAK, WEAK])), "correlation")
    plot = Plot(_time_axis(time, 6), y, f"autocorrelation of the {word} residuals", 8.0)
    plot.rule(0.0, "zero")
    plot.rule(limit)
    plot.rule(-limit)
    plot.line(time[1:], values[1:], "residual")
    plot.dots(time[1:], values[1:], "measured small")
    return plot.render()


def autocorrelation(series: Sequence[Floats], lags: int) -> Floats:
    """The correlation of values with those up to ``lags`` later, pooled; shape (lags + 1,)."""
    sums = np.zeros(lags + 1)
    for values in series:
        centred = values - np.mean(values)
        size = 1 << (2 * len(centred) - 1).bit_length()
        power = np.abs(np.fft.rfft(centred, size)) ** 2
        covariance = np.fft.irfft(power, size)[: lags + 1]
        sums[: len(covariance)] += covariance
    return sums / sums[0] if sums[0] > 0 else sums
