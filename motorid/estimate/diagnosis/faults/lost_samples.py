"""Steps of the position that no motion makes: samples that are missing, counts that are lost.

A missing sample makes the next increment a whole multiple of its neighbours. Lost counts make it
smaller, or turn it round.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import HELD, POSITION, Capture
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.time_grid import Timeline
from motorid.program import whole_ticks

Floats = NDArray[np.float64]
Places = NDArray[np.intp]

AROUND = 5  # increments on either side whose median is the usual one
STANDS_OUT = 8.0  # times the scatter of increments
COUNTS = 3.5  # at least so many
WITHIN = 1e-6  # of a sample period: rounding
ALIKE = 0.3  # of the usual increment, by which others may differ from it
WHOLE = 0.2  # by which an increment may miss a multiple of its neighbours


@dataclass(frozen=True)
class Jumps:
    """``places`` (samples) of increments that stand out, and by how many usual ones, (k,)."""

    places: Places
    counts: Floats  # beyond the usual increment, in its direction; negative: lost
    missing: Floats  # samples that would explain each; 0 where no whole number does
    nearly: Floats  # the same, not whole

    @property
    def dropped(self) -> int:
        """Samples that are missing."""
        return int(self.missing.sum())

    @property
    def lost(self) -> float:
        """Counts that are lost."""
        return float(-self.counts[self.counts < 0].sum())


def suspects(capture: Capture, timeline: Timeline) -> list[Suspect]:
    """Samples that are missing, counts that are lost."""
    jumps, short = find(capture, timeline), short_of_program(capture)
    dropped = jumps.dropped if jumps is not None else 0
    out = []
    if short or dropped:
        evidence = (
            f"the run is {short} samples shorter than its program, and no gap is recorded"
            if short
            else f"the position jumps by whole steps {int((jumps.missing > 0).sum())} times"
            if jumps is not None
            else ""
        )
        evidence += (
            f"; {dropped} of them show as jumps of the position" if short and dropped else ""
        )
        action = "count the samples on the board and send their numbers, so that gaps are known"
        out.append(Suspect("samples_dropped", "time", evidence, action, "named"))
    elif jumps is not None and jumps.lost:
        evidence = (
            f"the position falls short by {jumps.lost:.0f} counts in {len(jumps.places)} jumps, "
            f"first at {capture.time_s[jumps.places[0]]:.4g} s"
        )
        action = "look for a loose encoder, a bad cable or an interrupt that comes too late"
        out.append(Suspect("encoder_loses_counts", "position", evidence, action, "named"))
    return out


def find(capture: Capture, timeline: Timeline) -> Jumps | None:
    """The position's jumps; None where it is not read, repeats its readings, or has no step."""
    position = capture.get(POSITION)
    if position is None or not position.resolution > 0:
        return None
    if POSITION in (capture.provenance.get(HELD) or {}):  # repetitions, and jumps between
        return None
    counts = np.asarray(position.values / position.resolution, dtype=np.float64)
    steps = np.diff(counts)
    neighbours = np.diff(timeline.index) == 1
    usual = 0.5 * (np.roll(steps, 1) + np.roll(steps, -1))
    odd = np.abs(steps - usual)
    scatter = float(np.median(odd[neighbours])) if neighbours.any() else 0.0
    least = max(STANDS_OUT * scatter, COUNTS)
    places = np.flatnonzero((odd > 0.6 * least) & neighbours)
    places = places[(places >= AROUND) & (places < len(steps) - AROUND)]
    out, beyond, missing, nearly = [], [], [], []
    for k in places.tolist():
        middle = _usual(np.r_[steps[k - AROUND : k], steps[k + 1 : k + AROUND + 1]])
        more = (steps[k] - middle) * (np.sign(middle) or 1.0)
        between = abs(steps[k + 1] - steps[k - 1])  # a motor that starts moves on both sides
        if abs(more) <= max(least, between):
            continue
        multiple = more / max(abs(middle), 1e-9)
        whole = round(multiple) >= 1 and abs(multiple - round(multiple)) < WHOLE
        out.append(k + 1)
        beyond.append(more)
        missing.append(float(round(multiple)) if whole else 0.0)
        nearly.append(multiple)
    index = np.array(out, dtype=np.intp)
    return Jumps(index, np.array(beyond), np.array(missing), np.array(nearly))


def _usual(steps: Floats) -> float:
    """The mean of increments (counts) that are like most of them: finer than a whole count."""
    middle = float(np.median(steps))
    alike = np.abs(steps - middle) <= max(COUNTS, ALIKE * abs(middle))
    return float(steps[alike].mean()) if alike.any() else middle


def short_of_program(capture: Capture) -> int:
    """Samples by which a completed run is shorter than its program, gaps counted; 0: none."""
    if capture.program is None or capture.end_reason != "completed" or not capture.phases:
        return 0
    if capture.phases[0].index != 0:
        return 0
    period = capture.period_s * capture.clock_hz  # ticks
    begin = capture.phases[0].tick - int(capture.ticks[0])
    expected = math.floor((begin + _planned_ticks(capture, period)) / period + WITHIN)
    present = len(capture) + sum(gap.samples for gap in capture.gaps)
    return max(expected - present, 0)


def _planned_ticks(capture: Capture, period: float) -> int:
    """The program's length as a board counts it: each of its steps in whole sample periods.

    Of a fast burst each step is a multiple of the shortest period of a stream.
    """
    known = capture.provenance
    clock_hz = known.get("identity", {}).get("clock_hz", capture.clock_hz)  # as a board knows it
    least = known.get("identity", {}).get("min_sample_period_ticks", 1)
    asked = known.get("configuration", {}).get("sample_period_ticks", 0) or round(period)
    unit = max(int(asked), int(least))
    steps = capture.program.steps if capture.program is not None else ()
    return sum(whole_ticks(step.duration_s, clock_hz, unit) for step in steps)
