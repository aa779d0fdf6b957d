"""Faults of the simulated rig and of the relay, as their ``fault`` options name them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from motorid.errors import UsageError
from motorid.sim.nearest import unknown


class Kind(NamedTuple):
    """One sort of fault: the value it takes when none is given (None: it takes none)."""

    default: float | None
    doc: str


KINDS = {
    # bytes on the link, both ways; the value is a rate per byte
    "flip": Kind(1e-3, "bytes with one bit flipped"),
    "drop": Kind(1e-3, "bytes lost"),
    "insert": Kind(1e-3, "foreign bytes put in"),
    "double": Kind(1e-3, "bytes sent twice"),
    # the link as a whole
    "silence": Kind(None, "the board says nothing more and hears nothing more"),
    "deaf": Kind(None, "the board hears nothing more"),
    "mute": Kind(None, "the host hears nothing more"),
    "unplug": Kind(None, "the port is gone"),
    "delay": Kind(0.05, "every byte arrives so many seconds late, both ways"),
    "burst": Kind(0.05, "what the board says arrives in lumps, every so many seconds"),
    "split": Kind(None, "reads return a few bytes at a time"),
    "text": Kind(None, "another device, which prints lines of text"),
    "garbage": Kind(None, "another device, which sends random bytes"),
    # the board
    "major": Kind(2, "the board speaks another protocol major"),
    "reset": Kind(None, "the board's processor resets"),
    "watchdog": Kind(None, "the firmware hangs, and its watchdog resets the board"),
    "driver": Kind(None, "the bridge's driver reports a fault of its own"),
    "brownout": Kind(0.05, "supply away for so many seconds, and the processor resets"),
    "guard_open": Kind(None, "the guard opens"),
    "part_absent": Kind(None, "the motor is not in its place"),
    # the bench
    "supply": Kind(0.0, "the motor supply goes to so many volts"),
    "stall": Kind(None, "the rotor jams"),
    "encoder_reversed": Kind(None, "the encoder counts the other way"),
    "encoder_dead": Kind(None, "the encoder stops counting"),
    "encoder_drop": Kind(0.05, "share of encoder counts lost"),
    "current_dead": Kind(None, "the current sensor reads nothing but its offset"),
    "current_reversed": Kind(None, "the current sensor reads the other sign"),
    "current_saturated": Kind(None, "the current sensor reads full scale"),
    "voltage_dead": Kind(None, "the terminal voltage reads nothing but its offset"),
    "adc_stuck": Kind(None, "the converter repeats its last readings"),
}
RATES = ("flip", "drop", "insert", "double", "encoder_drop")
PASSING = ("flip", "drop", "insert", "double", "silence", "deaf", "mute", "delay", "burst", "split")


@dataclass(frozen=True)
class Fault:
    """One fault; ``at_s`` counts from the start of the first run, None: from the beginning.

    ``until_s``: when it is over again, counted likewise; None: it stays.
    """

    name: str
    value: float
    at_s: float | None
    until_s: float | None = None


def parse_faults(text: str, kinds: Mapping[str, Kind] = KINDS) -> tuple[Fault, ...]:
    """Faults of a comma-separated list of NAME[:VALUE][@SECONDS[..SECONDS]]. Raises UsageError."""
    return tuple(_parse(item.strip(), kinds) for item in text.split(",") if item.strip())


def _parse(item: str, kinds: Mapping[str, Kind]) -> Fault:
    head, at, when = item.partition("@")
    name, colon, value = head.partition(":")
    if name not in kinds:
        raise unknown(name, kinds, "fault")
    kind = kinds[name]
    if colon and kind.default is None:
        raise UsageError(f"fault {name} takes no value")
    amount = _number(item, value) if colon else (kind.default or 0.0)
    if name in RATES and not 0 <= amount <= 1:
        raise UsageError(f"fault {name} is a share between 0 and 1, not {value}")
    start, passing, end = when.partition("..")
    at_s = _number(item, start) if at else None
    until_s = _number(item, end) if passing else None
    if amount < 0 or (at_s is not None and at_s < 0):
        raise UsageError(f"fault {item!r} has a negative number")
    if until_s is not None and (name not in PASSING or at_s is None or until_s <= at_s):
        raise UsageError(f"fault {item!r} cannot end then; these pass: {', '.join(PASSING)}")
    return Fault(name, amount, at_s, until_s)


def _number(item: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if value != value or value in (float("inf"), float("-inf")):
        raise UsageError(f"fault {item!r}: {text!r} is not a number")
    return value
