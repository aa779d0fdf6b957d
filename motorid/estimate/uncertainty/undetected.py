"""Effects that a motor may have and that no capture was found to show: what they leave open.

D is the change of the readings by one standard deviation of the effect's prior, cleared of what
parameters and nuisances explain; r are the residuals. 1/(1 + D'D) of the prior's variance stays
open, about a size of D'r/(1 + D'D). The parameters' shift is by both together. Driving and
coasting alone hardly tell some effects. Where the prior says more of one than the readings do, the
report says what its usual size would do: as of a gain that nobody stated, no interval holds it.

An effect of which more than the size is open has several forms. Each leaves a shift; the line is
the root of their mean square over the forms, weighed by their chances and by how likely each makes
the readings (Laplace).

An effect is seen only by as much as the pull of it on the residuals scatters (pull_scatter.py), and
by errors of the voltage, which the model's readings hold and no residual shows.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial, reduce

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Use, instances
from motorid.estimate.effects.registry import used
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.solver.dense_products import project, square
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.estimate.uncertainty.errors_in_variables import Hidden
from motorid.estimate.uncertainty.pull_scatter import pull_scatter

Floats = NDArray[np.float64]
_Change = tuple[int, Floats, Linearised]  # of the record of that number

UNTOLD = 0.2  # of a prior: where more of it stays open, these data do not tell the effect
BESIDE = 0.5  # the same beside an effect that was found: what can be told of both is less
FARTHEST = 1.0  # of it: a larger size is for other causes to explain
UNBOUNDED = 50.0  # of a logarithm, by which no reading tells it: any more says the same
FOUND = 4.0  # standard deviations of a size that is seen
TINY = 1e-12  # of what is moved: where no form moves anything


@dataclass(frozen=True)
class Undetected:
    """``shift`` (p,) of the parameters in search coordinates by what is open of an effect.

    ``open``: the part of the prior's standard deviation that the readings leave. ``seen``: how many
    standard deviations its size is from nothing, where that is too many for chance; else 0.
    ``kept``: the budget has its line whatever the readings tell.
    """

    quantity: InfluenceQuantity
    shift: Floats
    open: float
    seen: float = 0.0
    kept: bool = False

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
        """The prior says more of it than these data, and no line of a budget does."""
        return self.open > UNTOLD and not (self.kept and not self.seen)


@dataclass
class _Sums:
    """Of the readings' change by one standard deviation, cleared of nuisances: with itself, with
    the shared parameters (p,), with the residuals."""

    square: float
    shared: Floats
    pull: float

    def added(self, other: _Sums) -> _Sums:
        """Of both records."""
        square, shared = self.square + other.square, self.shared + other.shared
        return _Sums(square, shared, self.pull + other.pull)


def undetected(
    solution: Solution, records: Sequence[MotorRecord], unseen: Sequence[Hidden] = ()
) -> tuple[Undetected, ...]:
    """What every effect leaves open that these records could have and do not model.

    ``unseen``: errors of the voltage.
    """
    test = _Test(solution, records, unseen)
    left = []
    for quantity in used(Use.UNDETECTED):
        forms = [(chance, test.of(form)) for chance, form in quantity.shaped]
        if all(form is not None for _, form in forms):
            shift, open_, seen = _mixed([(chance, form) for chance, form in forms if form])
            kept = any(quantity.kept(records[k]) for _, form in forms if form for k in form.runs)
            left.append(Undetected(quantity, shift, open_, seen, kept))
    return tuple(left)


@dataclass(frozen=True)
class _Form:
    """What is left of an effect in one of its forms, in the ``runs`` that may have it.

    ``whole`` (p,): the parameters' shift by one standard deviation of its prior, and ``moves``
    their square in standard deviations. ``open``: the part of the prior's deviation that is left,
    about a ``size`` that is ``sure`` of its deviations from nothing.
    """

    runs: tuple[int, ...]
    whole: Floats
    moves: float
    open: float
    size: float
    sure: float


class _Test:
    """Looks for effects that ``records`` do not model at their solution."""

    def __init__(
        self, solution: Solution, records: Sequence[MotorRecord], unseen: Sequence[Hidden]
    ) -> None:
        self.solution, self.records, self.unseen = solution, records, unseen
        self.inverse = covariance_of(solution.information)
        self.slope = np.sum(
            [project(line.orthogonal.T, line.residual) for line in solution.records], axis=0
        )

    def of(self, quantity: InfluenceQuantity) -> _Form | None:
        """The effect in one form; None: no record could have it, or has readings with it."""
        changes = list(_changes(quantity, self.solution, self.records))
        if not changes:
            return None
        sums = reduce(_Sums.added, (_sums(change, line) for _, change, line in changes))
        if not np.isfinite(sums.square):  # no motor with it and these parameters has readings
            return None
        follows = self.inverse @ sums.shared
        information = _information(changes, self.solution.records, follows)
        left = partial(_left, [k for k, *_ in changes], sums, information, self.inverse, self.slope)
        found = left()
        if found.sure > FOUND:
            found = left(_scatter(changes, follows, self.unseen))
        return found


def _mixed(forms: Sequence[tuple[float, _Form]]) -> tuple[Floats, float, float]:
    """(shift, open, seen) over forms and their chances. The likeliest form says whether the effect
    is seen; which part is open counts by what each form moves.
    """
    logs = np.array([np.log(chance * one.open) + one.sure**2 / 2.0 for chance, one in forms])
    likely = np.exp(logs - logs.max())
    likely /= likely.sum()
    each = [one for _, one in forms]
    best = each[int(np.argmax(likely))]
    seen = best.sure if best.sure > FOUND else 0.0
    sizes = np.array([np.hypot(one.open, 0.0 if seen else one.size) for one in each])
    whole = np.array([one.whole for one in each])
    shift = np.copysign(np.sqrt(likely @ (sizes[:, None] * whole) ** 2), best.whole)
    moves = likely * np.array([max(one.moves, TINY) for one in each])
    left = np.array([one.open for one in each])
    return shift, float(np.sqrt(moves @ left**2 / moves.sum())), seen


def _information(changes: Sequence[_Change], lines: Sequence[Linearised], follows: Floats) -> float:
    """What readings tell of an effect that the parameters follow by ``follows``: the squares of
    what is left in all ``lines``, with those of the nuisances' priors. A difference of both squares
    would be rounding where nothing is left.
    """
    total, by_record = 0.0, {k: change for k, change, _ in changes}
    for k, line in enumerate(lines):
        free, information = line.cleared()
        target = by_record.get(k, 0.0) - line.shared @ follows
        sizes = covariance_of(information) @ project(free.T, target)
        total += square(target - free @ sizes) + float(line.own_precision @ sizes**2)
    return total


def _scatter(changes: Sequence[_Change], follows: Floats, unseen: Sequence[Hidden]) -> float:
    """Variance of the pull, over that of white residuals; the parameters follow by ``follows``."""
    left = [_cleared(change, line) - line.orthogonal @ follows for _, change, line in changes]
    pulls = [
        sum(float(c @ e.change) for (k, *_), c in zip(changes, left, strict=True) if k == e.record)
        for e in unseen
    ]
    return pull_scatter(left, [line.residual for *_, line in changes], pulls)


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
        if one.open <= BESIDE or one.kept
    }


def _changes(
    quantity: InfluenceQuantity, solution: Solution, records: Sequence[MotorRecord]
) -> Iterator[_Change]:
    """(n,) of a record's readings by one standard deviation of the effect, wherever it may be."""
    each = zip(records, solution.own, solution.records, strict=True)
    for k, (record, own, line) in enumerate(each):
        if quantity.term in record.modelled:
            continue
        for one in instances(quantity, record):
            if (unknown := one.unknown(record)) is not None:
                moved = record.weighed(tangent(record, solution.values, own, one))
                pairs = zip(moved, line.sigmas, strict=True)
                yield k, np.concatenate([unknown.prior_sd * d / s for d, s in pairs]), line


def _sums(change: Floats, line: Linearised) -> _Sums:
    free, information = line.cleared()
    own = free.T
    taken, pulled = project(own, change), project(own, line.residual)
    follows = covariance_of(information)
    return _Sums(
        square(change) - float(taken @ follows @ taken),
        project(line.orthogonal.T, change),
        float(project(change[None], line.residual)[0]) - float(taken @ follows @ pulled),
    )


def _cleared(change: Floats, line: Linearised) -> Floats:
    """The change less what the record's nuisances explain of it."""
    free, information = line.cleared()
    own = free.T
    return np.asarray(change - covariance_of(information) @ project(own, change) @ own)


def _left(
    runs: Sequence[int],
    sums: _Sums,
    information: float,
    inverse: Floats,
    slope: Floats,
    scatter: float = 1.0,
) -> _Form:
    share = 1.0 / (1.0 + information)
    size = share * (sums.pull - float(sums.shared @ inverse @ slope))
    size = min(max(size, 0.0), FARTHEST)
    left = float(share**0.5)
    # readings that are larger by what the model lacks pull the other way
    whole = -inverse @ sums.shared
    moves = -float(sums.shared @ whole)
    return _Form(tuple(runs), whole, moves, left, size, size / left / float(np.sqrt(scatter)))
