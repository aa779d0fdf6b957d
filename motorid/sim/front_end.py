"""Facts of the simulated board's front end: the firmware's own, or those that a host has stored."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from motorid.sim.chain import Chain, Converter
from motorid.wire.enums import Bridge, FrontEndSource, Sensor
from motorid.wire.hashes import front_end_hash

REFERENCE_V = 4.096  # of the converters
GAIN_UNIT, ZERO_UNIT_V, FILTER_UNIT_S = 1e-5, 1e-4, 1e-7
U16 = (1 << 16) - 1
NAME_BYTES = 16
BOUNDS = {
    "reference_v": (0.5, 10.0),
    "voltage_divider": (0.1, 1e3),
    "supply_divider": (0.1, 1e3),
}
MOST_LIFT = 0.75  # of the reference
SLOPES = (1e-5, 1e3)  # V/A
Fields = dict[str, Any]


class FrontEnd:
    """What the board keeps. ``wired``: the chain as it is, which no facts change."""

    def __init__(self, wired: Chain, holds: bool) -> None:
        self._wired, self._holds = wired, holds
        self.stored: Fields | None = None

    @property
    def source(self) -> FrontEndSource:
        """Whence the facts in force are."""
        if self.stored is not None:
            return FrontEndSource.STORED
        return FrontEndSource.COMPILED if self._holds else FrontEndSource.NONE

    @property
    def hash(self) -> int:
        """Of the stored facts; 0 where none are stored."""
        return 0 if self.stored is None else front_end_hash(self.stored)

    def store(self, facts: Mapping[str, Any]) -> bool:
        """Keeps facts; False where they can be true of no front end."""
        if not is_sound(facts):
            return False
        self.stored = dict(facts)
        return True

    def facts(self) -> Fields:
        """Those in force; the firmware's own where there are none."""
        return compiled(self._wired) if self.stored is None else self.stored

    def reply(self) -> Fields:
        """Fields of the reply to read_front_end."""
        known = self.facts()
        if self.source is FrontEndSource.NONE:
            known = {name: "" if isinstance(value, str) else 0 for name, value in known.items()}
        return known | {"source": self.source, "front_end_hash": self.hash}

    @property
    def most_ma(self) -> int:
        """The largest limit of the current: the firmware's, the facts', the converter's range."""
        ceiling = most_ma(self._wired.current, magnitude=False)
        allowed = int(self.facts()["max_current_ma"])
        return min(ceiling, allowed, most_ma(self.chain().current, magnitude=self.magnitude))

    @property
    def magnitude(self) -> bool:
        """Whether the current has no sign."""
        return bool(self.facts()["sensor"] == Sensor.MAGNITUDE)

    @property
    def opens(self) -> bool:
        """Whether the bridge's driver can open it."""
        return bool(self.facts()["bridge"] != Bridge.PWM_DIR_BARE)

    def chain(self) -> Chain:
        """The chain as the facts in force declare it."""
        return self._wired if self.stored is None else declared(self._wired, self.stored)


def compiled(wired: Chain) -> Fields:
    """The facts that describe the chain as it is wired."""
    current, volts, supply = wired.converters
    volts_a = _count_v(current) / current.scale
    return {
        "name": "simulated",
        "sensor": Sensor.SHUNT,
        "ratiometric": 0,
        "bridge": Bridge.MOSFET,
        "reference_v": REFERENCE_V,
        "current_v_a": volts_a,
        "current_zero_v": current.offset * _count_v(current),
        "voltage_divider": volts.scale / _count_v(volts),
        "supply_divider": supply.scale / _count_v(supply),
        "lift_v": supply.offset * _count_v(supply),
        "max_current_ma": most_ma(current, magnitude=False),
        "current_filter": _whole(current.slope_s, FILTER_UNIT_S),
        "current_filter2": _whole(current.root_s, FILTER_UNIT_S),
        "voltage_filter": _whole(volts.slope_s, FILTER_UNIT_S),
        "voltage_filter2": _whole(volts.root_s, FILTER_UNIT_S),
        "current_gain_uncertainty": _whole(current.gain_uncertainty, GAIN_UNIT),
        "voltage_gain_uncertainty": _whole(volts.gain_uncertainty, GAIN_UNIT),
        "current_zero_uncertainty": 0,
    }


def _count_v(converter: Converter) -> float:
    return REFERENCE_V / 2.0**converter.bits


def _whole(value: float, unit: float) -> int:
    return min(round(value / unit), U16)


def most_ma(current: Converter, *, magnitude: bool) -> int:
    """The largest current that a converter tells from a larger one, whichever its sign."""
    above, below = current.raw_max - current.offset, current.offset
    shown = above if current.scale > 0 else below
    counts = shown if magnitude else min(above, below)
    return max(int(abs(current.scale) * counts * 1000), 0)


def is_sound(facts: Mapping[str, Any]) -> bool:
    """Whether facts can be true of any front end."""
    name, reference = facts["name"], facts["reference_v"]
    slope = abs(facts["current_v_a"])
    return (
        0 < len(name) <= NAME_BYTES
        and all(" " <= letter <= "~" for letter in name)
        and facts["sensor"] in tuple(Sensor)
        and facts["ratiometric"] in (0, 1)
        and facts["bridge"] in tuple(Bridge)
        and all(low <= facts[key] <= high for key, (low, high) in BOUNDS.items())
        and SLOPES[0] <= slope <= SLOPES[1]
        and 0 <= facts["current_zero_v"] <= reference
        and 0 <= facts["lift_v"] <= MOST_LIFT * reference
        and facts["max_current_ma"] > 0
    )


def declared(wired: Chain, facts: Mapping[str, Any]) -> Chain:
    """The chain as it is, declared as the facts have it. What its readings are stays."""
    lsb = facts["reference_v"] / 2.0**wired.current.bits
    zero = facts["current_zero_v"] / lsb
    drift = facts["current_zero_uncertainty"] * ZERO_UNIT_V / lsb
    one_sided = facts["sensor"] == Sensor.MAGNITUDE  # rests at an end of the range
    rising = facts["current_v_a"] > 0
    current = replace(
        _redeclared(wired.current, lsb / facts["current_v_a"], zero, facts, "current"),
        raw_min=wired.current.raw_min - (one_sided and rising),
        raw_end=wired.current.raw_end + (one_sided and not rising),
        offset_uncertainty=math.hypot(wired.current.offset_uncertainty, drift),
    )
    volts, supply = wired.voltage, wired.supply
    lift = facts["lift_v"] / lsb
    return replace(
        wired,
        current=current,
        voltage=_redeclared(volts, lsb * facts["voltage_divider"], volts.offset, facts, "voltage"),
        supply=_redeclared(supply, lsb * facts["supply_divider"], lift, facts, "voltage"),
    )


def _redeclared(
    wired: Converter, scale: float, offset: float, facts: Mapping[str, Any], name: str
) -> Converter:
    return replace(
        wired,
        scale=scale,
        gain=wired.gain * scale / wired.scale,
        offset=offset,
        slope_s=facts[f"{name}_filter"] * FILTER_UNIT_S,
        root_s=facts[f"{name}_filter2"] * FILTER_UNIT_S,
        gain_uncertainty=facts[f"{name}_gain_uncertainty"] * GAIN_UNIT,
    )
