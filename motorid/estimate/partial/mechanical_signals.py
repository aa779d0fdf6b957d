"""A capture without its electrical side: what drove the motor, and how it turned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, HELD, POSITION, SPEED, TORQUE, VOLTAGE, Capture, Channel
from motorid.errors import DataError
from motorid.estimate.signals.neighbour_noise import neighbour_noise

Floats = NDArray[np.float64]

COMMAND = "command"
COASTING = "nothing"  # no drive is measured: there must be none
DRIVES = (TORQUE, CURRENT, VOLTAGE, COMMAND)  # what the balance is written in, best first
STANDSTILL = 0.01  # of the top speed: below it, friction's sign is not trusted
NOISES = 3.0  # speeds within so many standard deviations of zero may be standstill
QUANTA = 2.0  # and speeds within so many steps of the sensor
JUMPS = 5.0  # standard deviations of a second difference, beyond which the drive jumps or bends
FEWEST_SAMPLES = 8  # in a stretch of motion
PAUSE = 5.0  # usual periods without a reading that part what lies before from what lies after
SMOOTHING = 0.25  # of a bump's half-width: the span over which a position becomes a speed


@dataclass(frozen=True)
class Stretch:
    """Samples ``start`` to ``stop`` (exclusive) in which the motor turns one way."""

    start: int
    stop: int
    sign: int

    @property
    def slice(self) -> slice:
        """The stretch's samples."""
        return slice(self.start, self.stop)


@dataclass(frozen=True)
class Motion:
    """What a momentum balance needs of one capture, at the motor's shaft.

    ``time_s`` and ``drive`` have shape (n,); ``turned`` (n − 1,) is the angle from each sample to
    the next. Samples at which ``broken`` (n − 1,) is true are not joined to the next: a gap.
    ``drive_late_s``: by how much the drive acts later than straight lines between its readings.
    """

    time_s: Floats
    drive: Floats
    turned: Floats
    measured_speed: Floats | None  # (n,), or None: from position
    broken: NDArray[np.bool_]
    drive_name: str
    drive_unit: str
    linear: bool
    unsigned: bool
    speed_quantum: float  # of measured_speed
    angle_quantum: float  # of the position, where no speed was measured
    drive_quantum: float
    aperture_s: float  # the longest that went into either side
    drive_late_s: float = 0.0

    @cached_property
    def middle_s(self) -> Floats:
        """Midpoints between samples, shape (n − 1,)."""
        return (self.time_s[1:] + self.time_s[:-1]) / 2

    @cached_property
    def top_speed(self) -> float:
        """The usual highest speed, robust against single outliers."""
        return float(np.percentile(np.abs(self.speed(self.period_s * 16)), 99))

    @cached_property
    def period_s(self) -> float:
        """The usual sample period."""
        return float(np.median(np.diff(self.time_s)))

    def speed(self, half_width_s: float) -> Floats:
        """Speed at the samples, shape (n,): measured, or position's slope over a short span."""
        if self.measured_speed is not None:
            return self.measured_speed
        reach = max(round(SMOOTHING * half_width_s / self.period_s / 2), 1)
        angle = np.r_[0.0, np.cumsum(self.turned)]
        index = np.arange(len(angle))
        low, high = np.maximum(index - reach, 0), np.minimum(index + reach, len(angle) - 1)
        return np.asarray((angle[high] - angle[low]) / (self.time_s[high] - self.time_s[low]))

    def inertia_noise(self, half_width_s: float) -> float:
        """Standard deviation that the motion's noise gives the inertia's regressor in one row.

        From ∫φ'² = π²/(4h) and ∫φ''² = π⁴/(4h³) over ∫φ² = 3h/4, for white noise of the readings.
        """
        times = np.pi / half_width_s
        if self.measured_speed is not None:
            sigma = max(noise(self.measured_speed), self.speed_quantum / np.sqrt(12.0))
        else:
            sigma = noise(np.r_[0.0, np.cumsum(self.turned)])
            sigma, times = max(sigma, self.angle_quantum / np.sqrt(12.0)), times**2
        return float(sigma * times * np.sqrt(self.period_s / 3.0))

    @cached_property
    def drive_noise(self) -> float:
        """Standard deviation of the drive's readings, rounding and all."""
        return float(max(noise(self.drive), self.drive_quantum / np.sqrt(12.0)))

    def jumps_variance(self, half_width_s: float) -> float:
        """Variance that a row of the balance has because nobody knows when between two readings the
        drive jumped. A jump anywhere in an interval spreads its integral by the jump times the
        interval over √12.
        """
        bend = np.abs(np.diff(self.drive, 2))
        bend[bend < JUMPS * np.sqrt(6.0) * self.drive_noise] = 0.0
        jump = np.minimum(np.r_[0.0, bend], np.r_[bend, 0.0])  # (n − 1,): it bends at both ends
        stretches = self.stretches(half_width_s)
        inside = [slice(s.start, s.stop - 1) for s in stretches]
        step = np.diff(self.time_s)
        spread = sum(float(((jump[one] * step[one]) ** 2).sum()) for one in inside) / 12.0
        length = sum(float(step[one].sum()) for one in inside)
        return spread / length if length else 0.0

    def stretches(self, half_width_s: float) -> list[Stretch]:
        """Where the motor surely turns, split at standstill, reversal and gaps."""
        speed = self.speed(half_width_s)
        least = max(STANDSTILL * self.top_speed, NOISES * noise(speed), QUANTA * self.speed_quantum)
        signs = np.where(np.abs(speed) > least, np.sign(speed), 0).astype(np.int64)
        cuts = np.flatnonzero((np.diff(signs) != 0) | self.broken) + 1
        edges = np.r_[0, cuts, len(signs)]
        return [
            Stretch(int(a), int(b), int(signs[a]))
            for a, b in pairwise(edges)
            if signs[a] and b - a >= FEWEST_SAMPLES
        ]


def noise(values: Floats) -> float:
    """Standard deviation of a signal's sample-to-sample noise, from its second differences."""
    return neighbour_noise(values) if len(values) >= 8 else 0.0


def drive_of(channels: Mapping[str, Channel]) -> str | None:
    """Which channel the balance is written in: torque, current, volts or command; or None."""
    return next((name for name in DRIVES if name in channels), None)


def output_of(capture: Capture) -> Channel | None:
    """The motion: a speed where there is one, else a position."""
    return capture.get(SPEED) or capture.get(POSITION)


def stands_still(capture: Capture) -> bool:
    """Whether speed or position is measured and never changes."""
    output = output_of(capture)
    return output is not None and not np.nanmax(np.abs(np.diff(output.values)), initial=0.0)


def of_capture(capture: Capture, drive: str) -> Motion:
    """The motion in ``capture``, driven by its channel ``drive``.

    Averages over an aperture are matched: the drive is averaged as the speed was, and the speed as
    the drive was, so that both sides of the balance went through the same filter. Raises DataError
    where a channel is missing, does not change, or is linear beside an angular one.
    """
    output = output_of(capture)
    none = Channel(drive, "", np.zeros(len(capture)))
    source = none if drive == COASTING else capture.get(drive)
    name = capture.path or "the capture"
    if source is None or output is None:
        raise DataError(f"{name} lacks {drive if source is None else 'speed and position'}")
    good = np.isfinite(source.values) & np.isfinite(output.values) & ~source.saturated
    time, gear = capture.time_s, capture.wiring.gear_ratio
    if good.sum() < 2 * FEWEST_SAMPLES:
        raise DataError(f"{name} holds {good.sum()} usable samples: capture a longer run")
    linear = output.unit in ("m", "m/s")
    if drive == TORQUE and linear != (source.unit == "N"):
        raise DataError(f"{name}: {source.unit} drives {output.unit}: map both linear or both not")
    if stands_still(capture):
        raise DataError(f"{name}: {output.name} never changes, so nothing can be fitted")
    kept = fresh(np.flatnonzero(good), output, capture.provenance.get(HELD, {}))
    stamps = time[kept]
    steps = np.diff(stamps)
    broken = steps > PAUSE * float(np.median(steps))
    values = output.values[kept] * gear
    shifted = _shifted(stamps, values, output.delay_s - source.delay_s)
    averaged = _averaged(stamps, shifted, source.aperture_s)
    turned = np.diff(averaged)
    speed = None
    if output.name == SPEED:
        speed = averaged
        turned = (averaged[1:] + averaged[:-1]) / 2 * np.diff(stamps)
    return Motion(
        time_s=stamps,
        drive=_averaged(stamps, source.values[kept], output.aperture_s),
        turned=turned,
        measured_speed=speed,
        broken=broken,
        drive_name=drive,
        drive_unit=source.unit,
        linear=linear,
        unsigned=source.unsigned,
        speed_quantum=output.resolution * gear if output.name == SPEED else 0.0,
        angle_quantum=output.resolution * gear if output.name == POSITION else 0.0,
        drive_quantum=source.resolution,
        aperture_s=max(source.aperture_s, output.aperture_s),
    )


def fresh(kept: NDArray[np.intp], output: Channel, held: Mapping[str, int]) -> NDArray[np.intp]:
    """Of a channel that repeats each reading, the samples at which a reading is new."""
    period = int(held.get(output.name, 1))
    if period < 2:
        return kept
    changes = np.flatnonzero(np.diff(output.values)) + 1
    phase = int(np.bincount(changes % period).argmax())
    return kept[np.flatnonzero(kept % period == phase)]


def _shifted(time: Floats, values: Floats, delay_s: float) -> Floats:
    """The signal as if read ``delay_s`` less late."""
    return np.interp(time + delay_s, time, values) if delay_s else values


def _averaged(time: Floats, values: Floats, aperture_s: float) -> Floats:
    """Mean over the ``aperture_s`` before each sample, of the signal joined by straight lines."""
    if not aperture_s:
        return values
    steps = np.diff(time)
    integral = np.r_[0.0, np.cumsum(steps * (values[1:] + values[:-1]) / 2)]
    begins = time - aperture_s
    early = np.maximum(time[0] - begins, 0.0) * values[0]
    begins = np.maximum(begins, time[0])
    k = np.searchsorted(time[1:-1], begins, side="right")  # the line on which it begins
    since = begins - time[k]
    before = integral[k] + since * (values[k] + since * (np.diff(values) / steps)[k] / 2)
    return np.asarray((integral - before + early) / aperture_s)
