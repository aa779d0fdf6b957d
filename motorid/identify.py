"""Which fit suits the captures: the one door to the estimator and to the searches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motorid.capture.model import Capture
    from motorid.estimate.results.estimate import Diagnostic, Estimate, Suspect

OPTIONAL = ("L", "B", "T0")  # what ``without`` may take out of the model
ML = "ml"  # the method of the likelihood


def fit(
    captures: Sequence[Capture],
    *,
    fix: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
    method: str = ML,
    model: str = "auto",
    **search: Any,
) -> Estimate:
    """The estimate that captures of one motor give together.

    ``fix`` holds parameters at SI values; ``without`` leaves L, B or T0 out of the model. Captures
    without a voltage are fitted by their mechanics alone, and logs without a current by what volts
    and motion show of all. ``model``: auto (a better model beside the six parameters where the
    residuals ask for one), six, or terms of ``extended_terms`` joined by +. ``search``: ``budget``
    and ``seed`` of another method (``search.fit``). Raises UsageError on an unknown name, method or
    model, DataError where the captures hold too little.
    """
    from motorid.capture.plausible import insist
    from motorid.errors import DataError
    from motorid.estimate.assembly.doubt import settled
    from motorid.estimate.diagnosis.facts.compare import findings
    from motorid.estimate.diagnosis.facts.current_sense import one_sided
    from motorid.estimate.diagnosis.facts.pwm.alignment import aligned
    from motorid.estimate.diagnosis.facts.pwm.frequency import corrected
    from motorid.estimate.diagnosis.faults.readings import held_channels
    from motorid.estimate.fit.rough_fit import departures, moves
    from motorid.estimate.signals import voltage_low_pass
    from motorid.estimate.signals.upsampled_rows import own_readings
    from motorid.estimate.uncertainty.reference_temperature import with_reference

    if not captures:
        raise DataError("there is no capture to fit: name at least one file")
    search = {**search, "model": model}
    for capture in captures:
        insist(capture)
    captures, between = zip(*map(own_readings, captures), strict=True)
    undeclared: list[Suspect] = []
    for channel in (held_channels, one_sided, voltage_low_pass):
        captures, found = zip(*map(channel.declared, captures), strict=True)
        undeclared += [one for one in dict.fromkeys(found) if one is not None][:1]
    again = partial(_fit, fix=fix, without=without, method=method, search=search)
    estimate = again(captures)
    if method == ML:
        glance = partial(departures, fix=fix or {}, without=without)
        stated = captures
        captures, estimate = corrected(captures, estimate, again, glance)
        if captures is stated:
            foreseen = partial(moves, fix=fix or {}, without=without)
            captures, estimate = aligned(captures, estimate, again, glance, foreseen)
    said = tuple(findings(captures, estimate, again))
    said = (*filter(None, between), *_of_logs(captures, estimate), *said)
    estimate = replace(estimate, suspects=(*undeclared, *estimate.suspects))
    estimate = with_reference(settled(estimate, said), captures)
    return replace(estimate, diagnostics=(*estimate.diagnostics, *_unread(captures), *said))


def _of_logs(captures: Sequence[Capture], estimate: Estimate) -> list[Diagnostic]:
    """A voltage that cannot be the motor's, and what was left out because a bridge was open."""
    from motorid.estimate.diagnosis import foreign_voltage
    from motorid.estimate.partial import mechanical_fit
    from motorid.estimate.signals.log_sections import left_out, unbroken

    if mechanical_fit.suits(captures):
        return []
    fitted = sum(one["samples"] for one in estimate.inputs)
    whole = fitted == sum(len(piece) for piece in unbroken(captures))
    return [*foreign_voltage.remarks(captures), *([] if whole else left_out(captures))]


def _unread(captures: Sequence[Capture]) -> Iterator[Diagnostic]:
    """What of a rig's facts could not be read, each once."""
    from motorid.estimate.results.estimate import Diagnostic

    for said in dict.fromkeys(c.stated.unread for c in captures if c.stated.unread):
        text = f"{said}: the fit goes without it; name the rig again by --rig, or give --nameplate"
        yield Diagnostic("rig_unread", "warning", text)


def _fit(
    captures: Sequence[Capture],
    fix: Mapping[str, float] | None,
    without: Sequence[str],
    method: str,
    search: dict[str, Any],
) -> Estimate:
    from motorid.errors import UsageError
    from motorid.estimate.partial import current_transient_alone, mechanical_fit
    from motorid.estimate.partial.without_current import likelihood
    from motorid.estimate.results.estimate import AUTO, SIX

    known, model = {name: float(value) for name, value in (fix or {}).items()}, search["model"]
    if method != ML:
        from motorid.search.fit import fit as by_name

        _check(known, without)
        search |= {"model": "linear"} if model in (SIX, AUTO) else {}
        return by_name(captures, method, fix=known, without=without, **search)
    foreign = [name for name in search if name != "model"]
    if foreign:
        raise UsageError(
            f"the method ml takes no {', '.join(foreign)}: choose another by --method, such as nls"
        )
    from motorid.estimate.selection import fewer_channels, held_rotor

    if held_rotor.suits(captures):
        _check(known, without)
        return held_rotor.fit(captures, known, without, SIX if model == "linear" else model)
    if current_transient_alone.suits(captures):
        _insist_on_six(model)
        _check(known, without)
        return current_transient_alone.fit(captures, known)
    if mechanical_fit.suits(captures):
        _insist_on_six(model)
        if likelihood.suits(captures, without):
            _check(known, ())
            return fewer_channels.without_current(captures, known, without)
        return mechanical_fit.fit(captures, fix=known, without=without)
    _check(known, without)
    from motorid.estimate.partial import electrical_only, locked_rotor, turned_from_outside
    from motorid.estimate.selection import entry
    from motorid.estimate.signals.log_sections import pieces

    captures = locked_rotor.without_constant_motion(captures)
    if electrical_only.suits(captures):
        _insist_on_six(model)
        return fewer_channels.without_motion(pieces(captures), known, without)
    if model in (SIX, AUTO) and not without and turned_from_outside.suits(captures):
        return turned_from_outside.fit(captures, known)
    at_rest = (
        locked_rotor.without_motion(captures, known, without) if model in (SIX, AUTO) else None
    )
    if at_rest is not None:
        return at_rest
    return entry.fit(captures, known, without, SIX if model == "linear" else model)


def _insist_on_six(model: str) -> None:
    from motorid.errors import UsageError
    from motorid.estimate.results.estimate import AUTO, SIX

    if model not in (SIX, AUTO, "linear"):
        raise UsageError(
            f"--model {model} needs captures with a voltage, a current and a motion: leave it "
            "out for these"
        )


def _check(fix: Mapping[str, float], without: Sequence[str]) -> None:
    import math

    from motorid.errors import UsageError
    from motorid.estimate.results.estimate import PARAMETERS

    for name, value in fix.items():
        if name not in PARAMETERS:
            raise UsageError(f'cannot fix "{name}": the parameters are {", ".join(PARAMETERS)}')
        if not math.isfinite(value) or value < 0 or (value == 0 and name not in OPTIONAL):
            raise UsageError(f"cannot fix {name} at {value:g}: give a positive value in SI units")
    for name in without:
        if name not in OPTIONAL:
            raise UsageError(f'cannot leave "{name}" out: only {", ".join(OPTIONAL)} can be')
        if name in fix:
            raise UsageError(f"{name} is both fixed and left out: choose one")
