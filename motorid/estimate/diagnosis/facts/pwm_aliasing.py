"""Readings that see part of a PWM period: their error keeps step with the samples, or beats.

The mean over whole PWM periods is the level, whatever the phase. Over n + f periods, 0 < f < 1, a
voltage of duty d is wrong by up to

    V max(min(f, d) - f d, f d - max(0, f + d - 1)) / (n + f)

Where the sample period is a whole number of PWM periods that error is the same in every sample,
and no residual tells it from a level. The model has a current's ripple then, and no voltage's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from motorid.capture.model import VOLTAGE, Capture, Channel
from motorid.estimate.results.estimate import Diagnostic, Parameter
from motorid.estimate.signals.pwm_bridge import driven_share
from motorid.estimate.signals.time_grid import Part, lay
from motorid.program import StepKind

WHOLE = 1e-3  # of a PWM period, by which a window may miss a whole number of them
HARM = 0.01  # of a level, that a reading of it may be wrong by
SLOW_HZ = 20.0  # a beat below it looks like a level, or like a drift of one
SHIFT = 2.5  # times the relative error of the worst level: what it may do to R, L, K and J


@dataclass(frozen=True)
class Aliased:
    """The level whose reading may be most wrong: ``error_v`` of ``level_v``."""

    level_v: float
    error_v: float
    periods: float  # of the PWM, that a reading sees

    @property
    def share(self) -> float:
        """Of the level."""
        return self.error_v / self.level_v


def findings(
    capture: Capture, parameters: Mapping[str, Parameter], where: str = ""
) -> Iterator[Diagnostic]:
    """A voltage that is read over part of a PWM period. ``where``: " in run 2", or nothing."""
    found, beat_hz = aliased(capture), beat(capture)
    if found is None or found.share <= HARM or beat_hz is None:
        return
    how = "an instant" if not found.periods else f"{found.periods:.3g} periods"
    keeps = "stays the same" if beat_hz == 0.0 else f"comes and goes at {beat_hz:.2g} Hz"
    yield Diagnostic(
        "pwm_aliasing", "warning",
        f"each reading of the terminal voltage sees {how} of the {capture.wiring.pwm_hz:.6g} Hz "
        f"PWM, so that {found.level_v:.3g} V may be read {found.error_v:.2g} V wrong, and the "
        f"error {keeps} from sample to sample{where}: let the board average over whole PWM "
        "periods, or change its PWM frequency",
        moves(found, parameters),
    )  # fmt: skip


def aliased(capture: Capture) -> Aliased | None:
    """The worst driven level; None where every reading sees whole PWM periods, or nothing does."""
    channel, pwm_hz, rail = capture.get(VOLTAGE), capture.wiring.pwm_hz, capture.supply_v
    if channel is None or not pwm_hz or not rail or len(capture) < 16:
        return None
    periods = channel.window_s * pwm_hz
    if periods and abs(periods - round(periods)) <= WHOLE:
        return None
    levels = [_of_part(part, rail, channel, pwm_hz) for part in lay(capture).parts if part.level]
    return max((one for one in levels if one is not None), key=lambda a: a.share, default=None)


def _of_part(part: Part, rail: float, channel: Channel, pwm_hz: float) -> Aliased | None:
    duty, volts = driven_share(part, rail)
    level = abs(part.level) * (rail if part.kind == StepKind.DRIVE_DUTY else 1.0)
    if not 0.0 < duty < 1.0 or not level > 0:
        return None
    periods = channel.window_s * pwm_hz
    part_of_one = periods - math.floor(periods)
    below = part_of_one * duty - max(0.0, part_of_one + duty - 1.0)
    above = min(part_of_one, duty) - part_of_one * duty
    error = volts * (max(above, below) / periods if periods else max(duty, 1.0 - duty))
    if channel.filter_s:
        error = min(error, volts * duty * (1.0 - duty) / (2.0 * channel.filter_s * pwm_hz))
    return Aliased(level, error, periods)


def beat(capture: Capture) -> float | None:
    """Hz, at which samples and PWM drift past one another; 0: in step. None: too fast to matter."""
    ratio = capture.period_s * capture.wiring.pwm_hz
    miss = abs(ratio - round(ratio))
    if miss <= WHOLE * min(ratio, 1.0) / 10:
        return 0.0
    beat_hz = miss / capture.period_s
    return beat_hz if beat_hz < SLOW_HZ else None


def moves(found: Aliased, parameters: Mapping[str, Parameter]) -> dict[str, float]:
    """What it may do: friction is a small difference of voltages, and may be anything."""
    share = min(SHIFT * found.share, 1.0)
    sized = {n: share * abs(p.value) for n, p in parameters.items() if p.value is not None}
    return {n: math.inf if n in ("B", "T0") else size for n, size in sized.items()}
