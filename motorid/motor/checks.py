"""Which readings and stretches a compiled response takes; it indexes memory by them.

Every function raises ValueError with one sentence. The compiled part refuses the same again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from motorid.motor.reading import Output, Stretch

MAX_OUTPUTS = 16  # response.h's
MAX_INTERVALS = 1e9  # that a reading reaches back: response.h's
VOLTS_OHMS_TIMES = ("series_ohm", "clamp_v", "duty", "swing_v", "late_s", "kick_rad_s")


def check_timing(period_s: float, pwm_period_s: float, count: int) -> None:
    """A record of ``count`` samples."""
    if not (math.isfinite(period_s) and period_s > 0.0):
        raise ValueError(f"the sample period is {period_s:g} s; it must be finite and positive")
    if not (math.isfinite(pwm_period_s) and pwm_period_s >= 0.0):
        raise ValueError(
            f"the PWM period is {pwm_period_s:g} s; give a finite one, or 0 where there is no PWM"
        )
    if count < 1:
        raise ValueError("the record has no samples; a response needs one at least")


def check_outputs(outputs: Sequence[Output], period_s: float) -> None:
    """As many as a response gives, each of them one that it can give."""
    if not 1 <= len(outputs) <= MAX_OUTPUTS:
        raise ValueError(f"{len(outputs)} outputs; a response gives 1 to {MAX_OUTPUTS}")
    for row, output in enumerate(outputs):
        check_output(row, output, period_s)


def check_output(row: int, output: Output, period_s: float) -> None:
    """One output, the ``row``-th."""
    for name in ("aperture_s", "delay_s", "filter_s"):
        value = getattr(output, name)
        if not (math.isfinite(value) and value >= 0.0):
            raise ValueError(
                f"output {row}: {name} is {value:g}; it must be finite and not negative"
            )
    if output.aperture_s + output.delay_s > MAX_INTERVALS * period_s:
        raise ValueError(
            f"output {row} reaches {output.aperture_s + output.delay_s:g} s back;"
            f" at most {MAX_INTERVALS:g} sample periods of {period_s:g} s are possible"
        )
    if output.quantity not in (0, 1, 2):
        raise ValueError(f"output {row}: there is no quantity {output.quantity}")
    if output.pwm_phase is not None and not 0.0 <= output.pwm_phase <= 1.0:
        raise ValueError(f"output {row}: pwm_phase is {output.pwm_phase:g}; it lies in 0 to 1")


def check_stretches(stretches: Sequence[Stretch], count: int) -> None:
    """In order, and over all intervals of ``count`` samples."""
    if not stretches:
        raise ValueError("there are no stretches; one at least must cover the record")
    if stretches[0].start > 1:
        raise ValueError(
            f"the first stretch starts at {stretches[0].start}; it must cover interval 1"
        )
    last = 0
    for k, s in enumerate(stretches):
        if not last <= s.start <= count:
            raise ValueError(
                f"stretch {k} starts at {s.start}; it must start between {last} and {count}"
            )
        last = s.start
        if not math.isfinite(
            s.series_ohm + s.clamp_v + s.duty + s.swing_v + s.late_s + s.kick_rad_s
        ):
            name = next(n for n in VOLTS_OHMS_TIMES if not math.isfinite(getattr(s, n)))
            raise ValueError(f"stretch {k}: {name} is {getattr(s, name):g}; it must be finite")
