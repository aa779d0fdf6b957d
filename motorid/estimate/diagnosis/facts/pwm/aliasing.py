"""Voltages that see part of a PWM period, with an error that keeps step with the samples, or beats.

Where the sample period is a whole number of PWM periods that error is the same in every sample,
and no residual tells it from a level. The model has a current's ripple then, and no voltage's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from motorid.capture.model import VOLTAGE, Capture, Channel
from motorid.capture.pwm_window import HARM, MEND, beat_hz, is_whole, largest_error, said
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.signals.source.pwm_bridge import driven_share
from motorid.estimate.signals.time_grid import Part, lay
from motorid.program import StepKind

SHIFT = 2.5  # times the relative error of the worst level: what it may do to R, L, K and J
FEWEST = 16  # samples


@dataclass(frozen=True)
class Aliased:
    """The level whose reading may be most wrong: ``error_v`` of ``level_v``."""

    level_v: float
    error_v: float

    @property
    def share(self) -> float:
        """Of the level."""
        return self.error_v / self.level_v


def findings(
    capture: Capture, parameters: Mapping[str, Parameter], where: str = ""
) -> Iterator[Diagnostic]:
    """A voltage that is read over part of a PWM period. ``where``: " in run 2", or nothing."""
    found, pwm_hz = aliased(capture), capture.wiring.pwm_hz
    if found is None or found.share <= HARM:
        return
    beat = beat_hz(capture.period_s, pwm_hz)
    if beat is not None:
        periods = capture.channels[VOLTAGE].window_s * pwm_hz
        what = said(periods, pwm_hz, found.level_v, found.error_v, beat)
        message = f"{what}{where}: {MEND}"
        yield Diagnostic("pwm_aliasing", "warning", message, moves(found, parameters))


def aliased(capture: Capture) -> Aliased | None:
    """The worst driven level; None where every reading sees whole PWM periods, or nothing does."""
    channel, pwm_hz, rail = capture.get(VOLTAGE), capture.wiring.pwm_hz, capture.supply_v
    if channel is None or not pwm_hz or not rail or len(capture) < FEWEST:
        return None
    if is_whole(channel.window_s * pwm_hz):
        return None
    levels = [_of_part(part, rail, channel, pwm_hz) for part in lay(capture).parts if part.level]
    return max((one for one in levels if one is not None), key=lambda a: a.share, default=None)


def _of_part(part: Part, rail: float, channel: Channel, pwm_hz: float) -> Aliased | None:
    duty, swing = driven_share(part, rail)
    level = abs(part.level) * (rail if part.kind == StepKind.DRIVE_DUTY else 1.0)
    error = largest_error(channel.window_s * pwm_hz, duty, swing, channel.filter_s * pwm_hz)
    return Aliased(level, error) if level > 0.0 and error > 0.0 else None


def moves(found: Aliased, parameters: Mapping[str, Parameter]) -> dict[str, float]:
    """What it may do: friction is a small difference of voltages, and may be anything."""
    share = min(SHIFT * found.share, 1.0)
    sized = {n: share * abs(p.value) for n, p in parameters.items() if p.value is not None}
    return {n: math.inf if n in ("B", "T0") else size for n, size in sized.items()}
