"""A coast-down by the terminal voltage alone: open, a motor is its own tachometer, v = K ω."""

from __future__ import annotations

from dataclasses import replace

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, VOLTAGE, Capture
from motorid.estimate.results.estimate import Estimate

OTHERS = (SPEED, POSITION, CURRENT, TORQUE, "command")
IN_VOLTS = "K·T0/J"


def is_tachometer(capture: Capture) -> bool:
    """Whether a voltage is all that the capture holds of the motor."""
    return VOLTAGE in capture.channels and not any(n in capture.channels for n in OTHERS)


def speed_from_voltage(capture: Capture, constant: float | None) -> Capture:
    """The capture with v/K for a speed, if a voltage is all that it has; as if K were 1 without."""
    if not is_tachometer(capture):
        return capture
    volts = capture.channels[VOLTAGE]
    share = 1.0 / (constant or 1.0)
    speed = replace(
        volts,
        name=SPEED,
        unit="rad/s",
        scale=volts.scale * share,
        resolution=volts.resolution * share,
        noise=volts.noise * share,
        offset_uncertainty=volts.offset_uncertainty * share,
        sense=None,
    )
    return replace(capture, channels={SPEED: speed})


def in_volts(estimate: Estimate) -> Estimate:
    """What a coast-down says of T0/J while K is not known: K·T0/J, by which the voltage falls."""
    found = dict(estimate.combinations)
    told = replace(found.pop("T0/J"), name=IN_VOLTS, unit="V/s")
    moves = {
        gain: {IN_VOLTS if name == "T0/J" else name: move for name, move in each.items()}
        for gain, each in estimate.not_stated.items()
    }
    return replace(estimate, combinations={**found, IN_VOLTS: told}, not_stated=moves)
