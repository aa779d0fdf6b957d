"""The better model, term by term: what the residuals ask for and the data support."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import Term
from motorid.estimate.selection.evidence import Evidence, weigh
from motorid.estimate.selection.extended_fit import Begun, Fitted, begin
from motorid.estimate.selection.predicted_gain import foresee
from motorid.estimate.selection.score_test import Candidate, screen
from motorid.estimate.selection.shaft_resonance import springs
from motorid.estimate.selection.trigger import HINT
from motorid.estimate.solver.problem import Solution

WORTH = 30.0  # of chi-square that a term must promise to be fitted
GROSS = 1000.0  # of chi-square: fitted whatever it moves
FORESEEN = 5  # candidates a round
REFITTED = 3
ROUNDS = 5
RIVAL = 0.5  # of the best promise, from which another is tried beside it


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
    """Supported fits, each with a term more than the one before, and what was tried."""

    stages: tuple[Fitted, ...]
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
    stages: list[Fitted] = []
    trials: list[Trial] = []
    now = _Model(records, solution, values)
    for _ in range(ROUNDS):
        found = _round(now, reach)
        trials += [replace(t, taken=t.earns) for _, t in found]
        if not (found and found[-1][1].earns):
            break
        stages.append(best := found[-1][0])
        now = _Model(best.records, best.solution, best.values, best.terms)
    return Selection(tuple(stages), tuple(trials))


def asks(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    reach: Mapping[str, float],
    but: Sequence[Term],
) -> bool:
    """Whether the residuals ask for any term ``but`` these, as far as straight lines show it."""
    return bool(_asked(_Model(records, solution, values, tuple(but)), reach))


@dataclass(frozen=True)
class _Model:
    """What the next term is added to. ``values`` of all parameters, those held among them."""

    records: Sequence[MotorRecord]
    solution: Solution
    values: Mapping[str, float]
    taken: tuple[Term, ...] = ()


def _round(now: _Model, reach: Mapping[str, float]) -> list[tuple[Fitted, Trial]]:
    """The candidates that were fitted; the last earns its place, if one does."""
    found: list[tuple[Fitted, Trial]] = []
    for candidate, begun, rough in _rivals(now, _asked(now, reach)):
        fitted = begun.nearly(rough)
        evidence = weigh(fitted, now.taken, now.solution, candidate.term)
        then = fitted.values
        moves = max((abs(then[n] - now.values[n]) / r for n, r in reach.items()), default=0.0)
        found.append((fitted, Trial(candidate.term, now.taken, evidence, moves)))
        if found[-1][1].earns:
            break
    return found


def _asked(now: _Model, reach: Mapping[str, float]) -> list[Candidate]:
    """What the residuals ask for and a fit is foreseen to support, the most promising first.

    Those that promise far less than the best wait for another round.
    """
    white = plain(now.records, now.solution)
    bare = (now.records, white, now.values)
    worth = [c for c in screen(*bare, now.taken) if _is_worth(c, reach)][:FORESEEN]
    asked: list[Candidate] = []
    for candidate in sorted([*worth, *springs(*bare, now.taken)], key=lambda c: -c.gain):
        if asked and (len(asked) == REFITTED or candidate.gain < RIVAL * asked[0].gain):
            break
        if not candidate.changes or foresee(now.records, white, candidate).supports:
            asked.append(candidate)
    return asked


def _rivals(now: _Model, asked: Sequence[Candidate]) -> list[tuple[Candidate, Begun, Fitted]]:
    """Each roughly fitted, the best of them first."""
    begun = [(c, _begun(now, c)) for c in asked]
    tried = [(c, b, b.roughly()) for c, b in begun]
    return sorted(tried, key=lambda one: one[2].solution.objective)


def _is_worth(candidate: Candidate, reach: Mapping[str, float]) -> bool:
    """It promises much, and to move what matters."""
    shift = candidate.shift
    moves = max((abs(shift.get(n, 0.0)) / limit for n, limit in reach.items()), default=0.0)
    return candidate.gain > GROSS or (candidate.gain > WORTH and moves > HINT)


def _begun(now: _Model, candidate: Candidate) -> Begun:
    names = {u.name for u in now.solution.unknowns}
    fixed = {n: v for n, v in now.values.items() if n not in names}
    own = [
        {u.name: float(v) for u, v in zip(r.unknowns, o, strict=True)}
        for r, o in zip(now.records, now.solution.own, strict=True)
    ]
    if candidate.own:
        own = [{**a, **b} for a, b in zip(own, candidate.own, strict=True)]
    return begin(
        now.records, now.solution, (*now.taken, candidate.term),
        fixed={n: v for n, v in fixed.items() if n not in candidate.term.free},
        start={**now.values, **candidate.start}, own=own,
    )  # fmt: skip
