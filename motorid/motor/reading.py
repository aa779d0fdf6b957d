"""What is read of a run, and what drives each stretch of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum


class Quantity(IntEnum):
    """What a reading shows; numbers are response.h's."""

    CURRENT = 0  # A
    SPEED = 1  # rad/s
    POSITION = 2  # rad


@dataclass(frozen=True)
class Output:
    """How one channel reads: ``aperture_s`` 0 is an instant (a position always is).

    ``pwm_phase``: of an instant current, fraction of the PWM period at which it is taken; None
    takes it from the time of the reading when the PWM keeps step with the samples, else no ripple.
    ``filter_s``: time constant of a low-pass filter of first order before that, as an RC before a
    converter: tau y' = x - y. It has settled upon the initial state, and sees the ripple too.
    ``delay_s`` comes after it, a pure delay.
    """

    quantity: Quantity
    aperture_s: float = 0.0
    delay_s: float = 0.0
    pwm_phase: float | None = None
    filter_s: float = 0.0

    def delayed(self, late_s: float, pwm_period_s: float) -> Output:
        """The reading with a larger delay: of an earlier moment, and so of an earlier phase."""
        phase = self.pwm_phase
        if phase is not None and pwm_period_s:
            phase = (phase - late_s / pwm_period_s) % 1.0
        return replace(self, delay_s=self.delay_s + late_s, pwm_phase=phase)


@dataclass(frozen=True)
class Stretch:
    """From interval ``start`` (the one that ends at tick ``start``) to the next stretch.

    ``series_ohm`` lies between the source of the voltage and the motor's terminals. ``open``: the
    bridge is open; ``clamp_v`` drives the current that flows then to zero (0: it is cut at once).
    ``duty`` (0 to 1) and ``swing_v`` (on level less off level) describe the PWM for its ripple.
    ``late_s``: dead time that delays the on part, of which ``duty`` is what is left.
    ``kick_rad_s``: by which a motor that turns changes its speed at the start, never its direction.
    ``discontinuous``: the current stops within every PWM period, so that its mean has no memory.
    ``still``: the rotor does not move, whatever the torque.
    """

    start: int
    open: bool = False
    series_ohm: float = 0.0
    clamp_v: float = 0.0
    duty: float = 0.0
    swing_v: float = 0.0
    late_s: float = 0.0
    kick_rad_s: float = 0.0
    discontinuous: bool = False
    still: bool = False
