"""An effect of the motor against lags and low-passes that nobody stated: the likelier of the two.

The fit of a log looks for lags and low-passes where six parameters leave a misfit, and a few of
them explain much of what brushes or iron do. So where some were found, the log is taken as stamped
again, and one term of a wider model is fitted in their place. Where that leaves less by more than
its unknowns cost (Schwarz), the chain is as stamped, and the search for a better model has the
rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from motorid.capture.model import Capture
from motorid.errors import DataError
from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.effects.registry import WITHOUT_WORD
from motorid.estimate.fit.joint_fit import ended
from motorid.estimate.fit.logs.log_unknowns import Fit, readings
from motorid.estimate.fit.logs.unstated_channels import told
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.selection.evidence import MARGIN
from motorid.estimate.selection.extended_fit import begin, sizes_by_name
from motorid.estimate.selection.score_test import screen
from motorid.estimate.signals.intersample_voltage import JOINED, LEVEL, Shape

SHAPES: tuple[Shape, ...] = (JOINED, *LEVEL)
FITTED = 2  # terms, the most promising


def likelier(captures: Sequence[Capture], found: Fit, held: Mapping[str, float]) -> Fit:
    """The fit that was ``found``; of the ``captures`` as stamped, where a term explains more."""
    records, solution = found
    if not any(one.quantity in WITHOUT_WORD for record in records for one in record.found):
        return found
    before = records[0].as_stamped
    if not before:
        return found
    free = [u.name for u in solution.unknowns]
    most = plain(records, solution).objective - MARGIN
    try:
        shaped, shape = _best_shape(captures, free, before, held)
        left = min(_left_by_terms(captures, merged(before, shaped[1]), free, held, shape))
    except (DataError, ValueError):  # no motor without them, or no term that has readings
        return found
    if left > most:
        return found
    for record, heard in zip(shaped[0], told(*shaped), strict=True):
        record.left_open = heard.shifts
    return shaped[0], ended(*shaped, free, merged(before, shaped[1]), logged=True)


def _best_shape(
    captures: Sequence[Capture],
    free: Sequence[str],
    start: Mapping[str, float],
    held: Mapping[str, float],
) -> tuple[Fit, Shape]:
    """The likeliest fit of the captures as stamped, and the shape of its voltage."""
    tried: list[tuple[Fit, Shape]] = []
    for shape in SHAPES:
        records = [MotorRecord(capture, free, held, shape) for capture in captures]
        tried.append(((records, settled(records, free, start)), shape))
    return min(tried, key=lambda one: one[0][1].fair)


def _left_by_terms(
    captures: Sequence[Capture],
    start: Mapping[str, float],
    free: Sequence[str],
    held: Mapping[str, float],
    shape: Shape,
) -> Iterator[float]:
    """F of the most promising terms with what their unknowns cost, on a motor that loses nothing in
    brushes and winding; infinite of none.
    """
    yield np.inf
    records = [MotorRecord(lossless(capture), free, held, shape) for capture in captures]
    solution = settled(records, free, start)
    white, values = plain(records, solution), merged(held, solution)
    own = sizes_by_name(records, white)
    cost = float(np.log(readings(records)))
    for one in screen(records, white, values)[:FITTED]:
        rough = begin(
            records, white, one.terms, fixed=held, start={**one.shifted(values), **one.start},
            own=one.beside(own),
        ).followed()  # fmt: skip
        if rough is not None:
            unknowns = sum(
                len(term.free) + (len(records) if term.phase else 0) for term in one.terms
            )
            yield rough.solution.objective + unknowns * cost
