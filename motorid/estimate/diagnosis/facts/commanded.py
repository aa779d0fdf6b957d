"""The motor's voltage against the level that the program commands.

A board turns volts into a duty by its reading of the supply. A bridge and its dead time take
something off; nothing adds, but where a motor brakes after a higher level. So a reading above it
says that one of two scales is wrong, or that the window of the voltage is not what the board
declares.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from motorid.capture.model import VOLTAGE, Capture
from motorid.estimate.diagnosis.facts.pwm.aliasing import aliased
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.signals.time_grid import lay
from motorid.program import Decay, StepKind

ABOVE = 0.05  # relative, by which a reading may lie above its level
SURE = 3.0  # standard uncertainties of the voltage's gain and offset beside that
FEWEST = 20  # samples of a level


def findings(
    capture: Capture, parameters: Mapping[str, Parameter], where: str = ""
) -> Iterator[Diagnostic]:
    """A voltage that reads more than was commanded. ``where``: " in run 2", or nothing."""
    channel = capture.get(VOLTAGE)
    if channel is None or channel.sense not in ("terminals", "bridge") or aliased(capture):
        return
    highest = 0.0  # a motor that brakes after it adds what the bridge drops
    for level, read in settled(capture):
        highest = max(highest, level)
        allowed = ABOVE * highest + SURE * math.hypot(
            channel.gain_uncertainty * level, channel.offset_uncertainty, channel.noise
        )
        if read - level > allowed:
            off = read / level - 1.0
            sized = {n: off * abs(p.value) for n, p in parameters.items() if p.value is not None}
            yield Diagnostic(
                "voltage_above_command", "warning",
                f"the terminal voltage reads {read:.3g} V where the program commands "
                f"{level:.3g} V{where}, and nothing adds to it: the voltage's scale is wrong, or "
                "that of the supply's channel by which the board sets the level, so compare both "
                "with a meter; or the board averages over part of a PWM period",
                sized,
            )  # fmt: skip
            return


def settled(capture: Capture) -> Iterator[tuple[float, float]]:
    """Each level in V, and the median of the later half of its readings; both without a sign."""
    if capture.program is None or len(capture) < FEWEST:
        return
    timeline = lay(capture)
    volts = capture.channels[VOLTAGE].values
    for part in timeline.parts:
        if part.kind != StepKind.DRIVE_VOLTS or part.decay != Decay.SYNCHRONOUS_SLOW:
            continue
        ends = ((part.start + part.stop) // 2, part.stop)
        first, last = (int(k) for k in np.searchsorted(timeline.index, ends))
        if part.level and last - first >= FEWEST:
            yield (
                abs(part.level),
                float(np.nanmedian(volts[first:last])) * math.copysign(1.0, part.level),
            )
