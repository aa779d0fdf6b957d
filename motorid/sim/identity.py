"""What the simulated board says of itself, and which configurations and steps it accepts."""

from __future__ import annotations

from typing import Any, Protocol

from motorid.sim.bench import Bench
from motorid.sim.chain import UNSYNCHRONISED, Chain, Converter, burst_samples, shortest_period
from motorid.sim.front_end import FrontEnd
from motorid.sim.options import CLOCK_HZ, Options, decay_mask
from motorid.sim.run import Run
from motorid.sim.stream import U32
from motorid.wire.enums import (
    Channel,
    ChannelKind,
    Decay,
    Fault,
    Feature,
    Input,
    Mode,
    ResetCause,
    State,
    Status,
    StepKind,
    Unit,
)
from motorid.wire.hashes import layout_hash

NAME = "motorid-sim"
FIRMWARE = (1, 0, 0)
CHANNELS = len(Channel)
FEATURES = sum(1 << feature for feature in Feature)  # all that there are
PINS = {Input.PART_PRESENT: "X1", Input.GUARD_CLOSED: "X2"}
INPUTS = sum(1 << one for one in PINS)
MAX_HOST_SILENCE_MS = 5000
MAX_VOLTS_MV = 1_000_000
LAST_INDEX = 255  # of a byte; a program has at most 255 steps, 0 to 254
FULL_DUTY = 1_000_000
I16_MIN, I16_MAX = -32_768, 32_767
DRIVES = (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)
Fields = dict[str, Any]


class Described(Protocol):
    """What is read of a board here; ``motorid.sim.board.Board`` has it all."""

    options: Options
    chain: Chain
    front_end: FrontEnd
    bench: Bench
    major: int
    boot_id: int
    reset_cause: ResetCause
    state: State
    fault: Fault
    dropped: int
    inputs: int
    config: Fields | None
    steps: list[Fields]
    run: Run | None

    @property
    def clock(self) -> int: ...


def identify(board: Described) -> Fields:
    """Fields of the reply to identify."""
    options = board.options
    pwm_ticks = CLOCK_HZ // options.pwm
    return {
        "protocol_major": board.major,
        "protocol_minor": options.minor,
        "layout_hash": layout_hash(),
        "board": NAME,
        "firmware_major": FIRMWARE[0],
        "firmware_minor": FIRMWARE[1],
        "firmware_patch": FIRMWARE[2],
        "boot_id": board.boot_id,
        "reset_cause": board.reset_cause,
        "state": board.state,
        "clock_hz": CLOCK_HZ,
        "clock_uncertainty_ppm": round(options.clock_uncertainty),
        "pwm_hz": options.pwm,
        "dead_time_ns": round(options.dead_time * 1e9),
        "decay_modes": decay_mask(options.decay_modes),
        "channel_count": CHANNELS,
        "min_sample_period_ticks": shortest_period(board.options, board.chain),
        "sample_period_step_ticks": pwm_ticks,
        "encoder_edge_ceiling_hz": options.edge_ceiling,
        "max_steps": options.max_steps,
        "max_current_ma": max_current_ma(board),
        "max_host_silence_ms": MAX_HOST_SILENCE_MS,
        "buffer_samples": options.buffer,
        "burst_sample_period_ticks": _burst_period(board),
        "burst_samples": options.buffer if _burst_period(board) else 0,
        "features": FEATURES,
        "inputs": INPUTS,
        "brown_out_mv": options.brown_out,
        "brown_out_least_mv": options.brown_out_least,
        "front_end_hash": board.front_end.hash,
    }


def _burst_period(board: Described) -> int:
    fast = burst_samples(board.options, board.chain)
    return shortest_period(board.options, board.chain) // fast if fast else 0


def pace(board: Described, config: Fields) -> tuple[int, int]:
    """Ticks between the samples that the guard sees, and samples of a fast burst in them or 0."""
    period: int = config["sample_period_ticks"]
    if config["mode"] == Mode.BURST and period and period == _burst_period(board):
        fast = burst_samples(board.options, board.chain)
        return period * fast, fast
    return period, 0


def max_current_ma(board: Described) -> int:
    """The largest limit of the current that board and front end allow."""
    return board.front_end.most_ma


def has_mode(board: Described, mode: int) -> bool:
    """Whether channels are described in this mode: a burst's where there is a fast one."""
    return mode == Mode.STREAM or (mode == Mode.BURST and _burst_period(board) > 0)


def describe(board: Described, index: int, mode: int = Mode.STREAM) -> Fields:
    """Fields of the reply to describe_channel."""
    if index == Channel.POSITION:
        return _describe_position()
    fields = _describe_converter(board.chain.converters[index])
    if mode == Mode.BURST:  # which takes instants at its ticks
        # its filter stays
        at_once = {"kind": ChannelKind.INSTANT, "aperture_ns": 0, "delay_ns": fields["filter_ns"]}
        return fields | at_once | {"pwm_phase_permille": UNSYNCHRONISED}
    return fields


def _describe_converter(converter: Converter) -> Fields:
    return {
        "channel": converter.channel,
        "unit": converter.unit,
        "kind": converter.kind,
        "bits": converter.bits,
        "scale": converter.scale,
        "offset": converter.offset,
        "aperture_ns": round(converter.aperture_s * 1e9),
        "delay_ns": round((converter.delay_s + converter.slope_s) * 1e9),
        "pwm_phase_permille": _permille(converter),
        "gain_uncertainty": converter.gain_uncertainty,
        "offset_uncertainty": converter.offset_uncertainty,
        "noise": converter.noise,
        "raw_min": converter.raw_min,
        "raw_max": converter.raw_end,
        "filter_ns": round(converter.slope_s * 1e9),
        "filter2_ns": round(converter.root_s * 1e9),
    }


def _permille(converter: Converter) -> int:
    return UNSYNCHRONISED if converter.phase is None else round(converter.phase * 1000)


def _describe_position() -> Fields:
    return {
        "channel": Channel.POSITION,
        "unit": Unit.COUNT,
        "kind": ChannelKind.INSTANT,
        "bits": 16,
        "scale": 1.0,
        "offset": 0.0,
        "aperture_ns": 0,
        "delay_ns": 0,
        "pwm_phase_permille": UNSYNCHRONISED,
        "gain_uncertainty": 0.0,
        "offset_uncertainty": 0.0,
        "noise": 0.0,
        "raw_min": I16_MIN,
        "raw_max": I16_MAX,
        "filter_ns": 0,
        "filter2_ns": 0,
    }


def status(board: Described) -> Fields:
    """Fields of the reply to read_status."""
    raw = board.bench.raw
    sign = -1 if board.config and board.config["encoder_reversed"] else 1
    stream = board.run.stream if board.run else None
    return {
        "state": board.state,
        "fault": board.fault,
        "tick": board.clock & U32,
        "position": sign * board.bench.count & U32,
        "current_raw": int(raw[0]),
        "terminal_voltage_raw": int(raw[1]),
        "supply_voltage_raw": int(raw[2]),
        "dropped": stream.dropped if stream else board.dropped,
        "inputs": board.inputs,
    }


def check_config(board: Described, config: Fields) -> Status:
    """OK, or why this configuration is refused."""
    step = CLOCK_HZ // board.options.pwm
    period, _ = pace(board, config)
    if (
        period < shortest_period(board.options, board.chain)
        or period % step
        or config["encoder_reversed"] > 1
    ):
        return Status.BAD_VALUE
    if not config["channels"]:
        return Status.BAD_VALUE
    if config["channels"] >> CHANNELS or config["mode"] not in tuple(Mode):
        return Status.NOT_SUPPORTED
    if config["speed_limit_counts_s"] > board.options.edge_ceiling:
        return Status.EDGE_CEILING
    limits_hold = (
        0 < config["current_limit_ma"] <= max_current_ma(board)
        and config["speed_limit_counts_s"] > 0
        and config["supply_min_mv"] < config["supply_max_mv"]
        and config["run_time_limit_ms"] > 0
        and 0 < config["host_silence_ms"] <= MAX_HOST_SILENCE_MS
    )
    return _check_features(board, config) if limits_hold else Status.BAD_VALUE


def _check_features(board: Described, config: Fields) -> Status:
    if config["inputs_required"] & ~INPUTS:
        return Status.NOT_SUPPORTED
    least = min(config[f"sign_check_{name}"] for name in ("ma", "mv", "counts"))
    if config["sign_check_ms"] and not least:
        return Status.BAD_VALUE
    foreign = config["front_end_hash"] not in (0, board.front_end.hash)
    return Status.HASH_MISMATCH if foreign else Status.OK


def check_step(board: Described, step: Fields) -> Status:
    """OK, or why this step is refused."""
    if step["index"] != len(board.steps) or step["index"] == LAST_INDEX:
        return Status.BAD_VALUE
    if len(board.steps) >= board.options.max_steps:
        return Status.PROGRAM_FULL
    if step["kind"] not in tuple(StepKind):
        return Status.NOT_SUPPORTED
    if step["kind"] == StepKind.COAST and not board.front_end.opens:
        return Status.NOT_SUPPORTED
    return _check_drive(board, step) or _check_duration(board, step)


def _check_drive(board: Described, step: Fields) -> Status:
    decay, level = step["decay"], step["level"]
    if step["kind"] not in DRIVES:
        return Status.BAD_VALUE if decay or level else Status.OK
    if decay not in tuple(Decay)[1:] or not decay_mask(board.options.decay_modes) >> decay & 1:
        return Status.NOT_SUPPORTED
    top = FULL_DUTY if step["kind"] == StepKind.DRIVE_DUTY else MAX_VOLTS_MV
    return Status.OK if abs(level) <= top else Status.BAD_VALUE


def _check_duration(board: Described, step: Fields) -> Status:
    assert board.config is not None  # steps are accepted only in configured and loaded
    ticks = step["ticks"]
    whole = ticks > 0 and ticks % board.bench.period_ticks == 0
    return Status.OK if whole else Status.BAD_VALUE
