"""A rotor that must not turn, on the board: a pulse that must not move it, a limit that trips.

A program for a rotor that is held would turn a free one to and fro at any of its levels. Four
things stand against that: a person or the rig file says that the rotor is held; a weak pulse must
not move it; the board trips when it turns by more than ``TRAVEL`` within its speed window; and this
computer stops the run when it creeps by twice that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from motorid.acquire.board import Board, Fields
from motorid.acquire.check import judge_sensors, weak_duties
from motorid.acquire.interrupt import Asked
from motorid.acquire.pulse import weak_pulse
from motorid.errors import RigError
from motorid.rig import Rig
from motorid.wire.codec import SampleBlock

TRAVEL = 1 / 400  # of a turn of the encoder's shaft: what a clamp may give way
COUNTS = 3  # at least: an edge under a line of the disc flickers
WINDOW_S, WINDOW_SAMPLES = 2e-3, 15  # over which a board takes the speed, at most
WRAP, HALF = 1 << 32, 1 << 31
MOVED = (  # for a trip of ``board_limit``
    "the rotor moved, and the board opened the bridge: clamp it firmly, or lower the program's "
    "levels"
)


def allowed_counts(rig: Rig) -> int:
    """Encoder counts by which a rotor that is held may move."""
    return max(COUNTS, round(TRAVEL * rig.wiring.counts_per_turn))


def board_limit(rig: Rig, identity: Mapping[str, Any], period_ticks: int) -> Fields:
    """The field of ``configure`` that lets the board trip at more than the allowed counts.

    Its speed is a difference of counts over a window of its own, which this foresees. A board with
    a longer window allows as much more.
    """
    clock_hz = identity["clock_hz"]
    samples = min(max(round(WINDOW_S * clock_hz / period_ticks), 1), WINDOW_SAMPLES)
    counts_s = math.ceil(allowed_counts(rig) * clock_hz / (samples * period_ticks))
    turns_s = rig.limits.speed_rad_s / (2 * math.pi * rig.wiring.gear_ratio)
    most = min(round(turns_s * rig.wiring.counts_per_turn), identity["encoder_edge_ceiling_hz"])
    return {"speed_limit_counts_s": min(counts_s, most)}


def check_held(
    board: Board, rig: Rig, config: Fields, zero: Fields, supply_v: float, stop: Asked
) -> Fields:
    """A weak pulse that must not move the rotor; its figures for the capture, none if stopped.

    Raises RigError where it moves, where no current flows, or where a sensor is wrong.
    """
    duty, before = next(weak_duties(rig, supply_v)), board.position()
    try:
        pulse = weak_pulse(board, rig, config, zero, stop, duty, supply_v)
    except RigError:
        _insist_on_rest(rig, board.position() - before, duty)  # the board tripped: of that, mostly
        raise
    if pulse is None:
        return {}
    judge_sensors(rig, pulse)
    _insist_on_rest(rig, pulse.counts, duty)
    if pulse.current_a is not None and not pulse.draws:
        raise RigError(
            f"the motor draws {pulse.current_a:.3g} A at {duty:.0%} duty ({pulse.volts:.2f} V): "
            "check its leads, the bridge's enable and the supply"
        )
    if pulse.current_a is not None and pulse.current_a < 0.0:
        raise RigError(
            f"the current reads {pulse.current_a:.3g} A under positive voltage: the sensor is "
            "reversed; swap its two wires"
        )
    bound = abs(pulse.volts / pulse.peak_a) if pulse.peak_a else None
    return asdict(pulse) | {"resistance_bound_ohm": bound}


def _insist_on_rest(rig: Rig, counts: int, duty: float) -> None:
    if abs(counts) > allowed_counts(rig):
        raise RigError(
            f"the rotor is not held: it moves by {counts} counts at {duty:.0%} duty; clamp it"
        )


class TravelWatch:
    """Asks for a stop once the rotor is further from where it began than a clamp gives way."""

    def __init__(self, rig: Rig, stop: Asked) -> None:
        self.most, self.stop = 2 * allowed_counts(rig), stop
        self.began: int | None = None
        self.counts = 0

    @property
    def moved(self) -> bool:
        """The rotor has crept away."""
        return abs(self.counts) > self.most

    @property
    def requested(self) -> bool:
        """As a stop that is asked for."""
        return self.moved or self.stop.requested

    def consume(self, block: SampleBlock) -> None:
        """Takes a block as it arrives."""
        if self.began is None:
            self.began = block.position
        if not self.moved:
            self.counts = (block.position - self.began + HALF) % WRAP - HALF

    def insist(self) -> None:
        """Raises RigError where it asked for the stop."""
        if self.moved:
            raise RigError(
                f"the rotor crept by {self.counts} counts and the run was stopped: clamp it firmly"
            )
