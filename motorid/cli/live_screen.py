"""A run's curves in a terminal while it goes on, for who works over ssh."""

from __future__ import annotations

import shutil
import threading
from collections import deque
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.strips import Strip, Strips, joined
from motorid.cli.streams import paint, plain
from motorid.errors import UsageError
from motorid.report.braille import plot

if TYPE_CHECKING:
    from motorid.acquire.tap import Tap

SPAN_S = 5.0  # of the curves
EACH_S = 0.2  # between pictures
WIDEST, LEAST, MOST = 120, 2, 6  # columns; lines of characters a curve
LABELS = {"terminal_voltage": "voltage", "supply_voltage": "supply"}


class LiveScreen:
    """Draws what comes through a tap, in a thread of its own, until it ends.

    A terminal that is slow makes pictures rare, and holds nothing up. Raises UsageError where
    ``stream`` is no terminal.
    """

    def __init__(self, tap: Tap, stream: TextIO) -> None:
        if not stream.isatty():
            raise UsageError("--live=terminal draws on a terminal, and standard error is none")
        self.tap, self.stream = tap, stream
        self.curves = Curves(plain=plain(stream))
        self.state = ""
        self._lines = 0  # of the latest picture
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._draw, name="screen", daemon=True)

    def post(self, state: str, text: str, said: int) -> None:
        """What goes on, in a line above the curves."""
        self.state = f"{state}: {text}" if text else state

    def __enter__(self) -> LiveScreen:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._thread.join(2 * EACH_S)  # a terminal that hangs is left alone

    def _draw(self) -> None:
        last = False
        while not last:
            last = self._ended.wait(EACH_S)
            self.curves.take(self.tap)
            size = shutil.get_terminal_size()
            page = self.curves.page(min(size.columns - 1, WIDEST), size.lines, self.state)
            up = f"\x1b[{self._lines}F" if self._lines else ""
            paint(self.stream, up + "".join(f"{line}\x1b[K\n" for line in page) + "\x1b[J")
            self._lines = len(page)


class Curves:
    """The last SPAN_S of what a tap gave, as lines of text."""

    def __init__(self, *, plain: bool = False) -> None:
        self.plain = plain  # without braille
        self._strips = Strips()
        self._kept: deque[Strip] = deque()

    def take(self, tap: Tap) -> None:
        """What came since the last call."""
        strips = [s for f, b in tap.taken() if (s := self._strips.take(f, b)) is not None]
        self._kept.extend(joined(strips))
        while self._kept and self._kept[0].end_s < self._kept[-1].end_s - SPAN_S:
            self._kept.popleft()

    def page(self, width: int, height: int, state: str) -> list[str]:
        """``state``, then each channel with its latest reading, its range and its curve."""
        head = [state[:width]] if state else []
        if not self._kept:
            return [*head, "no samples yet"]
        last = self._kept[-1]
        count = len(last.names)
        lines = min(max((height - 2) // count - 1, LEAST), MOST)
        page = head
        for index, (name, unit) in enumerate(zip(last.names, last.units, strict=True)):
            values = self._values(index)
            page.append(_caption(name, unit, values)[:width])
            page += plot(values, width, lines=lines, plain=self.plain)
        return page

    def _values(self, index: int) -> NDArray[np.float64]:
        """A channel on the grid of its samples (n,); NaN where one is missing."""
        last = self._kept[-1]
        alike = [s for s in self._kept if (s.names, s.period_s) == (last.names, last.period_s)]
        samples = round(SPAN_S / last.period_s)
        values = np.full(samples, np.nan)
        for strip in alike:
            end = samples - round((last.end_s - strip.end_s) / last.period_s)
            part = strip.values[index][-max(end, 0) :] if end > 0 else strip.values[index][:0]
            values[end - len(part) : end] = part
        return values


def _caption(name: str, unit: str, values: NDArray[np.float64]) -> str:
    finite = values[np.isfinite(values)]
    label = f"{LABELS.get(name, name)}, {unit}".ljust(14)
    if not len(finite):
        return label
    now, low, high = float(finite[-1]), float(finite.min()), float(finite.max())
    return f"{label} {now:+11.4g}   {low:+.4g} to {high:+.4g} in the last {SPAN_S:g} s"
