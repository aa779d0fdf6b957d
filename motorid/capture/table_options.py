"""What a person may say of a foreign table beside its columns, checked before anything is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, get_args

import numpy as np

from motorid.capture import declared
from motorid.capture.csv_marks import GROUPERS
from motorid.capture.declared import Given, Nonlinearity
from motorid.capture.mapping import SHORTHAND, ChannelMap
from motorid.capture.model import FACTS, POSITION, Channel, Fact, Sense, Stated
from motorid.capture.units import LINEAR
from motorid.errors import UsageError, nearest

_NO_SEPARATOR = "\"'\r\n\0+-.0123456789eE"  # what cells or lines are made of


@dataclass(frozen=True)
class TableOptions:
    """What a person knows of a file beyond its columns. Seconds and SI units."""

    aperture: Given = field(default_factory=dict)  # s before the stamp, or "128ms,around"
    delay: Given = field(default_factory=dict)  # s, or "1ms"; below 0 where the stamp is late
    delay_uncertainty: Given = field(default_factory=dict)  # standard, s, or "20us"
    filter: Given = field(default_factory=dict)  # "20Hz", "8ms", "20Hz,2"
    gain_uncertainty: Mapping[str, float] = field(default_factory=dict)  # standard, relative
    offset_uncertainty: Mapping[str, float] = field(default_factory=dict)  # standard, SI
    nonlinearity: Mapping[str, str] = field(default_factory=dict)  # of the current: "0.003,s,20"
    constants: Mapping[str, float] = field(default_factory=dict)  # names that maps may use
    unsigned: Sequence[str] = ()  # quantities that the file holds as magnitudes
    separator: str | None = None
    decimal: str | None = None
    thousands: str | None = None  # the mark between groups of three digits
    missing: Sequence[float] = ()  # marks for "missing"; a reading of any is left out
    drop_bad: bool = False
    counts_per_turn: float = 0.0
    gear_ratio: float = 1.0
    sense: str = "terminals"  # of the voltage
    bridge_resistance: float = 0.0  # ohm between a commanded or supply voltage and the motor
    bridge_resistance_uncertainty: float = 0.0  # standard
    eccentricity: float = 0.0  # rad, amplitude of the encoder's error once a turn
    reference_drift: str = ""  # of the converters in a run, standard: "0.001,2s"
    start_s: float = -np.inf  # of the file's own time
    stop_s: float = np.inf
    ambient_c: float | None = None
    ambient_uncertainty_c: float = 0.0  # standard
    stated: Stated = field(default_factory=Stated)  # of the motor
    serial: str = ""
    note: str = ""
    notes: Sequence[str] = ()  # of how the options came about, kept with the import's own


def insist_options(chosen: TableOptions, mapped: Mapping[str, ChannelMap]) -> None:
    """Raises UsageError for an option of a quantity that is not mapped, or out of its range."""
    texts = {
        "--aperture": chosen.aperture,
        "--delay": chosen.delay,
        "--delay-uncertainty": chosen.delay_uncertainty,
        "--filter": chosen.filter,
        "--nonlinearity": chosen.nonlinearity,
    }
    for option, given in texts.items():
        for name in given:
            _insist_mapped(option, name, mapped)
    named: list[tuple[str, Mapping[str, float], str]] = [
        ("--gain-uncertainty", chosen.gain_uncertainty, "a relative standard uncertainty"),
        ("--offset-uncertainty", chosen.offset_uncertainty, "a standard uncertainty in SI units"),
        ("--unsigned", dict.fromkeys(chosen.unsigned, 0.0), ""),
    ]
    for option, quantities, what in named:
        for name, number in quantities.items():
            _insist_mapped(option, name, mapped)
            if not 0 <= number < np.inf:
                raise UsageError(f"{option} {name}={number:g}: give {what}, 0 or more")
    turns = POSITION in mapped and mapped[POSITION].unit.si not in LINEAR
    if chosen.eccentricity and not turns:
        raise UsageError("--eccentricity is of an encoder, and no angle is mapped: leave it out")
    separator, decimal = chosen.separator, chosen.decimal
    if separator is not None and (
        len(separator) != 1 or not separator.isascii() or separator in _NO_SEPARATOR
    ):
        raise UsageError(
            f"--separator {separator!r}: give one ASCII character, such as ';' or a tab"
        )
    if decimal not in (None, ".", ","):
        raise UsageError(f"--decimal {decimal!r} is neither '.' nor ','")
    if separator is not None and separator == decimal:
        raise UsageError(f"--separator and --decimal are both {separator!r}: they must differ")
    if chosen.thousands is not None:
        _insist_thousands(chosen.thousands, separator, decimal)
    if chosen.sense not in get_args(Sense):
        raise UsageError(f"--sense {chosen.sense!r} is none of {', '.join(get_args(Sense))}")


def _insist_thousands(mark: str, separator: str | None, decimal: str | None) -> None:
    if len(mark) != 1 or mark not in GROUPERS:
        raise UsageError(f"--thousands {mark!r} is none of . , _ ' and a blank")
    for option, other in (("--separator", separator), ("--decimal", decimal)):
        if mark == other:
            raise UsageError(f"{option} and --thousands are both {mark!r}: they must differ")


def _insist_mapped(option: str, name: str, mapped: Mapping[str, ChannelMap]) -> None:
    if SHORTHAND.get(name, name) not in mapped:
        raise UsageError(f"{option} {name}: no such map{nearest(name, mapped)}")


def as_stated(channel: Channel, chosen: TableOptions, *, counted: bool = False) -> Channel:
    """The channel with the facts that options state of it, and which of them none does.

    ``counted``: its readings are an encoder's counts, whose gain --counts-per-turn states.
    """

    def given(option: Mapping[str, Any]) -> Any:
        return {SHORTHAND.get(name, name): one for name, one in option.items()}.get(channel.name)

    name, doubt = channel.name, given(chosen.delay_uncertainty)
    curve = given(chosen.nonlinearity)
    bent = declared.nonlinearity(name, curve) if curve else Nonlinearity()
    by_fact: dict[Fact, Any] = {
        "gain": given(chosen.gain_uncertainty) if not counted else 0.0,
        "offset": given(chosen.offset_uncertainty),
        "delay": given(chosen.delay),
        "filter": given(chosen.filter),
        "aperture": given(chosen.aperture),
    }
    mean = declared.aperture(name, by_fact["aperture"] or 0.0)
    smooth = declared.low_pass(name, by_fact["filter"] or 0.0)
    late_s = declared.duration("--delay", name, by_fact["delay"] or 0.0, negative=True)
    found = replace(
        channel,
        kind="mean" if mean.seconds else "instant",
        aperture_s=mean.seconds,
        delay_s=late_s - mean.ahead_s,
        delay_uncertainty_s=declared.duration("--delay-uncertainty", name, doubt or 0.0),
        gain_uncertainty=given(chosen.gain_uncertainty) or 0.0,
        offset_uncertainty=by_fact["offset"] or 0.0,
        filter_s=smooth.time_s,
        filter_order=smooth.order,
        filter_damping=smooth.damping,
        nonlinearity=bent.share,
        nonlinearity_shape=bent.shape,
        full_scale=bent.full_scale,
        undeclared=tuple(fact for fact in FACTS if by_fact[fact] is None),
    )
    return replace(found, delay_s=found.delay_s + found.filter_delay_s)


def stated_options(chosen: TableOptions) -> dict[str, dict[str, float | str]]:
    """What options say of channels, as it was given: for the record."""
    said: dict[str, Given] = {
        "aperture": chosen.aperture,
        "delay": chosen.delay,
        "delay_uncertainty": chosen.delay_uncertainty,
        "filter": chosen.filter,
        "gain_uncertainty": chosen.gain_uncertainty,
        "offset_uncertainty": chosen.offset_uncertainty,
        "nonlinearity": chosen.nonlinearity,
    }
    return {option: dict(given) for option, given in said.items() if given}
