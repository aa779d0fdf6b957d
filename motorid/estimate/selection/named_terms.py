"""The fit with terms that a person names: the screen finds where each begins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motorid.errors import DataError
from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.fit import alternating_fit
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import TERMS, Term
from motorid.estimate.selection.extended_fit import Fitted, begin, finished, sizes_by_name
from motorid.estimate.selection.joint_start import starts
from motorid.estimate.selection.shaft_resonance import springs
from motorid.estimate.solver.problem import Solution

COARSE = 100.0  # change of F that is near enough before what repeats with the rotor is in


def asked_for(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    terms: Sequence[Term],
) -> Fitted:
    """The fit with terms that a person names; the screen finds where each begins.

    What repeats with the rotor shows once the others are in: they are fitted roughly before it.
    """
    names = {u.name for u in solution.unknowns}
    fixed = {n: v for n, v in values.items() if n not in names}
    now = (records, solution, values)
    taken: tuple[Term, ...] = ()
    for stage in _stages(terms):
        start, own = _starts(*now, taken, stage)
        taken = (*taken, *stage)
        begun = begin(now[0], now[1], taken, fixed=fixed, start=start, own=own)
        rough = begun.roughly(alternating_fit.ROUGH if len(taken) == len(terms) else COARSE)
        now = rough.records, rough.solution, rough.values
    return finished(begun.nearly(rough, lent=False))


def _stages(terms: Sequence[Term]) -> list[tuple[Term, ...]]:
    """All that does not repeat with the rotor, then one by one what does: ripple shows more."""
    still = tuple(t for t in terms if not t.per_turn)
    turning = sorted((t for t in terms if t.per_turn), key=lambda t: t.name, reverse=True)
    return [stage for stage in (still, *((t,) for t in turning)) if stage]


def _starts(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    taken: Sequence[Term],
    terms: Sequence[Term],
) -> tuple[dict[str, float], list[dict[str, float]]]:
    """Where the parameters and every record's nuisances begin, with ``terms`` beside ``taken``."""
    white = plain(records, solution)
    found = starts(records, white, values, [t for t in terms if t not in taken])
    if TERMS["two-masses"] in terms:
        found |= {
            c.term: (dict(c.start), ()) for c in springs(records, white, values, taken, asked=True)
        }
    start: dict[str, float] = dict(values)
    own = sizes_by_name(records, solution)
    for term in terms:
        if term in found:
            shared, each = found[term]
            start |= shared
            for mine, more in zip(own, each or own, strict=True):
                mine.update(more)
        elif term.per_turn or term.name in ("ke-kt", "direction"):
            raise DataError(f"these captures cannot tell {term.name} ({term.title}){_why(term)}")
    return start, own


def _why(term: Term) -> str:
    if term.per_turn:
        return ": their residuals do not repeat with the rotor's angle"
    if term.name == "direction":
        return ": the motor turns one way; add a run the other way"
    return ": torque, inertia and friction scale together; hold one, as by --fix J=..."
