"""A log's current that firmware averaged from reading to reading, where nobody said so.

A recursive average and a mean of the last readings are what boards and loggers do most. Behind a
winding that is quicker than a sample neither looks like a circuit's low-pass, and a search with
lags and low-passes ends in an inductance. So each is tried by itself, of several sizes, and a
circuit of the same delay in its place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from motorid.capture.model import CURRENT, Capture
from motorid.errors import DataError
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.smoothing import SMOOTHED, delaying
from motorid.estimate.effects.reading.smoothing_kernels import Smoothing
from motorid.estimate.effects.unstated import default
from motorid.estimate.effects.unstated.current_second_order import CURRENT_SECOND_ORDER
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.fit.alternating_fit import vanished
from motorid.estimate.fit.logs import log_means
from motorid.estimate.fit.logs.log_unknowns import Fit, Search, of_sizes, readings, with_rivals_of
from motorid.estimate.fit.multistart import MOST_TRIED, settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import JOINED, Shape
from motorid.estimate.signals.measurements import motion
from motorid.estimate.signals.time_grid import IRREGULAR
from motorid.estimate.solver.problem import Unknown

LATE = (0.5, 3.0)  # readings, to begin with
LEAST = 0.4  # of one: less is no average
BENDS = (0.0, 0.5)  # second of first time constant, of a circuit in the place of an average
SHAPES: tuple[Shape, ...] = ("held", JOINED)  # of the voltage, besides the one that was likeliest
SMOOTHING, SECOND = Instance(CURRENT_SMOOTHING), Instance(CURRENT_SECOND_ORDER)
WAYS = {way: quantity for way, quantity in SMOOTHED[CURRENT].items() if way.behind}

Found = Callable[[MotorRecord], dict[Instance, Unknown]]


class _Search(Search):
    def __call__(self, shape: Shape, found: Found, near: Mapping[str, float]) -> Fit:
        """With these found."""
        records = self.records(shape)
        for record in records:
            record.find(found(record))
        return records, settled(records, self.free, near, self.worth)

    def each(self, shapes: Iterable[Shape], ways: Sequence[Found], near: Mapping[str, float]
    ) -> list[Fit]:  # fmt: skip
        """Every way under every shape of the voltage, as far as its work is bounded."""
        fits: list[Fit] = []
        for shape, way in product(shapes, ways):
            if sum(max(r.simulated for r in records) for records, _ in fits) > MOST_TRIED:
                break
            try:
                fits.append(self(shape, way, near))
            except DataError:  # no motor with finite readings is there
                continue
        return [fit for fit in fits if not vanished(fit[1], fit[0])]


def taken(
    before: Fit,
    as_read: Sequence[Capture],
    free: Sequence[str],
    known: Mapping[str, float],
    fixed: Mapping[str, float],
    alike: float,
) -> Fit:
    """The likeliest such fit of the captures ``as_read``; ``before`` where none is likelier, where
    what is much like it is, where somebody states the current's filter, where readings are not
    evenly apart, or where the current is all that tells of it.

    ``alike``: what is left by the likeliest fit that takes them as they were read, so that an
    average which is none is seen at once.
    """
    if any(not _may_be(record) for record in before[0]):
        return before
    search = _Search(as_read, free, fixed, before[1].objective)
    price = float(np.log(readings(before[0])))  # Schwarz
    found = _tried(before, search, merged(known, before[1]), alike - price)
    best = min(found, key=_cost, default=before)
    if _cost(before) - _cost(best) <= price or _late(best) < LEAST:
        return before
    search = replace(search, worth=best[1].objective)
    beside = _beside(best, _shapes(before), search, merged(known, best[1]))
    if any(_cost(fit) < _cost(best) for fit in beside):
        return before
    return with_rivals_of(before, best)


def _cost(fit: Fit) -> float:
    return fit[1].fair


def _may_be(record: MotorRecord) -> bool:
    unstated = SMOOTHING.unknown(record) is not None
    even = record.timeline.jitter <= IRREGULAR
    return unstated and even and motion(record.capture) is not None


def _averaged(way: Smoothing, late: float) -> Found:
    return lambda record: {Instance(WAYS[way]): delaying(WAYS[way], way, late)}


def _tried(before: Fit, search: _Search, near: Mapping[str, float], enough: float) -> list[Fit]:
    """Every way and size under one shape of the voltage, then the likeliest under others, if some
    objective is below ``enough``.
    """
    shape, *others = _shapes(before)
    begun = search.each([shape], [_averaged(way, late) for way in WAYS for late in LATE], near)
    best = min(begun, key=_cost, default=None)
    if best is None or _cost(best) >= enough:
        return begun
    way, _ = _average(best)
    ways = [_averaged(way, late) for late in (max(_late(best), LEAST), *LATE)]
    return [*begun, *search.each(others, ways, near)]


def _late(fit: Fit) -> float:
    """By how many readings an average makes its current so."""
    way, size = _average(fit)
    return way.behind * size


def _beside(
    best: Fit, shapes: Sequence[Shape], search: _Search, near: Mapping[str, float]
) -> Iterator[Fit]:
    """What is much like an average: circuits, and for a mean of readings that of a whole time."""
    way, size = _average(best)
    circuits = [_circuit(_late(best), bend) for bend in BENDS]
    yield from search.each(shapes, circuits, near)
    for count in {max(1, round(size)), round(size) + 1} if way.whole else ():
        width_s = count * max(default.period_s(record) for record in best[0])
        means = [log_means.as_means(capture, width_s) for capture in search.as_read]
        yield from replace(search, as_read=means).each(shapes, [lambda _: {}], near)


def _shapes(before: Fit) -> list[Shape]:
    """Of the voltage, the one that was likeliest first."""
    return list(dict.fromkeys((before[0][0].shape, *SHAPES)))


def _average(fit: Fit) -> tuple[Smoothing, float]:
    """How the current of a fit is averaged, and of what size."""
    sizes = dict(zip(fit[0][0].instances, fit[1].own[0].tolist(), strict=True))
    return next((way, sizes[Instance(q)]) for way, q in WAYS.items() if Instance(q) in sizes)


def _circuit(late: float, bend: float) -> Found:
    """A low-pass in the place of an average, late by as many readings."""

    def found(record: MotorRecord) -> dict[Instance, Unknown]:
        size = late * default.period_s(record)
        sizes = {SMOOTHING: size, SECOND: bend * size} if bend else {SMOOTHING: size}
        return of_sizes(record, sizes)

    return found
