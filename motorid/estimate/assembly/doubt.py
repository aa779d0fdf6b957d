"""Parameters that a finding could have moved are doubtful: their intervals cover what it could do.

A finding states its ``moves``: by how much it could have moved each parameter. Where one of them is
more than half of the parameter's half-width H, the parameter is doubtful. Its interval grows by M
on either side, where M is the root of the sum of the squares of all findings' moves: one fault is
named once, and several are independent. A move whose way is known counts on that side alone. The
total uncertainty grows in proportion to the interval, so that both keep their factor. The part that
it grows by is the finding's line of the budget.

K and L at other currents and frequencies move as K and L do, by the same share.

A move without a size (infinite) is bounded by what the residuals allow, or by the value itself
where nothing bounds it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from motorid.estimate.results.estimate import (
    ELSEWHERE,
    PARAMETERS,
    Diagnostic,
    Estimate,
    Parameter,
    Suspect,
)
from motorid.estimate.results.status import DOUBT, Status
from motorid.estimate.uncertainty.budget import FINDING
from motorid.estimate.uncertainty.intervals import NORMAL_95, RATIOS
from motorid.motor.parameters import FIGURES, Motor

Finding = Suspect | Diagnostic
Moves = Mapping[str, float]
Sides = Mapping[str, tuple[float, float]]

SHARE = 0.5  # of the half-width of an interval, beyond which a move makes a value doubtful
NONE: Mapping[str, float] = {}


@dataclass(frozen=True)
class _Move:
    """How far a finding, with its ``line`` of the budget, may have moved a value to either side."""

    line: str
    below: float
    above: float

    @property
    def most(self) -> float:
        """The larger of both."""
        return max(self.below, self.above)


@dataclass(frozen=True)
class _Widened:
    """A parameter with what findings add to it, and their lines of its budget."""

    parameter: Parameter
    lines: Mapping[str, float]


def settled(estimate: Estimate, findings: Iterable[Finding], allowed: Moves = NONE) -> Estimate:
    """The estimate with the standing that ``findings`` leave its values.

    Parameters, combinations and derived figures follow; ``findings`` are not added to it.
    ``allowed`` (SI) bounds moves without a size. Findings that were settled before must not come
    again: they would widen twice.
    """
    moving = [
        (line_of(one), *_elsewhere(_sized(one.moves, estimate, allowed), _sides(one), estimate))
        for one in findings
        if one.moves
    ]
    if not moving:
        return estimate
    budget = {name: dict(lines) for name, lines in estimate.budget.items()}

    def widened(table: Mapping[str, Parameter], kind: str) -> dict[str, Parameter]:
        out = {}
        for name, p in table.items():
            lines = budget.get(name, {})
            moved = [
                _Move(line, *sides.get(name, 2 * (_of(kind, name, sizes, estimate),)))
                for line, sizes, sides in moving
            ]
            found = _widened(p, moved, lines)
            out[name] = found.parameter
            if found.lines and name in budget:
                budget[name] = _summed(budget[name], found.lines)
        return out

    return replace(
        estimate,
        parameters=widened(estimate.parameters, "parameter"),
        combinations=widened(estimate.combinations, "combination"),
        derived=widened(estimate.derived, "derived"),
        budget=budget,
    )


def line_of(finding: Finding) -> str:
    """The name of a finding's line in the budgets."""
    return FINDING + finding.code.replace("_", " ")


def doubtful(estimate: Estimate) -> tuple[Parameter, ...]:
    """Parameters that are doubtful or not supported, in their order."""
    poor = (Status.DOUBTFUL, Status.NOT_SUPPORTED)
    tables = (estimate.parameters, estimate.combinations)
    return tuple(p for table in tables for p in table.values() if p.status in poor)


def _sides(finding: Finding) -> Sides:
    return finding.sides if isinstance(finding, Diagnostic) else {}


def _sized(moves: Moves, estimate: Estimate, allowed: Moves) -> dict[str, float]:
    """Moves with a size: one without has what is allowed, at most the value itself."""
    out = {}
    for name, move in moves.items():
        size = abs(move)
        if not math.isfinite(size):
            p = estimate.parameters.get(name) or estimate.combinations.get(name)
            value = abs(p.value) if p is not None and p.value is not None else 0.0
            size = min(allowed.get(name, value), value)
        out[name] = size
    return out


def _elsewhere(moves: Moves, sides: Sides, estimate: Estimate) -> tuple[Moves, Sides]:
    """With those of what moves by the share that a parameter moves by."""
    table = estimate.parameters
    for name in table.keys() & ELSEWHERE.keys() - moves.keys():
        at_none, other = table[ELSEWHERE[name]], table[name]
        if not at_none.value or other.value is None:
            continue
        share = abs(other.value / at_none.value)
        if at_none.name in moves:
            moves = {**moves, name: share * moves[at_none.name]}
        if at_none.name in sides:
            below, above = sides[at_none.name]
            sides = {**sides, name: (share * below, share * above)}
    return moves, sides


def _of(kind: str, name: str, moves: Moves, estimate: Estimate) -> float:
    """By how much the moves of parameters move a quantity (its unit)."""
    if name in moves:
        return moves[name]
    if kind == "combination" and name in RATIOS:
        powers = RATIOS[name][1]
        shares = (
            abs(power) * moves.get(n, 0.0) / abs(estimate.parameters[n].value or math.inf)
            for n, power in powers.items()
        )
        return abs(estimate.combinations[name].value or 0.0) * sum(shares)
    if kind == "derived" and name in FIGURES and estimate.nominal_v is not None:
        return _of_figure(name, moves, estimate.parameters, estimate.nominal_v)
    return 0.0


def _of_figure(
    name: str, moves: Moves, parameters: Mapping[str, Parameter], voltage_v: float
) -> float:
    values = {n: parameters[n].value for n in PARAMETERS}
    known = {n: math.nan if v is None else v for n, v in values.items()}
    of = FIGURES[name].of
    before = of(Motor.of(known), voltage_v)
    total = 0.0
    for n, move in moves.items():
        if n in known and move > 0.0 and math.isfinite(known[n]):
            total += abs(of(Motor.of({**known, n: known[n] + move}), voltage_v) - before)
    return total if math.isfinite(total) else 0.0


def _widened(p: Parameter, moved: Sequence[_Move], budget: Mapping[str, float]) -> _Widened:
    able = p.status.measured or p.status is Status.AT_BOUND
    if not able or p.value is None or p.interval_95 is None or p.total is None:
        return _Widened(p, {})
    low, high = p.interval_95
    half = (high - low) / 2.0
    if max(move.most for move in moved) <= SHARE * half:
        return _Widened(p, {})
    already = grown(p, budget)  # by others that were settled before
    below = math.hypot(already, *(move.below for move in moved)) - already
    above = math.hypot(already, *(move.above for move in moved)) - already
    factor = half / p.total if p.total > 0.0 and half > 0.0 else NORMAL_95
    total = (half + (below + above) / 2.0) / factor
    added = math.sqrt(max(total**2 - p.total**2, 0.0))
    least = 0.0 if low >= 0.0 else -math.inf
    return _Widened(
        replace(
            p,
            instrument=math.hypot(p.instrument or 0.0, added),
            total=total,
            interval_95=(max(low - below, least), high + above),
            status=Status.DOUBTFUL,
            note=_note(p, moved),
        ),
        _lines(moved, added),
    )


def _lines(moved: Sequence[_Move], added: float) -> dict[str, float]:
    """What findings add to a standard uncertainty, each by its part."""
    whole = math.hypot(*(move.most for move in moved))
    lines: dict[str, float] = {}
    for move in moved:
        if move.most > 0.0:
            lines[move.line] = math.hypot(lines.get(move.line, 0.0), added * move.most / whole)
    return lines


def grown(p: Parameter, budget: Mapping[str, float]) -> float:
    """By how much findings that were settled before have widened half of its interval."""
    if p.interval_95 is None or not p.total:
        return 0.0
    before = sum(u**2 for line, u in budget.items() if line.startswith(FINDING))
    half = (p.interval_95[1] - p.interval_95[0]) / 2.0
    return half * (1.0 - math.sqrt(max(1.0 - before / p.total**2, 0.0)))


def _note(p: Parameter, moved: Sequence[_Move]) -> str:
    """Which finding, and how far it could have moved the value."""
    more = math.hypot(*(move.most for move in moved))
    names = dict.fromkeys(
        move.line.removeprefix(FINDING) for move in sorted(moved, key=lambda m: -m.most)
        if move.most > SHARE * more
    )  # fmt: skip
    share = f"{more / abs(p.value):.2g} of its value" if p.value else f"{more:.2g} {p.unit}"
    if p.value and more < abs(p.value):
        share = f"{100.0 * more / abs(p.value):.2g} %"
    said = f"{DOUBT}{' and '.join(names)} could change it by {share}"
    return f"{p.note}; {said}" if p.note else said


def _summed(lines: Mapping[str, float], more: Mapping[str, float]) -> dict[str, float]:
    out = dict(lines)
    for line, u in more.items():
        out[line] = math.hypot(out.get(line, 0.0), u)
    return out
