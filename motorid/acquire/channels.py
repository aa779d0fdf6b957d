"""Raw readings of a board become a channel: by its descriptor, the run's zero and the rig."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SUPPLY, VOLTAGE, Channel
from motorid.errors import DataError
from motorid.rig import Calibration
from motorid.wire.enums import ChannelKind

UNITS = {CURRENT: "A", VOLTAGE: "V", SUPPLY: "V"}
UNSYNCHRONISED = 65535  # pwm_phase_permille of a channel that ignores the PWM
ZEROED = {CURRENT: "current", VOLTAGE: "voltage"}  # as the reply to zero names them
Counts = tuple[float, float, float]  # offset, its standard uncertainty, one reading's noise


def position(raw: NDArray[Any], fact: Mapping[str, Any], counts_per_turn: float) -> Channel:
    """The encoder's channel, in radians from the run's first sample."""
    count = 2 * math.pi / counts_per_turn
    return Channel(
        POSITION, "rad", raw, count, float(raw[0]), resolution=abs(count), **_timing(fact)
    )


def analogue(
    name: str,
    raw: NDArray[Any],
    fact: Mapping[str, Any],
    known: Calibration,
    counts: Counts,
    voltage_sense: str,
) -> Channel:
    """A converter's channel: the board's scale times the rig's gain, zeroed by ``counts``."""
    scale = fact["scale"] * known.gain
    offset, offset_uncertainty, noise = counts
    gain_u, offset_u = known.gain_uncertainty, known.offset_uncertainty
    sense: dict[str, Any] = {VOLTAGE: voltage_sense, SUPPLY: "supply"}
    return Channel(
        name=name,
        unit=UNITS[name],
        raw=raw,
        scale=scale,
        offset=offset,
        resolution=abs(scale),
        noise=noise * abs(scale),
        gain_uncertainty=fact["gain_uncertainty"] if gain_u is None else gain_u,
        offset_uncertainty=offset_uncertainty * abs(scale) if offset_u is None else offset_u,
        delay_uncertainty_s=known.delay_uncertainty_s,
        step_uncertainty=abs(scale) * fact.get("step_uncertainty", 0.0),
        raw_min=float(fact["raw_min"]),
        raw_max=float(fact["raw_max"]),
        sense=sense.get(name),
        **_bent(fact, known, scale, offset),
        **_timing(fact),
    )


def _bent(
    fact: Mapping[str, Any], known: Calibration, scale: float, offset: float
) -> dict[str, Any]:
    """The sensor's non-linearity as stated; of the converter's range where no full scale is."""
    if not known.nonlinearity:
        return {}
    ends = (abs(scale * (fact[end] - offset)) for end in ("raw_min", "raw_max"))
    return {
        "nonlinearity": known.nonlinearity,
        "nonlinearity_shape": known.nonlinearity_shape,
        "full_scale": known.full_scale or float(max(ends)),
    }


def zeroed(name: str, zero: Mapping[str, Any]) -> bool:
    """Whether a reply to zero holds this channel's offset."""
    return f"{ZEROED.get(name, name)}_offset" in zero


def offset_of(
    name: str, fact: Mapping[str, Any], zero: Mapping[str, Any], samples: int, known: Calibration
) -> Counts:
    """By the run's own zero over so many samples, else by the calibration, else by the board.

    Below half a count of noise the average of many readings still hides in one count.
    """
    if not zeroed(name, zero):
        offset = fact["offset"] if known.offset is None else known.offset
        return offset, fact["offset_uncertainty"], fact["noise"]
    key = ZEROED[name]
    noise = zero[f"{key}_noise"]
    hidden = 1 / math.sqrt(12) if noise < 0.5 else 0.0
    return zero[f"{key}_offset"], math.hypot(noise / math.sqrt(max(1, samples)), hidden), noise


def _filter(first_ns: int, second_ns: int) -> dict[str, Any]:
    """1 / (1 + first s), or of second order 1 / (1 + first s + (second s)²)."""
    if not second_ns:
        return {"filter_s": first_ns * 1e-9}
    damping = first_ns / (2 * second_ns)
    return {"filter_s": second_ns * 1e-9, "filter_order": 2, "filter_damping": damping}


def _timing(fact: Mapping[str, Any]) -> dict[str, Any]:
    phase = fact["pwm_phase_permille"]
    try:
        kind = ChannelKind(fact["kind"])
    except ValueError:
        raise DataError(
            f"the board reads a channel in a way that this version does not know ({fact['kind']}): "
            "update motorid; the journal keeps what was measured"
        ) from None
    return {
        "kind": kind.name.lower(),
        "aperture_s": fact["aperture_ns"] * 1e-9,
        "delay_s": fact["delay_ns"] * 1e-9,
        **_filter(fact["filter_ns"], fact.get("filter2_ns", 0)),
        "pwm_phase": None if phase == UNSYNCHRONISED else phase / 1000,
    }
