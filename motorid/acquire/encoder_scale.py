"""Whether the encoder's speed can be: no motor turns faster than its voltage over its constant.

Counts per turn stated too small, a gear stated too large, or a wrong constant on the nameplate make
the speed look too high. Limits of speed then trip too soon.
"""

from __future__ import annotations

import numpy as np

from motorid.acquire.pulse import Pulse
from motorid.acquire.safety import program_volts
from motorid.acquire.signs import Sign, seen
from motorid.capture.model import POSITION, Capture
from motorid.rig import Rig

SURE = 1.5  # times the applied voltage, as back-EMF of a weak pulse: K of a nameplate is rough
CLEAR = 1.2  # the same, where the board's limit of speed was passed
WINDOW = 12  # samples over which a speed is taken


def judge_scale(rig: Rig, pulse: Pulse) -> None:
    """Raises RigError where the first pulse's speed cannot be, by the rig's own facts."""
    if pulse.counts_per_s is None:
        return
    rad_s = abs(pulse.counts_per_s) * _rad_per_count(rig)
    if said := _impossible(rig, rad_s, abs(pulse.volts), SURE):
        raise seen(Sign.TOO_FAST, f"in the first weak pulse {said}")


def why_too_fast(rig: Rig, capture: Capture) -> str:
    """What to check before a limit of speed is raised, beginning with "; "; empty: nothing."""
    position = capture.get(POSITION)
    if position is None or len(capture) <= WINDOW:
        return ""
    turned = np.abs(position.values[WINDOW:] - position.values[:-WINDOW])
    took = capture.time_s[WINDOW:] - capture.time_s[:-WINDOW]
    rad_s = float(np.max(turned / took)) * rig.wiring.gear_ratio
    said = _impossible(rig, rad_s, _highest_volts(rig, capture), CLEAR)
    return f"; {said}" if said else ""


def _highest_volts(rig: Rig, capture: Capture) -> float:
    program = capture.program or rig.program
    return max(program_volts(rig, program, capture.supply_v), default=0.0)


def _rad_per_count(rig: Rig) -> float:
    return 2.0 * np.pi * rig.wiring.gear_ratio / rig.wiring.counts_per_turn


def _impossible(rig: Rig, rad_s: float, volts: float, beyond: float) -> str:
    constant = rig.nameplate.torque_constant_nm_a
    if constant is None or not volts > 0 or constant * rad_s <= beyond * volts:
        return ""
    times = constant * rad_s / volts
    return (
        f"the encoder says {rad_s:.0f} rad/s at {volts:.3g} V, {times:.2g} times what "
        f"nameplate.torque_constant_nm_a = {constant:g} allows: wiring.counts_per_turn = "
        f"{rig.wiring.counts_per_turn:g} is too small (turn the shaft once by hand and count), "
        f"or wiring.gear_ratio = {rig.wiring.gear_ratio:g} or the nameplate is wrong"
    )
