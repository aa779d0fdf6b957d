"""The fit of logs without a current: by the whole likelihood, or by a balance where that fails."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from motorid.capture.model import Capture
from motorid.capture.store import describe
from motorid.errors import DataError
from motorid.estimate.partial import mechanical_fit, mechanical_remarks, step_response
from motorid.estimate.partial.levels.one_level import OneLevelError, as_one
from motorid.estimate.partial.mechanical_results import CONSTANT, FRICTION, GAIN
from motorid.estimate.partial.mechanical_signals import stands_still
from motorid.estimate.partial.without_current import coasts
from motorid.estimate.partial.without_current.combinations import opened
from motorid.estimate.partial.without_current.likelihood import Better, Whole, whole
from motorid.estimate.results.estimate import Diagnostic, Estimate, Parameter


def fit(
    captures: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str] = (),
    better: Better | None = None,
) -> Estimate:
    """JR/(K²+RB), K/(K²+RB), T0·R/K and, where the readings are quick, L/R.

    ``better``: what better models say of the values. Raises DataError as ``mechanical_fit.fit``.
    """
    moving = [capture for capture in captures if not stands_still(capture)]
    if step_response.steps(moving) is not None:
        return mechanical_fit.fit(captures, fix=fix, without=without)
    found = _of_moving(moving, fix, without, better)
    still = len(captures) - len(moving)
    said = [mechanical_remarks.standing_still(still)] if still else []
    return replace(found, diagnostics=(*said, *found.diagnostics))


def _of_moving(
    captures: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str],
    better: Better | None,
) -> Estimate:
    """With a bridge that is closed where the command is 0, or open where that leaves far less."""
    closed = _fitted(captures, fix, without, better)
    parts = [coasts.parted(capture) for capture in captures]
    driven, coasting = ([one for part in parts for one in part[k]] for k in (0, 1))
    if not (driven and coasting):
        return closed
    alone = _under_drive(driven, fix, without, better)
    braked, free = (coasts.left(one.curves) if one else math.inf for one in (closed, alone))
    if alone is None or not free < braked / coasts.WORSE:
        return closed
    return _beside_coast(alone, coasting, captures, fix)


def _fitted(
    captures: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str],
    better: Better | None,
) -> Estimate:
    """By the likelihood where it answers, else by the balance."""
    try:
        balance = mechanical_fit.fit(captures, fix=fix, without=without)
    except DataError as error:
        found = whole(captures, None, without)
        if not found.answers and isinstance(error, OneLevelError) and "T0" not in without:
            found = whole(captures, None, (*without, "T0"))
            if found.answers:
                return as_one(opened(_with(found, better), captures, fix, without))
        if not found.answers:
            raise
        return opened(_with(found, better), captures, fix, without)
    try:
        found = whole(captures, _start(balance), without)
    except DataError:
        return balance  # which asks less of the readings
    return opened(_with(found, better), captures, fix, without) if found.answers else balance


def _with(found: Whole, better: Better | None) -> Whole:
    """With what better models say."""
    if better is None or not found.answers:
        return found
    return replace(found, estimate=better(found))


def _start(balance: Estimate) -> dict[str, float] | None:
    """Where the search begins, by a balance."""
    constant, gain, friction = (
        balance.combinations[name].value if name in balance.combinations else None
        for name in (CONSTANT, GAIN, FRICTION)
    )
    if not (constant and gain):
        return None
    return {"K": 1.0 / gain, "J": constant / gain**2, "T0": (friction or 0.0) / gain}


def _under_drive(
    driven: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str],
    better: Better | None,
) -> Estimate | None:
    """The parts under drive by themselves; None where they do not tell a motor."""
    try:
        single = step_response.steps(driven) is not None
        if single:
            return mechanical_fit.fit(driven, fix=fix, without=without)
        return _fitted(driven, fix, without, better)
    except DataError:
        return None  # too short, or at rest


def _beside_coast(
    found: Estimate,
    coasting: Sequence[Capture],
    captures: Sequence[Capture],
    fix: Mapping[str, float],
) -> Estimate:
    """With what the motor does without a drive."""
    said = Diagnostic(
        "bridge_open", "info",
        "where the command is 0 the motor is not braked but coasts: the bridge is open there. Time "
        "constant and gain are of the parts under drive",
    )  # fmt: skip
    try:
        coast = mechanical_fit.fit(coasting, fix={n: v for n, v in fix.items() if n == "J"})
    except DataError:
        more: Mapping[str, Parameter] = {}  # too short to show its friction
    else:
        more = coast.combinations
    return replace(
        found,
        combinations={**found.combinations, **more},
        diagnostics=(said, *found.diagnostics),
        inputs=tuple(describe(capture) for capture in captures),
    )
