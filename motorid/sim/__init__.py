"""The simulated rig behind sim://."""

from __future__ import annotations

import math
from typing import Any

LCR_HZ = 1e3  # of the usual meter


def truth(url: str) -> dict[str, Any]:
    """What is true of the rig of a sim:// URL, for tests and benches; SI units.

    ``R`` to ``T0`` are the motor's as a run begins (winding and magnets at ambient, load inertia
    included, K and L at no current); ``R_25`` and ``K_25`` at 25 °C; ``K_stall`` and ``L_stall``
    (dλ/di) at the stall current, ``L_1kHz`` as an LCR meter shows it at no current. ``chain``
    holds each channel's drawn gain error (relative), its offset error (counts) and its filters'
    time constants (s; 0: none), and the clock's error. Raises UsageError.
    """
    from motorid.sim.bench import COPPER_PER_K, MAGNET_PER_K
    from motorid.sim.chain import draw_chain
    from motorid.sim.options import parse_url

    options = parse_url(url)
    motor, chain = options.specimen, draw_chain(options)
    warmth = options.ambient - 25.0
    K = motor.torque_constant_nm_a * (1 + MAGNET_PER_K * warmth)
    eddy = (2 * math.pi * LCR_HZ * options.eddy_time) ** 2
    result: dict[str, Any] = {
        "R": motor.resistance_ohm * (1 + COPPER_PER_K * warmth),
        "L": motor.inductance_h,
        "K": K,
        "B": motor.viscous_nm_s,
        "J": motor.inertia_kg_m2 + options.load_inertia,
        "T0": motor.coulomb_nm,
        "R_25": motor.resistance_ohm,
        "K_25": motor.torque_constant_nm_a,
        "K_stall": K * (1 - options.reaction),
        "L_stall": motor.inductance_h * (1 - options.saturation),
        "L_1kHz": motor.inductance_h * (1 - options.eddy * eddy / (1 + eddy)),
        "breakaway": options.stiction * motor.coulomb_nm,
        "supply_v": options.supply_v,
        "nominal_v": motor.voltage_v,
        "stall_current_a": options.preset.stall_current_a,
        "counts_per_turn": options.counts_per_turn,
    }
    result["chain"] = {
        converter.channel.name.lower(): {
            "gain_error": converter.gain - 1,
            "offset_error": converter.true_offset - converter.offset,
            "scale": converter.scale,
            "filter_s": converter.poles_s,
        }
        for converter in chain.converters
    } | {"clock_ppm": chain.clock_ppm}
    return result
