"""The better model, term by term: what the residuals ask for and the data support."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Solution
from motorid.estimate.wider.fit import Fitted, fit_with
from motorid.estimate.wider.judge import Evidence, weigh
from motorid.estimate.wider.plain import plain
from motorid.estimate.wider.screen import Candidate, screen
from motorid.estimate.wider.shaft import springs
from motorid.estimate.wider.terms import Term

WORTH = 30.0  # of chi-square that a term must promise to be fitted
HINT = 0.5  # of what matters, that it must promise to move some parameter by
GROSS = 1000.0  # of chi-square: fitted whatever it moves
LINEAR = ("B", "T0")  # whose search coordinate is their value
REFITTED = 3  # candidates a round
ROUNDS = 5
RIVAL = 0.5  # of a supported term's promise, from which another is fitted beside it


@dataclass(frozen=True)
class Trial:
    """A term that was fitted: beside which others, its evidence, and whether it was taken.

    ``moves``: the largest move of a parameter that it makes, in units of what matters.
    """

    term: Term
    beside: tuple[Term, ...]
    evidence: Evidence
    moves: float
    taken: bool = False

    @property
    def earns(self) -> bool:
        """The data support it, and it matters."""
        return self.evidence.supports and self.moves > 1.0


@dataclass(frozen=True)
class Selection:
    """The best supported fit, None where it is the six parameters', and what was tried."""

    fitted: Fitted | None
    trials: tuple[Trial, ...]


def select(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    reach: Mapping[str, float],
) -> Selection:
    """Terms taken one by one, each the best of its round. ``values``: as ``screen``'s.

    ``reach``: by how much a parameter may move (SI) before it matters.
    """
    best: Fitted | None = None
    trials: list[Trial] = []
    for _ in range(ROUNDS):
        found = _round(records, solution, values, best, reach)
        taken = max(
            (f for f, trial in found if trial.earns),
            key=lambda f: -f.solution.objective,
            default=None,
        )
        trials += [replace(t, taken=fitted is taken) for fitted, t in found]
        if taken is None:
            break
        best = taken
    return Selection(best, tuple(trials))


def _round(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    best: Fitted | None,
    reach: Mapping[str, float],
) -> list[tuple[Fitted, Trial]]:
    now = (
        (records, solution, values) if best is None else (best.records, best.solution, best.values)
    )
    taken = () if best is None else best.terms
    bare = (*plain(*now, taken), now[2])
    asked = [c for c in screen(*bare, taken) if _is_worth(c, now[2], reach)][:REFITTED]
    found: list[tuple[Fitted, Trial]] = []
    supported = 0.0  # gain promised by the most promising term that the data support
    for candidate in asked:
        if candidate.gain < RIVAL * supported:
            break
        found.append(_tried(*now, taken, candidate, reach))
        if found[-1][1].earns:
            supported = max(supported, candidate.gain)
    if not supported:
        found += [_tried(*now, taken, candidate, reach) for candidate in springs(*bare, taken)]
    return found


def _is_worth(
    candidate: Candidate, values: Mapping[str, float], reach: Mapping[str, float]
) -> bool:
    """It promises much, and to move what matters."""
    moves = max(
        (
            abs(candidate.shift.get(n, 0.0)) * (1.0 if n in LINEAR else values[n]) / limit
            for n, limit in reach.items()
        ),
        default=0.0,
    )
    return candidate.gain > GROSS or (candidate.gain > WORTH and moves > HINT)


def _tried(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    taken: tuple[Term, ...],
    candidate: Candidate,
    reach: Mapping[str, float],
) -> tuple[Fitted, Trial]:
    names = {u.name for u in solution.unknowns}
    fixed = {n: v for n, v in values.items() if n not in names}
    own = [
        {u.name: float(v) for u, v in zip(r.unknowns, o, strict=True)}
        for r, o in zip(records, solution.own, strict=True)
    ]
    if candidate.own:
        own = [{**a, **b} for a, b in zip(own, candidate.own, strict=True)]
    fitted = fit_with(
        records, solution, (*taken, candidate.term),
        fixed={n: v for n, v in fixed.items() if n not in candidate.term.free},
        start={**values, **candidate.start}, own=own,
    )  # fmt: skip
    evidence = weigh(fitted, taken, solution, candidate.term)
    now = fitted.values
    moves = max((abs(now[n] - values[n]) / limit for n, limit in reach.items()), default=0.0)
    return fitted, Trial(candidate.term, taken, evidence, moves)
