"""The board's clock against this computer's, in every run: ticks asked for before and after it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from motorid.acquire.clock import Clock, Pair, clock_of, with_stated
from motorid.errors import DataError

QUESTIONS = 5  # before a run, and as many after it
HOST_U = 1e-4 / math.sqrt(3)  # of this computer's clock: 100 ppm at most
BEYOND = 4.0  # standard uncertainties of the difference
WRONG = 0.03  # beyond, it is no crystal and no resonator that is a little off


def resolution_s() -> float:
    """The steps in which this computer's clock goes."""
    return time.get_clock_info("monotonic").resolution


def measured(
    before: Sequence[Pair], after: Sequence[Pair], nominal_hz: float, step_s: float
) -> Clock | None:
    """The clock's rate by the last pairs before a run and the first ones after it.

    ``step_s``: resolution of this computer's clock. None where there are too few pairs.
    """
    pairs = [*before[-QUESTIONS:], *after[:QUESTIONS]]
    try:
        found = clock_of(pairs, nominal_hz, HOST_U)
    except DataError:
        return None
    stepped = step_s / math.sqrt(6) / found.span_s  # two ends, each within a step
    return replace(found, uncertainty=math.hypot(found.uncertainty, stepped))


def in_force(rate: float, uncertainty: float, found: Clock | None) -> tuple[float, float, str]:
    """Rate (true ticks a second over the nominal ones), its standard uncertainty, and a remark.

    ``rate`` and ``uncertainty`` are stated or calibrated; ``found`` is what this computer's clock
    showed. It counts where it contradicts what is stated, or knows better.
    """
    if found is None:
        return rate, uncertainty, ""
    apart, u = found.rate - rate, found.uncertainty
    limit = math.sqrt(3) * uncertainty + BEYOND * u  # the stated one is half a width
    if abs(apart) > max(WRONG, limit):
        return rate, uncertainty, _unbelievable(found.rate)
    if abs(apart) > limit:
        return found.rate, u, _contradicted(apart, uncertainty, u)
    if u >= uncertainty:
        return rate, uncertainty, ""
    both = with_stated(found, uncertainty, rate)
    return both.rate, both.uncertainty, ""


def of_identity(
    identity: Mapping[str, Any],
    rate: float = 1.0,
    uncertainty: float | None = None,
    found: Clock | None = None,
) -> tuple[float, float, str]:
    """Ticks a second, their relative standard uncertainty, and a remark on them.

    Calibrated, or the board's own; ``found``: what the run's own pairs of tick and time showed.
    """
    stated = identity["clock_uncertainty_ppm"] * 1e-6 / math.sqrt(3)
    known = stated if uncertainty is None else uncertainty
    rate, known, remark = in_force(rate, known, found)
    return identity["clock_hz"] * rate, known, remark


def _contradicted(apart: float, stated: float, u: float) -> str:
    return (
        f"by this computer's clock the board's is {100 * abs(apart):.2g} % "
        f"{'fast' if apart > 0 else 'slow'} (± {200 * u:.1g} %), which states "
        f"{100 * math.sqrt(3) * stated:.1g} % at most: times are by this computer's; run "
        "`motorid calibrate RIG --step clock`"
    )


def _unbelievable(seen: float) -> str:
    return (
        f"by this computer's clock the board's goes {seen:.3g} times as fast as it states: an "
        "emulated board, or another crystal than its firmware was built for; times are by the "
        "board's"
    )
