"""Time put back where samples are missing under stamps that count on, and it is seen where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorid.capture.model import Capture, Gap
from motorid.estimate.diagnosis.faults import lost_rows, lost_samples
from motorid.estimate.signals.time_grid import Timeline

CODE = "samples_dropped"
NEAR = 1.0  # samples by which a jump may miss a whole number of them, as where a motor starts
REASON = "missing, by the readings' jumps"


def put_back(capture: Capture, timeline: Timeline) -> Capture | None:
    """The capture with later stamps after every place where samples are seen to be missing.

    None where none is, or where it is not seen of all of them how many they are.
    """
    missing = _of_run(capture, timeline) if capture.program is not None else _of_log(capture)
    if not missing:
        return None
    period = round(float(np.median(np.diff(capture.ticks))))
    later = np.zeros(len(capture), dtype=np.int64)
    for place, samples in missing.items():
        later[place:] += samples * period
    gaps = tuple(Gap(place, samples, REASON) for place, samples in missing.items())
    known = tuple(sorted((*capture.gaps, *gaps), key=lambda gap: gap.index))
    return replace(capture, ticks=capture.ticks + later, gaps=known)


def _of_run(capture: Capture, timeline: Timeline) -> dict[int, int]:
    """Samples missing before each place, where they are as many as the program lacks."""
    jumps, short = lost_samples.find(capture, timeline), lost_samples.short_of_program(capture)
    if jumps is None or not short or (jumps.counts < 0.0).any():
        return {}
    unclear = jumps.missing == 0.0
    samples = np.where(unclear, np.maximum(np.rint(jumps.nearly), 1.0), jumps.missing)
    for _ in range(int(unclear.sum())):  # by one where the jump is nearest to it
        more = short - samples.sum()
        if not more:
            break
        miss = np.where(unclear, np.sign(more) * (jumps.nearly - samples), -np.inf)
        samples[int(miss.argmax())] += np.sign(more)
    sure = np.abs(samples - jumps.nearly) <= NEAR
    if samples.sum() != short or not (sure & (samples >= 1.0)).all():
        return {}
    return dict(zip(jumps.places.tolist(), samples.astype(int).tolist(), strict=True))


def _of_log(capture: Capture) -> dict[int, int]:
    lost = lost_rows.find(capture)
    if lost is None or (lost.rows < 1.0).any():
        return {}
    pairs = zip(lost.places.tolist(), lost.rows.tolist(), strict=True)
    return {place: round(rows) for place, rows in pairs}
