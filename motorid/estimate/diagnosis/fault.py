"""A suspicion that can be put to the data: what a fault of some size does to the readings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE, Capture
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.fit.block_regression import Size
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import EMF

Floats = NDArray[np.float64]
Effect = Callable[[MotorRecord, Floats, Floats, Floats], list[Floats]]
Remedy = Callable[[Capture, float], list[Capture]]

SMALL = 1e-3  # of an added voltage, by which its effect is tried


@dataclass(frozen=True)
class Words:
    """What is said of a fault: ``evidence`` and ``action``, without capital or full stop."""

    where: str
    evidence: str
    action: str


@dataclass(frozen=True)
class Hypothesis:
    """One fault with a size of one or more numbers.

    ``effect(record, values, own, size)`` is the change of every block's readings in SI units.
    ``sizes`` are tried first, ``scale`` is a typical step of each number, ``lower`` and ``upper``
    bound them. A ``guard`` is no fault of the chain but something that the six-parameter model
    lacks: where it explains the residuals, no fault is named. ``quantity``: by which a fit takes
    it among its unknowns; None: it only marks what it could have moved. ``remedy``: the captures
    that declare a fault of about that size; for whole fits, where no quantity acts as it does.
    ``belongs``: shares of parameters that are the fault's own at a size, not the motor's.
    ``least``: of its first number, that contradicts what is declared. ``vague``: much that a motor
    does looks like it, so that it must explain most of a small misfit. ``stepwise``: it acts in
    whole samples. ``afterwards``: it was done to the readings of a log, and no fit of
    logs looks for it by itself. ``whole``: its size is a whole number, at which a fit holds it.
    ``place``: that of its quantity at a size, whose first number alone is an unknown then.
    ``scatter``: variance (SI) of every block's readings that chance gives the fault at a size: so
    much of what it leaves is its own.
    """

    code: str
    effect: Effect
    sizes: tuple[Size, ...]
    scale: Size
    lower: Size
    upper: Size
    words: Callable[[Floats], Words]
    guard: bool = False
    quantity: InfluenceQuantity | None = None
    remedy: Remedy | None = None
    belongs: Callable[[Floats], Mapping[str, float]] | None = None
    least: float = 0.0
    vague: bool = False
    stepwise: bool = False
    afterwards: bool = False
    whole: bool = False
    place: Callable[[Floats], int] | None = None
    scatter: Effect | None = None


def acting(quantity: InfluenceQuantity) -> Effect:
    """What a quantity of some size does, by the same action by which a fit estimates it."""
    one = Instance(quantity)

    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        usual = record.fitted(values, own)
        moved = record.fitted(values, own, {one: float(size[0])})
        return [new - old for old, new in zip(usual, moved, strict=True)]

    return effect


def short(name: str) -> str:
    """A channel in codes and in a few words: current, position, speed, voltage."""
    return "voltage" if name == VOLTAGE else name


def word(name: str) -> str:
    """A channel in a sentence."""
    return name.replace("_", " ")


def highest(records: Sequence[MotorRecord], name: str) -> float:
    """The highest reading (SI) of a channel with a sign; 0: no record has one."""
    blocks = (m for r in records for m in r.measured if m.block.name == name and not m.unsigned)
    return max((float(np.abs(m.values).max()) for m in blocks), default=0.0)


def showing(name: str, shown: Callable[[Floats, Floats, float], Floats]) -> Effect:
    """A channel that shows another course (count,) of the run: ``shown`` of the course, of the
    size, and of the time between ticks, s.
    """

    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        out, period_s = nothing(record), record.timeline.period_s
        for k, y in series(record, values, own, name):
            out[k] = (shown(y, size, period_s) - y)[record.measured[k].where]
        return out

    return effect


def nothing(record: MotorRecord) -> list[Floats]:
    """No change of any block."""
    return [np.zeros(len(m.values)) for m in record.measured]


def series(
    record: MotorRecord, values: Floats, own: Floats, *names: str
) -> Iterator[tuple[int, Floats]]:
    """Place and response (count,) of the blocks of these names, in their unit, without offsets."""
    full = record.readings(values, own)
    for k, m in enumerate(record.measured):
        if m.block.name in names and not m.unsigned:
            yield k, full[m.row] * (record.emf_constant(values) if m.block.name == EMF else 1.0)


def current_of(record: MotorRecord, values: Floats, own: Floats) -> Floats | None:
    """The model's current at every tick, (count,); None: the capture has none."""
    return next((y for _, y in series(record, values, own, CURRENT)), None)


def added_voltage(record: MotorRecord, values: Floats, own: Floats, volts: Floats) -> list[Floats]:
    """What ``volts`` (count,), added to the source, does to the readings; to first order."""
    base = record.fitted(values, own)
    usual = record.volts
    largest = float(np.abs(volts).max())
    if not largest > 0:
        return nothing(record)
    step = min(1.0, SMALL * float(np.abs(usual).max()) / largest)
    moved = record.fitted_with(values, own, usual + step * volts)
    return [(new - old) / step for new, old in zip(moved, base, strict=True)]


def changed_voltage(
    record: MotorRecord, values: Floats, own: Floats, volts: Floats
) -> list[Floats]:
    """The same for another source voltage (count,) altogether, exactly."""
    base = record.fitted(values, own)
    moved = record.fitted_with(values, own, volts)
    return [new - old for new, old in zip(moved, base, strict=True)]
