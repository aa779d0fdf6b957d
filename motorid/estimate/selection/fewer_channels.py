"""Captures without a motion, or without a current: what the better models say of the values.

The search is the one of captures with all channels, on the scale that such a fit holds: without a
motion for friction and for what the winding and the brushes do, without a current for friction. Of
angles nobody knows the scale, and an inductance takes on the shape of what lies between the
readings. The values stay. Where a model that the data support moves one, or no longer tells it, it
is doubtful, and one finding says what it is beside the term.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from motorid.capture.model import Capture
from motorid.estimate.assembly.assemble import UNCHANGED
from motorid.estimate.assembly.covering import covering_sides
from motorid.estimate.assembly.doubt import settled
from motorid.estimate.diagnosis.faults.readings import log_spikes
from motorid.estimate.diagnosis.refit import plain as plain_noise
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.partial import electrical_only
from motorid.estimate.partial.modulating_functions import COASTING_PWM
from motorid.estimate.partial.without_current import fit as no_current
from motorid.estimate.partial.without_current.combinations import shares
from motorid.estimate.partial.without_current.likelihood import Whole
from motorid.estimate.results.estimate import Diagnostic, Estimate, Parameter
from motorid.estimate.selection.entry import (
    MOST,
    STATED,
    known_beside,
    looked_for,
    reach,
    standing_out,
)
from motorid.estimate.selection.extended_results import parameters
from motorid.estimate.selection.predicted_gain import foresee
from motorid.estimate.selection.score_test import screen
from motorid.estimate.selection.seen_effects import with_seen
from motorid.estimate.selection.unsettled_models import Unsettled, with_unsettled
from motorid.estimate.solver.allowance import current, opened
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.intervals import Findings

HEATING = TERMS["heating"]
SQUARE_TITLE = TERMS["quadratic-load"].title
HALF = 0.5  # of what a fit would need
WITHOUT_MOTION = ("quadratic-load", "direction", "brush-drop", "heating")
WITHOUT_CURRENT = ("quadratic-load", "direction", "stribeck")
Parameters = Mapping[str, Parameter]
Said = Callable[[Parameters, Parameters, str], list[Diagnostic]]


def without_motion(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str]
) -> Estimate:
    """``electrical_only.fit``, doubtful where a better model says otherwise. Raises as that."""
    with opened():
        return electrical_only.fit(captures, fix, without, better_models)


def without_current(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str]
) -> Estimate:
    """``without_current.fit``, doubtful where a better model says otherwise. Raises as that."""
    cleared, spiked = log_spikes.removed(captures)
    with opened():
        found = no_current.fit(cleared, fix, without, _on_scale)
    return replace(found, suspects=(*spiked, *found.suspects)) if spiked else found


def better_models(
    estimate: Estimate,
    records: Sequence[MotorRecord],
    doubts: Findings,
    held: Mapping[str, float],
    without: Sequence[str],
    names: Mapping[str, str],
) -> list[Diagnostic]:
    """Findings on the parameters of ``estimate``; ``names`` of what stands in the place of some."""

    def said(values: Parameters, others: Parameters, titles: str) -> list[Diagnostic]:
        return _said(values, others, titles, names)

    return _looked_for(estimate, records, doubts, held, without, WITHOUT_MOTION, said)


def _on_scale(found: Whole) -> Estimate:
    """What is found without a current, with the standing that better models leave it."""
    said = _looked_for(
        found.estimate, found.records, found.found, found.held, (), WITHOUT_CURRENT, _said_on_scale
    )
    covering = settled(found.estimate, said)
    return replace(covering, diagnostics=(*said, *covering.diagnostics))


def _looked_for(
    estimate: Estimate,
    records: Sequence[MotorRecord],
    doubts: Findings,
    held: Mapping[str, float],
    without: Sequence[str],
    shown: Sequence[str],
    said: Said,
) -> list[Diagnostic]:
    """Findings by the terms that are ``shown``; ``said`` of values, and of others with a title."""
    current().bound(MOST, STATED)
    plain = replace(estimate, diagnostics=())
    others = tuple(term for term in TERMS.values() if term.name not in shown)
    chosen, _ = looked_for(records, doubts.solution, held, reach(plain.parameters), others)
    best, open_models = standing_out(chosen, held, without)
    warming = () if best or HEATING.name not in shown else _warming(records, doubts.solution, held)
    found = doubts
    if best is not None:
        fitted, found = best
        titles = " and ".join(term.title for term in fitted.terms)
        told = said(plain.parameters, parameters(found, fitted), titles)
        plain = replace(plain, diagnostics=tuple(told))
    plain = with_unsettled(plain, [*open_models, *warming], nameable=False)
    plain = with_seen(plain, known_beside(found, chosen.harmless, held, without))
    return list(plain.diagnostics)


def _warming(
    records: Sequence[MotorRecord], solution: Solution, held: Mapping[str, float]
) -> list[Unsettled]:
    """A winding that warms up, where the readings half speak for it: no motion tells it from K."""
    values, white = merged(held, solution), plain_noise(records, solution)
    out = []
    for one in screen(records, white, values, (), [HEATING.name]):
        found = foresee(records, white, one)
        if found.counted > HALF * found.needed:
            moved = {name: value + one.shift.get(name, 0.0) for name, value in values.items()}
            out.append(Unsettled(HEATING, moved))
    return out


def _said(
    values: Mapping[str, Parameter],
    others: Mapping[str, Parameter],
    titles: str,
    names: Mapping[str, str],
) -> list[Diagnostic]:
    """Of parameters that are searched, as ``names`` has them."""
    moves: dict[str, float] = {}
    sides: dict[str, tuple[float, float]] = {}
    told = []
    for name, p in values.items():
        other, found = others[name], covering_sides(p, others[name])
        shown = names.get(name, name)
        if found is not None:
            sides[name], moves[name] = found, max(found)
            told.append(f"{shown} {other.value:.4g} ± {other.total:.2g}")
        elif other.value is None and p.value and p.status.measured:
            moves[name] = math.inf
            told.append(f"no {shown}")
    if not moves:
        return []
    return [
        Diagnostic(
            "better_model", "warning",
            f"the residuals show {titles}: the values do without it and are biased. With it: "
            f"{', '.join(told)}",
            moves, sides,
        )
    ]  # fmt: skip


def _said_on_scale(
    values: Mapping[str, Parameter], others: Mapping[str, Parameter], titles: str
) -> list[Diagnostic]:
    """Of a fit without a current: in its combinations."""
    titles += COASTING_PWM if SQUARE_TITLE in titles else ""
    return [
        replace(one, message=f"{one.message.split(' With it: ')[0]} With it: {shares(others)}")
        for one in _said(values, others, titles, UNCHANGED)
    ]
