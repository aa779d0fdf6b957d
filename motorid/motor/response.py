"""The motor's response to a sampled voltage, at the readings that the channels really take.

Exact between samples (matrix exponentials, friction events located inside the sample), compiled
from response.c. The voltage is the mean over each sample period; a reading is an instant or a
mean over an aperture that ends a delay before its tick.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.motor import tally
from motorid.motor._response import ffi, lib
from motorid.motor.checks import check_output, check_outputs, check_stretches, check_timing
from motorid.motor.reading import Output, Stretch

Floats = NDArray[np.float64]
AT_REST = (0.0, 0.0, 0.0)
FEW = 100, 0.005  # events, also of a response's intervals, that take no longer than the rest


class Response:
    """The readings of one record as a function of the motor. Holds its buffers: one per thread.

    ``voltage_v[n]`` (V) is the mean over the interval that ends at tick n; element 0 is not used.
    ``worth``: so many ordinary responses took as long as the last one. An absurd motor that starts
    and stops thousands of times takes hundreds of times as long.
    """

    worth = 1

    def __init__(
        self,
        period_s: float,
        voltage_v: Floats,
        outputs: Sequence[Output],
        stretches: Sequence[Stretch] = (Stretch(0),),
        pwm_period_s: float = 0.0,
    ) -> None:
        check_timing(period_s, pwm_period_s, len(voltage_v))
        check_outputs(outputs, period_s)
        self.count = len(voltage_v)
        self.period_s = period_s
        self.pwm_period_s = pwm_period_s
        self._motor = ffi.new("mr_motor *")
        self._initial = ffi.new("double[3]")
        self._given_outputs = tuple(outputs)
        self._now = list(outputs)
        self._outputs = ffi.new("mr_output[]", [_as_c(o) for o in outputs])
        self._n_outputs = len(outputs)
        self._work = np.empty(lib.mr_work_size(self.count, len(outputs)))
        self._work_c = ffi.cast("double *", ffi.from_buffer(self._work))
        self.excite(voltage_v, stretches)

    def excite(self, voltage_v: Floats, stretches: Sequence[Stretch]) -> None:
        """Take another voltage of the same length, and other stretches."""
        given = np.array(voltage_v, dtype=np.float64)
        if given.shape != (self.count,):
            raise ValueError(f"voltages of shape {given.shape} for {self.count} samples")
        check_stretches(stretches, self.count)
        self._given = given
        self._voltage = self._given.copy()
        self._voltage_c = ffi.cast("double *", ffi.from_buffer(self._voltage))
        self._stretches = ffi.new(
            "mr_stretch[]",
            [
                (
                    s.start,
                    s.open,
                    s.series_ohm,
                    s.clamp_v,
                    s.duty,
                    s.swing_v,
                    s.late_s,
                    s.kick_rad_s,
                    s.discontinuous,
                    s.still,
                )
                for s in stretches
            ],
        )

    def shift(self, volts: float | Floats) -> None:
        """Add ``volts`` to the voltage as it was given (0 takes an earlier shift back)."""
        np.add(self._given, volts, out=self._voltage)

    def kick(self, stretch: int, speed_rad_s: float) -> None:
        """The jump of speed at the start of a stretch."""
        if not 0 <= stretch < len(self._stretches):
            raise ValueError(
                f"there is no stretch {stretch}; the last is {len(self._stretches) - 1}"
            )
        self._stretches[stretch].kick = speed_rad_s

    def delay(self, row: int, late_s: float) -> None:
        """Read an output so much later than it was given (0 takes an earlier delay back).

        Raises ValueError where that is before its moment has come.
        """
        given, now = self._given_outputs[self._row(row)], self._now[row]
        output = replace(given.delayed(late_s, self.pwm_period_s), filter_s=now.filter_s)
        if output.delay_s < 0.0:
            raise ValueError(f"a reading cannot show what is {-output.delay_s:g} s ahead of it")
        self._read_as(row, output)

    def filter(self, row: int, filter_s: float) -> None:
        """Read an output through a filter of this time constant from now on; 0 takes it away.

        Raises ValueError where it is negative or not finite.
        """
        self._read_as(row, replace(self._now[self._row(row)], filter_s=filter_s))

    def _row(self, row: int) -> int:
        if not 0 <= row < self._n_outputs:
            raise ValueError(f"there is no output {row}; the last is {self._n_outputs - 1}")
        return row

    def _read_as(self, row: int, output: Output) -> None:
        check_output(row, output, self.period_s)
        self._now[row] = output
        self._outputs[row] = _as_c(output)

    def __call__(
        self,
        motor: Sequence[float] | Floats,
        initial: Sequence[float] = AT_REST,
    ) -> Floats:
        """Readings, shape (outputs, n), for ``motor`` = (R, L, K, B, J, T0) in SI units.

        ``initial`` is (current A, speed rad/s, position rad) at tick 0. Raises ValueError when
        R or J is not positive, or L negative.
        """
        if len(motor) != 6 or len(initial) != 3:
            raise ValueError(
                f"{len(motor)} parameters and {len(initial)} initial values, where 6 and 3 belong"
            )
        m = self._motor
        m.R, m.L, m.K, m.B, m.J, m.T0 = motor
        self._initial[0], self._initial[1], self._initial[2] = initial
        tally.add(1)
        readings = np.empty((self._n_outputs, self.count))
        events = lib.mr_response(
            m,
            self.period_s,
            self.pwm_period_s,
            self.count,
            self._voltage_c,
            self._stretches,
            len(self._stretches),
            self._initial,
            self._outputs,
            self._n_outputs,
            ffi.cast("double *", ffi.from_buffer(readings)),
            self._work_c,
        )
        if events < 0:
            raise ValueError(f"no response exists for R, L, K, B, J, T0 = {tuple(motor)}")
        self.worth = self.worth_of(events)
        return readings

    def worth_of(self, events: int) -> int:
        """What a response was worth, by its events: by no clock."""
        few, share = FEW
        return 1 + events // max(few, int(share * self.count))


def _as_c(o: Output) -> tuple[int, float, float, float, float]:
    """An ``mr_output``."""
    phase = -1.0 if o.pwm_phase is None else o.pwm_phase
    return o.quantity, o.aperture_s, o.delay_s, phase, o.filter_s
