"""Captures of a rotor that is held: R, L and what the iron makes of L.

Such a program says that the rotor stands, and the encoder must agree. K, B, J and T0 move no
reading then. L that falls with the current and L beside eddy currents each look like the other
while one of them lacks, so both are fitted together, and each that the data do not support is left
out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.errors import DataError, UsageError
from motorid.estimate.assembly.covering import covering
from motorid.estimate.assembly.doubt import settled
from motorid.estimate.fit import joint_fit
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.extended_terms import TERMS, Term, parse
from motorid.estimate.partial import locked_rotor
from motorid.estimate.results.estimate import (
    AUTO,
    SIX,
    UNITS,
    Alternative,
    Diagnostic,
    Estimate,
    TermTrial,
)
from motorid.estimate.selection.entry import reach
from motorid.estimate.selection.evidence import Evidence, weigh
from motorid.estimate.selection.extended_fit import Fitted
from motorid.estimate.selection.extended_results import alternative, findings
from motorid.estimate.selection.named_terms import asked_for
from motorid.estimate.signals.standstill import STIR
from motorid.estimate.uncertainty.intervals import unknown
from motorid.program import StepKind

IRON = (TERMS["eddy"], TERMS["saturation"])
SHOWN = (*IRON, TERMS["brush-drop"], TERMS["heating"])  # by a rotor that stands
GAVE = 1 / 200  # of a turn: what a clamp may give way; twice what the board allows in a moment
PWM_SHARE = 0.02  # of a PWM period: by which the model of its ripple in such an iron may be off
WHY = "the rotor was held"


def suits(captures: Sequence[Capture]) -> bool:
    """Whether these were captured with the rotor held.

    Raises DataError where some were and others not.
    """
    held = [c.program is not None and c.program.held for c in captures]
    if any(held) and not all(held):
        raise DataError(
            "some of these captures are of a rotor that was held and some of one that turned: fit "
            "them apart"
        )
    return all(held)


def fit(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str], model: str
) -> Estimate:
    """R and L and, as the ``alternative``, the model with what the iron does.

    Raises UsageError for a term that such a rotor does not show, DataError where it turned.
    """
    asked = () if model in (AUTO, SIX) else _asked(model)
    said = [remark for capture in captures if (remark := _gave_way(capture))]
    still_captures = [stilled(capture) for capture in captures]
    still = locked_rotor.still_motor(still_captures, {**dict.fromkeys(without, 0.0), **fix})
    records, solution = joint_fit.solved(still_captures, still, ())
    six = locked_rotor.estimate(still_captures, records, solution, still, fix, without, WHY)
    six = replace(six, diagnostics=(*said, *six.diagnostics))
    if model == SIX:
        return six
    values = merged(still, solution)
    fitted = asked_for(records, solution, values, asked or IRON)
    trials: tuple[TermTrial, ...] = ()
    if not asked:
        fitted, trials = _supported(fitted, _Moves(values, reach(six.parameters)))
    if not fitted.terms:
        return six
    found = findings(fitted, still, without)
    better = alternative(fitted, found, records, solution, trials, asked=bool(asked))
    return _with(six, _without_mechanics(better, fix, without))


def _asked(model: str) -> tuple[Term, ...]:
    terms = parse(model)
    for term in terms:
        if term not in SHOWN:
            known = ", ".join(one.name for one in SHOWN)
            raise UsageError(
                f"--model {term.name}: a rotor that is held does not show {term.title}; it shows "
                f"{known}"
            )
    return terms


def _gave_way(capture: Capture) -> Diagnostic | None:
    """A remark where the encoder moved a little. Raises DataError where it moved more."""
    channel = capture.get(POSITION)
    if channel is None:
        return None
    known = channel.values[np.isfinite(channel.values)]
    travel = float(np.ptp(known)) if len(known) else 0.0
    if travel <= STIR * channel.resolution:
        return None
    degrees = np.degrees(travel)
    if travel > max(2 * np.pi * GAVE, 6 * channel.resolution):
        raise DataError(
            f"{capture.path or 'a capture'}: the program says that the rotor is held, and it moved "
            f"by {degrees:.2g}°: clamp it and capture again"
        )
    return Diagnostic(
        "clamp_gave_way", "warning",
        f"the rotor moved by {degrees:.2g}° in its clamp, and the back-EMF of that is not in the "
        "model: clamp it stiffer",
    )  # fmt: skip


def stilled(capture: Capture) -> Capture:
    """Without the motion that there is not, and without the open terminals after a drive.

    There the field that the iron still holds shows, and the diodes.
    """
    channels = {n: c for n, c in capture.channels.items() if n not in (POSITION, SPEED)}
    voltage = channels.get(VOLTAGE)
    if voltage is not None:
        opened = _opened(capture)
        raw = np.where(opened, np.nan, np.asarray(voltage.raw, dtype=np.float64))
        channels[VOLTAGE] = replace(voltage, raw=raw)
    current = channels.get(CURRENT)
    if current is not None and capture.wiring.pwm_hz:
        slack = PWM_SHARE / capture.wiring.pwm_hz
        sure = float(np.hypot(current.delay_uncertainty_s, slack))
        channels[CURRENT] = replace(current, delay_uncertainty_s=sure)
    return replace(capture, channels=channels)


def _opened(capture: Capture) -> np.ndarray:
    """Samples (n,) at open terminals after the first drive."""
    assert capture.program is not None
    steps, driven = capture.program.steps, False
    out = np.zeros(len(capture), dtype=bool)
    for phase in capture.phases:
        coast = steps[phase.index].kind is StepKind.COAST
        driven = driven or not coast
        out[capture.ticks >= phase.tick] = coast and driven
    return out


@dataclass(frozen=True)
class _Moves:
    """How far a model moves R and L from these ``values``, in units of what matters."""

    values: Mapping[str, float]
    matters: Mapping[str, float]

    def of(self, fitted: Fitted) -> float:
        """The larger of both moves."""
        then, known = fitted.values, [n for n in locked_rotor.ELECTRICAL if n in self.matters]
        each = (abs(then[n] - self.values[n]) / self.matters[n] for n in known)
        return max(each, default=0.0)


def _supported(fitted: Fitted, moves: _Moves) -> tuple[Fitted, tuple[TermTrial, ...]]:
    """Without the terms that the data do not support, the worst first; what was tried."""
    trials: list[TermTrial] = []
    while fitted.terms:
        weighed = [(term, weigh(fitted, _but(fitted.terms, term), fitted.solution, term))
                   for term in fitted.terms]  # fmt: skip
        weak = [(term, e) for term, e in weighed if not e.supports]
        if not weak:
            trials += [_trial(fitted, term, e, moves, taken=True) for term, e in weighed]
            break
        term, least = min(weak, key=lambda one: one[1].counted)
        trials.append(_trial(fitted, term, least, moves, taken=False))
        fitted = _refitted(fitted, _but(fitted.terms, term))
    return fitted, tuple(trials)


def _refitted(fitted: Fitted, terms: tuple[Term, ...]) -> Fitted:
    if not terms:
        return replace(fitted, terms=())
    return asked_for(*fitted.model, terms)


def _but(terms: Sequence[Term], term: Term) -> tuple[Term, ...]:
    return tuple(t for t in terms if t is not term)


def _trial(fitted: Fitted, term: Term, e: Evidence, moves: _Moves, taken: bool) -> TermTrial:
    beside = tuple(t.name for t in _but(fitted.terms, term))
    return TermTrial(
        term.name, term.title, beside, e.counted, e.needed, e.size, e.left_out,
        moves.of(fitted), taken,
    )  # fmt: skip


def _without_mechanics(
    better: Alternative, fix: Mapping[str, float], without: Sequence[str]
) -> Alternative:
    """What a rotor that is held does not show is not in the better model either."""
    parameters = {n: p for n, p in better.parameters.items() if n != "K_rated"}
    for name in locked_rotor.MECHANICAL:
        if name not in fix and name not in without:
            parameters[name] = unknown(name, UNITS[name], f"{WHY}; let it turn")
    return replace(better, parameters=parameters)


def _with(six: Estimate, better: Alternative) -> Estimate:
    """The better model beside the plain one, whose values are doubtful where it moves them."""
    what = " and ".join(better.titles)
    if better.asked:
        said = Diagnostic("model_asked", "info", f"beside it, as asked: a model with {what}")
        found = six
    else:
        cover = covering(six, better, locked_rotor.ELECTRICAL)
        said = Diagnostic(
            "better_model", "warning",
            f"the residuals show {what}: L holds at no current and low frequency in the better "
            "model alone, so use its values",
            cover.moves, cover.sides,
        )  # fmt: skip
        found = settled(six, [said])
    suspects = tuple(one for one in found.suspects if one.code not in better.terms)
    whole = (said, *found.diagnostics)
    return replace(found, alternative=better, suspects=suspects, diagnostics=whole)
