"""An influence quantity: what is no parameter of the motor but moves a reading (VIM 2.52).

It is declared once. All else follows from the declaration: the unknown of a fit with its prior, the
line of the uncertainty budget, the test for a fault, the remedy, the row of the documents.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.problem import Unknown

if TYPE_CHECKING:
    from motorid.capture.model import Capture
    from motorid.estimate.effects.action import Action
    from motorid.estimate.effects.brush_and_heating import Loss
    from motorid.estimate.effects.source_noise import SourceNoise
    from motorid.estimate.signals.measurements import Measured
    from motorid.estimate.signals.source.thevenin_source import Source
    from motorid.estimate.signals.time_grid import Timeline
    from motorid.estimate.signals.voltage_sensing import Sense

Floats = NDArray[np.float64]


class Scope(Enum):
    """Of what there is one: a cause common to all captures is one unknown, not one each."""

    MOTOR = auto()  # all captures: the motor's own, or of the bench that took them
    CAPTURE = auto()
    PART = auto()  # of a capture's program


class Use(Enum):
    """What a fit does with a quantity that applies."""

    ESTIMATED = auto()  # an unknown, with its prior
    PROPAGATED = auto()  # a line of the budget: its uncertainty times its tangent
    UNDETECTED = auto()  # said, where the readings tell less of it than a stated prior does
    TESTED = auto()  # nothing, unless the residuals show it: a fault, or what the model lacks


class Repeats(Protocol):
    """What repeats with the rotor's angle: what each block (n,) shows of a unit of each."""

    @property
    def slopes(self) -> Mapping[Instance, Mapping[str, Floats]]: ...


class Subject(Protocol):
    """The capture that a quantity acts on, as far as declarations read it."""

    capture: Capture
    sensed: Sense
    measured: tuple[Measured, ...]
    driven: NDArray[np.bool_]
    volts: Floats
    noise: SourceNoise
    judged_at: Floats | None  # the motor by which its source was judged; None: not yet
    losing: Mapping[str, float]  # what it lost then, by unknown
    held: Mapping[str, float]  # parameters (SI) that the fit holds

    @property
    def repeating(self) -> Repeats: ...
    @property
    def timeline(self) -> Timeline: ...
    @property
    def sources(self) -> tuple[Source | None, ...]: ...
    @property
    def loss(self) -> Loss | None: ...
    @property
    def pwm_period_s(self) -> float: ...
    def block(self, name: str) -> Measured | None: ...


@dataclass(frozen=True)
class Prior:
    """Gaussian knowledge of a size before any data; ``sd`` infinite: none. ``start``: of a search,
    the mean where None.
    """

    sd: float = np.inf
    mean: float = 0.0
    start: float | None = None


def once(_: Subject) -> Sequence[int]:
    """Of a quantity that is there once in a capture."""
    return (0,)


def unbounded(_: Subject) -> tuple[float, float]:
    """Of a quantity of any size."""
    return -np.inf, np.inf


def undeclared(_: Subject, __: int) -> Prior | None:
    """Of a quantity of which no capture says anything: another room knows its size, or a test."""
    return None


def never(_: Subject) -> bool:
    """Of a quantity that no reading tells."""
    return False


@dataclass(frozen=True)
class Shape:
    """One of the forms that a quantity's effect may have, and how likely it is before any data."""

    chance: float
    acts: tuple[Action, ...]


@dataclass(frozen=True, eq=False)  # each is itself
class InfluenceQuantity:
    """``prior``: from what is declared (GUM type B) or a stated default; None: it is not there.

    ``scale``: over which its effect keeps its course, in ``unit``; a derivative's step is ``step``
    of it. ``places``: the parts, or jumps, of a capture that have one each. ``told``: the readings
    may tell a propagated one better than its declaration. ``kept``: one that was not detected has
    its line in a budget even where readings hardly tell it. ``listed`` among what was estimated.
    ``term``: of a wider model, that has the effect by itself. ``shapes``: forms of an effect that
    was not detected, where a parameter beside its size is open; their chances add up to 1.
    """

    name: str
    unit: str
    scope: Scope
    use: Use
    acts: tuple[Action, ...]
    prior: Callable[[Any, int], Prior | None]
    scale: Callable[[Any], float]
    remedy: str
    bounds: Callable[[Any], tuple[float, float]] = unbounded
    places: Callable[[Any], Sequence[int]] | None = None
    step: float = 1e-5
    told: Callable[[Any], bool] = never
    kept: Callable[[Any], bool] = never
    listed: bool = True
    term: str = ""
    shapes: tuple[Shape, ...] = ()

    @property
    def shaped(self) -> tuple[tuple[float, InfluenceQuantity], ...]:
        """The quantity in each of its forms, with the chance of that."""
        if not self.shapes:
            return ((1.0, self),)
        return tuple((one.chance, replace(self, acts=one.acts, shapes=())) for one in self.shapes)

    @property
    def simulated(self) -> bool:
        """It changes the run or the moments of readings, not only what channels show."""
        return any(action.simulated for action in self.acts)


@dataclass(frozen=True)
class Instance:
    """A quantity where it is: in a capture, or in part ``place`` of it."""

    quantity: InfluenceQuantity
    place: int = 0

    @property
    def name(self) -> str:
        """Unique within a capture."""
        numbered = self.quantity.places is not None
        return f"{self.quantity.name} {self.place}" if numbered else self.quantity.name

    def unknown(self, subject: Subject) -> Unknown | None:
        """As a search takes it; None: it is not there."""
        prior = self.quantity.prior(subject, self.place)
        if prior is None:
            return None
        lower, upper = self.quantity.bounds(subject)
        start = prior.mean if prior.start is None else prior.start
        return Unknown(
            self.name, start, lower, upper, scale=self.quantity.scale(subject),
            prior_mean=prior.mean, prior_sd=prior.sd,
        )  # fmt: skip


def instances(quantity: InfluenceQuantity, subject: Subject) -> list[Instance]:
    """Wherever the quantity is in a capture, those that do not apply there included."""
    return [Instance(quantity, k) for k in (quantity.places or once)(subject)]
