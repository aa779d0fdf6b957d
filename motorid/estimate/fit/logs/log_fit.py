"""The fit of logs, of which nobody says what their voltage did between readings, nor whether a
channel is late or smoothed.

First every shape of the voltage is tried with all channels taken as stamped. Most logs need no
more. Where the readings ask for it, lags and low-passes become unknowns of the likeliest shape. One
that is there may be of any size: its prior is widened to what was found, and all shapes are tried
again. A smoothed channel is much like an inductance: other inductances are tried then as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.timing.voltage_late import VOLTAGE_LATE
from motorid.estimate.effects.unstated import default
from motorid.estimate.fit.alternating_fit import vanished
from motorid.estimate.fit.logs import (
    log_averages,
    log_grid,
    log_lags,
    log_means,
    log_one_filter,
    log_readings,
    log_second_order,
    log_shapes,
    smoothed_voltage,
)
from motorid.estimate.fit.logs.log_shapes import BETTER, RISES
from motorid.estimate.fit.logs.log_unknowns import (
    Fit,
    like,
    moved,
    readings,
    widened,
    with_rivals_of,
)
from motorid.estimate.fit.logs.unstated_channels import Told, told
from motorid.estimate.fit.multistart import GROSS, MOST_TRIED, settled, whitened
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.unexplained import unsupported
from motorid.estimate.signals.intersample_voltage import SHAPES, Shape
from motorid.estimate.signals.measurements import motion
from motorid.estimate.signals.time_grid import IRREGULAR
from motorid.estimate.solver.autoregression import inflation
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]
PLAIN = SHAPES[:4]  # that need nothing but the readings of the voltage
RESTARTED = 3  # shapes whose answer is where a search begins once more, its lags in whole samples
ALIKE = 1.5  # variance of residuals, of that between neighbours: those are off alike
FAR = 4.0  # standard deviations of what is usual, that a voltage is late: no stamp makes it so
WORSE = 1.5  # times: what an explanation may leave most readings off by


def best(
    first: list[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
    fixed: Mapping[str, float],
) -> Fit:
    """The likeliest answer; ``first``: records of the smoothest shape, with their ``solution``."""
    as_read = [record.capture for record in first]
    captures = as_read  # as their readings turn out to be
    joined, joined_at = solution, merged(start, solution)

    def fresh(shape: Shape) -> list[MotorRecord]:
        return [MotorRecord(capture, free, fixed, shape) for capture in captures]

    plain = log_shapes.likeliest(log_shapes.of_every_shape(first, solution, free, start, fresh))
    alike = plain[1].fair
    plain = log_readings.taken(*plain, free, start, fixed)
    if log_shapes.turns_otherwise(plain, as_read):
        captures = [record.capture for record in plain[0]]
        plain = log_shapes.shaped_again(plain, free, start, fresh)
    plain, heard = _on_its_grid(plain, free, start, fixed)
    if any(one.asked_for for one in heard):
        other = log_shapes.otherwise_shaped(plain, free, start, fixed)
        plain, heard = (plain, heard) if other is plain else (other, told(*other))
    averages: list[Fit] = []
    if any(one.asked_for for one in heard):
        averaged = log_averages.taken(plain, as_read, free, start, fixed, alike)
        averages = [averaged] if averaged is not plain else []
        then = told(*averaged)
        if not any(one.asked_for for one in then):  # it is all that there is
            for record in averaged[0]:
                record.as_stamped = merged(start, plain[1])
            plain, heard = averaged, then
    captures = [record.capture for record in plain[0]]
    for record, one in zip(plain[0], heard, strict=True):
        record.left_open = (*one.shifts, one.step)
    needed = sum(one.needed for one in heard)
    smoothed = smoothed_voltage.begun(first, joined, free, joined_at, fixed)
    better = any(plain[1].fair - fit[1].fair > needed for fit in smoothed)
    asked = any(one.asked_for for one in heard) or vanished(plain[1], plain[0])
    misfit = unsupported(*plain) is None and (_leaves_much(*plain) or _comes_far(*plain))
    coloured = not (asked or better or misfit)
    if coloured:
        colour = inflation(plain[1])
        if colour < log_readings.COLOURED:
            return plain
        needed *= colour
    known = merged(start, plain[1])
    records = like(plain, fresh(plain[0][0].shape))
    solution = widened(records, free, known, settled(records, free, known))
    found = [(records, solution), *smoothed]
    records, solution = log_shapes.likeliest(found)
    if any(record.found for record in records) or vanished(solution, records):
        found += _begun_elsewhere((records, solution), free, known, fresh)[1:]
    wider = log_shapes.likeliest(found)
    if not any(moved(record, own) for record, own in zip(wider[0], wider[1].own, strict=True)):
        records = [MotorRecord(r.capture, free, fixed, r.shape) for r in plain[0]]
        again = settled(records, free, merged(start, wider[1]))  # as likely without them
        plain = _instead(plain, (records, again))
    price = float(np.log(readings(wider[0])))
    if misfit:
        alone = log_one_filter.taken(wider, as_read, free, known, fixed, sought=True)
        wider = log_means.likelier(wider, alone, price)
    gain = plain[1].fair - wider[1].fair
    if gain > needed and coloured and _white_alone(plain, wider, free, start):
        return plain
    if gain > needed and serves_few(plain, wider):
        for record in plain[0]:
            record.outlying = True
        return plain
    if gain > needed:
        filtered = log_second_order.taken(wider, free, known, fixed)
        means = log_means.taken(wider, free, known, fixed)
        lagged = log_lags.taken(wider, as_read, free, known, fixed)
        alone = log_one_filter.taken(wider, as_read, free, known, fixed)
        for other in (filtered, means, lagged, alone, *averages):
            wider = log_means.likelier(wider, other, price)
        wider = log_readings.reconsidered(wider, free, known, fixed)
        wider = log_second_order.without_vanished(wider, free, known, fixed)
        for record in wider[0]:
            record.as_stamped = known
        return wider
    if coloured:
        return plain
    for record in plain[0]:
        record.left_open = ()
    plain[0][0].left_open = _less_known(plain[1], solution)  # larger steps are not worth it
    return plain


def _on_its_grid(
    plain: Fit, free: Sequence[str], start: Mapping[str, float], fixed: Mapping[str, float]
) -> tuple[Fit, list[Told]]:
    """The fit, on a finer grid where that answers what its residuals ask; and what they ask for."""
    heard = told(*plain)
    if not any(one.asked_for for one in heard):
        return plain, heard
    finer = log_grid.settled(plain, free, start, fixed)
    if finer is plain:
        return plain, heard
    then = told(*finer)
    return (plain, heard) if any(one.asked_for for one in then) else (finer, then)


def _white_alone(before: Fit, after: Fit, free: Sequence[str], start: Mapping[str, float]) -> bool:
    """The second is the likelier for white residuals alone: with their memory in the weights, as an
    answer is given at last, it is not. A position adds up noise of the voltage, which lags fit.
    """
    ends = []
    for records, solution in (before, after):
        twins = [record.twin() for record in records]
        ends.append(whitened(twins, free, merged(start, solution), solution).objective)
    return ends[0] <= ends[1]


def serves_few(before: Fit, after: Fit) -> bool:
    """What explains a few readings that lie far off has most of the others off by more."""
    was, now = _typical(before), _typical(after)
    return any(now[name] > WORSE * was[name] for name in now)


def _typical(fit: Fit) -> dict[str, float]:
    """By how much most readings of a channel are off (SI), at most."""
    sizes: dict[str, float] = {}
    for record, own in zip(fit[0], fit[1].own, strict=True):
        left = record.departures(fit[1].values, own)
        for m, one in zip(record.measured, left, strict=True):
            size = max(float(np.median(np.abs(one))), m.block.floor)
            sizes[m.block.name] = max(size, sizes.get(m.block.name, 0.0))
    return sizes


def _leaves_much(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """Residuals of a channel are large beside its range, and neighbours are off alike.

    Not of a log without a motion, or with irregular stamps: nobody knows what its voltage did.
    """
    if any(r.timeline.jitter > IRREGULAR or not motion(r.capture) for r in records):
        return False
    for record, own in zip(records, solution.own, strict=True):
        for m, left in zip(record.measured, record.departures(solution.values, own), strict=True):
            between = float(np.mean(np.diff(left) ** 2)) / 2.0
            least = (GROSS * float(np.ptp(m.values))) ** 2
            if float(np.mean(left**2)) > max(ALIKE * between, least):
                return True
    return False


def _comes_far(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """The voltage of a log with a motion is taken for later or earlier than stamps make it: a slow
    low-pass of it is a lag to first order, and the winding makes up for the rest.
    """
    return any(
        one.quantity is VOLTAGE_LATE and abs(float(size)) > FAR * unknown.prior_sd
        for record, own in zip(records, solution.own, strict=True)
        if motion(record.capture)
        for one, unknown, size in zip(record.instances, record.unknowns, own, strict=True)
    )


def _instead(before: Fit, other: Fit) -> Fit:
    """The likelier of two fits of the same readings; with the rivals of the first."""
    gain = before[1].fair - other[1].fair
    if gain <= 0.0:
        return before
    for record, last in zip(other[0], before[0], strict=True):
        record.left_open = last.left_open
    return with_rivals_of(before, other)


def _less_known(narrow: Solution, wide: Solution) -> tuple[Floats, ...]:
    """Shifts (p,) of the parameters by which a solution with more unknowns leaves them open."""
    more = covariance_of(wide.information) - covariance_of(narrow.information)
    sizes, ways = np.linalg.eigh(more)
    pairs = zip(sizes, ways.T, strict=True)
    return tuple(way * np.sqrt(size) for size, way in pairs if size > 0)


def _begun_elsewhere(
    before: Fit,
    free: Sequence[str],
    known: Mapping[str, float],
    fresh: Callable[[Shape], list[MotorRecord]],
) -> list[Fit]:
    """The same with unknown lags and low-passes from other inductances, then of other shapes.

    What is left out, to end at all, is said.
    """

    def began(near: Fit, shape: Shape, whole: bool, start: Mapping[str, float]) -> Fit:
        records = like(near, fresh(shape), whole)
        return records, widened(records, free, start, settled(records, free, start))

    found, shape = [before], before[0][0].shape
    period_s = max(default.period_s(record) for record in before[0])
    near = merged(known, before[1])
    for rise in RISES if "L" in free else ():
        if _exhausted(found):
            break
        start = {**near, "L": rise * period_s * near["R"]}
        found.append(began(before, shape, False, start))
    best = min(found, key=lambda one: one[1].fair - (BETTER if one is before else 0.0))
    near, shape = merged(known, best[1]), best[0][0].shape
    shapes = dict.fromkeys((*PLAIN, shape))
    ways = [(other, whole) for other in shapes for whole in (False, True)]
    ways = [way for way in ways if way != (shape, False)]
    for k, (other, whole) in enumerate(ways):
        if _exhausted(found):
            for records, _ in found:
                records[0].untried += len(ways) - k
            break
        found.append(began(best, other, whole, near))
    for fit in _best_of_each_shape(found)[:RESTARTED]:
        if _exhausted(found):
            break
        found.append(began(fit, fit[0][0].shape, True, merged(known, fit[1])))
    return found


def _best_of_each_shape(found: Sequence[Fit]) -> list[Fit]:
    """The likeliest first. A search stops short where a jump of the voltage passes a reading; a lag
    of whole samples, as software makes it, puts every jump there.
    """
    best: dict[Shape, Fit] = {}
    for one in sorted(found, key=lambda fit: fit[1].fair):
        best.setdefault(one[0][0].shape, one)
    return list(best.values())


def _exhausted(found: Sequence[Fit]) -> bool:
    """As many responses of a capture were computed as other starts are worth."""
    return sum(max(r.simulated for r in records) for records, _ in found) > MOST_TRIED
