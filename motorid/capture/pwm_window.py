"""What a window over part of a PWM period does to a reading, and whether it does so every time.

The mean over whole periods is the level, whatever the phase. Over n + f periods, 0 < f < 1, a
voltage of duty d and swing V is wrong by up to

    V max(min(f, d) - f d, f d - max(0, f + d - 1)) / (n + f)
"""

from __future__ import annotations

import math

WHOLE = 1e-3  # of a PWM period, by which a window may miss a whole number of them
IN_STEP = 1e-4  # of a period: samples and PWM of one clock
SLOW_HZ = 20.0  # a beat below it looks like a level, or like a drift of one
HARM = 0.01  # of a level, that a reading of it may be wrong by


def is_whole(periods: float) -> bool:
    """Whether a window of so many PWM periods shows the level alone."""
    return periods > 0.0 and abs(periods - round(periods)) <= WHOLE


def largest_error(
    periods: float, duty: float, swing_v: float, filter_periods: float = 0.0
) -> float:
    """V by which a reading may miss the level. ``periods`` 0: it is an instant.

    ``filter_periods``: time constant of a low-pass before it, in PWM periods.
    """
    if not 0.0 < duty < 1.0 or is_whole(periods):
        return 0.0
    f = periods - math.floor(periods)
    above, below = min(f, duty) - f * duty, f * duty - max(0.0, f + duty - 1.0)
    error = swing_v * (max(above, below) / periods if periods else max(duty, 1.0 - duty))
    if filter_periods > 0.0:
        error = min(error, swing_v * duty * (1.0 - duty) / (2.0 * filter_periods))
    return error


def beat_hz(period_s: float, pwm_hz: float) -> float | None:
    """Hz, at which samples and PWM drift past one another; 0: in step. None: too fast to matter."""
    ratio = period_s * pwm_hz
    miss = abs(ratio - round(ratio))
    if round(ratio) and miss <= IN_STEP:
        return 0.0
    found = miss / period_s
    return found if round(ratio) and found < SLOW_HZ else None


def said(periods: float, pwm_hz: float, level_v: float, error_v: float, beat: float) -> str:
    """What such a window does to a voltage, as a clause."""
    sees = "an instant" if not periods else f"{periods:.3g} periods"
    keeps = "stays the same" if beat == 0.0 else f"comes and goes at {beat:.2g} Hz"
    return (
        f"each reading of the terminal voltage sees {sees} of the {pwm_hz:.6g} Hz PWM, so that "
        f"{level_v:.3g} V may be read {error_v:.2g} V wrong, and the error {keeps} from sample to "
        "sample"
    )


MEND = "let the board average over whole PWM periods, or change its PWM frequency"
