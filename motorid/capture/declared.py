"""What a person states of an imported channel: its low-pass, its delay, its readings' aperture,
its sensor's non-linearity.

Numbers are seconds; texts carry a unit: ``20Hz,2``, ``5ms``, ``128ms,around``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, cast, get_args

from motorid.capture.model import BUTTERWORTH, CURRENT, FACTS, Channel, Curve, Fact
from motorid.errors import UsageError, nearest

Given = Mapping[str, float | str]  # by quantity: seconds, or a text with a unit
Place = Literal["before", "around", "after"]

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WITH_UNIT = re.compile(rf"\s*({_NUMBER})\s*([^\W\d_]*)\s*\Z")
_SECONDS = {"": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9}
_HERTZ = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6}
LONGEST_S = 1e6  # of a delay, a filter or an aperture: beyond any capture
INSTANT = "instant"
MOST_SHARE = 0.5  # of full scale, or of a reference: beyond it nothing is measured
_AHEAD = {"before": 0.0, "around": 0.5, "after": 1.0}  # share of an aperture behind its stamp


@dataclass(frozen=True)
class LowPass:
    """``time_s`` of a filter of ``order`` 1 or 2; ``damping`` as of ``Channel.filter_damping``."""

    time_s: float
    order: int = 1
    damping: float = 1.0


@dataclass(frozen=True)
class Aperture:
    """A reading is the mean over ``seconds`` before, around or after its stamp; 0: an instant."""

    seconds: float
    place: Place = "before"

    @property
    def ahead_s(self) -> float:
        """How far it reaches beyond the stamp."""
        return _AHEAD[self.place] * self.seconds


@dataclass(frozen=True)
class Nonlinearity:
    """As of ``Channel``: a standard uncertainty in shares of ``full_scale``, and its course."""

    share: float = 0.0
    shape: Curve | None = None
    full_scale: float = 0.0


def duration(option: str, quantity: str, given: float | str, *, negative: bool = False) -> float:
    """Seconds. Raises UsageError on what is none, or negative unless that may be."""
    return _seconds(f"{option} {quantity}={given}", f"{option} {quantity}=1ms", given, negative)


def aperture(quantity: str, given: float | str) -> Aperture:
    """Of ``128ms``, ``128ms,around`` or ``instant``. Raises UsageError on what is none."""
    said = f"--aperture {quantity}={given}"
    width, comma, place = str(given).partition(",")
    place = place.strip()
    if width.strip() == INSTANT and not comma:
        return Aperture(0.0)
    if comma and place not in get_args(Place):
        known = get_args(Place)
        raise UsageError(
            f"{said}: {place!r} is no place of an aperture"
            f"{nearest(place, known)}; known: {', '.join(known)} (the stamp)"
        )
    seconds = _seconds(said, f"--aperture {quantity}=1ms,around", width)
    return Aperture(seconds, cast(Place, place or "before"))


def low_pass(quantity: str, given: float | str) -> LowPass:
    """Of a cut-off (−3 dB) ``20Hz`` or a time constant ``8ms``, and an order: ``20Hz,2``.

    A cut-off of second order is Butterworth's; a time constant of second order is that of each of
    two equal stages. Raises UsageError on what is none.
    """
    said = f"--filter {quantity}={given}"
    such_as = f"--filter {quantity}=20Hz, {quantity}=8ms or {quantity}=20Hz,2"
    size, comma, behind = str(given).partition(",")
    order = {"1": 1, "2": 2}.get(behind.strip() if comma else "1")
    if order is None:
        raise UsageError(
            f"{said}: {behind.strip()!r} is no order of a filter: give 1 or 2, such as {such_as}"
        )
    number, unit = _parted(said, such_as, size)
    if unit in _HERTZ:
        if not number > 0:
            raise UsageError(f"{said}: a cut-off lies above 0 Hz")
        time_s = 1.0 / (2.0 * math.pi * number * _HERTZ[unit])
        if not time_s <= LONGEST_S:
            raise UsageError(f"{said}: no capture is so long")
        return LowPass(time_s, order, BUTTERWORTH if order == 2 else 1.0)
    if not unit and number and isinstance(given, str):
        raise UsageError(f"{said}: is it Hz or seconds? Give the unit, such as {such_as}")
    return LowPass(_seconds(said, such_as, size), order)


def nonlinearity(quantity: str, given: str) -> Nonlinearity:
    """Of ``0.003,s,20``: a share of full scale, its course, the full scale (A).

    Raises UsageError on what is none, or of another quantity than the current.
    """
    said, courses = f"--nonlinearity {quantity}={given}", get_args(Curve)
    if quantity != CURRENT:
        raise UsageError(f"{said}: only the current's sensor has one")
    share, _, rest = given.partition(",")
    shape, _, full = rest.partition(",")
    found = Nonlinearity(_bare(share), cast(Curve, shape.strip()), _bare(full))
    if (
        found.shape in courses
        and 0.0 <= found.share <= MOST_SHARE
        and 0.0 < found.full_scale < math.inf
    ):
        return found
    raise UsageError(
        f"{said}: give a share of full scale, its course ({', '.join(courses)}) and the full "
        f"scale in A, such as --nonlinearity {CURRENT}=0.003,s,20"
    )


def drift(given: str) -> dict[str, float]:
    """Of ``0.001,2s``: by which share a reference may drift in a run, and over how many seconds; by
    the names of ``Wiring``.

    Raises UsageError on what is none.
    """
    said, such_as = f"--reference-drift {given}", "--reference-drift 0.001,2s"
    share, _, time = given.partition(",")
    number, seconds = _bare(share), _seconds(said, such_as, time)
    if not (0.0 <= number <= MOST_SHARE and seconds > 0.0):
        raise UsageError(f"{said}: give a share and a time above 0, such as {such_as}")
    return {"reference_drift": number, "reference_time_s": seconds}


def _bare(text: str) -> float:
    """A number without a unit; NaN where it is none."""
    found = _WITH_UNIT.match(text)
    return float(found[1]) if found is not None and not found[2] else math.nan


def _seconds(said: str, such_as: str, text: float | str, negative: bool = False) -> float:
    number, unit = _parted(said, such_as, text)
    if unit not in _SECONDS:
        raise UsageError(
            f"{said}: {unit!r} is not a unit of it{nearest(unit, _SECONDS)}: give one, such as "
            f"{such_as}"
        )
    seconds = number * _SECONDS[unit]
    if seconds < 0 and not negative:
        raise UsageError(f"{said}: give seconds, 0 or more")
    if not abs(seconds) <= LONGEST_S:
        raise UsageError(f"{said}: no capture is so long")
    return seconds


def _parted(said: str, such_as: str, text: float | str) -> tuple[float, str]:
    """A finite number and the unit behind it."""
    found = _WITH_UNIT.match(str(text))
    if found is None or not math.isfinite(float(found[1])):
        raise UsageError(f"{said}: give a number with a unit, such as {such_as}")
    return float(found[1]), found[2]


def without_early_readings(channels: Mapping[str, Channel]) -> dict[str, Channel]:
    """The same with all stamps moved to where no reading shows what comes after its own.

    A reading that was stamped early, or averages over what follows its stamp, has a delay below
    that of its filter. All channels are later by the same then, so that what each shows of the
    others' time stays as it was.
    """
    early = (channel.filter_delay_s - channel.delay_s for channel in channels.values())
    moved = max(early, default=0.0)
    if moved <= 0.0:
        return dict(channels)
    return {name: replace(c, delay_s=c.delay_s + moved) for name, c in channels.items()}


def of_old_import(channel: Channel) -> tuple[Fact, ...]:
    """What an import of a format without that record left open: facts that are 0 there."""
    stated: dict[Fact, float] = {
        "gain": channel.gain_uncertainty,
        "offset": channel.offset_uncertainty,
        "delay": channel.delay_s,
        "filter": channel.filter_s,
        "aperture": channel.aperture_s,
    }
    return tuple(fact for fact in FACTS if not stated[fact])
