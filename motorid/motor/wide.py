"""The response of a motor with more than six parameters, read as ``Response`` reads.

Compiled from wide.c, whose header has the equations. A term that is zero costs nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.motor import tally
from motorid.motor._response import ffi, lib
from motorid.motor.reading import Output, Stretch
from motorid.motor.response import Floats, Response

SIX = ("R", "L", "K", "B", "J", "T0")
NAMES = (
    *SIX,
    "emf", "brush", "brush_current", "quadratic", "asymmetry", "stiction", "stribeck",
    "cogging", "cogging_per_turn", "k_ripple", "r_ripple", "ripple_per_turn",
    "warming", "cooling", "load_inertia", "stiffness", "damping", "load_friction",
    "reaction", "reaction_bend", "saturation", "saturation_current", "eddy", "eddy_time",
    "commutation", "commutation_from", "drift", "drift_rate", "drift_span",
)  # fmt: skip
"""Fields of ``mw_motor`` in order: the six, then what is added, each 0 where it is not wanted."""
START = ("current", "speed", "position", "warmth", "cogging_phase", "ripple_phase")
"""Fields of ``mw_start`` in order: A, rad/s, rad, relative rise of R, rad, rad."""
AT_REST = (0.0,) * len(START)
TOLERANCE = 3e-6  # of the largest current and speed, in an interval


LANES: int = lib.mw_lanes()
"""Motors that are computed side by side; 1 where the compiler knows no vectors."""


@dataclass(frozen=True)
class Posed:
    """A run of a response as it stood: what drove it, what its channels read, and the motor."""

    motor: Floats
    initial: tuple[float, ...]
    voltage: Floats
    stretches: Any
    outputs: Any

    @property
    def terms(self) -> bytes:
        """Which terms it has: runs of the same ones can share their steps."""
        return bytes(self.motor != 0.0)


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
        self._beside: Floats | None = None  # memory that several runs at once need

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
        tally.add(1)
        self._take(motor, initial)
        readings = np.empty((self._n_outputs, self.count))
        events = lib.mw_response(
            self._wide, self.period_s, self.pwm_period_s, self.count, self._voltage_c,
            self._stretches, len(self._stretches), self._start, self._outputs, self._n_outputs,
            self._levels(), self._known_angle(),
            ffi.cast("double *", ffi.from_buffer(readings)), self._work_c,
        )  # fmt: skip
        _refuse(events, motor)
        self.worth = self.worth_of(events)
        return readings

    def pose(self, motor: Floats, initial: Sequence[float]) -> Posed:
        """This run as it stands now, for ``several``: later changes do not touch it."""
        stretches = ffi.new("mr_stretch[]", list(self._stretches))
        outputs = ffi.new("mr_output[]", list(self._outputs))
        return Posed(np.array(motor), tuple(initial), self._voltage.copy(), stretches, outputs)

    def several(self, runs: Sequence[Posed]) -> list[tuple[Floats, int] | None]:
        """Readings (outputs, n) of these runs and what each was worth, to the same bits as one by
        one. None: a run that has no response, or is quicker by itself.
        """
        answers: list[tuple[Floats, int] | None] = [None] * len(runs)
        for places in _lanes(runs):
            for place, answer in zip(places, self._at_once([runs[k] for k in places]), strict=True):
                answers[place] = answer
        return answers

    def _at_once(self, runs: Sequence[Posed]) -> list[tuple[Floats, int] | None]:
        cases = ffi.new("mw_case[]", len(runs))
        readings = np.empty((len(runs), self._n_outputs, self.count))
        for case, run, y in zip(cases, runs, readings, strict=True):
            _fill(ffi.addressof(case, "motor"), run.motor, len(NAMES))
            _fill(ffi.addressof(case, "start"), run.initial, len(START))
            case.v = ffi.from_buffer("double[]", run.voltage)
            case.y = ffi.from_buffer("double[]", y)
            case.stretches, case.outputs = run.stretches, run.outputs
        if self._beside is None:
            self._beside = np.empty(lib.mw_lanes_work_size(self.count, self._n_outputs))
        refused = lib.mw_responses(
            len(runs), cases, self.period_s, self.pwm_period_s, self.count,
            len(self._stretches), self._n_outputs, self._levels(), self._known_angle(),
            ffi.from_buffer("double[]", self._beside),
        )  # fmt: skip
        if refused:
            return [None] * len(runs)
        tally.add(len(runs))
        return [(y, self.worth_of(case.events)) for case, y in zip(cases, readings, strict=True)]


def _lanes(runs: Sequence[Posed]) -> Iterator[list[int]]:
    """Places of runs that go side by side: of the same terms, as many as there are lanes."""
    order = sorted(range(len(runs)), key=lambda k: runs[k].terms)
    for _, alike in groupby(order, key=lambda k: runs[k].terms):
        places = list(alike)
        for first in range(0, len(places), LANES):
            some = places[first : first + LANES]
            if len(some) > 1:
                yield some


def _fill(structure: Any, values: Sequence[float] | Floats, count: int) -> None:
    """Write a structure of so many doubles."""
    if len(values) != count:
        raise ValueError(f"{len(values)} values for {count} fields")
    ffi.cast("double *", structure)[0:count] = [float(v) for v in values]


def _refuse(events: int, motor: Sequence[float] | Floats) -> None:
    if events < 0:
        given = ", ".join(f"{n}={v:g}" for n, v in zip(NAMES, motor, strict=True) if v)
        raise ValueError(f"no response exists for {given}")
