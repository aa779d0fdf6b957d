"""What a first drive saw that may be the motor's own defect: an error that a verdict can read."""

from __future__ import annotations

from enum import StrEnum

from motorid.errors import RigError


class Sign(StrEnum):
    """What was seen. Whether motor or rig is its cause is for whoever can show the rig sound."""

    SHORTED = "shorted"  # a weak pulse drives the current to its limit, or to the sensor's
    OPEN = "open"  # the terminals have their voltage, and hardly any current flows
    SEIZED = "seized"  # current flows, and no voltage of a turning rotor follows
    SWINGS = "swings"  # the rotor moves by a part of a turn and comes back
    BACKWARDS = "backwards"  # it turns, and the encoder counts the other way
    TOO_FAST = "too_fast"  # for the nameplate's constant
    OVER_CURRENT = "over_current"  # in the program
    OVER_SPEED = "over_speed"


class SignError(RigError):
    """A RigError with the ``sign`` that it rests on."""

    sign: Sign | None = None


def seen(sign: Sign, text: str) -> SignError:
    """The error to raise."""
    error = SignError(text)
    error.sign = sign
    return error
