"""Parts of a program in which the motor was driven and stood still all the same.

Breakaway and cogging hold a rotor against more torque than T0, the level of a motion. A model that
knows T0 alone would let it creep: where the encoder shows no motion, it is told to stand.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorid.capture.model import POSITION, Capture
from motorid.estimate.signals.time_grid import Part, Timeline

STIR = 1.5  # counts, by which the edge of one may flicker
FEWEST = 24  # readings that tell


def with_standstill(capture: Capture, timeline: Timeline) -> Timeline:
    """With those parts marked in which the position stayed within a count from beginning to end."""
    channel = capture.get(POSITION)
    if channel is None or channel.resolution <= 0 or capture.program is None:
        return timeline
    place = timeline.spread(channel.values)

    def stands(part: Part) -> bool:
        here = place[part.slice]
        here = here[np.isfinite(here)]
        if part.open or not part.level or len(here) < FEWEST:
            return False
        return float(np.ptp(here)) <= STIR * channel.resolution

    return replace(timeline, parts=tuple(replace(p, still=stands(p)) for p in timeline.parts))
