"""Which part of its capture's program a residual belongs to: what a model lacks differs by part."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import Measured
from motorid.estimate.signals.time_grid import Timeline
from motorid.estimate.solver.problem import Solution


def by_part(solution: Solution, records: Sequence[MotorRecord]) -> list[NDArray[np.intp]]:
    """Of every record: the number of the part that each of its residuals (n,) belongs to."""
    out = []
    for record, line in zip(records, solution.records, strict=True):
        numbers = np.zeros(len(line.residual), dtype=np.intp)
        for m, block in zip(record.measured, line.slices, strict=True):
            own = numbers[block]
            for k, rows in part_rows(record.timeline, m, len(own)):
                own[rows] = k
        out.append(numbers)
    return out


def part_rows(timeline: Timeline, m: Measured, count: int) -> Iterator[tuple[int, slice]]:
    """The last ``count`` readings of a block by the part of the program: its number, and which."""
    edges = [part.start for part in timeline.parts] + [timeline.count]
    places = np.searchsorted(m.keep[-count:], edges)
    for k, (a, b) in enumerate(pairwise(places)):
        if b > a:
            yield k, slice(int(a), int(b))
