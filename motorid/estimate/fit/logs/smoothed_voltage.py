"""A log's voltage behind a low-pass that nobody stated, beside a winding about as slow.

    current = ... (1 + s V) / (1 + s L/R) voltage

Where V, the low-pass of the voltage, is near L/R, the two cancel: the log reads as one of a motor
without an inductance, and no slope leads a search from there to the two. Their difference is what
readings show at once, as a delay of the current behind the voltage. So a search begins at several
inductances, each with the low-pass that leaves that delay what it is. One of them has the low-pass
that the voltage's own readings show: they go on rising after a jump. Where they do not, nothing is
tried.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import UNSTATED
from motorid.estimate.effects.unstated import default
from motorid.estimate.effects.unstated.voltage_second_order import VOLTAGE_SECOND_ORDER
from motorid.estimate.effects.unstated.voltage_smoothing import VOLTAGE_SMOOTHING
from motorid.estimate.fit.logs.log_unknowns import Fit, voltage_delay_s, widened
from motorid.estimate.fit.multistart import settled
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import JOINED, Shape
from motorid.estimate.signals.time_grid import IRREGULAR
from motorid.estimate.solver.problem import Solution

RISES = (0.3, 1.0, 3.0)  # L/R in samples of a log, to begin with
LEAST = 0.4  # samples: a shorter low-pass needs no start of its own
BEGUN = 0.5  # of a change: one that was as large a sample before began then
JUMPS = 0.05  # of the square of all changes; behind a low-pass of 20 samples they are .1 of it
SLOWEST = 0.95  # of a change that goes on: a low-pass of 20 samples
SMOOTH: Shape = "curved"  # as a low-pass leaves it
OTHERS: tuple[Shape, ...] = (JOINED, "held")
LOW_PASS, SECOND = Instance(VOLTAGE_SMOOTHING), Instance(VOLTAGE_SECOND_ORDER)


def begun(
    first: Sequence[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    known: Mapping[str, float],
    fixed: Mapping[str, float],
) -> list[Fit]:
    """Fits with such low-passes; none: somebody states it, the voltage's readings show none, or
    none would leave the delay, or the stamps are irregular, so that what a jump's next reading
    shows is a matter of its stamp.

    ``first``: records of a joined voltage with their ``solution``, all channels as stamped; its
    parameters are ``known``.
    """
    if "L" not in free or any(LOW_PASS.unknown(record) is None for record in first):
        return []
    if any(record.timeline.jitter > IRREGULAR for record in first):
        return []
    period_s = max(default.period_s(record) for record in first)
    goes_on = max(_goes_on(record) for record in first)
    if goes_on < math.exp(-1.0 / LEAST):
        return []
    seen_s = -period_s / math.log(min(goes_on, SLOWEST))
    delays = [_delay_s(r, own, known) for r, own in zip(first, solution.own, strict=True)]

    def began(rise_s: float, shape: Shape, order: int) -> Fit:
        records = [MotorRecord(record.capture, free, fixed, shape) for record in first]
        for record, delay_s in zip(records, delays, strict=True):
            _smooth(record, rise_s - delay_s, order)
        start = {**known, "L": rise_s * known["R"]}
        return records, widened(records, free, start, settled(records, free, start))

    rises = [seen_s + max(delays), *(rise * period_s for rise in RISES)]
    rises = [r for r in rises if r > 0.0 and r - max(delays) > LEAST * period_s]
    if not rises:
        return []
    tried = {rise_s: began(rise_s, SMOOTH, 1) for rise_s in rises}
    best = min(tried, key=lambda rise_s: tried[rise_s][1].fair)
    ways = [(shape, order) for shape in (SMOOTH, *OTHERS) for order in (1, 2)][1:]
    return [*tried.values(), *(began(best, shape, order) for shape, order in ways)]


def _goes_on(record: MotorRecord) -> float:
    """By what share of its last change the voltage changes on, where it jumps: exp(-T/V) behind a
    low-pass V, at samples T apart; about nothing where it jumps at once.

    A change that began before is no jump: a voltage that goes up and down by itself shows none.
    """
    waveform = record.sensed.waveform
    if waveform is None:
        return 0.0
    rises = np.diff(waveform.volts)
    jumps = waveform.steps_off - 1
    jumps = jumps[(jumps > 0) & (jumps + 1 < len(rises))]
    every = float(rises[jumps] @ rises[jumps])
    jumps = jumps[rises[jumps - 1] * rises[jumps] < BEGUN * rises[jumps] ** 2]
    total = float(rises[jumps] @ rises[jumps])
    if total <= JUMPS * every:
        return 0.0
    return float(rises[jumps] @ rises[jumps + 1]) / total


def _delay_s(record: MotorRecord, own: np.ndarray, known: Mapping[str, float]) -> float:
    """Of the current behind the logged voltage, as its stamps and its winding together make it."""
    return voltage_delay_s(record, own) + known["L"] / known["R"]


def _smooth(record: MotorRecord, size_s: float, order: int) -> None:
    """Let the voltage's low-pass be an unknown that begins there, with all that nobody stated.

    Of second order: as two equal ones, one after the other.
    """
    record.estimate(*(Instance(quantity) for quantity in UNSTATED))
    for one, share in ((LOW_PASS, 1.0), (SECOND, 0.5))[:order]:
        unknown = one.unknown(record)
        if unknown is not None:
            size = share * size_s
            record.find({one: replace(unknown, start=size, prior_sd=size)})
