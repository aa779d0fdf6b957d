"""A rig and a program as the board takes them: integers, limits, and whether it can at all."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from motorid.acquire.guards import guards
from motorid.errors import RigError
from motorid.program import Program, StepKind, whole_ticks
from motorid.rig import Rig
from motorid.wire.enums import Channel, ChannelKind, Mode
from motorid.wire.hashes import config_hash, program_hash

U32 = (1 << 32) - 1
NEAR = 1e-3  # of a rate that a person rounds
LEVEL_UNIT = {StepKind.DRIVE_DUTY: 1e6, StepKind.DRIVE_VOLTS: 1e3}  # millionths, millivolts
Fields = dict[str, Any]


@dataclass(frozen=True)
class WireProgram:
    """A program in the board's ticks. ``origin[i]``: the program's step that wire step i is."""

    steps: tuple[Fields, ...]
    origin: tuple[int, ...]

    @property
    def hash(self) -> int:
        """What the board must answer when all steps are loaded."""
        return program_hash(self.steps)

    @property
    def ticks(self) -> int:
        """Length of the run."""
        return sum(int(step["ticks"]) for step in self.steps)


def configuration(rig: Rig, identity: Mapping[str, Any], known: Mapping[str, Any]) -> Fields:
    """The fields of ``configure``. Raises RigError where this board cannot do what the rig asks."""
    limits, per_turn = rig.limits, rig.wiring.counts_per_turn
    missing = [name for name in rig.sampling.channels if name not in known]
    if missing:
        raise RigError(
            f"sampling.channels asks for {missing[0]}, which the board {identity['board']} has "
            f"not: it has {', '.join(known)}"
        )
    for name in rig.sampling.channels:
        if (kind := known[name].get("kind", 0)) not in list(ChannelKind):
            raise RigError(
                f"the board reads {name} in a way that this version does not know ({kind}): "
                "update motorid"
            )
    turns_s = limits.speed_rad_s / (2 * math.pi * rig.wiring.gear_ratio)
    counts_s = turns_s * per_turn
    if counts_s > identity["encoder_edge_ceiling_hz"]:
        fastest = limits.speed_rad_s * identity["encoder_edge_ceiling_hz"] / counts_s
        raise RigError(
            f"limits.speed_rad_s means {counts_s:.0f} encoder edges a second, and the board "
            f"counts {identity['encoder_edge_ceiling_hz']}: lower it to {fastest:.0f} or less"
        )
    if limits.current_a * 1e3 > identity["max_current_ma"]:
        raise RigError(
            f"limits.current_a is above the {identity['max_current_ma'] / 1e3:g} A that the "
            "board accepts: lower it"
        )
    return guards(rig, identity, known) | {
        "sample_period_ticks": sample_period(rig, identity),
        "channels": sum(1 << Channel[name.upper()] for name in rig.sampling.channels),
        "mode": int(Mode[rig.sampling.mode.upper()]),
        "encoder_reversed": int(rig.encoder_reversed),
        "current_limit_ma": _whole("limits.current_a", limits.current_a * 1e3),
        "speed_limit_counts_s": _whole("limits.speed_rad_s", counts_s),
        "supply_min_mv": _whole("limits.supply_min_v", limits.supply_min_v * 1e3),
        "supply_max_mv": _whole("limits.supply_max_v", limits.supply_max_v * 1e3),
        "run_time_limit_ms": _whole("limits.run_time_s", limits.run_time_s * 1e3),
        "host_silence_ms": min(
            _whole("limits.host_silence_s", limits.host_silence_s * 1e3),
            int(identity["max_host_silence_ms"]),
        ),
    }


def sample_period(rig: Rig, identity: Mapping[str, Any]) -> int:
    """Ticks between samples: what the rig asks, as near as the board's steps allow.

    A burst that is asked for more than a stream can do is the board's fast one.
    """
    step = max(1, int(identity["sample_period_step_ticks"]))
    wanted = identity["clock_hz"] / rig.sampling.rate_hz
    period: int = round(wanted / step) * step
    shortest = int(identity["min_sample_period_ticks"])
    bursts = rig.sampling.mode == "burst" and identity.get("burst_sample_period_ticks", 0)
    if period < shortest or (bursts and wanted < shortest * (1 - NEAR)):
        return _fastest(rig, identity, wanted)
    if period > U32:
        raise RigError(f"sampling.rate_hz is {rig.sampling.rate_hz:g}: too slow for this board")
    return period


def _fastest(rig: Rig, identity: Mapping[str, Any], wanted: float) -> int:
    """Period of the fastest burst where that is asked for and is fast enough."""
    clock_hz, asked_hz = identity["clock_hz"], rig.sampling.rate_hz
    shortest = int(identity["min_sample_period_ticks"])
    fast = int(identity.get("burst_sample_period_ticks", 0))  # none before minor 1
    if rig.sampling.mode == "burst":
        if math.isinf(asked_hz):
            return fast or shortest
        if fast and wanted > fast * (1 - NEAR):
            return fast
        shortest, fast = fast or shortest, 0
    hint = ""
    if fast:
        hint = f', or set sampling.mode = "burst" for a short run at {clock_hz / fast:g} Hz'
    raise RigError(
        f"sampling.rate_hz is {asked_hz:g}, and the board samples at {clock_hz / shortest:g} Hz "
        f"at most: lower it{hint}"
    )


def is_fast(period: int, identity: Mapping[str, Any]) -> bool:
    """Whether samples come faster than a stream's can: a fast burst."""
    return period < int(identity["min_sample_period_ticks"])


def step_ticks(period: int, identity: Mapping[str, Any]) -> int:
    """What the durations of steps are multiples of: where the board's guard looks."""
    least = int(identity["min_sample_period_ticks"])
    return math.lcm(period, least) if is_fast(period, identity) else period


def differing(sent: Mapping[str, Any], read: Mapping[str, Any], minor: int) -> str | None:
    """What a board of that minor says it holds otherwise than it was sent, or None."""
    for name, value in sent.items():
        if read.get(name) != value:
            return f"{name} was sent as {value} and reads back as {read.get(name)}"
    if read.get("config_hash") != config_hash(sent, minor):
        return "the hash of the configuration does not match it"
    return None


def wire_program(program: Program, identity: Mapping[str, Any], period: int) -> WireProgram:
    """``program`` in whole periods, of ``step_ticks``. Raises RigError where the board cannot."""
    steps: list[Fields] = []
    origin: list[int] = []
    longest = U32 // period * period
    for number, step in enumerate(program.steps):
        if step.decay and not identity["decay_modes"] >> step.decay & 1:
            raise RigError(
                f"step {number} of the program asks for {step.decay.name.lower()} decay, which "
                f"the board {identity['board']} has not"
            )
        left = whole_ticks(step.duration_s, identity["clock_hz"], period)
        while left:
            ticks = min(left, longest)
            left -= ticks
            steps.append(
                {
                    "index": len(steps),
                    "kind": int(step.kind),
                    "decay": int(step.decay),
                    "level": round(step.level * LEVEL_UNIT.get(step.kind, 0)),
                    "ticks": ticks,
                }
            )
            origin.append(number)
            if len(steps) > identity["max_steps"]:
                raise RigError(
                    f"the program has more than the {identity['max_steps']} steps that the board "
                    f"{identity['board']} holds: shorten it"
                )
    return WireProgram(tuple(steps), tuple(origin))


def check_burst(rig: Rig, wire: WireProgram, identity: Mapping[str, Any], period: int) -> None:
    """Raises RigError where a burst does not fit the board's memory."""
    samples = wire.ticks // period
    fast = is_fast(period, identity)
    most = identity["burst_samples" if fast else "buffer_samples"]
    if rig.sampling.mode == "burst" and samples > most:
        longest_ms = 1e3 * most * period / identity["clock_hz"]
        raise RigError(
            f"the program takes {samples} samples, and the board keeps {most} in burst mode: "
            f"shorten it to {longest_ms:.3g} ms, or lower sampling.rate_hz"
        )


def _whole(key: str, value: float) -> int:
    number = round(value)
    if not 0 <= number <= U32:
        raise RigError(f"{key} does not fit the protocol's 32 bits: lower it")
    return number
