"""Effects that the residuals of the last model show and that no model offered explains.

The search offers a term where it earns its place. What it leaves out may still be seen, by its size
along straight lines: the values that it would move are doubtful then.
"""

from __future__ import annotations

from dataclasses import replace

from motorid.estimate.assembly.doubt import settled
from motorid.estimate.results.estimate import Diagnostic, Estimate
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.intervals import Findings
from motorid.estimate.uncertainty.undetected import Undetected

WORTH = 0.5  # of half an interval: a move that matters


def with_seen(estimate: Estimate, known: Findings) -> Estimate:
    """The estimate, with what the captures still show under its widest model, of ``known``."""
    found = [_said(estimate, one, known.solution) for one in known.undetected if one.seen]
    findings = [one for one in found if one.moves]
    whole = settled(estimate, findings)
    return replace(whole, diagnostics=(*findings, *whole.diagnostics))


def _said(estimate: Estimate, one: Undetected, solution: Solution) -> Diagnostic:
    moves: dict[str, float] = {}
    sides: dict[str, tuple[float, float]] = {}
    for name, share in one.moves(solution, one.seen).items():
        p = estimate.parameters.get(name)
        if p is None or p.value is None or p.interval_95 is None:
            continue
        move = share * p.value
        if abs(move) > WORTH * (p.interval_95[1] - p.interval_95[0]) / 2.0:
            moves[name] = abs(move)
            sides[name] = (max(-move, 0.0), max(move, 0.0))
    name = one.quantity.name
    return Diagnostic(
        "effect_seen", "warning",
        f"the residuals show {name} ({one.seen:.1f} standard deviations), but no model with it was "
        f"accepted: it can move {', '.join(moves)}; {one.quantity.remedy}",
        moves, sides,
    )  # fmt: skip
