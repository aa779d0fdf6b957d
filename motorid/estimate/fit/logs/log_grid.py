"""A log whose stamps are irregular, or whose voltage jumps, on a finer grid where its intervals are
too long for it.

A reading between two ticks is compared with the line between them, and a voltage that jumps there
with its mean. While a current rises within a tick or two, both are wrong by more than the noise of
a good converter. So the fit goes on upon a grid that is several times finer, until the parameters
stay. What is left to come is a cause of the budget. Readings too coarse to tell the grids apart
keep the first, and all that the finer one changes is such a cause.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.effects.unstated import default
from motorid.estimate.fit.alternating_fit import Change, with_sources
from motorid.estimate.fit.logs.log_unknowns import Fit, readings, voltage_delay_s
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import CONTINUOUS
from motorid.estimate.signals.time_grid import FINER_GRID, IRREGULAR
from motorid.estimate.uncertainty import added_noise

Floats = NDArray[np.float64]

FACTOR, MOST_TIMES = 4, 2  # by which a grid gets finer, and how often
BETWEEN = 0.05  # of a tick, by which a jump is off the nearest
FINE = 1.0 / 32.0  # of L/R, an interval that needs no finer one
LEFT = 1.0 / (FACTOR - 1)  # of a change, that all further ones bring: errors fall with the interval
WORTH_IT = 0.3  # standard deviations by noise, left to come, that are worth a finer one
RISES = (0.1, 0.3)  # L/R in samples of the log, to begin with instead
WORSE = 1.0  # times a gain that tells: a fit that is worse by more went astray


def settled(
    before: Fit, free: Sequence[str], start: Mapping[str, float], fixed: Mapping[str, float]
) -> Fit:
    """The same fit where the grid no longer matters; the same records where it never did."""
    told = False
    for _ in range(MOST_TIMES):
        each, known = zip(before[0], before[1].own, strict=True), merged(start, before[1])
        if not any(_coarse(record, own, known) for record, own in each):
            break
        found = _gone_on(before, free, known, fixed)
        if found is None:
            break
        change = Change.of(before[1], found[1])
        gain = before[1].objective - found[1].objective
        told = told or gain > _telling(before)
        before, share = (found, LEFT) if told else (before, 1.0)
        for record in before[0]:
            record.between_ticks = share * change.shift
        if not told:
            break
        if LEFT * change.size < WORTH_IT:
            break
    return before


def _gone_on(
    before: Fit, free: Sequence[str], known: Mapping[str, float], fixed: Mapping[str, float]
) -> Fit | None:
    """On a finer grid; None: there is none, or no search ends as well there.

    A coarse one may take a quick winding for a still quicker one: other inductances are tried then.
    """
    period_s = max(default.period_s(record) for record in before[0])
    rises = RISES if "L" in free else ()
    for start in (known, *({**known, "L": rise * period_s * known["R"]} for rise in rises)):
        records = [_finer(record, free, fixed) for record in before[0]]
        if all(map(_as_fine, records, before[0])):
            return None
        for record, last, own in zip(records, before[0], before[1].own, strict=True):
            record.go_on(last, own)
        solution = with_sources(records, free, start)
        if solution.objective < before[1].objective + WORSE * _telling(before):
            return records, added_noise.judged(records, solution)
    return None


def _telling(fit: Fit) -> float:
    """Of chi-square, that readings tell two grids apart by (Schwarz)."""
    return float(np.log(readings(fit[0])))


def _coarse(record: MotorRecord, own: Floats, known: Mapping[str, float]) -> bool:
    """Readings or jumps lie between ticks which are too far apart for this winding."""
    line = record.timeline
    if record.sensed.waveform is None or line.past is None:
        return False
    if line.jitter <= IRREGULAR and not _jumps_between(record, own):
        return False
    return line.period_s * known["R"] > FINE * known["L"]


def _jumps_between(record: MotorRecord, own: Floats) -> bool:
    """The voltage jumped between two ticks."""
    waveform = record.sensed.waveform
    if waveform is None or waveform.shape in CONTINUOUS or not len(waveform.steps_off):
        return False
    ticks = voltage_delay_s(record, own) / record.timeline.period_s
    return len(waveform.jumps) > 0 or abs(ticks - round(ticks)) > BETWEEN


def _finer(record: MotorRecord, free: Sequence[str], fixed: Mapping[str, float]) -> MotorRecord:
    return MotorRecord(_on_finer_grid(record.capture), free, fixed, record.shape)


def _on_finer_grid(capture: Capture) -> Capture:
    times = FACTOR * capture.provenance.get(FINER_GRID, 1)
    return replace(capture, provenance={**capture.provenance, FINER_GRID: times})


def _as_fine(record: MotorRecord, last: MotorRecord) -> bool:
    """No finer grid is to be had."""
    return record.timeline.period_s > 0.75 * last.timeline.period_s
