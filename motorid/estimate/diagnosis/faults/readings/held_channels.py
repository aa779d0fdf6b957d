"""A board's position or speed that is renewed every few samples alone, such as one read by a bus.

Readings between are repetitions. Taken for readings, they make jumps that look like lost samples,
and a motion that no motor makes. The fit looks at the renewed readings, as it does in a log.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorid.capture.model import HELD, POSITION, SPEED, Capture, Channel
from motorid.capture.table_checks import held_samples
from motorid.estimate.results.estimate import Suspect

COARSE = 2.0  # counts of a change, the median, with which samples between would have changed too


def declared(capture: Capture) -> tuple[Capture, Suspect | None]:
    """The capture with those channels marked, and what is said; as it came: none is held."""
    known = capture.provenance.get(HELD) or {}
    if capture.program is None or known:
        return capture, None
    moving = {n: c for n in (POSITION, SPEED) if (c := capture.get(n)) is not None and _fine(c)}
    held = held_samples(moving)
    if not held:
        return capture, None
    name, repeat = next(iter(held.items()))
    said = Suspect(
        "readings_held", name,
        f"the {name} is renewed every {repeat} samples, and repeated between; the fit uses the "
        "renewed readings",
        f"read the encoder at each sample, or sample {repeat} times slower", "named", allowed=True,
    )  # fmt: skip
    return replace(capture, provenance={**capture.provenance, HELD: held}), said


def _fine(channel: Channel) -> bool:
    """It changes by more than a count at once: a slow motion would else look held."""
    changes = np.abs(np.diff(channel.values))
    changed = changes[changes > 0.0]
    return bool(len(changed)) and float(np.median(changed)) > COARSE * channel.resolution
