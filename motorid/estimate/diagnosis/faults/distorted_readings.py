"""A channel that shows another figure by how large it is, by its sign, or by how it came there.

A sensor may bend, have another gain in its low range or for one sign, stay behind by the hysteresis
of its core, warm by what it measures, settle slowly, or drift. Each is put to the data as a change
of what the channel shows.

Readings tell that two gains of a channel differ, not which of them is the true one. A gain that is
off by a share takes R and L with it, B, J and T0 the other way: so much of them is in doubt.
A reference that falls with the current is right where none flows, and a dead band leaves the gain
as it is: their sizes are estimated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE
from motorid.estimate.diagnosis.fault import (
    Effect,
    Hypothesis,
    Words,
    acting,
    changed_voltage,
    highest,
    series,
    short,
    showing,
    word,
)
from motorid.estimate.effects.brush_and_heating import DROP
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.reading.speed_dead_band import SPEED_DEAD_BAND, swallowed
from motorid.estimate.effects.source.reference_sag import REFERENCE_SAG
from motorid.estimate.fit.block_regression import Size
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.signals.time_grid import IRREGULAR

Floats = NDArray[np.float64]
Shown = Callable[[Floats, Floats, float], Floats]
"""What a channel shows of a course (count,) for a size, by ticks of so many s."""

UNITS = {CURRENT: "A", SPEED: "rad/s", VOLTAGE: "V"}
BY_GAIN = {  # powers of a gain that are in the parameters, of either sign
    CURRENT: {"R": 1, "L": 1, "B": 1, "J": 1, "T0": 1},
    SPEED: {"K": 1, "T0": 1, "B": 2, "J": 2},
    VOLTAGE: {"R": 1, "L": 1, "K": 1, "B": 1, "J": 1, "T0": 1},
}
WIDTHS = (0.0003, 0.001, 0.003, 0.01, 0.03)  # of the highest reading: hysteresis to begin with
RANGES = (0.01, 0.02, 0.04, 0.08, 0.15, 0.3, 0.5)  # of it: where a low range may end
TIMES_S = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # in which a shunt may warm, or a sensor settle
SOME = 0.01  # of a gain, or of the highest reading
DEAD = 0.003  # of the highest reading: a dead band to begin with
MOST = 1.2  # of a gain: a channel that shows nothing below, or of one sign, is none of its ends
SHORTEST = 1e-2  # samples: at once
LOSSY = 0.05  # of the highest voltage: brushes that drop more bend a little as a voltage may
SAG = 0.3  # of a reference, at the highest current: more, and no converter worked
WIDEST, LONGEST = 0.5, 2.0  # of the highest reading; of the longest time tried


@dataclass(frozen=True)
class Distortion:
    """What a channel whose highest reading is ``peak`` may do to its readings.

    ``sizes`` of a peak are tried first, within ``bounds``. ``of_gain``: the first of a size is a
    share of a gain. ``quantity``: by which a fit takes it among its unknowns.
    """

    code: str
    shown: Shown
    sizes: Callable[[float], tuple[Size, ...]]
    bounds: Callable[[float], tuple[Size, Size]]
    evidence: Callable[[str, Floats, float], str]
    action: str
    of_gain: bool = True
    quantity: InfluenceQuantity | None = None


def hysteresis(y: Floats, size: Floats, _: float) -> Floats:
    """(count,) behind a play of ``size[0]`` either way, which begins in its middle at zero."""
    play, out, last = abs(size[0]), np.empty_like(y), 0.0
    for k, value in enumerate(y.tolist()):
        last = min(max(last, value - play), value + play)
        out[k] = last
    return out


def low_range(y: Floats, size: Floats, _: float) -> Floats:
    """(count,) with another gain, by a share ``size[0]``, below ``size[1]``."""
    return np.where(np.abs(y) < size[1], (1.0 + size[0]) * y, y)


def one_sign(y: Floats, size: Floats, _: float) -> Floats:
    """(count,) with another gain below zero, by a share ``size[0]``."""
    return np.where(y < 0.0, (1.0 + size[0]) * y, y)


def bent(y: Floats, size: Floats, _: float) -> Floats:
    """(count,) that departs by a share ``size[0]`` at its highest, as its cube."""
    share = float(size[0])
    return y * (1.0 + share * (y / max(float(np.abs(y).max()), 1e-300)) ** 2)


def warming(y: Floats, size: Floats, period_s: float) -> Floats:
    """(count,) with a gain that rises by a share ``size[0]`` as what y² heats is at its warmest,
    in a time of ``size[1]`` s.
    """
    heat = _lagging(y**2, size[1], period_s)
    return np.asarray(y * (1.0 + size[0] * heat / max(float(heat.max()), 1e-300)))


def settling(y: Floats, size: Floats, period_s: float) -> Floats:
    """(count,) of which a share ``size[0]`` comes late, by a low-pass of ``size[1]`` s."""
    return y + float(size[0]) * (_lagging(y, size[1], period_s) - y)


def _lagging(y: Floats, time_s: float, period_s: float) -> Floats:
    """(count,) behind a low-pass of first order, from rest.

    1 / (1 - p/z) is the product of 1 + p/z, 1 + (p/z)², 1 + (p/z)⁴ and so on.
    """
    pole = float(np.exp(-period_s / max(time_s, SHORTEST * period_s)))
    behind = (1.0 - pole) * y
    late = 1
    while late < len(y) and pole:
        behind[late:] = behind[late:] + pole * behind[:-late]
        pole, late = pole * pole, 2 * late
    return behind


def changing(y: Floats, size: Floats, _: float) -> Floats:
    """(count,) with a gain that has changed by a share ``size[0]`` at the end."""
    return y * (1.0 + float(size[0]) * np.linspace(0.0, 1.0, len(y)))


def drifting(y: Floats, size: Floats, _: float) -> Floats:
    """(count,) with a zero that has moved by ``size[0]`` at the end."""
    return y + float(size[0]) * np.linspace(0.0, 1.0, len(y))


BENT = Distortion(
    "bent", bent, lambda peak: ((SOME,),), lambda peak: ((-0.5,), (0.5,)),
    lambda unit, size, peak: f"at {peak:.3g} {unit} it shows {1.0 + size[0]:.3g} times what its "
    "gain at small readings gives",
    "calibrate it at several levels up to the highest",
)  # fmt: skip
HYSTERESIS = Distortion(
    "hysteresis", hysteresis, lambda peak: tuple((w * peak,) for w in WIDTHS),
    lambda peak: ((0.0,), (WIDEST * peak,)),
    lambda unit, size, peak: f"it stays {size[0]:.3g} {unit} behind on the way up and down, as a "
    "sensor with hysteresis",
    "degauss its core, or take a shunt", of_gain=False,
)  # fmt: skip
LOW_RANGE = Distortion(
    "low_range", low_range, lambda peak: tuple((SOME, share * peak) for share in RANGES),
    lambda peak: ((-MOST, 0.2 * RANGES[0] * peak), (MOST, peak)),
    lambda unit, size, peak: f"below {size[1]:.3g} {unit} it shows {1.0 + size[0]:.3g} times as "
    "much as above, as another range",
    "calibrate every range, or hold it in one",
)  # fmt: skip
ONE_SIGN = Distortion(
    "one_sign", one_sign, lambda peak: ((SOME,),), lambda peak: ((-MOST,), (MOST,)),
    lambda unit, size, peak: f"below zero it shows {1.0 + size[0]:.3g} times as much as above",
    "calibrate it with both signs",
)  # fmt: skip
WARMING = Distortion(
    "warming", warming, lambda peak: tuple((SOME, tau) for tau in TIMES_S),
    lambda peak: ((-0.5, 0.2 * TIMES_S[0]), (0.5, LONGEST * TIMES_S[-1])),
    lambda unit, size, peak: f"its gain changes by {100.0 * size[0]:+.2g} % within "
    f"{size[1]:.2g} s, as of a shunt that warms",
    "take a shunt of more power, or of less resistance",
)  # fmt: skip
SETTLING = Distortion(
    "settling", settling, lambda peak: tuple((SOME, tau) for tau in TIMES_S),
    lambda peak: ((-0.5, 0.2 * TIMES_S[0]), (0.5, LONGEST * TIMES_S[-1])),
    lambda unit, size, peak: f"{100.0 * size[0]:.2g} % of what it shows comes late, "
    f"within {size[1]:.2g} s",
    "take a sensor that settles at once",
)  # fmt: skip
DRIFTING = Distortion(
    "drifting", drifting, lambda peak: ((SOME * peak,),), lambda peak: ((-peak,), (peak,)),
    lambda unit, size, peak: f"its zero moves by {size[0]:+.2g} {unit} from the first reading to "
    "the last", "let it warm up, and record its zero before and after the run", of_gain=False,
)  # fmt: skip
CHANGING = Distortion(
    "changing", changing, lambda peak: ((SOME,),), lambda peak: ((-0.5,), (0.5,)),
    lambda unit, size, peak: f"its gain changes by {100.0 * size[0]:+.2g} % from the first "
    "reading to the last",
    "let it warm up, and look at the reference of its converter",
)  # fmt: skip
DEAD_BAND = Distortion(
    "dead_band", lambda y, size, _: swallowed(y, float(size[0])),
    lambda peak: ((DEAD * peak,),), lambda peak: ((0.0,), (WIDEST * peak,)),
    lambda unit, size, peak: f"it shows {size[0]:.3g} {unit} less than there is, of either sign, "
    "as a tachogenerator whose brushes or rectifier keep a fixed voltage",
    SPEED_DEAD_BAND.remedy, of_gain=False, quantity=SPEED_DEAD_BAND,
)  # fmt: skip
OF = {
    CURRENT: (BENT, HYSTERESIS, LOW_RANGE, ONE_SIGN, WARMING, SETTLING, DRIFTING, CHANGING),
    SPEED: (BENT, LOW_RANGE, DEAD_BAND),
    VOLTAGE: (BENT, SETTLING, CHANGING),
}


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """Those of the current, of a measured speed, and of a voltage that is read throughout.

    None of logs with irregular stamps: nobody knows what their voltage did between readings.
    """
    if any(r.sensed.waveform is not None and r.timeline.jitter > IRREGULAR for r in records):
        return []
    found = []
    for name, each in OF.items():
        peak = max((_peak(record, name) for record in records), default=0.0)
        if peak > 0.0:
            signed = name == VOLTAGE or any(_negative(record, name) for record in records)
            found += [_of(name, one, peak) for one in each if signed or one is not ONE_SIGN]
    return found + _sagging(records)


def _negative(record: MotorRecord, name: str) -> bool:
    """Whether a reading of that channel is below zero."""
    return any(m.block.name == name and bool((m.values < 0.0).any()) for m in record.measured)


def _sagging(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """Of boards whose converters read both: a reference that falls as the motor draws current."""
    peak = highest(records, CURRENT)
    if not peak > 0.0 or any(
        r.sensed.channel is None or r.sensed.waveform is not None for r in records
    ):
        return []
    follows = all(m.channel.ratiometric for r in records if (m := r.block(CURRENT)) is not None)
    shown = "the voltage reads" if follows else "the current and the voltage both read"

    def words(size: Floats) -> Words:
        more = 100.0 * float(size[0]) * peak
        return Words(
            "converters' reference",
            f"at {peak:.3g} A {shown} {more:.2g} % more than by the gain at no current, in "
            "proportion to the current, as of converters whose reference falls while the motor "
            "draws it",
            REFERENCE_SAG.remedy,
        )

    return [
        Hypothesis(
            "reference_sags", acting(REFERENCE_SAG), ((SOME / peak,),), (SOME / peak,), (0.0,),
            (SAG / peak,), words, quantity=REFERENCE_SAG,
        )
    ]  # fmt: skip


def _peak(record: MotorRecord, name: str) -> float:
    """The highest reading of a channel; 0: none that can be distorted."""
    if name == VOLTAGE:
        read = record.sensed.channel is not None and record.sensed.shows_emf
        top_v = float(np.abs(record.volts).max())
        return top_v if read and record.losing.get(DROP, 0.0) < LOSSY * top_v else 0.0
    return highest([record], name)


def _of(name: str, one: Distortion, peak: float) -> Hypothesis:
    def words(size: Floats) -> Words:
        told = one.evidence(UNITS[name], size, peak)
        return Words(word(name), f"the {word(name)} is distorted: {told}", one.action)

    def belongs(size: Floats) -> Mapping[str, float]:
        share = abs(float(size[0])) if one.of_gain else 0.0
        return {parameter: power * share for parameter, power in BY_GAIN[name].items()}

    sizes, (lower, upper) = one.sizes(peak), one.bounds(peak)
    effect = _read(one.shown) if name == VOLTAGE else showing(name, one.shown)
    return Hypothesis(
        f"{short(name)}_{one.code}", effect, sizes, sizes[0], lower, upper, words,
        belongs=belongs, vague=name == VOLTAGE, quantity=one.quantity,
    )  # fmt: skip


def _read(shown: Shown) -> Effect:
    """Of a voltage: what drove the motor is what is read, less its distortion. Where the bridge is
    open the back-EMF is read, with what is left of the drive.
    """

    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        drive, emf = record.volts, list(series(record, values, own, EMF))
        course = np.where(record.driven, drive, emf[0][1]) if emf else drive
        more = shown(course, size, record.timeline.period_s) - course
        taken = np.where(record.driven, more, 0.0)
        out = changed_voltage(record, values, own, drive - taken)
        for k, _ in emf:
            out[k] = out[k] + more[record.measured[k].where]
        return out

    return effect
