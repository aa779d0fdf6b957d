"""Segments of a capture as a table for a terminal and as a page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.report import page as pages
from motorid.report.numbers import NOTHING, fixed, scaled_unit
from motorid.report.plot import Plot, axis, legend, thin
from motorid.report.words import file_name
from motorid.segment import Segment, SegmentKind

Floats = NDArray[np.float64]

SHOWN = (CURRENT, TORQUE, SPEED, POSITION, VOLTAGE)
COLUMNS = 900
DIGITS = 4  # of the largest mean of a column
NBSP = "\N{NO-BREAK SPACE}"
HEAD = ("", "from, s", "to, s", "samples")


def table(capture: Capture, segments: Sequence[Segment]) -> str:
    """One line a segment: kind, times, samples, means of the signals, and the reason."""
    if not segments:
        return "The capture is empty: there is nothing to segment."
    rows = [_head(capture), *_rows(capture, segments)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row, reason in zip(rows, ("", *(s.reason for s in segments)), strict=True):
        cells = [f"{row[0]:<{widths[0]}}"]
        cells += [f"{c:>{w}}" for c, w in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join((*cells, reason)).rstrip())
    return "\n".join((*lines, "", _summary(capture, segments)))


def page(capture: Capture, segments: Sequence[Segment]) -> str:
    """A self-contained HTML page: every signal with the segments behind it, and the table."""
    name = file_name(capture.path)
    title = f"Segments of {name}" if name else "Segments"
    kinds = [k for k in SegmentKind if any(s.kind is k for s in segments)]
    plots = [_plot(capture, channel, segments) for channel in _channels(capture)]
    cells = _rows(capture, segments)
    rows = [(*row, s.reason) for row, s in zip(cells, segments, strict=True)]
    body = [
        f'<header><p class="kicker">Segments, from the signals alone</p><h1>{escape(title)}</h1>'
        f"{pages.paragraph(_summary(capture, segments), 'summary')}</header>",
        pages.section("Signals", legend([(f"area {k}", k) for k in kinds]), *plots),
        pages.section("Segments", pages.table((*_head(capture), ""), rows)),
    ]
    return pages.page(title, body)


def _channels(capture: Capture) -> list[Channel]:
    found = (capture.get(name) for name in SHOWN)
    return [channel for channel in found if channel is not None]


def _means(capture: Capture) -> list[Channel]:
    """Channels whose mean over a segment says something; a position's does not."""
    return [c for c in _channels(capture) if c.name != POSITION]


def _head(capture: Capture) -> tuple[str, ...]:
    moves = ("speed, rad/s",) if _speed_from_position(capture) else ()
    means = (f"{c.name.removeprefix('terminal_')}, {c.unit}" for c in _means(capture))
    return (*HEAD, *means, *moves)


def _rows(capture: Capture, segments: Sequence[Segment]) -> list[tuple[str, ...]]:
    time = capture.time_s
    columns = [
        [str(s.kind) for s in segments],
        [fixed(float(time[s.start]), 4) for s in segments],
        [fixed(float(time[s.stop - 1]), 4) for s in segments],
        [str(s.stop - s.start) for s in segments],
    ]
    for channel in _means(capture):
        columns.append(_even([_mean(channel.values[s.slice]) for s in segments]))
    if _speed_from_position(capture):
        columns.append(_even([_mean_speed(capture, s) for s in segments]))
    return list(zip(*columns, strict=True))


def _even(means: list[float]) -> list[str]:
    """Numbers of one column with the same decimals: DIGITS of the largest."""
    largest = max((abs(m) for m in means if np.isfinite(m)), default=0.0)
    decimals = DIGITS - 1 - math.floor(math.log10(largest)) if largest else 0
    return [fixed(m, max(decimals, 0)) if np.isfinite(m) else NOTHING for m in means]


def _mean(values: Floats) -> float:
    finite = values[np.isfinite(values)]
    return float(np.mean(finite)) if len(finite) else math.nan


def _speed_from_position(capture: Capture) -> bool:
    return capture.get(SPEED) is None and capture.get(POSITION) is not None


def _mean_speed(capture: Capture, s: Segment) -> float:
    position = capture.channels[POSITION].values[s.slice]
    length = float(capture.time_s[s.stop - 1] - capture.time_s[s.start])
    return float(position[-1] - position[0]) / length if length > 0 else math.nan


def _summary(capture: Capture, segments: Sequence[Segment]) -> str:
    """How much of the capture is of each kind, in a sentence."""
    if not segments:
        return "The capture is empty."
    parts = []
    for kind in SegmentKind:
        count = sum(s.stop - s.start for s in segments if s.kind is kind)
        if count:
            parts.append(f"{kind} {100 * count / len(capture):.1f}{NBSP}%")
    return f"{len(segments)} segments over {len(capture)} samples: {', '.join(parts)}."


def _plot(capture: Capture, channel: Channel, segments: Sequence[Segment]) -> str:
    word = channel.name.replace("_", " ")
    values, time = channel.values, capture.time_s
    finite = np.abs(values[np.isfinite(values)])
    unit, factor = scaled_unit(channel.unit, float(finite.max()) if len(finite) else 0.0)
    t_unit, t_factor = scaled_unit("s", float(time[-1]) if len(time) else 0.0)
    x = axis((time,), f"time, {t_unit}", t_factor, count=8, margin=0.0)
    plot = Plot(x, axis((values,), f"{word}, {unit}", factor), f"{word} against time")
    for s in segments:
        end = float(time[s.stop]) if s.stop < len(time) else float(time[-1])
        plot.band(float(time[s.start]), end, s.kind, s.kind)
    plot.line(*thin(time, values, COLUMNS), "residual")
    return pages.figure(word, plot.render())
