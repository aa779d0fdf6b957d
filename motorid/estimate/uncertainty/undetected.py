"""Effects that a motor may have and that no capture was found to show: what they leave open.

D is the change of the readings by one standard deviation of the effect's prior, cleared of what
parameters and nuisances explain; r are the residuals. 1/(1 + D'D) of the prior's variance stays
open, about a size of D'r/(1 + D'D). The parameters' shift is by both together. Driving and
coasting alone hardly tell some effects. Where the prior says more of one than the readings do, the
report says what its usual size would do: as of a gain that nobody stated, no interval holds it.

Between two readings of a log nobody knows its voltage, so that few readings after each jump are
left far more than the others. There an effect is seen only by as much as the readings that show it
scatter (White's covariance).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance, Use, instances
from motorid.estimate.effects.registry import used
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.solver.dense_products import project, square
from motorid.estimate.solver.problem import Linearised, Solution, Unknown
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

UNTOLD = 0.1  # of a prior: where more of it stays open, these data do not tell the effect
BESIDE = 0.5  # the same beside an effect that was found: what can be told of both is less
FARTHEST = 1.0  # of it: a larger size is for other causes to explain
UNBOUNDED = 50.0  # of a logarithm, by which no reading tells it: any more says the same
FOUND = 4.0  # standard deviations of a size that is seen


@dataclass(frozen=True)
class Undetected:
    """``shift`` (p,) of the parameters in search coordinates by what is open of an effect.

    ``open``: the part of the prior's standard deviation that the readings leave. ``seen``: how many
    standard deviations its size is from nothing, where that is too many for chance; else 0.
    """

    quantity: InfluenceQuantity
    shift: Floats
    open: float
    seen: float = 0.0

    def moves(self, solution: Solution, times: float = 1.0) -> dict[str, float]:
        """Relative changes of the parameters by so many ``times`` the shift, the largest first."""
        each = zip(solution.unknowns, solution.values, times * self.shift, strict=True)
        shares = {
            u.name: float(np.expm1(min(shift, UNBOUNDED)) if u.log else shift / value)
            for u, value, shift in each
            if u.log or value
        }
        return dict(sorted(shares.items(), key=lambda one: -abs(one[1])))

    @property
    def untold(self) -> bool:
        """The prior says more of it than these data."""
        return self.open > UNTOLD


@dataclass
class _Sums:
    """Of the readings' change by one standard deviation, cleared of nuisances: with itself, with
    the shared parameters (p,), with the residuals. ``logged``: the change itself, (n,) a log, with
    the record that it is of."""

    square: float
    shared: Floats
    pull: float
    logged: list[tuple[Floats, Linearised]] = field(default_factory=list)

    def scatter(self, inverse: Floats) -> float:
        """Variance of the pull, over that of white residuals; 1 at least."""
        follows = inverse @ self.shared
        white = robust = 0.0
        for change, line in self.logged:
            squares = (change - line.orthogonal @ follows) ** 2
            white += float(squares.sum())
            robust += project(squares[None], line.residual**2)[0]
        return max(robust / white, 1.0) if white else 1.0


def undetected(solution: Solution, records: Sequence[MotorRecord]) -> tuple[Undetected, ...]:
    """What every effect leaves open that these records could have and do not model."""
    inverse = covariance_of(solution.information)
    found: dict[InfluenceQuantity, _Sums] = {}
    slope = np.sum([project(line.orthogonal.T, line.residual) for line in solution.records], axis=0)
    for record, line, own in zip(records, solution.records, solution.own, strict=True):
        for one, unknown in _possible(record):
            moved = tangent(record, solution.values, own, one)
            parts = [
                unknown.prior_sd * d / s
                for d, s in zip(record.weighed(moved), line.sigmas, strict=True)
            ]
            sums = _sums(np.concatenate(parts), line, record.sensed.waveform is not None)
            before = found.setdefault(one.quantity, _Sums(0.0, np.zeros(len(inverse)), 0.0))
            before.square += sums.square
            before.shared = before.shared + sums.shared
            before.pull += sums.pull
            before.logged += sums.logged
    return tuple(_left(quantity, sums, inverse, slope) for quantity, sums in found.items())


def told(found: Sequence[Undetected]) -> dict[str, Floats]:
    """Lines of a budget: shifts (p,) in search coordinates by what is open of those that these data
    tell. One that is seen has none: whether it is there, and what it moves, the search says.
    """
    return {one.quantity.name: one.shift for one in found if not (one.untold or one.seen)}


def beside(found: Sequence[Undetected]) -> dict[str, Floats]:
    """The same lines of a model that has an effect already, which takes much of what the readings
    tell of others. One that is seen has its size: no model with it was accepted.
    """
    return {
        one.quantity.name: one.shift * float(np.hypot(1.0, one.seen))
        for one in found
        if one.open <= BESIDE
    }


def _possible(record: MotorRecord) -> Iterator[tuple[Instance, Unknown]]:
    for quantity in used(Use.UNDETECTED):
        for one in instances(quantity, record):
            unknown = None if quantity.name in record.modelled else one.unknown(record)
            if unknown is not None:
                yield one, unknown


def _sums(column: Floats, line: Linearised, logged: bool) -> _Sums:
    free, information = line.cleared()
    own = free.T
    taken, pulled = project(own, column), project(own, line.residual)
    follows = covariance_of(information) if len(own) else np.zeros((0, 0))
    left = column - follows @ taken @ own if len(own) else column
    return _Sums(
        square(column) - float(taken @ follows @ taken),
        project(line.orthogonal.T, column),
        float(project(column[None], line.residual)[0]) - float(taken @ follows @ pulled),
        [(left, line)] if logged else [],
    )


def _left(quantity: InfluenceQuantity, sums: _Sums, inverse: Floats, slope: Floats) -> Undetected:
    information = max(sums.square - float(sums.shared @ inverse @ sums.shared), 0.0)
    share = 1.0 / (1.0 + information)
    size = share * (sums.pull - float(sums.shared @ inverse @ slope))
    size = min(max(size, 0.0), FARTHEST)
    left = float(share**0.5)
    sure = size / left / float(np.sqrt(sums.scatter(inverse)))
    seen = sure if sure > FOUND else 0.0
    # readings that are larger by what the model lacks pull the other way
    whole = -inverse @ sums.shared
    return Undetected(quantity, whole * float(np.hypot(left, 0.0 if seen else size)), left, seen)
