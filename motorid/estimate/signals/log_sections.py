"""A log that pauses, as the pieces between its pauses: what the motor did in one nobody knows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from motorid.capture.model import Capture

PAUSE = 5.0  # usual periods between two samples, from which a log begins anew
NEAR = 4  # samples on either side that tell the usual period there
FEWEST = 64  # samples of a piece worth a beginning of its own


def pieces(captures: Sequence[Capture]) -> list[Capture]:
    """The captures, those without a program cut where they pause.

    A piece too short to tell where the motor was when it began is left out, unless all are.
    """
    return [piece for capture in captures for piece in _cut(capture)]


def _cut(capture: Capture) -> list[Capture]:
    if capture.program is not None or len(capture) < 2 * FEWEST:
        return [capture]
    steps = np.diff(capture.time_s)
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(steps, NEAR, mode="edge"), 2 * NEAR + 1
    )
    cuts = np.flatnonzero(steps > PAUSE * np.median(around, axis=1)) + 1
    edges = pairwise([0, *cuts.tolist(), len(capture)])
    long = [(a, b) for a, b in edges if b - a >= FEWEST]
    if not len(cuts) or not long:
        return [capture]
    return [_part(capture, a, b) for a, b in long]


def _part(capture: Capture, start: int, stop: int) -> Capture:
    """Samples ``start`` to ``stop`` (exclusive) as a capture."""
    channels = {
        name: replace(channel, raw=channel.raw[start:stop])
        for name, channel in capture.channels.items()
    }
    inside = [gap for gap in capture.gaps if start < gap.index < stop]
    gaps = tuple(replace(gap, index=gap.index - start) for gap in inside)
    return replace(capture, ticks=capture.ticks[start:stop], channels=channels, gaps=gaps)
