"""What repeats with the rotor's angle becomes unknowns of the captures whose readings ask for it.

Every brushed motor has commutation ripple, and many an encoder an error of its own turn. Residuals
that repeat with the angle are counted by their spectrum over it. An order is taken where straight
lines along the fitted motion show that the likelihood of what repeats rises by more than its
unknowns cost. It is a ripple or cogging, not both: cogging explains much of a start or a reversal,
which does not repeat. Where nothing stands out, nothing is simulated.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.rotor.friction_ripple import FRICTION_RIPPLE
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.r_ripple import R_RIPPLE
from motorid.estimate.effects.rotor.repeating import Courses, Repeating, order
from motorid.estimate.fit.straight_lines import Sight, StraightLines, fall
from motorid.estimate.model.angle_spectrum import (
    PEAK,
    TURN,
    Turned,
    periods_a_turn,
    recurring,
    turned,
)
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.repeating_response import RepeatingResponse, is_of_motor
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.solver.problem import Derivatives, Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]
Slopes = dict[Instance, Courses]

MARGIN = 10.0  # of F, beyond Schwarz's penalty: odds of exp(-5)
ORDERS = 4  # of a motor: the commutation, its harmonic, bars that differ, cogging
TRIED = 3  # counts a round, the strongest
FEWEST = 1.0  # turns of a rotor that show what repeats with them
FEW, NO_PEAK = 5.0, 1.0  # turns: in fewer a count's power leaks into its neighbours'
OF_ENCODER = (1, 2)  # a turn: a disc off its centre, a disc that is bent
SAME = 3.0  # standard deviations of all readings together, by which courses are still the same
SHIFTED = 0.1  # of a parameter: the same of what they would move
HEAVY = 0.05  # of K or R
RIPPLE = (K_RIPPLE, R_RIPPLE)
KINDS = (RIPPLE, (K_RIPPLE,), (COGGING,), (FRICTION_RIPPLE,))  # of an order: one; K may show alone
STRAIGHT = 0.3  # of what a ripple shows, beyond which it is no straight line in its size


def with_repeating(records: Sequence[MotorRecord], solution: Solution) -> Solution | None:
    """Where a search goes on with what repeats among the unknowns; None: nothing asks for it.

    Nor is anything taken where a ripple is too large for straight lines: a wider model has it.
    """
    if not any(_tells(line) for line in solution.records):
        return None
    inverse = covariance_of(solution.information)
    found = [
        _Turning(record, solution.values, own, line, inverse)
        for record, own, line in zip(records, solution.own, solution.records, strict=True)
    ]
    if min(one.turns for one in found) < FEWEST:
        return None
    _take(found)
    bends = [one.bend() for one in found]
    if not found[0].slopes or any(bend is None for bend in bends):
        return None
    for one, bend in zip(found, bends, strict=True):
        one.record.repeating = Repeating(one.slopes, bend or {}, one.course())
        one.record.estimate(*one.slopes)
    own = tuple(np.append(x, one.sizes) for x, one in zip(solution.own, found, strict=True))
    return replace(solution, own=own, derivatives=_lent(solution.derivatives, found))


def _tells(line: Linearised) -> bool:
    """Whether more is left of some block than the least that its readings can scatter by."""
    each = zip(line.blocks, line.sigmas, strict=True)
    return any(sigma > block.floor for block, sigma in each)


def taken_again(records: Sequence[MotorRecord], solution: Solution) -> Solution | None:
    """Where a search goes on with courses taken anew along the motion that it found; None: they
    show what they showed.
    """
    inverse, moved = covariance_of(solution.information), False
    new = []
    for record, own, line in zip(records, solution.own, solution.records, strict=True):
        sizes = {one: float(x) for one, x in zip(record.instances, own, strict=True)}
        new.append(_anew(record, sizes, RepeatingResponse(record, solution.values, own)))
        lines = StraightLines(record, line, inverse)
        before, after = (_total(known, sizes) for known in (record.repeating, new[-1]))
        change = {block: after[block] - before[block] for block in after}
        moved |= lines.length(change) > SAME or lines.shift(change) > SHIFTED
    if not moved:
        return None
    for record, repeating in zip(records, new, strict=True):
        record.repeating = repeating
    return replace(solution, derivatives=None)


def _anew(
    record: MotorRecord, sizes: Mapping[Instance, float], response: RepeatingResponse
) -> Repeating:
    """The same quantities along the motion of a response."""
    slopes = dict(record.repeating.slopes)
    for periods in {order(one) for one in slopes if is_of_motor(one)}:
        slopes |= {one: c for one, c in response.slopes(periods).items() if one in slopes}
    known = {one: sizes[one] for one in slopes}
    return Repeating(slopes, response.bends(slopes, sizes), response.course(known))


def _total(repeating: Repeating, sizes: Mapping[Instance, float]) -> Courses:
    """All that it shows, by block."""
    out = dict(repeating.bend)
    for one, courses in repeating.slopes.items():
        for block, course in courses.items():
            out[block] = out.get(block, 0.0) + sizes[one] * course
    return out


def is_heavy(records: Sequence[MotorRecord], solution: Solution) -> bool:
    """K or R ripples by more than straight lines describe to the last: a wider model does."""
    sizes: dict[tuple[int, InfluenceQuantity, int], float] = {}
    for k, (record, own) in enumerate(zip(records, solution.own, strict=True)):
        for one, size in zip(record.instances, own.tolist(), strict=True):
            if one.quantity in (K_RIPPLE, R_RIPPLE):
                key = (k, one.quantity, order(one))
                sizes[key] = math.hypot(sizes.get(key, 0.0), size)
    return max(sizes.values(), default=0.0) > HEAVY


def repeat_as(records: Sequence[MotorRecord], others: Sequence[MotorRecord]) -> None:
    """Let what repeats in other records of the same captures be unknowns of these."""
    for record, other in zip(records, others, strict=True):
        record.repeating = other.repeating
        record.estimate(*other.repeating.slopes)


class _Turning:
    """A record whose readings follow straight lines about a solution.

    ``slopes`` of what was taken, their ``sizes``, and the residual (n,) that they leave.
    """

    def __init__(
        self, record: MotorRecord, shared: Floats, own: Floats, line: Linearised, inverse: Floats
    ) -> None:
        self.record = record
        self.lines = StraightLines(record, line, inverse)
        self.response = RepeatingResponse(record, shared, own)
        self._departures = record.departures(shared, own)
        self.slopes: Slopes = {}
        self.sizes, self.left = np.zeros(0), line.residual

    @property
    def turns(self) -> float:
        """Of its rotor, from one end of its motion to the other."""
        return float(np.ptp(self.response.angle)) / TURN

    def sights(self, period: float, coasts: bool) -> list[Sight]:
        """What to look at of each block's residuals to see whether something repeats so (rad).

        ``coasts``: at an open bridge too.
        """
        angle = self.response.angle
        return [
            partial(recurring, keep=m.keep, angle=angle, period=period)
            if coasts or m.block.name != EMF
            else _nothing
            for m in self.record.measured
        ]

    def counted(self) -> list[Turned]:
        """What is left of its readings over the rotor's angle."""
        shown = self._shown(self.slopes)
        left = [
            r - shown.get(m.block.name, 0.0)
            for m, r in zip(self.record.measured, self._departures, strict=True)
        ]
        return turned(self.record, left, self.response.angle)

    def take(self, slopes: Slopes) -> None:
        """Have these too."""
        self.slopes = {**self.slopes, **slopes}
        self.sizes, self.left = self.lines.fitted(self.slopes)

    def bend(self) -> Courses | None:
        """What the motor shows beyond straight lines; None where that is much of what it shows."""
        bend = self.response.bends(self.slopes, self._sized)
        line = self._shown({one: s for one, s in self.slopes.items() if is_of_motor(one)})
        straight = self.lines.length(bend) <= STRAIGHT * self.lines.length(line)
        return bend if straight else None

    def course(self) -> Floats:
        """What was taken adds to the run by which the driving voltage is judged."""
        return self.response.course(self._sized)

    def _shown(self, slopes: Slopes) -> dict[str, Floats]:
        """What some of those taken show, by block."""
        out: dict[str, Floats] = {}
        for one, size in self._sized.items():
            for block, course in slopes.get(one, {}).items():
                out[block] = out.get(block, 0.0) + size * course
        return out

    @property
    def _sized(self) -> dict[Instance, float]:
        return dict(zip(self.slopes, self.sizes.tolist(), strict=True))


@dataclass(frozen=True)
class _Trial:
    """An order as each record would have it, and by how much F would fall beyond its cost."""

    slopes: Sequence[Slopes]
    gain: float


def _take(found: Sequence[_Turning]) -> None:
    """Orders of the motor, the strongest first, then those of its encoder."""
    tried: set[int] = set()
    peak = PEAK if max(one.turns for one in found) > FEW else NO_PEAK
    for _ in range(ORDERS):
        counts = periods_a_turn([one.counted() for one in found], peak)
        new = [n for n in counts if n not in tried][:TRIED]
        trials = [_either(found, n) for n in new]
        best = max(trials, key=lambda trial: trial.gain, default=None)
        if best is None or not best.gain > 0.0:
            break
        tried |= {order(one) for one in best.slopes[0]}
        _taken(found, best)
    for n in OF_ENCODER:
        turn = TURN * max(one.record.gear for one in found)
        trial = _trial(found, [one.response.encoder_error(n) for one in found], turn / n)
        if trial.gain > 0.0:
            _taken(found, trial)


def _either(found: Sequence[_Turning], periods: int) -> _Trial:
    """A ripple of so many periods a turn, cogging, or friction: what explains more. One way cogging
    and friction are alike, and it is called cogging.

    Where K shows alone, R ripples too: starts and reversals tell it, and they do not repeat.
    """
    slopes = [one.response.slopes(periods) for one in found]
    trials = {kind: _trial(found, [_of(x, kind) for x in slopes], TURN / periods) for kind in KINDS}
    best = max(trials, key=lambda kind: trials[kind].gain)
    taken = trials[RIPPLE] if K_RIPPLE in best else trials[best]
    return replace(taken, gain=trials[best].gain)


def _of(slopes: Slopes, kind: Sequence[InfluenceQuantity]) -> Slopes:
    return {one: courses for one, courses in slopes.items() if one.quantity in kind}


def _taken(found: Sequence[_Turning], trial: _Trial) -> None:
    for one, slopes in zip(found, trial.slopes, strict=True):
        one.take(slopes)


def _trial(found: Sequence[_Turning], slopes: Sequence[Slopes], period: float) -> _Trial:
    """Beside what was taken. ``period``: of the rotor's angle, rad. Only what repeats with it
    counts, each block by the colour of what is left of it. An open bridge is asked about K alone:
    cogging moves the speed of a coast, which is no straight line in its size for long.
    """
    gain, readings = -MARGIN, 0.0
    for one, more in zip(found, slopes, strict=True):
        _, left = one.lines.fitted({**one.slopes, **more})
        coasts = any(known.quantity is K_RIPPLE for known in more)
        fallen, worth = fall(one.lines.line, one.left, left, one.sights(period, coasts))
        gain, readings = gain + fallen, readings + worth
    return _Trial(slopes, gain - sum(map(len, slopes)) * float(np.log(max(readings, 2.0))))


def _nothing(residual: Floats) -> Floats:
    return residual[:0]


def _lent(known: Derivatives | None, found: Sequence[_Turning]) -> Derivatives | None:
    """The derivatives that a search knows, with those of what was taken."""
    if known is None:
        return None
    own = tuple(np.append(x, one.sizes) for x, one in zip(known.own, found, strict=True))
    more = zip(known.own_slopes, found, strict=True)
    slopes = tuple(np.vstack([C, one.lines.rows(one.slopes)]) for C, one in more)
    return replace(known, own=own, own_slopes=slopes)
