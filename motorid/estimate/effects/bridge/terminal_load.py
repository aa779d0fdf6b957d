"""The conductance across the motor's terminals, behind the current's sensor: dividers, a lamp.

No reading tells it: it makes another motor of it (``loaded_motor``). What is declared of it is
taken off every answer, and its uncertainty is a line of the budget.
"""

from __future__ import annotations

from motorid.estimate.effects.action import Loading, Reading, times
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.measurements import EMF

DECLARED = 0.05  # of a declared resistance: its standard uncertainty where none is given


def _prior(subject: Subject, _: int) -> Prior | None:
    wiring = subject.capture.wiring
    if not wiring.terminal_load_ohm:
        return None
    doubt_ohm = wiring.terminal_load_uncertainty_ohm or DECLARED * wiring.terminal_load_ohm
    return Prior(doubt_ohm / wiring.terminal_load_ohm**2)


def _scale(subject: Subject) -> float:
    return subject.capture.wiring.terminal_load_s or 1.0


def _of_emf(subject: Subject) -> float:
    """1/S: an open bridge shows less of the back-EMF, in proportion to R."""
    return 0.0 if subject.judged_at is None else -float(subject.judged_at[0])


TERMINAL_LOAD = InfluenceQuantity(
    name="terminal load",
    unit="S",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Loading(), Reading(EMF, times, _of_emf)),
    prior=_prior,
    scale=_scale,
    remedy="take the resistor off, or measure it with the motor unplugged (terminal_load_ohm)",
    step=1e-3,
)
