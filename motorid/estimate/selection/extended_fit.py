"""The fit with given terms: the six-parameter fit's engine, noise model and voltage sources."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorid.errors import DataError
from motorid.estimate.effects.winding_temperature import STALL_K_S
from motorid.estimate.fit import alternating_fit, multistart
from motorid.estimate.fit.parameter_bounds import merged, typical, unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_capture_model import Priors, WideRecord
from motorid.estimate.model.extended_terms import ADDED, Scales, Term
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.allowance import current
from motorid.estimate.solver.levenberg_marquardt import ENOUGH, MAX_ITERATIONS, maximise
from motorid.estimate.solver.problem import Solution

KNEE_SD = 1.0  # of ln i_b about a twentieth of the stall current
SLOW_SD = 1.0  # of ln w_s about a twentieth of the highest speed
ROUGH_STEPS = 12  # of a rough fit: one that needs more is not the best of its rivals
MOST_INTEGRATED = 10_000_000  # steps of responses, for each unknown: a search to be judged by
AT_THE_END = (
    1e-6  # change of F: valleys of friction are flat, and their ends must be the same anywhere
)
IRON_SD = 1.5  # of the logarithm of where K or L falls, and of an eddy time
FARTHEST = 0.8  # of the most that an added parameter may be, where a search begins
LEAST = 4  # times a set of derivatives: less is not enough to end a fit
LAST = 6  # the same, of which the passes leave so many to the search in the noise that they show
PART = 0.4  # of what is left: the same
FROM = 0.5  # of the highest speed: standard deviation of that from which R rises, about none
COOLS_1_S = 0.5  # standard deviation of a winding's rate of cooling
BENDS = 5.0  # standard deviation of the rate of a friction's change, over the longest capture


@dataclass(frozen=True)
class Fitted:
    """The most likely parameters under six parameters and ``terms``."""

    terms: tuple[Term, ...]
    records: tuple[WideRecord, ...]
    solution: Solution
    free: tuple[str, ...]
    start: Mapping[str, float]  # every value that was not searched among them
    settled: bool = True  # nothing that was to come was left out to bound the work
    took: int = 0  # responses, to be judged

    @property
    def width(self) -> int:
        """Responses that its derivatives take."""
        return width_of(self.records, self.free)

    @property
    def values(self) -> dict[str, float]:
        """Every parameter, searched or not."""
        return merged(self.start, self.solution)

    @property
    def model(self) -> tuple[Sequence[MotorRecord], Solution, Mapping[str, float]]:
        """What another term is added to."""
        return self.records, self.solution, self.values

    def deviation(self, name: str) -> float:
        """Standard deviation of a parameter for white residuals, in its unit; inf at a bound."""
        k = self.free.index(name)
        if self.solution.at_bound[k]:
            return float("inf")
        return float(np.sqrt(self.solution.covariance[k, k]) * self.solution.slopes[k])


def width_of(records: Sequence[MotorRecord], free: Sequence[object]) -> int:
    """Responses of all records that derivatives by their unknowns take."""
    return sum(1 + len(free) + len(record.unknowns) for record in records)


def sizes_by_name(records: Sequence[MotorRecord], solution: Solution) -> list[dict[str, float]]:
    """Every record's own unknowns at a solution."""
    return [
        dict(zip((u.name for u in record.unknowns), own.tolist(), strict=True))
        for record, own in zip(records, solution.own, strict=True)
    ]


def scales_of(records: Sequence[MotorRecord], values: Mapping[str, float]) -> Scales:
    """Typical sizes in these captures."""
    torque, speed = typical(records, values)
    volts = max(float(np.abs(record.volts).max()) for record in records) or 1.0
    duration = max(r.timeline.count * r.timeline.period_s for r in records)
    return Scales(
        volts, volts / values["R"], speed, torque, values["R"], values["J"], values["L"], duration
    )


@dataclass(frozen=True)
class Begun:
    """A fit with terms that has a start: the records under it, ``fixed`` values among its start."""

    terms: tuple[Term, ...]
    records: tuple[WideRecord, ...]
    free: tuple[str, ...]
    start: Mapping[str, float]

    def roughly(self, enough: float = alternating_fit.ROUGH) -> Fitted:
        """The best in white noise, with the voltage sources as they are, to a change of F."""
        unknowns = unknowns_of(self.records, self.free, self.start)
        solution = maximise(unknowns, self.records, max_iterations=ROUGH_STEPS, enough=enough)
        return Fitted(self.terms, self.records, solution, self.free, self.start)

    def followed(self) -> Fitted | None:
        """``roughly``; None where no motor with finite readings follows from the start."""
        try:
            return self.roughly()
        except DataError:
            return None

    def nearly(self, rough: Fitted, lent: bool = True) -> Fitted:
        """Sources, noise and all, near enough to be judged; ``rough``: what ``roughly`` gave, whose
        derivatives serve on where they are ``lent``.
        """
        first, before = rough.solution, current().spent
        first = first if lent else replace(first, derivatives=None)
        start = merged(self.start, first)
        each = zip(self.records, first.own, sizes_by_name(self.records, first), strict=True)
        for record, own, sizes in each:
            record.plan(first.values, own)
            record.starting(sizes)
        most = _most(self.records)
        white = alternating_fit.going_on(self.records, self.free, start, first, most)
        judged = _weighed(self.records, self.free, start, white, alternating_fit.JUDGED, most)
        return Fitted(
            self.terms, self.records, judged, self.free, merged(start, white),
            took=current().spent - before,
        )  # fmt: skip


def _most(records: Sequence[WideRecord]) -> int:
    """Iterations of a search to be judged by: fewer where every response is long to integrate."""
    steps = sum(record.integrated for record in records)
    return min(max(MOST_INTEGRATED // steps, ROUGH_STEPS), alternating_fit.JUDGED_STEPS)


def finished(near: Fitted) -> Fitted:
    """The same fit to its end: what drives the motor, and the noise, settled as a fit of six has
    them, and then the search. As far as the allowance goes.
    """
    allowance = current()
    if not allowance.has(LEAST * near.width):
        return replace(near, settled=False)
    records, free, values = near.records, near.free, near.values
    allowance.ended = False
    part = PART * allowance.left if allowance.left < np.inf else 0.0
    with allowance.keeping(max(LAST * near.width, part)):
        passed = alternating_fit.in_turn(records, free, values, near.solution, thorough=True)
    white = _weighed(records, free, values, passed)
    settled = not allowance.ended
    values = merged(values, white)
    solution = alternating_fit.again(records, free, values, white, enough=AT_THE_END)
    return Fitted(near.terms, records, solution, free, near.start, settled)


def _weighed(
    records: Sequence[WideRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    white: Solution,
    enough: float = ENOUGH,
    most: int = MAX_ITERATIONS,
) -> Solution:
    """In the noise that a solution's residuals show, with steps as fine as it needs."""
    for record, own in zip(records, white.own, strict=True):
        record.plan(white.values, own)
    anew = replace(white, derivatives=None)  # of other steps, and maybe of other weights
    return multistart.whitened(records, free, merged(start, white), anew, enough, most)


def begin(
    records: Sequence[MotorRecord],
    before: Solution,
    terms: Sequence[Term],
    *,
    fixed: Mapping[str, float] | None = None,
    start: Mapping[str, float] | None = None,
    own: Sequence[Mapping[str, float]] | None = None,
    priors: Priors | None = None,
) -> Begun:
    """A fit of the records and of ``terms``, from ``before``, the records' own solution.

    ``fixed`` are those that are not searched; ``start`` and ``own`` begin others elsewhere than
    their terms say (``own`` nuisances, one mapping a record). ``priors``: (mean, sd) of an added
    parameter in search coordinates, the logarithm of those that are positive.
    """
    fixed = {**(fixed or {}), **_counted(terms, start or {})}
    names = [name for term in terms for name in term.free]
    free = [n for n in (*PARAMETERS, *names) if n not in fixed]
    known_of = {n: v for n, v in merged({}, before).items() if n in (*PARAMETERS, *names)}
    values = {**dict.fromkeys(PARAMETERS, 0.0), **fixed, **known_of}  # of terms that go, nothing
    scales = scales_of(records, values)
    first = {name: ADDED[name].part * scales.of(name) for name in names}
    first = {**first, **values, **(start or {}), **fixed}
    first |= {n: _within(n, first[n]) for n in names if n not in fixed}
    known = {**_known(scales), **(priors or {})}
    wide = []
    for k, record in enumerate(records):
        wider = WideRecord(record, free, fixed, terms, scales, known, first=k == 0)
        named = zip((u.name for u in record.unknowns), before.own[k].tolist(), strict=True)
        wider.starting({**dict(named), **(own[k] if own else {})})
        wider.plan(np.array([first[n] for n in free]), np.array([u.start for u in wider.unknowns]))
        wide.append(wider)
    return Begun(tuple(terms), tuple(wide), tuple(free), first)


def _within(name: str, start: float) -> float:
    """A start, by straight lines, that is no end of what an added parameter may be."""
    added = ADDED[name]
    return min(max(start, added.lower), FARTHEST * added.upper)


def _known(scales: Scales) -> Priors:
    """What is known of a term's shape before any data: it keeps a search from where none is."""
    bend, slow = (ADDED[n].part * scales.of(n) for n in ("i_b", "w_s"))
    return {
        "i_b": (float(np.log(bend)), KNEE_SD),
        "w_s": (float(np.log(slow)), SLOW_SD),
        "per_C_w": (0.0, STALL_K_S / 2 / (scales.volts * scales.current)),
        "k_w": (0.0, COOLS_1_S),
        "w_R": (0.0, FROM * scales.speed),
        "r_f": (0.0, BENDS * scales.of("r_f")),
        **{
            n: (float(np.log(ADDED[n].part * scales.of(n))), IRON_SD) for n in ("i_K", "i_L", "t_e")
        },
    }


def _counted(terms: Sequence[Term], start: Mapping[str, float]) -> dict[str, float]:
    """Periods a turn are whole numbers: given, never searched."""
    return {t.per_turn: start[t.per_turn] for t in terms if t.per_turn}
