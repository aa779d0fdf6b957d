"""A board that obeys the protocol, on a clock of its own, for habits to make it disobey.

It has no physics: readings are what a healthy motor's would look like to the check pulse.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from motorid.errors import LinkError
from motorid.wire.codec import (
    BadPayload,
    Command,
    channel_mask,
    decode,
    encode_event,
    encode_reply,
    mask_channels,
)
from motorid.wire.enums import Channel, ChannelKind, EndReason, Fault, State, Status, StepKind, Unit
from motorid.wire.framing import Decoder, Frame
from motorid.wire.hashes import config_hash, layout_hash, program_hash
from motorid.wire.spec import load

CLOCK_HZ = 16_000_000
BLOCK = 20  # samples
ZERO_RAW, DRIVEN_RAW = 2048, 100
SUPPLY_V, VOLTS_COUNT = 7.0, 0.005
COUNTS_A_SAMPLE = 5
BYTE_S = 1e-5
Fields = dict[str, Any]
IDENTITY: Fields = {
    "protocol_major": load().major,
    "protocol_minor": load().minor,
    "layout_hash": layout_hash(),
    "board": "hostile",
    "firmware_major": 1,
    "firmware_minor": 0,
    "firmware_patch": 0,
    "boot_id": 77,
    "reset_cause": 0,
    "clock_hz": CLOCK_HZ,
    "clock_uncertainty_ppm": 50,
    "pwm_hz": 20_000,
    "dead_time_ns": 500,
    "decay_modes": 0b1111,
    "channel_count": 4,
    "min_sample_period_ticks": 1600,
    "sample_period_step_ticks": 1600,
    "encoder_edge_ceiling_hz": 2_000_000,
    "max_steps": 64,
    "max_current_ma": 10_000,
    "max_host_silence_ms": 1000,
    "buffer_samples": 4096,
    "burst_sample_period_ticks": 0,
    "burst_samples": 0,
}
CONVERTER: Fields = {
    "kind": ChannelKind.MEAN,
    "bits": 12,
    "aperture_ns": 50_000,  # a whole PWM period
    "delay_ns": 10_000,
    "pwm_phase_permille": 65535,
    "gain_uncertainty": 0.002,
    "offset_uncertainty": 1.0,
    "noise": 1.0,
    "raw_min": 0,
    "raw_max": 4095,
    "filter_ns": 0,
}
CHANNELS: dict[int, Fields] = {
    Channel.CURRENT: CONVERTER | {"unit": Unit.AMPERE, "scale": 1e-3, "offset": float(ZERO_RAW)},
    Channel.TERMINAL_VOLTAGE: CONVERTER
    | {"unit": Unit.VOLT, "scale": VOLTS_COUNT, "offset": 0.0, "raw_min": -2000},
    Channel.SUPPLY_VOLTAGE: CONVERTER | {"unit": Unit.VOLT, "scale": VOLTS_COUNT, "offset": 0.0},
    Channel.POSITION: CONVERTER
    | {"kind": ChannelKind.INSTANT, "unit": Unit.COUNT, "scale": 1.0, "offset": 0.0}
    | {"raw_min": -32768, "raw_max": 32767, "noise": 0.0, "gain_uncertainty": 0.0},
}


class HostileBoard:
    """Answers commands and plays runs. ``say`` takes every payload it would send."""

    def __init__(self, say: Callable[[bytes], None]) -> None:
        self.say = say
        self.now_s = 0.0
        self.state = State.IDLE
        self.config: Fields = {}
        self.steps: list[Fields] = []
        self.position = 0
        self.runs = 0
        self.ends = True  # whether a run ends when its program is over
        self.heeds_stop = True
        self._run: _Run | None = None
        self._kept: tuple[int, bytes] | None = None

    @property
    def tick(self) -> int:
        """Of the clock, without wrapping."""
        return int(self.now_s * CLOCK_HZ)

    @property
    def running(self) -> bool:
        """Whether the bridge may conduct."""
        return self._run is not None

    def advance(self, seconds: float) -> None:
        """Lets time pass up to ``seconds``."""
        self.now_s = max(self.now_s, seconds)
        if self._run is not None:
            self._run.advance()

    def next_s(self) -> float:
        """When it has something to say next."""
        return self._run.next_s() if self._run is not None else float("inf")

    def reset(self) -> None:
        """Forgets everything, and greets."""
        self._run, self.config, self.steps = None, {}, []
        self.state = State.IDLE
        self.say(encode_event("hello", boot_id=78, reset_cause=1))

    def hear(self, payload: bytes) -> None:
        """One payload of the host's."""
        try:
            command = decode(payload)
        except BadPayload:
            return
        if not isinstance(command, Command):
            return
        if self._kept is not None and self._kept[0] == command.request:
            self.say(self._kept[1])
            return
        status, fields = self._answer(command)
        reply = encode_reply(command.name, command.request, status, **fields)
        self._kept = (command.request, reply)
        self.say(reply)
        if command.name == "start" and not status:
            self._run = _Run(self, fields["start_tick"])

    def _answer(self, command: Command) -> tuple[Status, Fields]:
        sent = command.fields
        match command.name:
            case "identify":
                return Status.OK, IDENTITY | {"state": self.state}
            case "describe_channel":
                channel = sent["index"]
                if channel not in CHANNELS:
                    return Status.BAD_VALUE, {}
                return Status.OK, CHANNELS[channel] | {"channel": channel}
            case "configure":
                self.config, self.state = sent, State.CONFIGURED
                return Status.OK, {"config_hash": config_hash(sent)}
            case "read_config":
                return Status.OK, self.config | {"config_hash": config_hash(self.config)}
            case "clear_program":
                self.steps = []
            case "add_step":
                self.steps.append(sent)
                self.state = State.LOADED
                return Status.OK, {
                    "steps": len(self.steps) % 256,
                    "program_hash": program_hash(self.steps),
                }
            case "start":
                self.runs += 1
                self.state = State.RUNNING
                start = self.tick + self.config["sample_period_ticks"]
                return Status.OK, {"start_tick": start % 2**32}
            case "stop":
                if self._run is not None and self.heeds_stop:
                    self.end(EndReason.STOPPED)
                return Status.OK, {"state": self.state}
            case "zero":
                return Status.OK, {
                    "current_offset": float(ZERO_RAW),
                    "current_noise": 1.0,
                    "voltage_offset": 0.0,
                    "voltage_noise": 1.0,
                }
            case "read_status":
                return Status.OK, self._status()
            case "clear_fault":
                self.state = State.CONFIGURED
                return Status.OK, {"state": self.state}
            case "heartbeat" if self._run is not None:
                self._run.heard_s = self.now_s
        return Status.OK, {}

    def _status(self) -> Fields:
        return {
            "state": self.state,
            "fault": Fault.NONE,
            "tick": self.tick % 2**32,
            "position": self.position % 2**32,
            "current_raw": ZERO_RAW,
            "terminal_voltage_raw": 0,
            "supply_voltage_raw": round(SUPPLY_V / VOLTS_COUNT),
            "dropped": 0,
        }

    def end(self, reason: EndReason) -> None:
        """The bridge opens, and the board says so."""
        run, self._run = self._run, None
        assert run is not None
        self.state = State.FAULTED if reason is EndReason.FAULT else State.LOADED
        counts = {"blocks": run.blocks, "samples": run.samples, "dropped": 0}
        self.say(encode_event("done", reason=reason, tick=self.tick % 2**32, **counts))


class _Run:
    """A program under way."""

    def __init__(self, board: HostileBoard, start: int) -> None:
        self.board, self.start = board, board.tick + (start - board.tick) % 2**32
        self.period = board.config["sample_period_ticks"]
        self.channels = mask_channels(board.config["channels"])
        self.steps = list(board.steps)
        self.begins = np.cumsum([0, *(step["ticks"] for step in self.steps)])
        self.heard_s = board.now_s
        self.blocks = self.samples = 0
        self.phase = 0

    def next_s(self) -> float:
        return (self.start + (self.samples + BLOCK) * self.period) / CLOCK_HZ

    def advance(self) -> None:
        board = self.board
        silence_s = board.config["host_silence_ms"] / 1e3
        while board.running and self.next_s() <= board.now_s:
            if board.now_s - self.heard_s > silence_s:
                board.say(encode_event("fault", fault=Fault.HOST_SILENCE, tick=0, value=0))
                board.end(EndReason.FAULT)
                return
            self._block()
            if board.ends and self.start + self.samples * self.period >= self.start + self._ticks():
                board.end(EndReason.COMPLETED)

    def _ticks(self) -> int:
        return int(self.begins[-1])

    def _block(self) -> None:
        ticks = (self.samples + np.arange(BLOCK)) * self.period
        index = np.searchsorted(self.begins, ticks, side="right") - 1
        while self.phase <= min(int(index[-1]), len(self.steps) - 1):
            tick = (self.start + int(self.begins[self.phase])) % 2**32
            self.board.say(encode_event("phase", index=self.phase % 256, tick=tick))
            self.phase += 1
        rows = [self._row(self.steps[min(int(n), len(self.steps) - 1)]) for n in index]
        self.board.say(
            encode_event(
                "sample_block",
                sequence=self.blocks % 2**16,
                first_tick=(self.start + int(ticks[0])) % 2**32,
                dropped=0,
                position=rows[0][1] % 2**32,
                channels=channel_mask(self.channels),
                samples=np.array([row[0] for row in rows], dtype=np.int16),
            )
        )
        self.blocks += 1
        self.samples += BLOCK

    def _row(self, step: Fields) -> tuple[list[int], int]:
        """Readings of the run's channels, and the full position."""
        driven = step["kind"] in (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)
        braked = step["kind"] == StepKind.BRAKE
        volts = step["level"] / (1e6 / SUPPLY_V if step["kind"] == StepKind.DRIVE_DUTY else 1e3)
        noise = (self.samples * 7919 + self.board.position) % 3 - 1
        self.board.position += COUNTS_A_SAMPLE if driven else 0
        readings = {
            Channel.CURRENT: ZERO_RAW + noise + DRIVEN_RAW * (driven - braked),
            Channel.TERMINAL_VOLTAGE: noise + (round(volts / VOLTS_COUNT) if driven else 0),
            Channel.SUPPLY_VOLTAGE: round(SUPPLY_V / VOLTS_COUNT) + noise,
            Channel.POSITION: (self.board.position + 2**15) % 2**16 - 2**15,
        }
        return [readings[channel] for channel in self.channels], self.board.position


class HostilePort:
    """The board behind a port whose time moves only while the host waits or bytes cross.

    ``mangle`` makes of each payload what goes on the wire, in whole; ``before_read`` acts on time.
    """

    name = "hostile://"

    def __init__(self, mangle: Callable[[bytes], list[bytes]]) -> None:
        self.board = HostileBoard(self._say)
        self.sent: list[Command] = []
        self.read_bytes = 0
        self.reads = 0
        self.gone = False
        self.hush = self.deaf = False
        self.before_read: Callable[[], None] = lambda: None
        self._mangle = mangle
        self._up: deque[bytes] = deque()
        self._decoder = Decoder()

    def _say(self, payload: bytes) -> None:
        if not self.hush:
            self._up.extend(self._mangle(payload))

    def put(self, data: bytes) -> None:
        """Bytes on the wire to the host."""
        self._up.append(data)

    def read(self, size: int, timeout_s: float) -> bytes:
        """See Port."""
        self.reads += 1
        self.before_read()
        self._check()
        until = self.now() + timeout_s
        while not self._up:
            due = self.board.next_s()
            self.board.advance(min(due, until))
            if not self._up and self.now() >= until:
                return b""
        data = bytearray()
        while self._up and len(data) < size:
            piece, room = self._up.popleft(), size - len(data)
            data += piece[:room]
            if len(piece) > room:
                self._up.appendleft(piece[room:])
        self.board.advance(self.now() + BYTE_S * len(data))
        self.read_bytes += len(data)
        return bytes(data)

    def write(self, data: bytes) -> None:
        """See Port."""
        self._check()
        for frame in self._decoder.feed(data):
            if isinstance(frame, Frame):
                command = decode(frame.payload)
                assert isinstance(command, Command)
                self.sent.append(command)
                if not self.deaf:
                    self.board.hear(frame.payload)

    def now(self) -> float:
        """See Port."""
        return self.board.now_s

    def close(self) -> None:
        """See Port."""

    def _check(self) -> None:
        if self.gone:
            raise LinkError(f"{self.name}: the link broke")
