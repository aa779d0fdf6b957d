"""Facts of the front end that an emulated Pico has in flash, as `motorid board set` leaves them."""

from __future__ import annotations

import zlib
from typing import Any

from motorid.rig_front_end import load_front_end
from motorid.wire.hashes import front_end_bytes

LIKE = "pico-ina240"
# of parts whose errors the emulator draws: standard, in 1e-5; its sensor's zero has none of its own
UNCERTAINTIES = {
    "current_gain_uncertainty": 400,
    "voltage_gain_uncertainty": 150,
    "current_zero_uncertainty": 0,
}
OWN_RANGE = 0.99  # of the converter's, that a limit may use
NUMBER = b"\1"  # of the storing
WHOLE = b"\xa5"  # firmware/core/front_end.h


def facts(amplified_ohm: float, divider: int, bridge: int) -> dict[str, Any]:
    """Those of the parts that the rig has: a shunt and its amplifier, dividers, the driver."""
    like = load_front_end(LIKE).facts
    most_a = like["reference_v"] / 2 / amplified_ohm * OWN_RANGE
    return {
        **like,
        "name": "emulated",
        "bridge": bridge,
        "current_v_a": amplified_ohm,
        "voltage_divider": 2.0 * divider,
        "supply_divider": float(divider),
        "max_current_ma": int(most_a * 1e3),
        **UNCERTAINTIES,
    }


def slot(known: dict[str, Any]) -> bytes:
    """A slot of the board's memory that holds them, from its first byte on."""
    numbered = front_end_bytes(known) + NUMBER
    return numbered + zlib.crc32(numbered).to_bytes(4, "little") + WHOLE
