"""A zero of the current that is not where its channel declares it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting
from motorid.estimate.effects.reading.driven_current_offset import DRIVEN_CURRENT_OFFSET
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Suspect

Floats = NDArray[np.float64]

BEYOND = 5.0  # standard uncertainties that the channel declares
OF_RUNNING = 0.02  # of the usual driven current, below which an offset does no harm
LATE = 8  # samples after the bridge opened, in which a current may still flow
FEWEST = 16  # readings at rest


def suspects(record: MotorRecord) -> list[Suspect]:
    """An offset with the bridge open that is far beyond what the channel declares."""
    zero = seen(record)
    if zero is None:
        return []
    beyond = abs(zero) / record.capture.channels[CURRENT].offset_uncertainty
    evidence = (
        f"the current reads {zero:+.3g} A with the bridge open, {beyond:.0f} times the "
        "uncertainty that its channel declares for its zero"
    )
    action = "take the zero again with the motor at rest, and look for a ground loop"
    return [Suspect("current_offset", "current", evidence, action, "named")]


def seen(record: MotorRecord) -> float | None:
    """A, what the current reads with the bridge open; None: no more than is declared."""
    m = next((m for m in record.measured if m.block.name == CURRENT and not m.unsigned), None)
    if m is None or not m.channel.offset_uncertainty > 0:
        return None
    driven = record.driven[m.keep]
    still = np.convolve(driven, np.ones(LATE + 1))[: len(driven)] < 0.5  # now, and as long before
    if still.sum() < FEWEST or still.all():
        return None
    zero = float(np.median(m.values[still]))
    running = float(np.median(np.abs(m.values[~still] - zero)))
    beyond = abs(zero) / m.channel.offset_uncertainty
    if beyond < BEYOND or abs(zero) < max(OF_RUNNING * running, m.resolution):
        return None
    return zero


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """An offset that is there while the motor is driven only."""
    peak = max(
        (float(np.ptp(m.values)) for r in records for m in r.measured
         if m.block.name == CURRENT and not m.unsigned), default=0.0,
    )  # fmt: skip
    if not peak > 0:
        return []

    def words(size: Floats) -> Words:
        return Words(
            "current",
            f"the current's zero is off by {size[0]:+.3g} A while the motor is driven",
            "take the sensor's zero with the bridge switching, and keep its leads away from it",
        )

    return [
        Hypothesis(
            "current_offset",
            acting(DRIVEN_CURRENT_OFFSET),
            ((0.01 * peak,),),
            (0.01 * peak,),
            (-peak,),
            (peak,),
            words,
            quantity=DRIVEN_CURRENT_OFFSET,
        )
    ]
