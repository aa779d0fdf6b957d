"""What a weak pulse says of a bench: signs, counts, scales; each right, wrong or not to be told."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from motorid.acquire.board import Fields
from motorid.rig import Rig

Word = Literal["right", "wrong", "cannot be told"]
FAR = 0.25  # of the applied voltage, by which the terminals' reading is worth a word
SUPPLY_FAR = 0.1  # of the supply as stated
ZERO_FAR = 3.0  # standard uncertainties of a sensor's zero
MOST_DROP = 1.5  # of what a bipolar bridge is stated to drop
# A nameplate is rough, and a pulse is no calibration: what lies within these is called right.
LEAST_CURRENT, MOST_CURRENT = 0.5, 1.5  # of the current by voltage and resistance
LEAST_COUNTS, MOST_COUNTS = 0.7, 1.3  # of the voltage that the turning motor may induce
NARROW = 2.0  # bounds of that voltage, one over the other: wider ones hide a factor of 2
TURNS = 0.2  # of the applied voltage, induced: less says nothing of counts or current


@dataclass(frozen=True)
class Verdict:
    """Of one thing: the word, and what was seen; where it is not right, what to do."""

    of: str
    word: Word
    said: str

    def line(self) -> str:
        """For a person."""
        return f"{self.of:8} {self.word}: {self.said}"


def verdicts(rig: Rig, seen: Fields, constant: float | None) -> Iterator[Verdict]:
    """Of a pulse whose signs were right; ``seen``: its figures; ``constant``: the motor's (V s)."""
    yield Verdict(
        "signs",
        "right",
        f"+{seen['volts']:.3g} V brings current, voltage and counts forward "
        f"({seen['duty']:.0%} duty)",
    )
    yield _counts(rig, seen, constant)
    if seen["current_a"] is not None:
        yield _current(rig, seen)
        yield _zero(seen)
    if seen["voltage_v"] is not None:
        yield _voltage(rig, seen["volts"], seen["voltage_v"])
    if seen["supply_v"] is not None:
        yield _supply(rig, seen["supply_v"])


def _induced(seen: Fields) -> float | None:
    """V of the open terminals just after the pulse, where that is clear."""
    volts: float | None = seen.get("coast_v")
    return volts if volts is not None and volts > TURNS * _driving(seen) else None


def _driving(seen: Fields) -> float:
    """V at the motor, as read there, else as applied."""
    return float(seen["volts"] if seen["voltage_v"] is None else seen["voltage_v"])


def _counts(rig: Rig, seen: Fields, constant: float | None) -> Verdict:
    turns = seen["counts"] / rig.wiring.counts_per_turn * rig.wiring.gear_ratio
    said = f"{seen['counts']} in the pulse, {turns:.3g} turns of the motor"
    volts, rate = _induced(seen), seen.get("counts_per_s")
    if not constant or volts is None or not rate:
        lacks = "state the no-load speed (--rpm)" if not constant else "the motor hardly turned"
        return Verdict(
            "counts",
            "cannot be told",
            f"{said}; {lacks}, or look whether its shaft turned so far",
        )
    # it slows down in a coast, and induces no more than drives it
    rad_s = rate * math.tau / rig.wiring.counts_per_turn * rig.wiring.gear_ratio
    shown, most = rad_s * constant, _driving(seen)
    by_hand = (
        "turn the shaft once by hand and count; wiring.counts_per_turn is "
        f"{rig.wiring.counts_per_turn:g}"
    )
    if not LEAST_COUNTS * volts <= shown <= MOST_COUNTS * most:
        return Verdict(
            "counts",
            "wrong",
            f"{said}; at that speed the motor induces {shown:.2g} V by its label, and it was "
            f"{volts:.2g} to {most:.2g} V: {by_hand}",
        )
    if most > NARROW * volts:
        return Verdict("counts", "cannot be told", f"{said}, and friction slows it: {by_hand}")
    return Verdict("counts", "right", f"{said}, as the voltage that it induces has it")


def _current(rig: Rig, seen: Fields) -> Verdict:
    """By what the resistance allows: it starts at that, and the turning motor takes less."""
    mean, peak = seen["current_a"], seen["peak_a"]
    said = f"{mean:.3g} A while driving, {peak:.3g} A at most"
    stated = rig.nameplate.resistance_ohm
    if not stated:
        return Verdict(
            "current",
            "cannot be told",
            f"{said}; state the motor's resistance by a meter (--resistance)",
        )
    volts, ohm = seen["voltage_v"], stated
    if volts is None:  # not read at the motor
        volts = max(seen["volts"] - rig.wiring.bridge_drop_v, 0.0)
        ohm += rig.wiring.bridge_resistance_ohm + rig.wiring.lead_resistance_ohm
    most, induced = volts / ohm, _induced(seen)
    least = (volts - induced) / ohm if induced is not None else 0.0
    allowed = f"{volts:.3g} V at {ohm:.3g} ohm give {most:.3g} A"
    do = (
        "check the sensor's volts per ampere (the front end's facts), and the resistance at the "
        "motor's terminals"
    )
    if mean > MOST_CURRENT * most:
        return Verdict("current", "wrong", f"{said}, and {allowed} at most: {do}")
    if LEAST_CURRENT * most <= peak <= MOST_CURRENT * most:
        return Verdict("current", "right", f"{said}; {allowed} at the start")
    if least > TURNS * most and mean < LEAST_CURRENT * least:
        return Verdict("current", "wrong", f"{said}, and no less than {least:.3g} A flow: {do}")
    return Verdict(
        "current",
        "cannot be told",
        f"{said}; compare with a meter in the motor's line (motorid calibrate)",
    )


def _zero(seen: Fields) -> Verdict:
    said = f"the sensor reads {seen['zero_a']:.3g} A without current"
    if abs(seen["zero_a"]) <= ZERO_FAR * seen["zero_uncertainty_a"]:
        return Verdict("zero", "right", said)
    return Verdict("zero", "wrong", f"{said}, more than its facts allow: is it the right sensor?")


def _voltage(rig: Rig, applied: float, read: float) -> Verdict:
    said = f"the terminals read {read:.3g} V of {applied:.3g} V applied"
    kept, drop = applied - read, rig.wiring.bridge_drop_v
    if abs(kept) <= FAR * applied:
        return Verdict("voltage", "right", said)
    if drop and 0.0 < kept <= MOST_DROP * drop + FAR * applied:
        return Verdict("voltage", "right", f"{said}; the bridge keeps the rest")
    return Verdict("voltage", "wrong", f"{said}: check the divider, and the front end's facts")


def _supply(rig: Rig, read: float) -> Verdict:
    stated = rig.supply_voltage_v
    if not stated:
        return Verdict("supply", "cannot be told", f"{read:.3g} V; compare with a meter")
    if abs(read / stated - 1.0) <= SUPPLY_FAR:
        return Verdict("supply", "right", f"{read:.3g} V")
    return Verdict(
        "supply", "wrong", f"{read:.3g} V, not {stated:g} V as stated: check the divider"
    )
