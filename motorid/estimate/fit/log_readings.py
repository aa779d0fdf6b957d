"""How the readings of a log came, where nobody says so and a choice between few ways decides it.

A speed that counts edges since the last reading is the mean over that time, and so is a current
behind an integrating converter. A voltage that was read when it jumped, or jumped between two
readings, is no course that joins or holds them: then the moment of each jump is an unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, Capture
from motorid.estimate.effects.unstated import default
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import LOOSE, Rival
from motorid.estimate.solver.problem import Solution

Floats = NDArray[np.float64]
Fit = tuple[list[MotorRecord], Solution]
Search = Callable[[list[MotorRecord], Solution], Solution]

AFTER = 3  # samples after a jump in which its moment shows
LARGER = 4.0  # variance there, of that elsewhere, from which the moments are asked for


def taken(
    records: list[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
    fixed: Mapping[str, float],
) -> Fit:
    """The likeliest way in which these readings came; the others are its rivals."""

    def again(others: list[MotorRecord], near: Solution) -> Solution:
        return settled(others, free, merged(start, near))

    best = records, solution
    for name in (SPEED, CURRENT):
        best = _averaged(best, name, free, fixed, again)
    return _loosened(best, free, fixed, again)


def _averaged(
    before: Fit, name: str, free: Sequence[str], fixed: Mapping[str, float], again: Search
) -> Fit:
    """The likelier of readings of an instant, and of means since the reading before."""
    captures = [_of_means(record, name) for record in before[0]]
    if not any(captures):
        return before
    others = [
        MotorRecord(capture or record.capture, free, fixed, record.shape)
        for capture, record in zip(captures, before[0], strict=True)
    ]
    other = others, again(others, before[1])
    best, rival = (other, before) if other[1].objective < before[1].objective else (before, other)
    behind = rival[1].objective - best[1].objective
    gain = before[1].objective - best[1].objective
    known = [Rival(r.values, r.behind + gain) for r in before[0][0].rivals]
    for record in best[0]:
        record.rivals = (*known, Rival(rival[1].values, behind))
    return best


def _of_means(record: MotorRecord, name: str) -> Capture | None:
    """The capture with a channel of means over the usual period; None: somebody states otherwise,
    or it is no log.
    """
    measured, period_s = record.block(name), default.period_s(record)
    if measured is None or not default.unstated(record, measured.channel, "aperture"):
        return None
    channel = replace(record.capture.channels[name], kind="mean", aperture_s=period_s)
    return replace(record.capture, channels={**record.capture.channels, name: channel})


def _loosened(before: Fit, free: Sequence[str], fixed: Mapping[str, float], again: Search) -> Fit:
    """With the moment of every jump as an unknown, where the residuals ask for it."""
    records, solution = before
    if not any(
        _asks(r, solution.values, own) for r, own in zip(records, solution.own, strict=True)
    ):
        return before
    others = [MotorRecord(record.capture, free, fixed, LOOSE) for record in records]
    found = others, again(others, solution)
    more = sum(len(r.unknowns) for r in others) - sum(len(r.unknowns) for r in records)
    readings = sum(len(m.values) for r in records for m in r.measured)
    if solution.objective - found[1].objective < more * np.log(readings):  # Schwarz
        return before
    return found


def _asks(record: MotorRecord, values: Floats, own: Floats) -> bool:
    """After jumps of the voltage the current is left far larger residuals than elsewhere."""
    waveform, current = record.sensed.waveform, record.block(CURRENT)
    if waveform is None or current is None or waveform.shape == LOOSE:
        return False
    jumped = waveform.time_s[replace(waveform, shape=LOOSE).jumps]
    if not len(jumped):
        return False
    left = record.departures(values, own)[record.measured.index(current)]
    at_s = current.keep * record.timeline.period_s
    since = at_s - jumped[np.maximum(np.searchsorted(jumped, at_s, side="right") - 1, 0)]
    near = (since >= 0.0) & (since < AFTER * waveform.period_s)
    if near.all() or not near.any():
        return False
    return bool(np.mean(left[near] ** 2) > LARGER * np.mean(left[~near] ** 2))
