"""The six-parameter answer with a better model beside it: where the data ask for one, or a person.

The six values stay. Where a model that the data support moves one of them, its interval covers that
model's too, and it is doubtful.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from motorid.capture.model import Capture
from motorid.errors import DataError
from motorid.estimate.assembly import untold
from motorid.estimate.assembly.assemble import answered
from motorid.estimate.assembly.covering import covering, excluded
from motorid.estimate.assembly.doubt import settled
from motorid.estimate.assembly.lack_of_fit import with_lack
from motorid.estimate.diagnosis import misfit, rank
from motorid.estimate.diagnosis.facts import cooling_winding
from motorid.estimate.diagnosis.faults.readings import log_spikes, spikes
from motorid.estimate.effects.brush_and_heating import lossless, undropped
from motorid.estimate.fit import joint_fit, multistart, sign_check
from motorid.estimate.fit.alternating_fit import vanished, with_inductance
from motorid.estimate.fit.logs.log_unknowns import Fit
from motorid.estimate.fit.parameter_bounds import held_values, merged, searched
from motorid.estimate.fit.repeating import is_heavy, repeat_as
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.extended_terms import TERMS, Term, parse
from motorid.estimate.results.estimate import (
    AUTO,
    PARAMETERS,
    SIX,
    Diagnostic,
    Estimate,
    Parameter,
    TermTrial,
)
from motorid.estimate.results.status import Status
from motorid.estimate.selection.extended_fit import Fitted, finished
from motorid.estimate.selection.extended_results import (
    alternative,
    findings,
    stands_out,
    without_faint,
)
from motorid.estimate.selection.forward_selection import Selection, Trial, select
from motorid.estimate.selection.logs import motor_or_chain
from motorid.estimate.selection.named_terms import asked_for
from motorid.estimate.selection.seen_effects import with_seen
from motorid.estimate.selection.trigger import ALLOWED, carry_loss, drop_gives, loss_stands_out
from motorid.estimate.selection.unsettled_models import (
    Unsettled,
    with_left_out,
    with_unsettled,
)
from motorid.estimate.signals.log_sections import pieces, unbroken
from motorid.estimate.solver.allowance import current, opened
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.intervals import Findings

Narrow = tuple[Sequence[MotorRecord], Solution, Mapping[str, float]]

COUNTS = 0.02  # of a value: a move that matters, where the interval is wider
VAGUE = 0.1  # the same, of an inductance that readings hardly tell
OWN = ("R",)  # of such a model: without the drop of the brushes, or before the winding warms up
LITTLE, FEW = 20.0, 0.02  # of chi-square; of the samples
HALF = 0.5  # of that, from which a term is worth offering
MOST = 5.0  # times the responses of the six-parameter fit that all of it takes
STATED = 0.25  # times them, of which: to state what is uncertain of the last model
ENDED = 12  # times a set of derivatives: with less no other fit is carried to its end


def fit(
    captures: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str] = (),
    model: str = AUTO,
) -> Estimate:
    """``motor_fit.fit`` and, as its ``alternative``, the better model or the one of that name.

    ``model``: auto, six, or terms joined by +. Raises UsageError for an unknown one, DataError
    where a term that was asked for cannot be told from these captures.
    """
    captures, spiked = spikes.removed(captures)
    captures, beyond = log_spikes.removed(captures)
    spiked = (*spiked, *beyond)
    try:
        estimate = _of(captures, fix, without, model)
    except sign_check.WrongSignError as error:
        estimate = _of(sign_check.put_right(captures, error), fix, without, model)
        estimate = replace(estimate, suspects=(sign_check.allowed(error), *estimate.suspects))
    return replace(estimate, suspects=spikes.behind(estimate.suspects, spiked))


def _of(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str], model: str
) -> Estimate:
    """What the last model of all leaves unexplained moves the parameters still."""
    with opened():
        return with_lack(*_answer(captures, fix, without, model))


def _answer(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str], model: str
) -> tuple[Estimate, Sequence[MotorRecord], Solution]:
    """The estimate, and the fit of the last model in it."""
    terms = () if model in (AUTO, SIX) else parse(model)
    captures, records, solution = _closed(captures, fix, without, model != SIX)
    estimate, records, known = answered(captures, records, solution, fix, without)
    solution = known.solution
    K = estimate.parameters["K"].status
    if K is Status.NOT_SUPPORTED:  # no model of a motor explains these captures
        return estimate, records, solution
    if model == SIX or (K.unknown and not terms):  # a wider model would know K even less
        return estimate, records, solution
    if not terms and any(r.outlying for r in records):  # any term explains what lies far off
        return estimate, records, solution
    held = held_values(fix, without)
    if terms:
        narrow = _narrow(records, solution, merged(held, solution), held, terms)
        fitted = asked_for(*narrow, terms)
        found = findings(fitted, fix, without)
        trials: tuple[TermTrial, ...] = ()
        unsettled: Sequence[Unsettled] = ()
    else:
        current().bound(MOST, STATED)
        chosen, narrow = looked_for(records, solution, held, reach(estimate.parameters))
        trials = tuple(_stated(trial) for trial in chosen.trials)
        best, unsettled = standing_out(chosen, fix, without)
        estimate = _with_left_out(estimate, chosen, best[0] if best else None)
        if best is None:
            estimate = with_unsettled(_with_trials(estimate, trials), unsettled)
            widest = known_beside(known, chosen.harmless, fix, without)
            return with_seen(estimate, widest), records, solution
        fitted, found = best
        offered = {term.name for term in fitted.terms}
        trials = tuple(replace(t, taken=t.taken and t.term in offered) for t in trials)
    better = alternative(fitted, found, *narrow[:2], trials, asked=bool(terms))
    estimate = with_unsettled(_said(replace(estimate, alternative=better), fitted), unsettled)
    widest = found if terms else known_beside(found, chosen.harmless, fix, without)
    return with_seen(estimate, widest), fitted.records, fitted.solution


def _closed(
    captures: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str],
    wider: bool = False,
) -> tuple[Sequence[Capture], Sequence[MotorRecord], Solution]:
    """Captures and their fit: logs as they are, or without the stretches in which their bridge was
    open, where a motor that was connected throughout does not fit.

    A late current, or one through zero, looks like that too: whichever fit leaves less to explain
    is the answer. ``wider``: an effect of the motor that looks like it is asked first.
    """
    whole, cut = unbroken(captures), pieces(captures)
    if [len(one) for one in whole] == [len(one) for one in cut]:
        return cut, *_solved(cut, fix, without, wider)[0]
    try:
        (records, solution), of_motor = _solved(whole, fix, without, wider)
    except DataError:  # neither a sign nor a start that suits: what is left may have one
        return cut, *_solved(cut, fix, without, wider)[0]
    left = misfit.of_fit(records, solution)
    if of_motor or left < _least_left(whole, cut, records):
        return whole, records, solution
    (others, other), _ = _solved(cut, fix, without, wider)
    if left < misfit.of_fit(others, other):
        return whole, records, solution
    return cut, others, other


def _solved(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str], wider: bool
) -> tuple[Fit, bool]:
    """Their fit, and whether an effect of the motor took the place of lags and low-passes."""
    found = joint_fit.solved(captures, fix, without)
    held = held_values(fix, without)
    other = motor_or_chain.likelier(captures, found, held) if wider else found
    return other, other is not found


def _least_left(
    whole: Sequence[Capture], cut: Sequence[Capture], records: Sequence[MotorRecord]
) -> float:
    """What an open bridge leaves to explain, for each reading: no search settles to its last digit.
    To leave out a few samples costs nothing, and they may matter all the same.
    """
    samples = sum(map(len, whole))
    if samples - sum(map(len, cut)) > FEW * samples:
        return rank.LIKELY
    readings = sum(m.block.count for record in records for m in record.measured)
    return min(rank.LIKELY, LITTLE / readings)


def looked_for(
    records: Sequence[MotorRecord],
    solution: Solution,
    held: Mapping[str, float],
    matters: Mapping[str, float],
    but: Sequence[Term] = (),
) -> tuple[Selection, Narrow]:
    """The better model, if there is one, and the fit that it is held against; ``but`` some terms.

    Every capture has unknowns of brushes and winding: other terms are looked for beside those. If
    none is found and they take what stands out, the terms that describe them are looked for. If
    brushes seem to give voltage, they stand in for another effect, which shows without them alone.
    """
    narrow: Narrow = (records, solution, merged(held, solution))
    loss, anew = carry_loss(records), is_heavy(records, solution)
    if anew:
        narrow = _bare(records, narrow[2], held, None, anew)
    found = select(*narrow, matters, (*but, *(ALLOWED if loss else ())))
    if found.stages or not loss:
        return found, narrow
    if drop_gives(records, solution):
        less, then = undropped, [*but, *ALLOWED]
    elif loss_stands_out(records, solution, matters):
        others = [term for term in TERMS.values() if term not in ALLOWED]
        less, then = lossless, [*but, *others]
    else:
        return found, narrow
    allowance = current()
    allowance.ended = False
    bare = _bare(records, narrow[2], held, less, anew) if allowance.has(0.0) else None
    if bare is None or allowance.ended:
        more = tuple(term for term in TERMS.values() if term not in then)
        return replace(found, left_out=(*found.left_out, *more)), narrow
    return _both(found, select(*bare, matters, then)), bare


def _both(found: Selection, then: Selection) -> Selection:
    """What was found after nothing was, and all that was tried."""
    return replace(
        then, trials=(*found.trials, *then.trials), left_out=(*found.left_out, *then.left_out),
        unsettled=(*found.unsettled, *then.unsettled), harmless=then.harmless or found.harmless,
    )  # fmt: skip


def _narrow(
    records: Sequence[MotorRecord],
    solution: Solution,
    values: Mapping[str, float],
    held: Mapping[str, float],
    terms: Sequence[Term],
) -> Narrow:
    """The fit that named terms begin from: they explain brushes, heat and what repeats with the
    rotor by themselves.
    """
    lossy = carry_loss(records) and bool(set(terms) & set(ALLOWED))
    repeats = any(record.repeating.slopes for record in records)
    anew = repeats and (any(term.per_turn for term in terms) or is_heavy(records, solution))
    if not (lossy or anew):
        return records, solution, values
    return _bare(records, values, held, lossless if lossy else None, anew)


def _bare(
    records: Sequence[MotorRecord],
    values: Mapping[str, float],
    held: Mapping[str, float],
    less: Callable[[Capture], Capture] | None,
    anew: bool,
) -> Narrow:
    """The fit of captures as motors have them that lose ``less`` in brushes and winding (None: no
    less), and without what repeats with the rotor, where ``anew``: terms explain it.
    """
    free = searched(held)
    captures = [less(r.capture) if less else r.capture for r in records]
    bare = [MotorRecord(capture, free, held) for capture in captures]
    for record, six in zip(bare, records, strict=True):
        record.foretold = six.foretold
    if not anew:
        repeat_as(bare, records)
    known = {name: values[name] for name in PARAMETERS}
    solution = multistart.solve(bare, free, known)
    if "L" in free and vanished(
        solution, bare
    ):  # what it lacks took the place of L: terms need one
        solution = with_inductance(bare, free, known, solution, known["L"])
    return bare, solution, merged(held, solution)


def reach(parameters: Mapping[str, Parameter]) -> dict[str, float]:
    """By how much a parameter may move before it matters: half its interval, or 1 % if less.

    An inductance that readings hardly tell follows whatever a term takes of the current's ripple:
    its interval alone counts.
    """
    out = {}
    for name, p in parameters.items():
        if p.value is not None and p.interval_95:
            half = (p.interval_95[1] - p.interval_95[0]) / 2
            vague = name == "L" and half > VAGUE * abs(p.value)
            whole = vague or not p.value  # friction may be at 0
            most = half if whole else min(half, COUNTS * abs(p.value))
            out[name] = HALF * most if half else float("inf")
    return out


def standing_out(
    chosen: Selection, fix: Mapping[str, float], without: Sequence[str]
) -> tuple[tuple[Fitted, Findings] | None, Sequence[Unsettled]]:
    """The widest of these fits in which the size of its last term stands out of all that is
    uncertain of it: instruments and what the voltage hides, too. And what the data half support
    beside it.

    A term that other effects could feign may stand out only in the fit that has one of those too.
    """
    unsettled = list(chosen.unsettled)
    wider: tuple[Fitted, Findings] | None = None
    for stage in reversed(chosen.stages):
        fitted = finished(stage)
        found, last = findings(fitted, fix, without), fitted.terms[-1]
        if stands_out(found, last):
            return without_faint(fitted, found, fix, without, unsettled)
        if wider and last in wider[0].terms and stands_out(wider[1], last):
            return wider, unsettled[:-1]
        unsettled.append(Unsettled(last, fitted.values))
        wider = fitted, found
    return None, unsettled


def known_beside(
    found: Findings, harmless: Fitted | None, fix: Mapping[str, float], without: Sequence[str]
) -> Findings:
    """What a search knows beside a term that explains more and moves nothing, where something is
    still seen without it: near enough, where no room is left to end its fit.
    """
    if harmless is None or not any(one.seen for one in found.undetected):
        return found
    whole = current().has(ENDED * harmless.width)
    return findings(finished(harmless) if whole else harmless, fix, without)


def _stated(trial: Trial) -> TermTrial:
    e = trial.evidence
    return TermTrial(
        trial.term.name, trial.term.title, tuple(t.name for t in trial.beside),
        e.counted, e.needed, e.size, e.left_out, trial.moves, trial.taken,
    )  # fmt: skip


def _with_left_out(estimate: Estimate, chosen: Selection, last: Fitted | None) -> Estimate:
    """What was left out to bound the work, as a remark."""
    if last is None:
        return with_left_out(estimate, chosen.left_out)
    older = [term for term in chosen.not_revised if term in last.terms]
    return with_left_out(estimate, chosen.left_out, last.terms, older, last.settled)


def _with_trials(estimate: Estimate, trials: Sequence[TermTrial]) -> Estimate:
    """What was tried and not offered, as a remark."""
    if not trials:
        return estimate
    names = ", ".join(dict.fromkeys(trial.term for trial in trials))
    said = Diagnostic(
        "model_tried", "info",
        f"a model with {names} was tried: the data do not support it, or it changes nothing that "
        "matters",
    )  # fmt: skip
    return replace(estimate, diagnostics=(*estimate.diagnostics, said))


def _said_of(allowed: bool, harmless: bool) -> str:
    """What lacking its terms means for the six parameters."""
    if harmless:
        return "the six parameters allow for it, and the better model says how large it is"
    less = "allow for less of it" if allowed else "do without it"
    return f"the six parameters {less} and are biased, so use those of the better model"


def _said(estimate: Estimate, fitted: Fitted) -> Estimate:
    better = estimate.alternative
    assert better is not None
    what = " and ".join(term.title for term in fitted.terms)
    if better.asked:
        said = Diagnostic("model_asked", "info", f"beside it, as asked: a model with {what}")
    else:
        allowed = set(fitted.terms) <= set(ALLOWED)  # the six have unknowns for these
        biased = excluded(estimate, better, but=OWN) if allowed else estimate.parameters
        names = excluded(estimate, better) if allowed and biased else biased
        found = covering(estimate, better, names)
        harmless = allowed and not found.sides
        said = Diagnostic(
            "better_model", "info" if harmless else "warning",
            f"the residuals show {what}: {_said_of(allowed, harmless)}",
            found.moves, found.sides,
        )  # fmt: skip
        estimate = settled(estimate, [said])
        if cooling_winding.explained(better.nuisance, better.parameters):
            rest = [d for d in estimate.diagnostics if d.code != cooling_winding.CODE]
            estimate = replace(estimate, diagnostics=tuple(rest))
    others = untold.beside(estimate.suspects, [term.name for term in fitted.terms])
    return replace(estimate, diagnostics=(said, *estimate.diagnostics), suspects=others)
