"""The response of a motor with more than six parameters, read as ``Response`` reads.

Compiled from wide.c, whose header has the equations. A term that is zero costs nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.motor._response import ffi, lib
from motorid.motor.reading import Output, Stretch
from motorid.motor.response import Floats, Response
from motorid.motor.tally import Tally

SIX = ("R", "L", "K", "B", "J", "T0")
NAMES = (
    *SIX,
    "emf", "brush", "brush_current", "quadratic", "asymmetry", "stiction", "stribeck",
    "cogging", "cogging_per_turn", "k_ripple", "r_ripple", "ripple_per_turn",
    "warming", "cooling", "load_inertia", "stiffness", "damping", "load_friction",
    "reaction", "reaction_bend", "saturation", "saturation_current", "eddy", "eddy_time",
)  # fmt: skip
"""Fields of ``mw_motor`` in order: the six, then what is added, each 0 where it is not wanted."""
START = ("current", "speed", "position", "warmth", "cogging_phase", "ripple_phase")
"""Fields of ``mw_start`` in order: A, rad/s, rad, relative rise of R, rad, rad."""
AT_REST = (0.0,) * len(START)
TOLERANCE = 3e-6  # of the largest current and speed, in an interval


class WideResponse(Response):
    """``Response`` for motors of ``NAMES`` and states of ``START``.

    Steps within an interval are those of the last ``plan``, so that the readings are a smooth
    function of the motor; before any, one step an interval. ``angle`` (count,), rad: the rotor's
    at every tick, where it is known better than by the model; cogging and ripple follow it.
    """

    def __init__(
        self,
        period_s: float,
        voltage_v: Floats,
        outputs: Sequence[Output],
        stretches: Sequence[Stretch] = (Stretch(0),),
        pwm_period_s: float = 0.0,
    ) -> None:
        super().__init__(period_s, voltage_v, outputs, stretches, pwm_period_s)
        self._wide = ffi.new("mw_motor *")
        self._start = ffi.new("mw_start *")
        self.levels: NDArray[np.uint8] = np.zeros(self.count, dtype=np.uint8)
        self.angle: Floats | None = None

    def _take(self, motor: Sequence[float] | Floats, initial: Sequence[float]) -> None:
        _fill(self._wide, motor, len(NAMES))
        _fill(self._start, initial, len(START))

    def _known_angle(self) -> Any:
        if self.angle is None:
            return ffi.NULL
        if self.angle.shape != (self.count,):
            raise ValueError(f"{self.angle.shape} angles for {self.count} ticks")
        if self.angle.dtype != np.float64 or not self.angle.flags.c_contiguous:
            raise ValueError("the angles are not an array of 64-bit floats without gaps")
        return ffi.from_buffer("double[]", self.angle)

    def _levels(self) -> Any:
        levels = self.levels
        if levels.shape != (self.count,) or levels.dtype != np.uint8:
            raise ValueError(
                f"levels are {levels.shape} of {levels.dtype}, not {self.count} of uint8"
            )
        return ffi.from_buffer("unsigned char[]", levels, require_writable=True)

    def plan(
        self,
        motor: Sequence[float] | Floats,
        initial: Sequence[float] = AT_REST,
        tolerance: float = TOLERANCE,
    ) -> None:
        """Choose each interval's steps for such a motor: 1, 2, 4 .. 64 of them."""
        self._take(motor, initial)
        events = lib.mw_plan(
            self._wide, self.period_s, self.pwm_period_s, self.count, self._voltage_c,
            self._stretches, len(self._stretches), self._start, self._known_angle(), tolerance,
            self._levels(),
        )  # fmt: skip
        _refuse(events, motor)

    def __call__(
        self, motor: Sequence[float] | Floats, initial: Sequence[float] = AT_REST
    ) -> Floats:
        """Readings, shape (outputs, n), for ``motor`` by ``NAMES``, ``initial`` by ``START``.

        Raises ValueError when R or J is not positive, L negative, or a term lacks its scale.
        """
        Tally.responses += 1
        self._take(motor, initial)
        readings = np.empty((self._n_outputs, self.count))
        events = lib.mw_response(
            self._wide, self.period_s, self.pwm_period_s, self.count, self._voltage_c,
            self._stretches, len(self._stretches), self._start, self._outputs, self._n_outputs,
            self._levels(), self._known_angle(),
            ffi.cast("double *", ffi.from_buffer(readings)), self._work_c,
        )  # fmt: skip
        _refuse(events, motor)
        self.weigh(events)
        return readings


def _fill(structure: Any, values: Sequence[float] | Floats, count: int) -> None:
    """Write a structure of so many doubles."""
    if len(values) != count:
        raise ValueError(f"{len(values)} values for {count} fields")
    ffi.cast("double *", structure)[0:count] = [float(v) for v in values]


def _refuse(events: int, motor: Sequence[float] | Floats) -> None:
    if events < 0:
        given = ", ".join(f"{n}={v:g}" for n, v in zip(NAMES, motor, strict=True) if v)
        raise ValueError(f"no response exists for {given}")
