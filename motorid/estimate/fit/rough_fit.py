"""What a rough search leaves of the readings: which of some suppositions is worth a whole fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.fit.alternating_fit import ROUGH, ROUGH_PASSES, again
from motorid.estimate.fit.parameter_bounds import held_values, searched, unknowns_of
from motorid.estimate.fit.start_values import begun
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.log_sections import pieces
from motorid.estimate.solver.levenberg_marquardt import maximise

Floats = NDArray[np.float64]


def departures(
    captures: Sequence[Capture],
    start: Mapping[str, float],
    fix: Mapping[str, float],
    without: Sequence[str],
    channels: Sequence[str] = (),
) -> list[Floats]:
    """Measured less fitted in SI units, one array per channel of each capture; of all, or of some
    ``channels``.

    From ``start`` values, and those of a fit where they lack one; there are no other starts. Raises
    DataError where a capture cannot be fitted.
    """
    records, free, start = _posed(captures, start, held_values(fix, without))
    solution = maximise(unknowns_of(records, free, start), records, enough=ROUGH)
    for _ in range(ROUGH_PASSES):
        for record, own in zip(records, solution.own, strict=True):
            record.retake_sources(solution.values, own)
        solution = again(records, free, start, solution, ROUGH)
    return [
        left
        for record, own in zip(records, solution.own, strict=True)
        for m, left in zip(record.measured, record.departures(solution.values, own), strict=True)
        if not channels or m.block.name in channels
    ]


def moves(
    captures: Sequence[Capture],
    others: Sequence[Capture],
    values: Mapping[str, float],
    fix: Mapping[str, float],
    without: Sequence[str],
    channel: str,
) -> list[Floats]:
    """What ``others`` would show more than ``captures`` at these values, SI, one array of that
    channel for each capture: a response each, and no search.
    """
    held, shown = held_values(fix, without), []
    for supposed in (captures, others):
        records, free, start = _posed(supposed, values, held)
        shared = np.array([start[name] for name in free])
        shown.append([
            y for record in records
            for m, y in zip(record.measured, record.fitted(shared, _begin(record)), strict=True)
            if m.block.name == channel
        ])  # fmt: skip
    return [more - y for y, more in zip(*shown, strict=True)]


def _begin(record: MotorRecord) -> Floats:
    """Its own unknowns (m,) where a search begins."""
    return np.array([unknown.start for unknown in record.unknowns])


def _posed(
    captures: Sequence[Capture], values: Mapping[str, float], held: Mapping[str, float]
) -> tuple[list[MotorRecord], list[str], dict[str, float]]:
    """Records of the captures, what is free, and where a search begins: by ``values``, or where a
    fit would where they lack one.
    """
    free = searched(held)
    records = [MotorRecord(capture, free, held) for capture in pieces(captures)]
    return records, free, {**begun(records, held)[0], **values}
