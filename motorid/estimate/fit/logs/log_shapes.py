"""The shapes that a log's voltage may have between its readings, and the likeliest of them.

Nobody says whether a voltage joins its readings, holds them or jumps between them. So each shape is
fitted, and what the others leave more is said of them as rivals. Means, stated or likeliest, are
tried as those of a curve as well. A speed of means in place of instants is late by half a sample,
as a held voltage is: with it, all shapes are tried again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from motorid.capture.model import SPEED, Capture
from motorid.estimate.effects.unstated import default
from motorid.estimate.fit.alternating_fit import vanished
from motorid.estimate.fit.logs import log_readings
from motorid.estimate.fit.logs.log_unknowns import Fit, as_rival
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.unexplained import unsupported
from motorid.estimate.signals import curved_means
from motorid.estimate.signals.intersample_voltage import (
    BROKEN,
    CURVED_MEANS,
    JOINED,
    MEANS,
    SHAPES,
    SOURCED,
    Shape,
)
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

RISES = (0.4, 1.0, 4.0)  # L/R in samples of a log, to begin with as well
QUICK = 0.1  # the same of a winding that rows hardly tell
HARDLY = 0.1  # standard deviation of a logarithm
BETTER = 1.0  # of chi-square, by which another start is worth taking


def of_every_shape(
    first: list[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
    fresh: Callable[[Shape], list[MotorRecord]],
) -> list[Fit]:
    """A voltage that jumps makes bad ground for a search: each begins where the smoothest ended.

    Where an inductance vanished there, from one that rows tell as well: no search finds back. Where
    it is hardly told, a lag of the voltage stands in for it, or the reverse: from next to none too.
    """
    near = merged(start, solution)
    found, elsewhere = [(first, solution)], []
    rise = RISES[0] if vanished(solution, first) else QUICK if _hardly_told(solution) else None
    if "L" in free and rise:
        rise_s = rise * max(default.period_s(record) for record in first)
        elsewhere = [{**near, "L": rise_s * near["R"]}]
    for shape in _shapes(first)[1:]:
        records = fresh(shape)
        if shape == BROKEN and not any(_wanders(record) for record in records):
            continue  # it is joined, or held
        if shape == SOURCED and not any(_has_source(record) for record in records):
            continue  # it is broken
        if shape == MEANS and all(unsupported(*one) is not None for one in found):
            continue  # rows in any order are each a mean: a current of its own voltage alone
        tried = [(records, settled(records, free, near))]
        for other in elsewhere:
            records = fresh(shape)
            tried.append((records, settled(records, free, other)))
        found.append(min(tried, key=lambda one: one[1].fair))
    best = min(found, key=lambda one: one[1].fair)
    if any(_moves_in_means(record) for record in best[0]):
        records = fresh(CURVED_MEANS)
        found.append((records, settled(records, free, merged(start, best[1]))))
    return found


def shaped_again(
    before: Fit,
    free: Sequence[str],
    start: Mapping[str, float],
    fresh: Callable[[Shape], list[MotorRecord]],
) -> Fit:
    """The likeliest shape of the voltage for a speed as it turned out to be: one that is late by
    half a sample speaks for a voltage that is.
    """
    near, first = merged(start, before[1]), fresh(JOINED)
    found = of_every_shape(first, settled(first, free, near), free, start, fresh)
    best = min(found, key=lambda one: one[1].fair)
    if best[1].fair > before[1].fair - BETTER:
        return before
    return likeliest([*found, before])


def otherwise_shaped(
    before: Fit, free: Sequence[str], start: Mapping[str, float], fixed: Mapping[str, float]
) -> Fit:
    """The likeliest shape for a speed of means in place of instants, or the reverse, if it is
    likelier: neither a shape alone nor such a speed alone may have been.
    """
    other = [log_readings.otherwise(record, SPEED) for record in before[0]]
    if not any(other):
        return before
    captures = [c or record.capture for c, record in zip(other, before[0], strict=True)]

    def fresh(shape: Shape) -> list[MotorRecord]:
        return [MotorRecord(capture, free, fixed, shape) for capture in captures]

    return shaped_again(before, free, start, fresh)


def turns_otherwise(fit: Fit, as_read: Sequence[Capture]) -> bool:
    """Its speed turned out to be means, or instants, with which no other shape was tried."""
    each = [(record.capture, read) for record, read in zip(fit[0], as_read, strict=True)]
    return any(now.get(SPEED) is not read.get(SPEED) for now, read in each)


def likeliest(found: Sequence[Fit]) -> Fit:
    """And the others are its rivals."""
    best = min(found, key=lambda one: one[1].fair)
    for k, record in enumerate(best[0]):
        record.rivals = tuple(as_rival(one, best, k) for one in found if one[1] is not best[1])
    return best


def _hardly_told(solution: Solution) -> bool:
    """The inductance."""
    deviations = np.sqrt(np.diag(covariance_of(solution.information)))
    named = zip(solution.unknowns, deviations, strict=True)
    return any(u.name == "L" and deviation > HARDLY for u, deviation in named)


def _shapes(records: Sequence[MotorRecord]) -> Sequence[Shape]:
    """That a voltage may have: means are means where somebody says so."""
    waveforms = [record.sensed.waveform for record in records]
    stated = all(waveform is not None and waveform.window_s for waveform in waveforms)
    return (MEANS,) if stated else SHAPES


def _moves_in_means(record: MotorRecord) -> bool:
    """Its voltage is taken for means of levels, and moves besides its jumps."""
    waveform = record.sensed.waveform
    return waveform is not None and waveform.shape == MEANS and curved_means.move(waveform.volts)


def _wanders(record: MotorRecord) -> bool:
    waveform = record.sensed.waveform
    return waveform is not None and waveform.wanders


def _has_source(record: MotorRecord) -> bool:
    waveform = record.sensed.waveform
    return waveform is not None and waveform.ohms > 0.0
