"""A wider fit as values with intervals: the six as in every other fit, then what the terms add."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.assembly import assemble
from motorid.estimate.assembly.plot_data import UNITS as CHANNEL_UNITS
from motorid.estimate.diagnosis import residual_remarks
from motorid.estimate.fit.parameter_bounds import held_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import ADDED, Term
from motorid.estimate.results.estimate import Alternative, ChannelFit, Parameter, TermTrial
from motorid.estimate.results.status import Status
from motorid.estimate.selection import measurands, revision
from motorid.estimate.selection.evidence import deviation_at, shapes_of
from motorid.estimate.selection.extended_fit import Fitted, finished
from motorid.estimate.selection.trigger import ALLOWED
from motorid.estimate.selection.unsettled_models import Unsettled
from motorid.estimate.solver.allowance import current
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import budget, errors_in_variables, intervals
from motorid.estimate.uncertainty.findings import scattered
from motorid.estimate.uncertainty.intervals import Findings
from motorid.estimate.uncertainty.undetected import beside, undetected

Floats = NDArray[np.float64]

UNTOLD = "these data do not determine it"
SHARE, HEATED = "J2_share", "per_C_w"  # searched, and shown as what is known by other names
CAPACITY = "C_w"
ROOM = 36  # times the responses of a set of derivatives: for another fit and its end
EXPECTED = 3.0  # total uncertainties, of a size of what every brushed motor has
SEARCHED = 4.0  # the same of what a motor may have: a dozen terms are tried beside faults unstated


def findings(fitted: Fitted, fix: Mapping[str, float], without: Sequence[str]) -> Findings:
    """Covariance and budget of a wider fit: what its input hides is in both, as for the six."""
    unseen = errors_in_variables.hidden(fitted.solution, fitted.records)
    lines = undetected(fitted.solution, fitted.records, unseen)
    carried = budget.carried(fitted.solution, fitted.records)
    return Findings(
        fitted.solution,
        scattered(fitted.solution, fitted.records, unseen),
        {**budget.lines_of(carried.shared, fitted.solution, fitted.records), **beside(lines)},
        held_values(fix, without),
        without,
        undetected=lines,
        hidden=unseen,
        carried=carried,
    )


def stands_out(found: Findings, term: Term) -> bool:
    """A term's size is several of its total uncertainties, by its distance from 0 or as a factor,
    at the shape that was found.

    Brushes and winding, which the six parameters allow for, need fewer than others: an error of the
    model or of the measuring chain that nobody stated is one of those as easily.
    """
    needed = EXPECTED if term in ALLOWED else SEARCHED
    k = found.names.index(term.size)
    known = sum(np.outer(d, d) for d in found.causes.values())
    total = found.statistical.covariance + known
    size = 1.0 if found.solution.unknowns[k].log else abs(float(found.solution.values[k]))
    return size > needed * deviation_at(total, k, shapes_of(found.names, term))


def without_faint(
    fitted: Fitted,
    found: Findings,
    fix: Mapping[str, float],
    without: Sequence[str],
    unsettled: Sequence[Unsettled],
) -> tuple[tuple[Fitted, Findings], Sequence[Unsettled]]:
    """The model without its older terms that do not stand out, if all others do: those may be there
    and are not offered. As it is, where no room is left.
    """
    faint = [term for term in fitted.terms[:-1] if not stands_out(found, term)]
    if faint and current().has(ROOM * fitted.width):
        less = finished(revision.without(fitted, faint))
        others = findings(less, fix, without)
        if less.settled >= fitted.settled and all(stands_out(others, term) for term in less.terms):
            half = [Unsettled(term, fitted.values) for term in faint]
            return (less, others), [*unsettled, *half]
    return (fitted, found), unsettled


def parameters(found: Findings, fitted: Fitted) -> dict[str, Parameter]:
    """R, L, K, B, J, T0, then those of the terms; two masses as J1 and J2, heat as C_w; K and L at
    other currents and frequencies where iron makes them differ."""
    out = intervals.parameters(found)
    for term in fitted.terms:
        if term.per_turn:
            out[term.per_turn] = _counted(term.per_turn, fitted.values[term.per_turn])
        for name in term.free:
            if name == SHARE:
                out |= _masses(found)
            elif name == HEATED:
                out[CAPACITY] = _capacity(found)
            elif name in found.names:
                out[name] = _added(found, name)
        size = CAPACITY if term.size == HEATED else term.size
        if size in out and out[size].value in (None, 0.0):
            for name in set(term.free) - {term.size}:
                note = f"it means nothing without {size}"
                out[name] = intervals.unknown(name, ADDED[name].unit, note)
    return out | measurands.stated(found, fitted)


def _counted(name: str, value: float) -> Parameter:
    note = "a whole number, by the angle at which the residuals repeat"
    added = ADDED[name]
    return Parameter(name, added.unit, value, 0.0, 0.0, 0.0, (value, value), Status.FIXED, note)


def _added(found: Findings, name: str) -> Parameter:
    k, added = found.names.index(name), ADDED[name]
    value, slope = float(found.solution.values[k]), float(found.solution.slopes[k])
    deviation, known, freedom = found.propagate(np.eye(len(found.names))[k])
    return _stated(
        name, added.unit, value, (deviation * slope, known * slope), freedom,
        log=added.log, bound=bool(found.solution.at_bound[k]), lower=added.lower,
    )  # fmt: skip


def _stated(
    name: str,
    unit: str,
    value: float,
    parts: tuple[float, float],
    freedom: float,
    *,
    log: bool,
    bound: bool,
    lower: float,
) -> Parameter:
    total = float(np.hypot(*parts))
    factor = intervals.student(freedom)
    limit = intervals.UNKNOWN if log else intervals.UNKNOWN_FRICTION
    if bound and not log and value == lower == 0.0:
        return Parameter(
            name, unit, 0.0, *parts, total, (0.0, factor * total), Status.AT_BOUND,
            "the best fit would be negative; set to 0",
        )  # fmt: skip
    if bound or not total <= limit * abs(value):
        reach = f": below {abs(value) + factor * total:.2g} {unit}" if not (bound or log) else ""
        return intervals.unknown(name, unit, UNTOLD + reach)
    if log:
        reach_factor = float(np.exp(factor * total / value))
        interval = (value / reach_factor, value * reach_factor)
    else:
        interval = (max(value - factor * total, lower), value + factor * total)
    return Parameter(name, unit, value, *parts, total, interval, Status.ESTIMATED)


def _capacity(found: Findings) -> Parameter:
    """C_w, one over what was searched; none where no warming shows."""
    k = found.names.index(HEATED)
    rise = float(found.solution.values[k])
    if not rise > 0.0:
        return intervals.unknown(CAPACITY, "J/K", UNTOLD)
    deviation, known, freedom = found.propagate(np.eye(len(found.names))[k])
    parts = deviation / rise**2, known / rise**2
    bound = bool(found.solution.at_bound[k])
    return _stated(CAPACITY, "J/K", 1.0 / rise, parts, freedom, log=True, bound=bound, lower=0.0)


def _masses(found: Findings) -> dict[str, Parameter]:
    """J1 = J (1 - share) and J2 = J share, whose errors go against each other."""
    out = {}
    p = len(found.names)
    share, inertia = found.names.index(SHARE), found.names.index("J")
    part, whole = float(found.solution.values[share]), float(found.solution.values[inertia])
    bound = bool(found.solution.at_bound[share])
    for name, value, sign in (("J1", whole * (1 - part), -1.0), ("J2", whole * part, 1.0)):
        gradient = np.zeros(p)
        gradient[inertia], gradient[share] = value, sign * whole
        deviation, known, freedom = found.propagate(gradient)
        out[name] = _stated(
            name, "kg·m²", value, (deviation, known), freedom, log=True, bound=bound, lower=0.0
        )
    return out


def alternative(
    fitted: Fitted,
    found: Findings,
    records: Sequence[MotorRecord],
    before: Solution,
    trials: Sequence[TermTrial],
    asked: bool,
) -> Alternative:
    """The wider answer beside that of ``records``, whose solution is ``before``."""
    names = tuple(term.name for term in fitted.terms)
    chi_square, freedom = residual_remarks.chi_square(fitted.solution, fitted.records)
    return Alternative(
        name="+".join(("six", *names)),
        terms=names,
        titles=tuple(term.title for term in fitted.terms),
        equations=tuple(term.equation for term in fitted.terms),
        asked=asked,
        parameters=parameters(found, fitted),
        nuisance=assemble.nuisance_parameters(found, fitted.records),
        chi_square=chi_square,
        degrees_of_freedom=freedom,
        evaluations=max(record.simulated for record in fitted.records),
        lack_of_fit=_lack_of_fit(fitted, records, before),
        trials=tuple(trials),
    )


def _lack_of_fit(
    fitted: Fitted, records: Sequence[MotorRecord], before: Solution
) -> tuple[ChannelFit, ...]:
    out = []
    for k, (narrow, wide) in enumerate(zip(records, fitted.records, strict=True)):
        old = narrow.departures(before.values, before.own[k])
        new = wide.departures(fitted.solution.values, fitted.solution.own[k])
        for m, a, b in zip(narrow.measured, old, new, strict=True):
            name = m.block.name
            out.append(ChannelFit(k, name, CHANNEL_UNITS[name], _rms(a), _rms(b)))
    return tuple(out)


def _rms(residual: Floats) -> float:
    return float(np.sqrt(square(residual) / max(len(residual), 1)))
