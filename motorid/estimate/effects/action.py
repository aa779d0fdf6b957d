"""What influence quantities do: to one run of the simulation, or to what a channel shows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.loaded_motor import loaded
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Stretch

Floats = NDArray[np.float64]
Restretch = Callable[[Stretch, Part, float], Stretch]
NEVER_NONE = ("R", "L", "J")  # of which a response needs some
LEFT = 1e-3  # of it, whatever else takes from it


@dataclass
class Setup:
    """One run; actions change it. Every number of it is beside what is declared and judged, but for
    ``load_s``, the whole conductance (S) across the motor.

    ``volts`` (count,) V are added to the source. ``kicks`` (rad/s) by part, ``late_s`` and
    ``filter_s`` by block, ``motor`` by parameter. ``second_s`` by block: the root of what s² has in
    its low-pass. ``log_jumps`` by jump, in shares of what hides them.
    """

    count: int
    initial: list[float]
    load_s: float = 0.0
    volts: Floats | float = 0.0
    kicks: dict[int, float] = field(default_factory=dict)
    late_s: dict[str, float] = field(default_factory=dict)
    filter_s: dict[str, float] = field(default_factory=dict)
    second_s: dict[str, float] = field(default_factory=dict)
    motor: dict[str, float] = field(default_factory=dict)
    log_late_s: float = 0.0
    log_filter_s: float = 0.0
    log_second_s: float = 0.0
    log_jumps: dict[int, float] = field(default_factory=dict)
    source_gain: float = 1.0
    clock: float = 1.0
    stretched: list[tuple[Restretch, float]] = field(default_factory=list)

    def add_volts(self, volts: Floats | float, where: slice | None = None) -> None:
        """More of the source, everywhere or in some intervals."""
        if where is None:
            self.volts = self.volts + volts
        else:
            if not isinstance(self.volts, np.ndarray):
                self.volts = np.full(self.count, self.volts)
            self.volts[where] += volts

    def onto(self, motor: Floats, names: Sequence[str]) -> Floats:
        """The parameters as readings show them, with what quantities add to them (in place).

        Of a resistance, an inductance or an inertia some is left, however much they take: no motor
        is without it, and no response. A fit of readings that no motor gives may end where a
        bridge's resistance is more than the winding's.
        """
        for name, more in self.motor.items():
            k = names.index(name)
            least = LEFT * motor[k] if name in NEVER_NONE else -np.inf
            motor[k] = max(motor[k] + more, least)
        return self.loaded(motor, names)

    def loaded(self, motor: Floats, names: Sequence[str]) -> Floats:
        """The parameters as readings show them beside the conductance across the motor."""
        return loaded(motor, names, self.load_s)

    def early(self, jumps: int) -> list[float]:
        """How early every one of so many jumps of a log came, (jumps,)."""
        return [self.log_jumps.get(k, 0.0) for k in range(jumps)]

    def all_later(self, by_s: float, blocks: Iterable[str]) -> None:
        """Everything that a log shows comes later after what drove the motor: the same run."""
        self.log_late_s -= by_s
        for block in blocks:
            self.late_s[block] = self.late_s.get(block, 0.0) + by_s

    def all_smoother(self, by_s: float, blocks: Iterable[str]) -> None:
        """Everything of a log passed one more low-pass: the same, of a motor nearly linear."""
        self.log_filter_s += by_s
        for block in blocks:
            self.filter_s[block] = self.filter_s.get(block, 0.0) + by_s

    @property
    def rebuilt(self) -> bool:
        """No response that stands can be changed into it."""
        return bool(self.source_gain != 1.0 or self.clock != 1.0 or self.stretched)


class Action(Protocol):
    """Adds ``size`` of a quantity to a run of ``subject``."""

    @property
    def simulated(self) -> bool:
        """It changes the run; else only what a channel shows of it."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None: ...

    def show(self, shown: dict[str, Floats], subject: Any, one: object, size: float) -> None:
        """Changes what the channels show of the run, (n,) by block."""


@dataclass(frozen=True)
class Simulated:
    """An action on the run."""

    @property
    def simulated(self) -> bool:
        """It is."""
        return True

    def show(self, shown: dict[str, Floats], subject: Any, one: object, size: float) -> None:
        """Every channel shows the run as it is."""


@dataclass(frozen=True)
class SourceVoltage(Simulated):
    """``shape`` of subject and place: V (count,), or one figure, for a unit of size; a loss is
    ``taken`` from the source.
    """

    shape: Callable[[Any, int], Floats | float]
    taken: bool = False

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        if size:
            setup.add_volts((-size if self.taken else size) * self.shape(subject, place))


@dataclass(frozen=True)
class PartLoss(Simulated):
    """``shape`` (count,) in V for a unit of size, taken from the source of one part alone."""

    shape: Callable[[Any, int], Floats]

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        if size:
            where = subject.timeline.parts[place].slice
            setup.add_volts(-size * self.shape(subject, place)[where], where)


class PartVoltage(Simulated):
    """V in the intervals of one part of the program."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        if size:
            setup.add_volts(size, subject.timeline.parts[place].slice)


@dataclass(frozen=True)
class SourceGain(Simulated):
    """The source, its PWM levels and its clamps are larger by ``sign`` times the size."""

    sign: float = 1.0

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.source_gain *= 1.0 + self.sign * size


class TimeBase(Simulated):
    """The board's ticks, and all that it times, lie 1 + size apart."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.clock *= 1.0 + size


@dataclass(frozen=True)
class Delay(Simulated):
    """Readings of a block come later (s)."""

    block: str

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.late_s[self.block] = setup.late_s.get(self.block, 0.0) + size


@dataclass(frozen=True)
class LowPass(Simulated):
    """The filter before a block's converter has a longer time constant (s)."""

    block: str

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.filter_s[self.block] = setup.filter_s.get(self.block, 0.0) + size


@dataclass(frozen=True)
class SecondOrderLowPass(Simulated):
    """The filter before a log's converter is 1/(1 + a s + b² s²); the size is b (s)."""

    block: str

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        if size:
            setup.second_s[self.block] = setup.second_s.get(self.block, 0.0) + size


@dataclass(frozen=True)
class InitialState(Simulated):
    """Index of the state in which the run begins: current (A), speed (rad/s), angle, then those of
    ``motorid.motor.wide.START``.
    """

    index: int

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        if self.index < len(setup.initial):
            setup.initial[self.index] += size


class Kick(Simulated):
    """rad/s by which a turning rotor's speed jumps where a part begins."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.kicks[place] = setup.kicks.get(place, 0.0) + size


@dataclass(frozen=True)
class MotorParameter(Simulated):
    """A parameter by its name in ``motorid.motor.wide.NAMES``, larger by the size (SI)."""

    name: str

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.motor[self.name] = setup.motor.get(self.name, 0.0) + size


class Loading(Simulated):
    """S across the motor's terminals, behind the current's sensor."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.load_s += size


class LogTime(Simulated):
    """A log's voltage comes later (s)."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.log_late_s += size


class LogFilter(Simulated):
    """A log's voltage passed a low-pass with a longer time constant (s)."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.log_filter_s += size


class LogSecondOrder(Simulated):
    """A log's voltage passed 1/(1 + a s + b² s²), with a larger b (s)."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.log_second_s += size


class LogJump(Simulated):
    """How early a jump of a log's voltage came, as a share of the time that hides it."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.log_jumps[place] = setup.log_jumps.get(place, 0.0) + size


@dataclass(frozen=True)
class Bridge(Simulated):
    """``change`` of a stretch of PWM, with its part of the program, by a size."""

    change: Restretch

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.stretched.append((self.change, size))


def everywhere(_: Any) -> float:
    """Of every reading."""
    return 1.0


class Unsimulated:
    """An action on what channels show of a run."""

    @property
    def simulated(self) -> bool:
        """It leaves the run as it is."""
        return False

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        """Nothing of the run changes."""


@dataclass(frozen=True)
class Reading(Unsimulated):
    """What the channel of a block shows of a series (n,): ``shown`` of it and of the size.

    ``share`` of subject: by how much of it each reading is moved, (n,) or one figure.
    """

    block: str
    shown: Callable[[Floats, Floats | float], Floats]
    share: Callable[[Any], Floats | float] = everywhere

    def show(self, shown: dict[str, Floats], subject: Any, one: object, size: float) -> None:
        """The block shows another series."""
        if self.block in shown:
            shown[self.block] = self.shown(shown[self.block], size * self.share(subject))


@dataclass(frozen=True)
class Added(Unsimulated):
    """What the channel of a block shows beside a series (n,), in proportion to its size.

    ``course`` (n,) of subject, place and series, for a unit of size.
    """

    block: str
    course: Callable[[Any, int, Floats], Floats]

    def show(self, shown: dict[str, Floats], subject: Any, one: Any, size: float) -> None:
        """The block shows more."""
        series = shown.get(self.block)
        if series is not None:
            shown[self.block] = series + size * self.course(subject, one.place, series)


class AlongAngle(Unsimulated):
    """What every channel shows of what repeats with the rotor, in proportion to its size.

    Its course stands in ``subject.repeating``: it was computed once, along the fitted motion.
    """

    def show(self, shown: dict[str, Floats], subject: Any, one: object, size: float) -> None:
        """The blocks that it moves show more."""
        for block, course in subject.repeating.slopes.get(one, {}).items():
            shown[block] = shown[block] + size * course


def plus(series: Floats, size: Floats | float) -> Floats:
    """Shown with an offset."""
    return series + size


def times(series: Floats, size: Floats | float) -> Floats:
    """Shown with a gain of 1 + size."""
    return series * (1.0 + size)


def restretched(
    stretches: Sequence[Stretch], parts: Sequence[Part], changes: Sequence[tuple[Restretch, float]]
) -> list[Stretch]:
    """Every stretch with these changes, each told of its part of the program."""
    out = list(stretches)
    for change, size in changes:
        for k, stretch in enumerate(out):
            part = next(p for p in reversed(parts) if p.start <= stretch.start)
            out[k] = change(stretch, part, size)
    return out
