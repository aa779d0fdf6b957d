"""A current, a voltage or an encoder that counts the wrong way, seen before any fit.

A current of the wrong sign turns R and J/K of the motor's laws round, an encoder K and J/K, a
voltage R and K.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.errors import DataError
from motorid.estimate.fit.block_regression import FEWEST, blocks, friction_columns, squares
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Suspect

CLEAR = 6.0  # a coefficient in units of its standard deviation
NEGATIVE: dict[tuple[str, ...], str] = {
    ("R", "J/K"): "current",
    ("K", "J/K"): "encoder",
    ("R", "K"): "voltage",
}
CHANNELS = {"current": (CURRENT,), "encoder": (POSITION, SPEED), "voltage": (VOLTAGE,)}
EVIDENCE = {
    "current": "the current flows against its voltage and against the motion it makes",
    "encoder": "the motor turns against its voltage and against its current",
    "voltage": "the voltage is against both the current and the motion",
}
ACTION = {
    "current": "swap the current sensor's leads, or give its scale the other sign",
    "encoder": "reverse the encoder in the rig (encoder_reversed), or swap its A and B",
    "voltage": "swap the voltage's leads, or give its scale the other sign",
}


class WrongSignError(DataError):
    """Captures whose signs contradict each other; ``suspect`` says which channel is reversed."""

    def __init__(self, suspect: Suspect) -> None:
        super().__init__(
            f"the sign of the {suspect.where} is wrong: {suspect.evidence}; {suspect.action}"
        )
        self.suspect = suspect


def put_right(captures: Sequence[Capture], found: WrongSignError) -> list[Capture]:
    """The captures with that channel turned round."""
    names = CHANNELS[found.suspect.where]
    return [
        replace(
            capture,
            channels={
                name: replace(one, scale=-one.scale) if name in names else one
                for name, one in capture.channels.items()
            },
        )
        for capture in captures
    ]


def allowed(found: WrongSignError) -> Suspect:
    """What is said of a channel that a fit has turned round."""
    evidence = f"{found.suspect.evidence}; the fit takes it the other way round"
    return replace(found.suspect, evidence=evidence, allowed=True)


def insist(records: Sequence[MotorRecord]) -> None:
    """Raises WrongSignError where one channel is clearly reversed."""
    which = wrong(records)
    if which:
        raise WrongSignError(
            Suspect(f"{which}_sign", which, EVIDENCE[which], ACTION[which], "named")
        )


def wrong(records: Sequence[MotorRecord]) -> str:
    """ "current", "encoder" or "voltage", whichever is reversed; "" where none clearly is."""
    b = blocks(records)
    if b is None or b.settled.sum() < FEWEST:
        return ""
    use = b.settled
    _, _, electrical = squares(np.column_stack([b.current, b.speed])[use], b.volts[use])
    _, _, mechanical = squares(friction_columns(b)[use], b.current[use])
    clear = {"R": electrical[0], "K": electrical[1], "J/K": mechanical[0]}
    if min(abs(t) for t in clear.values()) < CLEAR:
        return ""
    return NEGATIVE.get(tuple(n for n, t in clear.items() if t < 0), "")
