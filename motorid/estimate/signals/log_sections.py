"""A log as the pieces that a fit can use: between its pauses, and while the bridge was closed.

Nobody knows what the motor did in a pause, nor which voltage an open bridge left it. Each piece has
a beginning of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic
from motorid.estimate.signals.measurements import motion
from motorid.estimate.signals.neighbour_noise import running_median
from motorid.estimate.signals.opened_bridge import Opening, openings
from motorid.estimate.signals.standstill import STIR

PAUSE = 5.0  # usual periods between two samples, from which a log begins anew
COMMON = 0.9  # of the intervals of a log without a motion are no pauses, however they scatter
NEAR = 4  # samples on either side that tell the usual period there
FEWEST = 64  # samples of a piece worth a beginning of its own
DRIVEN = 24  # the same of one between two openings of the bridge
LISTED = 4  # openings whose times a remark gives


def pieces(captures: Sequence[Capture]) -> list[Capture]:
    """The captures, those without a program cut where they pause and where the bridge is open.

    A piece too short to tell where the motor was when it began is left out, unless all are.
    """
    whole = unbroken(captures)
    closed = [driven(piece, openings(piece)) for piece in whole]
    if not any(closed):
        return whole
    return [piece for each in closed for piece in each]


def unbroken(captures: Sequence[Capture]) -> list[Capture]:
    """The captures, those without a program cut where they pause."""
    return [piece for capture in captures for piece in _cut(capture)]


def _cut(capture: Capture) -> list[Capture]:
    if capture.program is not None or len(capture) < 2 * FEWEST:
        return [capture]
    steps = np.diff(capture.time_s)
    longer = steps / running_median(steps, NEAR)
    common = float(np.quantile(longer, COMMON)) if motion(capture) is None else 1.0
    cuts = np.flatnonzero(longer > PAUSE * max(common, 1.0)) + 1
    edges = pairwise([0, *cuts.tolist(), len(capture)])
    long = _worth(capture, edges, FEWEST)
    if not len(cuts) or not long:
        return [capture]
    return [part(capture, a, b) for a, b in long]


def _worth(
    capture: Capture, stretches: Iterable[tuple[int, int]], fewest: int
) -> list[tuple[int, int]]:
    """Those that are long enough, less those at rest where the motor moves in others."""
    long = [(a, b) for a, b in stretches if b - a >= fewest]
    moved = motion(capture)
    if moved is None:
        return long
    least = STIR * moved.resolution
    return [(a, b) for a, b in long if _changes(moved.values[a:b], least)] or long


def _changes(values: NDArray[np.float64], least: float) -> bool:
    known = values[np.isfinite(values)]
    return bool(len(known)) and float(np.ptp(known)) > least


def driven(capture: Capture, opened: Sequence[Opening]) -> list[Capture]:
    """The parts of a capture in which its bridge was closed; a rest before a drive counts."""
    if not opened:
        return [capture]
    return [part(capture, a, b) for a, b in _between(opened, capture)]


def _between(opened: Sequence[Opening], capture: Capture) -> list[tuple[int, int]]:
    edges = [0, *(edge for one in opened for edge in (one.start, one.rests)), len(capture)]
    return _worth(capture, zip(edges[::2], edges[1::2], strict=True), DRIVEN)


def left_out(captures: Sequence[Capture]) -> list[Diagnostic]:
    """What ``pieces`` leaves out of these captures because a bridge was open."""
    whole = unbroken(captures)
    opened = [openings(capture) for capture in whole]
    if not any(opened):
        return []
    if not any(map(driven, whole, opened)):
        return [
            Diagnostic(
                "bridge_open", "warning",
                "the bridge opens so often that no stretch between is long enough to fit: the "
                "voltage is taken as logged, also where the motor did not have it. Log the "
                "terminals' voltage, or capture with longer steps",
                dict.fromkeys(PARAMETERS, np.inf),
            )
        ]  # fmt: skip
    return [_remark(capture, found) for capture, found in zip(whole, opened, strict=True) if found]


def _remark(capture: Capture, opened: Sequence[Opening]) -> Diagnostic:
    kept = sum(b - a for a, b in _between(opened, capture))
    share = 100.0 * (1.0 - kept / len(capture))
    time = capture.ticks / capture.clock_hz
    stretches = [f"{time[one.start]:.4g} to {time[one.rests - 1]:.4g} s" for one in opened]
    more = f" and {len(stretches) - LISTED} more" if len(stretches) > LISTED else ""
    where = f" in {capture.path}" if capture.path else ""
    return Diagnostic(
        "bridge_open", "info",
        f"the bridge was open{where} at {', '.join(stretches[:LISTED])}{more}: no current flows, "
        f"and the logged voltage is not what drives the motor. {share:.0f} % of the samples are "
        "left out for that; each driven stretch begins anew",
    )  # fmt: skip


def part(capture: Capture, start: int, stop: int) -> Capture:
    """Samples ``start`` to ``stop`` (exclusive) as a capture."""
    inside = [gap for gap in capture.gaps if start < gap.index < stop]
    gaps = tuple(replace(gap, index=gap.index - start) for gap in inside)
    return capture.rows(slice(start, stop), gaps)
