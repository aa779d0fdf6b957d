"""The step to which a file's time stamps were rounded: by its digits, its counter, its word length.

A fixed number of decimals is one step for all stamps. Significant digits, and binary numbers of
single precision, are coarser the larger the stamp is.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DIGITS = 15  # decimal ones that a number of double precision surely holds
NOISE = 4 * float(np.finfo(np.float64).eps)  # relative, of a stamp that went through arithmetic
SINGLE = 23  # binary digits after the first of a number of single precision
COARSE_TIMER = 4.0  # times the step of the digits: from there a timer's own step can be seen
SEEN = 3  # times that each of a timer's two steps comes; a step seen less often was late
TRIED = 256  # stamps that reject a number of digits before all are looked at


def resolutions(stamps: Floats, steps: Floats) -> Iterator[Floats]:
    """What each stamp (n,) may have been rounded to (n,), in its unit, the likeliest first.

    ``steps`` are the differences between stamps that follow each other without a loss.
    """
    noise = 2 * NOISE * float(np.abs(stamps).max())
    written = _of_digits(stamps)
    yield written + noise
    _, exponent = np.frexp(np.abs(stamps))
    yield written + np.ldexp(1.0, exponent - 1 - SINGLE) + noise
    timer = _of_timer(steps, float(written.max()) + noise)
    if timer:
        yield written + timer + noise


def _of_digits(stamps: Floats) -> Floats:
    """The decimal step of each stamp (n,), or a multiple of it that all differences share."""
    large = np.abs(stamps)
    large = np.maximum(large, np.min(large, where=large > 0, initial=np.inf))  # 0 has no digits
    decade = np.floor(np.log10(large)).astype(np.intp)
    decade = np.maximum(decade, decade.max() - DIGITS)
    lowest = int(decade.min())
    count = int(decade.max()) - lowest + 1
    found = np.full(count, np.inf)
    for place in np.unique(decade):
        found[place - lowest] = _decimal_step(stamps[decade == place], int(place))
    for k in range(1, count):  # one more digit before the mark is at most one less after it
        found[k] = min(found[k], 10 * found[k - 1])
    finest = np.minimum.accumulate(found[::-1])[::-1]
    return np.asarray(np.maximum(finest[decade - lowest], _shared(stamps, float(finest.min()))))


def _shared(stamps: Floats, step: float) -> float:
    """The largest multiple of ``step`` of which all differences are multiples."""
    whole = np.rint((stamps - stamps[0]) / step)
    if np.abs(whole).max() > 10.0**DIGITS:  # no number of double precision is that exact
        return step
    return step * float(np.gcd.reduce(np.diff(whole.astype(np.int64))))


def _decimal_step(stamps: Floats, decade: int) -> float:
    """The largest power of ten of which all these stamps of one decade are multiples."""
    for digits in range(DIGITS):
        factor = 10.0 ** (digits - decade)
        if all(
            np.all(np.abs(x - np.rint(x)) <= NOISE * np.abs(x))
            for x in (stamps[:TRIED] * factor, stamps * factor)
        ):
            return float(1 / factor)
    return 10.0 ** (decade - DIGITS)


def _of_timer(steps: Floats, finest: float) -> float:
    """The step of a timer between whose counts these differences (n,) alternate; 0: none seen.

    A uniform period in counts is one whole number of them or the next.
    """
    low, high = float(steps.min()), float(steps.max())
    shorter, longer = int(np.sum(steps <= low + finest)), int(np.sum(steps >= high - finest))
    apart = high - low > COARSE_TIMER * finest and shorter + longer == len(steps)
    return high - low if apart and min(shorter, longer) >= SEEN else 0.0
