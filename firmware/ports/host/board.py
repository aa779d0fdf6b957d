"""Runs the host's port with the motor and the bench of a sim:// URL.

    python firmware/ports/host/board.py --socket 5331 "sim://?motor=maxon-re35&seed=3"

prints ``socket://127.0.0.1:5331``, which is a port like any other for motorid; ``--pty`` makes a
pseudo terminal instead. ``--speed`` is realtime, max or lockstep (see main.c). Options of the URL
that concern faults, pace and link loss belong to the simulated board and are refused here.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from motorid.sim._plant import ffi

from motorid.sim.bench import plant_params
from motorid.sim.board import Board
from motorid.sim.chain import Chain, Converter
from motorid.sim.front_end import REFERENCE_V
from motorid.sim.identity import describe, identify
from motorid.sim.options import CLOCK_HZ, Options, parse_url

BINARY = Path(__file__).resolve().parents[2] / "build" / "host" / "board"
FACTS = (
    "clock_hz",
    "clock_uncertainty_ppm",
    "pwm_hz",
    "dead_time_ns",
    "decay_modes",
    "min_sample_period_ticks",
    "sample_period_step_ticks",
    "encoder_edge_ceiling_hz",
    "max_current_ma",
    "max_host_silence_ms",
    "burst_sample_period_ticks",
    "brown_out_mv",
    "brown_out_least_mv",
)
OWN = (
    "fault",
    "buffer",
    "max_steps",
    "minor",
)  # of the simulated board, or fixed when this one is compiled


def arguments(url: str) -> list[str]:
    """NAME=VALUE arguments that give the host's port what the simulated board of ``url`` has.

    Raises UsageError when ``url`` is no sim:// URL, ValueError when it asks for what this port
    does not have.
    """
    options = parse_url(url)
    for name in OWN:
        if getattr(options, name) != getattr(Options(), name):
            raise ValueError(f"{url}: the host's port has no option {name}")
    board = Board(options, send=lambda payload: None)
    identity = identify(board)
    values: dict[str, Any] = {name: identity[name] for name in FACTS}
    values |= {
        "front_end_holds": options.front_end == "compiled",
        "reference_v": REFERENCE_V,
        "true_clock_hz": board.chain.clock_hz,
        "counts_per_turn": options.counts_per_turn,
        "encoder_angle": board.chain.encoder_angle,
        "seed": options.seed,
        "baud": options.baud,
        "first_tick": options.first_tick,
    }
    values |= _plant(options, board.chain)
    for index, converter in enumerate(board.chain.converters):
        values |= _converter(converter, describe(board, index), board.chain)
    return [f"{name}={float(value)!r}" for name, value in values.items()]


def _plant(options: Options, chain: Chain) -> dict[str, float]:
    """Every field of the plant's parameters."""
    params = plant_params(options, chain)
    fields = ffi.typeof("plant_params").fields
    return {f"plant.{name}": getattr(params, name) for name, _ in fields}


def _converter(converter: Converter, descriptor: dict[str, Any], chain: Chain) -> dict[str, float]:
    """A channel as it is and as it is declared."""
    stretch = CLOCK_HZ / chain.clock_hz  # the board's microsecond in true ones
    values = {name: value for name, value in descriptor.items() if name != "channel"}
    values |= {
        "gain": converter.gain,
        "true_offset": converter.true_offset,
        "true_aperture": converter.aperture_s * stretch,
        "true_delay": converter.delay_s * stretch,
    }
    return {f"{converter.channel.name.lower()}.{name}": value for name, value in values.items()}


def main() -> None:
    """Replaces this process by the board."""
    *flags, url = sys.argv[1:] or ["sim://"]
    os.execv(BINARY, [str(BINARY), *flags, *arguments(url)])  # noqa: S606 - our own binary


if __name__ == "__main__":
    main()
