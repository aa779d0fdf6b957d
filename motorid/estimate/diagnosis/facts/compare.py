"""All comparisons of what is stated of a bench with what was measured on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.facts import pooled, supply, unit_mistakes
from motorid.estimate.results.estimate import Diagnostic, Estimate


def findings(captures: Sequence[Capture], estimate: Estimate) -> Iterator[Diagnostic]:
    """Facts of the captures that contradict one another, or the estimate."""
    yield from pooled.findings(captures)
    for k, capture in enumerate(captures):
        yield from supply.findings(capture, f" in run {k + 1}" if len(captures) > 1 else "")
    yield from unit_mistakes.findings(captures, estimate.parameters)
