"""All comparisons of what is stated of a bench with what was measured on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.facts import (
    commanded,
    coupled_current,
    doubled_rows,
    plate,
    pooled,
    supply,
    supply_current,
    swapped_columns,
    unit_mistakes,
    unreached_command,
    voltage_scale,
)
from motorid.estimate.diagnosis.facts.pwm import aliasing
from motorid.estimate.results.estimate import Diagnostic, Estimate


def findings(
    captures: Sequence[Capture], estimate: Estimate, fit: Callable[[Sequence[Capture]], Estimate]
) -> Iterator[Diagnostic]:
    """Facts of the captures that contradict one another, or the estimate.

    ``fit`` fits some of the captures in the same way.
    """
    yield from pooled.findings(captures, estimate, fit)
    for k, capture in enumerate(captures):
        where = f" in run {k + 1}" if len(captures) > 1 else ""
        yield from swapped_columns.findings(capture, where)
        yield from supply_current.findings(capture, where)
        yield from coupled_current.findings(capture, where)
        yield from doubled_rows.findings(capture, estimate.parameters, where)
        yield from supply.findings(capture, estimate.parameters, where)
        yield from aliasing.findings(capture, estimate.parameters, where)
        above = tuple(commanded.findings(capture, estimate.parameters, where))
        yield from above or voltage_scale.findings(capture, estimate.parameters, where)
        yield from unreached_command.findings(capture, where)
    yield from unit_mistakes.findings(captures, estimate.parameters, estimate.combinations)
    yield from plate.findings(captures, estimate)
