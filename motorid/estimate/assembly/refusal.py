"""An estimate without values: where the model explains too little of what was measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from motorid.estimate.model.unexplained import CONTRADICTED, Unexplained
from motorid.estimate.results.estimate import Diagnostic, Estimate, Parameter
from motorid.estimate.results.status import Status

CODE = "not_supported"
MANY = 10.0
WHY = "no motor gives these readings together"


def refused(estimate: Estimate, worst: Unexplained) -> Estimate:
    """The same evidence, and no values: what was given stays, everything else is not supported.

    ``worst`` is the channel that the model explains least.
    """
    return replace(
        estimate,
        parameters=_without(estimate.parameters),
        combinations=_without(estimate.combinations),
        derived={},
        nuisance={},
        budget={},
        diagnostics=(_said(worst), *(d for d in estimate.diagnostics if d.code not in OF_VALUES)),
    )


OF_VALUES = ("budget", "inseparable", "few_runs", "widened", "drop_or_resistance", "run_to_add")


def _said(worst: Unexplained) -> Diagnostic:
    name = worst.channel.replace("_", " ")
    size = worst.share**0.5
    times = f"{size:.3g} times the readings" if size > MANY else f"{size:.0%} of the readings"
    return Diagnostic(
        CODE, "error",
        f"{WHY}: what the model leaves of the {name} is {times} (rms; at most "
        f"{CONTRADICTED**0.5:.0%} is fitted): check which column is which, the units, the signs, "
        "and that all channels are of one run",
    )  # fmt: skip


def _without(table: Mapping[str, Parameter]) -> dict[str, Parameter]:
    return {
        name: p
        if p.status is Status.FIXED
        else Parameter(name, p.unit, None, None, None, None, None, Status.NOT_SUPPORTED, WHY)
        for name, p in table.items()
    }
