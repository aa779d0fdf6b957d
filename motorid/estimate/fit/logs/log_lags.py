"""A log's current that is late by whole samples, as software makes it, behind a held voltage.

Every jump of the voltage then passes a reading at once, where no slope leads a search on. So the
current is taken earlier by whole samples, about the lag that a search found, and all begins anew.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from motorid.capture.model import CURRENT, Capture
from motorid.errors import DataError
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.unstated import default
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.fit.logs.log_unknowns import Fit, with_rivals_of
from motorid.estimate.fit.logs.unstated_channels import told
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.fit.start_values import start_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import JOINED, LEVEL

SHAPES = (JOINED, *LEVEL)
LAG = Instance(CURRENT_LAG)
BESIDE = (0, -1, 1)  # samples
TAKEN = "current taken earlier"  # provenance: by how many seconds


def taken(
    before: Fit,
    as_read: Sequence[Capture],
    free: Sequence[str],
    known: Mapping[str, float],
    fixed: Mapping[str, float],
) -> Fit:
    """The likeliest of such fits of the captures ``as_read``; ``before`` where its current is not
    late, or none is likelier.

    Readings that do not belong together may have been taken for means.
    """
    if not all(LAG in record.found for record in before[0]):
        return before
    lags = [
        default.whole(record, float(own[record.instances.index(LAG)]))
        for record, own in zip(before[0], before[1].own, strict=True)
    ]
    period_s = max(default.period_s(record) for record in before[0])
    best = before
    for more in BESIDE:
        late = [lag_s + more * period_s for lag_s in lags]
        if min(late) <= 0.0:
            continue  # an early one is seldom whole samples: nobody reads ahead
        captures = [_earlier(read, late_s) for read, late_s in zip(as_read, late, strict=True)]
        try:
            fits = list(_of_shapes(captures, free, known, fixed))
        except DataError:  # readings that belong together even less
            continue
        best = min(best, *fits, key=lambda fit: fit[1].fair)
    if best is not before:
        with_rivals_of(before, best)
        for record, heard in zip(best[0], told(*best), strict=True):
            record.left_open = (*heard.shifts, heard.step)
    return best


def _of_shapes(
    captures: Sequence[Capture],
    free: Sequence[str],
    known: Mapping[str, float],
    fixed: Mapping[str, float],
) -> Iterator[Fit]:
    """From start values of these captures; a level voltage from where a joined one ended."""
    near: Mapping[str, float] = known
    for shape in SHAPES:
        records = [MotorRecord(capture, free, fixed, shape) for capture in captures]
        if shape == SHAPES[0]:
            near = {**known, **start_values(records, fixed)}
        solution = settled(records, free, near)
        if shape == SHAPES[0]:
            near = merged(near, solution)
        yield records, solution


def _earlier(capture: Capture, late_s: float) -> Capture:
    """The capture with its current declared later by ``late_s``."""
    channel = capture.channels[CURRENT]
    channels = {**capture.channels, CURRENT: replace(channel, delay_s=channel.delay_s + late_s)}
    facts = {**capture.provenance, TAKEN: late_s + capture.provenance.get(TAKEN, 0.0)}
    return replace(capture, channels=channels, provenance=facts)
