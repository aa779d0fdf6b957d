"""A current of one sign though the motor was driven both ways: a magnitude, or one way alone.

A motor that speeds up backwards draws a negative current. A bridge with a current output (of a high
side, or of a sense resistor) shows the magnitude; an amplifier whose zero lies at the converter's
end shows none of it. Readings of the first are compared with the model's magnitude, and those at
the end of the second are left out as saturated ones are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture, Channel
from motorid.estimate.diagnosis.facts.current_sense import at_supply, turning_drive
from motorid.estimate.diagnosis.facts.current_sense.turning_drive import Turning
from motorid.estimate.results.estimate import Suspect

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

FEWEST = 20  # samples of either way
SPED_UP = 0.3  # of the top speed, that the motor must gain backwards
RARE = 0.5  # per cent of readings at either end that are not looked at
NEVER = 0.03  # of the highest current: the least that would be a negative one
SHOWN = 0.2  # of it, that a magnitude reads while the motor is driven backwards
OVER_NOISE = 10.0  # times the noise, that the highest current must be
ABOVE_ZERO = 4.0  # times the noise, up to which a reading may be a negative current
ACTION = 'state sensor = "magnitude" of the board\'s current, or use a sensor with a sign'


def declared(capture: Capture) -> tuple[Capture, Suspect | None]:
    """The capture with its current taken so, and what is said of it; as it came: it has signs."""
    turning = turning_drive.of(capture)
    if turning is None:
        return capture, None
    highest = _highest(turning, capture.channels[CURRENT])
    if highest is None or at_supply.found(turning):
        return capture, None
    backwards = _backwards(turning)
    shown = float(np.percentile(turning.current[backwards], 100.0 - RARE))
    whole = shown > SHOWN * highest
    current = capture.channels[CURRENT]
    current = replace(current, unsigned=True) if whole else _one_way(current)
    return replace(capture, channels={**capture.channels, CURRENT: current}), _said(whole)


def _highest(turning: Turning, current: Channel) -> float | None:
    """The current (A) forwards; None: it is negative at times, or nothing says that it should."""
    forwards, backwards = _forwards(turning), _backwards(turning)
    if min(forwards.sum(), backwards.sum()) < FEWEST:
        return None
    if float(np.ptp(turning.speed[backwards])) < SPED_UP:
        return None
    highest = float(np.percentile(turning.current[forwards], 100.0 - RARE))
    least = float(np.percentile(turning.current[backwards], RARE))
    noise = max(current.noise, current.resolution)
    if highest <= OVER_NOISE * noise or least < -max(NEVER * highest, ABOVE_ZERO * noise):
        return None
    return highest


def _forwards(turning: Turning) -> Bools:
    return np.asarray((turning.level > 0.0) & (turning.speed * _way(turning) > 0.0))


def _backwards(turning: Turning) -> Bools:
    return np.asarray((turning.level < 0.0) & (turning.speed * _way(turning) < 0.0))


def _way(turning: Turning) -> float:
    """1, or -1 of an encoder that counts the other way."""
    return 1.0 if float(turning.level @ turning.speed) > 0.0 else -1.0


def _one_way(current: Channel) -> Channel:
    """The channel, whose converter ends above zero."""
    least = current.offset + ABOVE_ZERO * max(current.noise, current.resolution) / current.scale
    return (
        replace(current, raw_min=max(current.raw_min, least))
        if current.scale > 0.0
        else replace(current, raw_max=min(current.raw_max, least))
    )


def _said(whole: bool) -> Suspect:
    if whole:
        return Suspect(
            "current_magnitude", "current",
            "the current is never negative though the motor speeds up both ways: it is a "
            "magnitude, and the fit takes it as one", ACTION, "named", allowed=True,
        )  # fmt: skip
    return Suspect(
        "current_one_way", "current",
        "the current reads nothing while the motor speeds up backwards: its sensor shows one way "
        "alone; the fit leaves out readings near zero and below",
        "use a sensor that shows both ways, or lift its zero to the middle of the converter's "
        "range", "named", allowed=True,
    )  # fmt: skip
