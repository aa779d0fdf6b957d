"""A resistance that falls through a run, where a current can only warm the winding.

The winding was hot when the run began, a contact got better, or what reads the voltage drifts. Its
size is an unknown of every fit (``effects/brush_and_heating.py``). Of a fit that leaves a lack it
says nothing: any misfit bends it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from motorid.estimate.effects.brush_and_heating import WARMING
from motorid.estimate.results.estimate import Diagnostic, Parameter

CODE = "winding_cools"
SURE = 4.0  # standard uncertainties below nothing
HARM = 0.015  # of R: less is what a motor cools that ran before


def findings(
    nuisance: Mapping[str, Parameter], parameters: Mapping[str, Parameter]
) -> Iterator[Diagnostic]:
    """A remark of the run in which R falls the most; ``nuisance``: unknowns of all runs by name."""
    R = parameters["R"].value
    fallen = [
        (p.value, p.total, name.removeprefix(WARMING))
        for name, p in nuisance.items()
        if name.startswith(WARMING) and p.value is not None and p.total
        if p.value < -max(SURE * p.total, HARM)
    ]
    if not fallen or not R:
        return
    grown, u, of_run = min(fallen)
    yield Diagnostic(
        CODE, "warning",
        f"R falls by {-100.0 * grown:.2g} ± {196.0 * u:.1g} % through the capture{of_run}, and a "
        "current warms a winding: it was hot when the run began, or a contact or the voltage's "
        "gain changes; let the motor cool, and look at brushes and clamps",
        {"R": -grown * R},
    )  # fmt: skip


def explained(nuisance: Mapping[str, Parameter], parameters: Mapping[str, Parameter]) -> bool:
    """A wider model in which R may fall through a run does not have it fall: what it adds does."""
    may = any(name.startswith(WARMING) for name in nuisance)
    return may and not any(findings(nuisance, parameters))
