"""Small plots as HTML: curves in an SVG that stretches, texts beside it that do not.

The curves live in a 1000 × 1000 box that is stretched to the page; lines keep their width by
``vector-effect``. Ticks and titles are HTML placed by percentages, so they stay readable on a
phone and on a wall. Colours come from the page's style sheet by class; the page's script reads
values off the paths.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np
from numpy.typing import NDArray

from motorid.report.numbers import MINUS

Floats = NDArray[np.float64]
BOX = 1000.0
MOST_COLUMNS, FEWEST_COLUMNS = 700, 60  # of a line
HUES = 12  # told apart by colour; further ones by dashes
WIDE = "<style>main{max-width:100rem}</style>"  # of a page whose tables have many columns
LETTER = 0.0065  # of a wide plot: what a letter of a band's word takes


@dataclass(frozen=True)
class Axis:
    """A range and its ticks, in ``factor`` times the data's unit."""

    low: float
    high: float
    step: float
    title: str = ""
    factor: float = 1.0

    def share(self, values: Floats) -> Floats:
        """Where values lie between low (0) and high (1)."""
        return np.asarray((values * self.factor - self.low) / (self.high - self.low))

    def ticks(self) -> list[tuple[float, str]]:
        """Each tick's share of the axis and its label."""
        first, last = (
            math.ceil(self.low / self.step - 1e-9),
            math.floor(self.high / self.step + 1e-9),
        )
        decimals = _decimals(self.step)
        span = self.high - self.low
        return [
            ((k * self.step - self.low) / span, _label(k * self.step, decimals))
            for k in range(first, last + 1)
        ]


def _decimals(step: float) -> int:
    """Decimals that write every multiple of ``step`` exactly."""
    coarse = max(0, -math.floor(math.log10(step) + 1e-9))
    return coarse + (not math.isclose(step * 10.0**coarse, round(step * 10.0**coarse)))


def _label(value: float, decimals: int) -> str:
    return f"{value + 0.0:.{decimals}f}".replace("-", MINUS)


def axis(
    values: Iterable[Floats],
    title: str = "",
    factor: float = 1.0,
    *,
    count: int = 5,
    margin: float = 0.04,
) -> Axis:
    """An axis about all finite ``values``, with about ``count`` round ticks."""
    finite = [v[np.isfinite(v)] for v in values]
    finite = [v for v in finite if len(v)]
    low = min((float(v.min()) for v in finite), default=0.0) * factor
    high = max((float(v.max()) for v in finite), default=1.0) * factor
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        low, high = low - (abs(low) or 1.0) * 0.5, high + (abs(high) or 1.0) * 0.5
    room = margin * (high - low)
    low, high = low - room, high + room
    return Axis(low, high, _round_step((high - low) / count), title, factor)


def _round_step(step: float) -> float:
    """The nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(step))
    return min((m * power for m in (1.0, 2.0, 5.0, 10.0)), key=lambda s: abs(math.log(s / step)))


@dataclass
class Plot:
    """Draws into one frame; ``render`` gives the HTML. ``height`` in rem."""

    x: Axis
    y: Axis
    label: str  # what is seen, for those who cannot see it
    height: float = 13.0
    shapes: list[str] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    def line(self, x: Floats, y: Floats, kind: str, name: str = "") -> None:
        """A line through the points; a missing point breaks it. ``name``: for a reader, if not
        ``kind``.
        """
        path = _path(self.x.share(x) * BOX, BOX - self.y.share(y) * BOX)
        named = f' data-line="{escape(name)}"' if name else ""
        self.shapes.append(f'<path class="{kind}"{named} d="{path}"/>')

    def dots(self, x: Floats, y: Floats, kind: str) -> None:
        """A round dot at each point (a line of no length with round ends)."""
        across, down = self.x.share(x) * BOX, BOX - self.y.share(y) * BOX
        path = "".join(f"M{_n(a)} {_n(d)}h0" for a, d in zip(across, down, strict=True))
        self.shapes.append(f'<path class="dots {kind}" d="{path}"/>')

    def links(self, x: Floats, y: Floats, targets: Sequence[str]) -> None:
        """Where each point leads, for a pointer; a table beside it leads there by keyboard."""
        across, down = self.x.share(x) * BOX, BOX - self.y.share(y) * BOX
        for a, d, target in zip(across, down, targets, strict=False):
            place = f'<path class="dots" d="M{_n(a)} {_n(d)}h0"/>'
            self.shapes.append(f'<a href="{escape(target)}" tabindex="-1">{place}</a>')

    def band(self, begin: float, end: float, kind: str, text: str = "") -> None:
        """A shaded stretch of the x axis, with a word above it where there is room."""
        left, right = (float(v) for v in np.clip(self.x.share(np.array([begin, end])), 0, 1))
        if right <= left:
            return
        width = f'x="{_n(left * BOX)}" width="{_n((right - left) * BOX)}"'
        self.shapes.insert(0, f'<rect class="{kind}" {width} y="0" height="1000"/>')
        if right - left > LETTER * len(text) > 0:
            place = f"left:{left:.2%};width:{right - left:.2%}"
            self.texts.append(f'<span class="over" style="{place}">{escape(text)}</span>')

    def bars(self, edges: Floats, heights: Floats, kind: str) -> None:
        """A histogram from the bottom of the frame."""
        across, down = self.x.share(edges) * BOX, BOX - self.y.share(heights) * BOX
        steps = "".join(
            f"H{_n(a)}V{_n(d)}H{_n(b)}"
            for a, b, d in zip(across[:-1], across[1:], down, strict=True)
        )
        path = f"M{_n(across[0])} 1000{steps}V1000Z"
        self.shapes.append(f'<path class="{kind}" d="{path}"/>')

    def rule(self, value: float, kind: str = "rule") -> None:
        """A level line."""
        at = _n(float(BOX - self.y.share(np.array([value]))[0] * BOX))
        self.shapes.append(f'<path class="{kind}" d="M0 {at}H1000"/>')

    def render(self, *, x_ticks: bool = True) -> str:
        """The figure; without ``x_ticks`` where another plot of the same axis stands below."""
        across, up = self.x.ticks(), self.y.ticks()
        grid = "".join(f"M0 {_n(BOX - s * BOX)}H1000" for s, _ in up)
        grid += "".join(f"M{_n(s * BOX)} 0V1000" for s, _ in across)
        y_labels = "".join(f'<span style="bottom:{s:.2%}">{t}</span>' for s, t in up)
        x_labels = "".join(
            f'<span class="{"odd" if k % 2 else "even"}" style="left:{s:.2%}">{t}</span>'
            for k, (s, t) in enumerate(across)
        )
        foot = (
            f'<div class="xs" aria-hidden="true">{x_labels}</div>'
            f'<div class="xt">{escape(self.x.title)}</div>'
        )
        kind = "plot headed" if self.texts else "plot"
        return (
            f'<div class="{kind}" role="img" aria-label="{escape(self.label)}">'
            f'<div class="yt">{escape(self.y.title)}</div>'
            f'<div class="ys" aria-hidden="true">{y_labels}</div>'
            f'<div class="frame" data-range="{self._range}" style="height:{self.height}rem">'
            f'<svg viewBox="0 0 1000 1000" preserveAspectRatio="none" aria-hidden="true">'
            f'<path class="grid" d="{grid}"/>{"".join(self.shapes)}</svg>'
            f"{''.join(self.texts)}</div>"
            f"{foot if x_ticks else ''}</div>"
        )

    @property
    def _range(self) -> str:
        """What the box shows, as its titles have it: left, right, bottom, top."""
        ends = (self.x.low, self.x.high, self.y.low, self.y.high)
        return " ".join(f"{end:.9g}" for end in ends)


def legend(entries: Sequence[tuple[str, str]]) -> str:
    """A line of (class, word)."""
    items = "".join(
        f'<span><svg class="key" viewBox="0 0 24 10" aria-hidden="true">'
        f'<path class="{kind}" d="{"M12 5h0" if kind.startswith("dots") else "M3 5H21"}"/></svg>'
        f"{escape(word)}</span>"
        for kind, word in entries
    )
    return f'<div class="legend">{items}</div>'


def style(count: int) -> str:
    """Colours of ``count`` curves, by class ``c0``, ``c1``, …"""
    rules = []
    for k in range(count):
        hue = round(360 * ((k * 5) % HUES) / HUES)  # neighbours in the list lie far apart
        dash = f"stroke-dasharray:{2 + 3 * (k // HUES)} 3;" if k >= HUES else ""
        rules.append(f"path.c{k}{{fill:none;stroke:hsl({hue} 70% 45%);stroke-width:1.6;{dash}}}")
    return f"<style>{''.join(rules)}</style>"


def columns_for(points: int, lines: int) -> int:
    """Of each of so many lines, for ``thin``, that have so many points together."""
    return min(max(points // (2 * max(lines, 1)), FEWEST_COLUMNS), MOST_COLUMNS)


def thin(x: Floats, y: Floats, columns: int) -> tuple[Floats, Floats]:
    """At most two points a column: the lowest and the highest, in the order of their time.

    A plot of them looks as that of all the points does; no peak is lost.
    """
    n = len(x)
    if n <= 2 * columns:
        return x, y
    edges = np.linspace(0, n, columns + 1).astype(np.int64)[:-1]
    safe = np.where(np.isfinite(y), y, 0.0)
    size = np.diff(np.append(edges, n))
    owner = np.repeat(np.arange(columns), size)
    order = np.lexsort((safe, owner))
    low, high = order[edges], order[edges + size - 1]
    keep = np.sort(np.stack((low, high)), axis=0).T.ravel()
    return x[keep], y[keep]


def _path(x: Floats, y: Floats) -> str:
    good = np.isfinite(x) & np.isfinite(y)
    parts, pen_up = [], True
    for a, b, ok in zip(np.round(x, 1), np.round(y, 1), good, strict=True):
        if ok:
            parts.append(f"{'M' if pen_up else 'L'}{_n(a)} {_n(b)}")
        pen_up = not ok
    return "".join(parts)


def _n(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
