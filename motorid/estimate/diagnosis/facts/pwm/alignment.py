"""Pulses of a bridge that do not begin with their PWM periods, where no rig says so.

A counter that counts up gives pulses that begin with the period, one that counts up and down gives
pulses about its middle, an inverted one pulses that end with it. After a step of the duty the
current is then late by that share of the off part; against L/R of a few periods that is L wrong by
several percent, and the residuals hardly grow. Where no rig states the alignment, a rough search
with each compares the likelihoods of the current. (A position adds up whatever the model lacks, and
says little of it.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture
from motorid.errors import DataError
from motorid.estimate.diagnosis.facts.pwm.frequency import (
    Fit,
    Glance,
    left_of,
    refused,
    size_of,
    values_known,
)
from motorid.estimate.results.estimate import Diagnostic, Estimate
from motorid.estimate.signals.source.pwm_bridge import driven_share
from motorid.estimate.signals.time_grid import lay

Floats = NDArray[np.float64]
Moves = Callable[..., Sequence[Floats]]  # (captures, others, values, channel)

CODE = "pwm_alignment"
ALIGNED = {0.0: "begin with", 0.5: "lie in the middle of", 1.0: "end with"}
SURE = 60.0  # by which twice the logarithm of the likelihood rises with another alignment
LIKELY = 30.0  # the same, foreseen, from which searches are worth their responses
TINY = 1e-300  # A²


def aligned(
    captures: Sequence[Capture], estimate: Estimate, fit: Fit, glance: Glance, moves: Moves
) -> tuple[Sequence[Capture], Estimate]:
    """The captures with pulses where the current shows them, and their estimate, which says so;
    both as they came where some capture states the place, or none does clearly better.

    ``glance`` gives what a rough search from the estimate's values leaves of a channel, ``moves``
    what other captures would show more of it there.
    """
    values = None if refused(estimate) else values_known(estimate)
    if values is None or not all(map(_switched, captures)):
        return captures, estimate
    try:
        more = moves(captures, _placed(captures, max(ALIGNED)), values, channel=CURRENT)
    except DataError:  # no fit begins from these captures as they are: a sign was put right
        return captures, estimate
    if _foreseen(_currents(estimate), more) < LIKELY:
        return captures, estimate
    left = {}
    for place in ALIGNED:
        tried = captures if not place else _placed(captures, place)
        try:
            left[place] = glance(tried, values, channels=(CURRENT,))
        except DataError:  # with pulses there the readings have no fit
            continue
    if 0.0 not in left:
        return captures, estimate
    gains = {place: _likelier(left[0.0], other) for place, other in left.items()}
    place = max(gains, key=lambda one: gains[one])
    if gains[place] < SURE:
        return captures, estimate
    tried = _placed(captures, place)
    found = fit(tried)
    if refused(found) or _likelier(_currents(estimate), _currents(found)) < SURE:
        return captures, estimate
    said = _elsewhere(place, estimate, found)
    return tried, replace(found, diagnostics=(*found.diagnostics, said))


def _foreseen(left: Sequence[Floats], more: Sequence[Floats]) -> float:
    """By how much twice the logarithm of the likelihood rises where readings show ``more`` of what
    is ``left``; twice that where they show half of it. What parameters could explain of it they
    have explained already.
    """
    if [len(one) for one in left] != [len(other) for other in more]:
        return np.inf
    each = zip(left, more, strict=True)
    return sum(float(one @ other) / max(float(np.mean(one**2)), TINY) for one, other in each)


def _switched(capture: Capture) -> bool:
    """Its bridge switches in some part of the program, and nobody states the alignment."""
    wiring = capture.wiring
    if wiring.pwm_alignment is not None or not wiring.pwm_hz or CURRENT not in capture.channels:
        return False
    rail = capture.supply_v
    return any(0.0 < driven_share(part, rail)[0] < 1.0 for part in lay(capture).parts)


def _placed(captures: Sequence[Capture], place: float) -> Sequence[Capture]:
    return tuple(replace(c, wiring=replace(c.wiring, pwm_alignment=place)) for c in captures)


def _likelier(before: Sequence[Floats], after: Sequence[Floats]) -> float:
    """By how much twice the logarithm of the likelihood rises, the noise of each channel free."""
    return sum(
        2.0 * len(one) * (size_of(one) - size_of(other))
        for one, other in zip(before, after, strict=True)
    )


def _currents(estimate: Estimate) -> Sequence[Floats]:
    return [left_of(curve) for curve in estimate.curves if curve.channel == CURRENT]


def _elsewhere(place: float, before: Estimate, after: Estimate) -> Diagnostic:
    """A remark: a bridge may place its pulses as it likes, and nothing is wrong with it."""
    was, now = (e.parameters["L"].value if "L" in e.parameters else None for e in (before, after))
    moved = f", and L is {was / now - 1.0:+.1%} off" if was and now else ""
    return Diagnostic(
        CODE, "info",
        f"the pulses of the bridge {ALIGNED[place]} their PWM periods, and no rig says so: the fit "
        "takes them there. Taken at the beginning of the period they leave more of the "
        f"current{moved}. State wiring.pwm_alignment = {place:g} in the rig file",
    )  # fmt: skip
