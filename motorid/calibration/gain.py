"""A channel's gain and offset from readings beside a reference: a meter, or a known resistor."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from motorid.calibration.line import fit_line
from motorid.errors import DataError, UsageError

RECTANGULAR = math.sqrt(3)  # half width of a stated limit over its standard uncertainty
FAR = 3.0  # standard uncertainties
APART = 10.0  # standard uncertainties by which levels must differ


@dataclass(frozen=True)
class Meter:
    """A reference instrument; ``of_reading`` (relative) and ``absolute`` are limits of error.

    The share of the reading moves all points of a line together, the rest each by itself.
    """

    name: str
    serial: str
    accuracy: str
    of_reading: float
    absolute: float

    @property
    def common(self) -> float:
        """Standard uncertainty, relative, that all readings share."""
        return self.of_reading / RECTANGULAR

    @property
    def apart(self) -> float:
        """Standard uncertainty of one reading, in its unit."""
        return self.absolute / RECTANGULAR


def meter(name: str, serial: str, accuracy: str) -> Meter:
    """The meter whose data sheet says ``accuracy``: ``0.5% + 0.003``, in % and in the unit.

    Raises UsageError where that cannot be read, or states no error at all.
    """
    number = r"(\d+(?:\.\d*)?(?:[eE][+-]?\d+)?)"
    found = re.fullmatch(rf"(?:{number}%)?\+?(?:{number})?", accuracy.replace(" ", ""))
    share, rest = (float(g) if g else 0.0 for g in found.groups()) if found else (0.0, 0.0)
    if not share and not rest:
        raise UsageError(
            f"accuracy {accuracy!r}: write it as the meter's data sheet does, such as 0.5%+0.003 "
            "(a share of the reading, and digits in A or V)"
        )
    return Meter(name, serial, accuracy, share / 100, rest)


@dataclass(frozen=True)
class Point:
    """One level: what the channel read and what the reference said, both in SI, u standard."""

    reading: float
    reading_uncertainty: float
    reference: float
    reference_uncertainty: float


@dataclass(frozen=True)
class Gain:
    """What multiplies the channel's scale; ``zero`` is the reading (SI) at a true zero."""

    gain: float
    uncertainty: float  # standard, relative to the gain
    zero: float
    zero_uncertainty: float
    excess: float  # how far the points scatter beyond what was stated; 1 if they do not

    def findings(self, unit: str) -> list[str]:
        """What a person should look at, in sentences."""
        said = []
        if self.excess > 2:
            said.append(
                f"the points lie {self.excess:.1f} times further from a line than their stated "
                "uncertainty explains, and it was widened by that: look for a loose contact, or a "
                "meter that was read before it had settled"
            )
        if abs(self.zero) > FAR * self.zero_uncertainty:
            said.append(
                f"the line passes zero at {self.zero:.3g} ± {self.zero_uncertainty:.2g} {unit}: "
                "the offset at rest and under load differ, or the meter has one of its own"
            )
        return said


def gain_of(points: Sequence[Point], common: float) -> Gain:
    """The gain that points at two or more levels give; ``common``: relative, of all references.

    Raises DataError where the levels are too alike, or channel and reference differ in sign.
    """
    _refuse_alike([(p.reading, p.reading_uncertainty) for p in points], "the board's readings")
    _refuse_alike([(p.reference, p.reference_uncertainty) for p in points], "the reference's")
    line = fit_line(
        [p.reading for p in points],
        [p.reference for p in points],
        [p.reading_uncertainty for p in points],
        [p.reference_uncertainty for p in points],
    )
    if line.slope <= 0:
        raise DataError("channel and reference go opposite ways: swap the meter's two leads")
    zero = -line.intercept / line.slope
    along = (
        line.intercept_uncertainty**2
        + 2 * zero * line.covariance
        + (zero * line.slope_uncertainty) ** 2
    )
    return Gain(
        gain=line.slope,
        uncertainty=math.hypot(line.excess * line.slope_uncertainty / abs(line.slope), common),
        zero=zero,
        zero_uncertainty=line.excess * math.sqrt(max(along, 0.0)) / abs(line.slope),
        excess=line.excess,
    )


def _refuse_alike(values: Sequence[tuple[float, float]], whose: str) -> None:
    """A gain from levels that differ by little more than their uncertainty is none."""
    if len(values) < 2:
        raise DataError("a gain needs readings at two different levels or more")
    spread = max(v for v, _ in values) - min(v for v, _ in values)
    if spread < APART * max(u for _, u in values):
        raise DataError(
            f"the levels are too alike to tell a gain: {whose} differ by {spread:.3g}; take levels "
            "further apart, and read the meter at each"
        )
