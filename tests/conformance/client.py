"""A client that can misbehave: sends anything, keeps everything, judges nothing."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.port import Port
from motorid.wire.codec import BadPayload, Event, Reply, SampleBlock, decode, encode_command
from motorid.wire.enums import Channel, Decay, Fault, Feature, State, Status, StepKind
from motorid.wire.framing import DELIMITER, BadFrame, Decoder, encode
from motorid.wire.hashes import config_hash, program_hash
from motorid.wire.spec import load

Fields = dict[str, Any]
U32 = 0xFFFF_FFFF
LIMITS = load().limits
DEADLINE_S = LIMITS.reply_deadline_ms * 1e-3
BEAT_S = LIMITS.heartbeat_period_ms * 1e-3
GENTLE = 0.4  # duty that a bench's motor bears from standstill
ALL = 0b1111
OUT_OF_STEP_S = 2.7e-3  # with a board's blocks, whose sealing makes it deaf to a long command


@dataclass
class Record:
    """What a run said, in the order of its coming."""

    start_tick: int
    told: list[Event | SampleBlock] = field(default_factory=list)

    @property
    def blocks(self) -> list[SampleBlock]:
        return [message for message in self.told if isinstance(message, SampleBlock)]

    @property
    def events(self) -> list[Event]:
        return [message for message in self.told if isinstance(message, Event)]

    @property
    def samples(self) -> NDArray[np.int16]:
        """All samples, (n, channels)."""
        return np.concatenate([block.samples for block in self.blocks])

    def all(self, name: str) -> list[Fields]:
        """The fields of every event of that name."""
        return [event.fields for event in self.events if event.name == name]

    def one(self, name: str) -> Fields:
        """The fields of the only event of that name."""
        (fields,) = self.all(name)
        return fields

    def channel(self, channel: Channel) -> NDArray[np.int16]:
        """One channel's raw samples."""
        return self.samples[:, self.blocks[0].channels.index(channel)]


class Client:
    """One end of the wire; the board is the other."""

    def __init__(self, port: Port, deadline_s: float = DEADLINE_S) -> None:
        """``deadline_s``: for a reply; longer than promised where a board shares a computer."""
        self.port = port
        self.deadline_s = deadline_s
        self.identity: Fields = {}
        self.descriptors: dict[Channel, Fields] = {}
        self.settings: Fields = {}
        self.told: list[Event | SampleBlock] = []
        self.replies: list[Reply] = []
        self.payloads: list[bytes] = []  # of everything that came
        self.bad: list[bytes] = []
        self._decoder = Decoder()
        self._request = 100

    # ------------------------------------------------------------------ bytes

    def listen(self, timeout_s: float = 0.02) -> bool:
        """Read once; False when nothing came."""
        data = self.port.read(4096, timeout_s)
        for frame in self._decoder.feed(data):
            if isinstance(frame, BadFrame):
                self.bad.append(frame.data)
            else:
                self._take(frame.payload)
        return bool(data)

    def _take(self, payload: bytes) -> None:
        self.payloads.append(payload)
        try:
            message = decode(payload)
        except BadPayload:
            return  # a reply to a command that no spec knows; it stays in payloads
        if isinstance(message, Reply):
            self.replies.append(message)
        elif isinstance(message, Event | SampleBlock):
            self.told.append(message)

    def wait(self, seconds: float) -> None:
        """Let time pass, hearing what comes."""
        until = self.port.now() + seconds
        while (left := until - self.port.now()) > 1e-9:
            self.listen(min(left, 0.02))

    def exchange(self, data: bytes, seconds: float = 0.1) -> list[bytes]:
        """Send bytes; the payloads that come within that time."""
        self.payloads.clear()
        self.port.write(data)
        self.wait(seconds)
        return list(self.payloads)

    # ------------------------------------------------------------------ commands

    def next_request(self) -> int:
        self._request += 1
        return self._request

    def send(self, name: str, request: int | None = None, /, **fields: Any) -> int:
        """Send without waiting; the request's number."""
        request = self.next_request() if request is None else request
        self.port.write(encode(encode_command(name, request, **fields)))
        return request

    def await_reply(self, request: int, timeout_s: float | None = None) -> Reply:
        """The reply with that number. Raises TimeoutError."""
        timeout_s = self.deadline_s if timeout_s is None else timeout_s
        until = self.port.now() + timeout_s
        while True:
            for reply in self.replies:
                if reply.request == request:
                    self.replies.remove(reply)
                    return reply
            if self.port.now() >= until:
                raise TimeoutError(f"no reply to request {request} within {timeout_s} s")
            self.listen()

    def ask(self, name: str, request: int | None = None, /, **fields: Any) -> Reply:
        """Send and wait for the reply, which must come in time."""
        return self.await_reply(self.send(name, request, **fields))

    def insist(self, name: str, timeout_s: float, /, **fields: Any) -> Reply:
        """Send until a reply comes, as hosts do: a busy board may lose a long command."""
        request = self.next_request()
        for _ in range(LIMITS.attempts - 1):
            self.send(name, request, **fields)
            with contextlib.suppress(TimeoutError):
                return self.await_reply(request, timeout_s)
            self.port.write(DELIMITER)  # ends what is left of it
            self.wait(OUT_OF_STEP_S)
        self.send(name, request, **fields)
        return self.await_reply(request, timeout_s)

    def get(self, name: str, /, **fields: Any) -> Fields:
        """The fields of a reply that must be ok."""
        reply = self.ask(name, **fields)
        assert reply.status is Status.OK, reply
        return reply.fields

    # ------------------------------------------------------------------ bringing up

    def bring_up(self) -> None:
        """Identify, describe, unlatch, and choose settings that this board and bench bear."""
        self.port.write(DELIMITER)
        until = self.port.now() + LIMITS.boot_deadline_ms * 1e-3
        while True:
            try:
                reply = self.ask("identify", host_major=load().major, host_minor=load().minor)
                break
            except TimeoutError:
                if self.port.now() > until:
                    raise
        self.identity = reply.fields
        for index in range(self.identity["channel_count"]):
            fact = self.get("describe_channel", index=index)
            self.descriptors[Channel(fact["channel"])] = fact
        self.get("stop")
        if self.get("read_status")["state"] == State.FAULTED:
            self.get("clear_fault")
        self.wait(0.01)  # until there are readings
        self.settings = self._settings()

    def value(self, channel: Channel, raw: float) -> float:
        """A raw reading in SI units."""
        fact = self.descriptors[channel]
        return float(fact["scale"]) * (raw - float(fact["offset"]))

    def _settings(self) -> Fields:
        identity = self.identity
        step = identity["sample_period_step_ticks"]
        shortest = max(identity["min_sample_period_ticks"], identity["clock_hz"] / 10_000)
        supply = 1000 * self.value(
            Channel.SUPPLY_VOLTAGE, self.get("read_status")["supply_voltage_raw"]
        )
        return {
            "sample_period_ticks": step * math.ceil(shortest / step),
            "channels": ALL,
            "mode": 0,
            "encoder_reversed": 0,
            "current_limit_ma": identity["max_current_ma"],
            "speed_limit_counts_s": identity["encoder_edge_ceiling_hz"],
            "supply_min_mv": round(0.5 * supply),
            "supply_max_mv": round(1.5 * supply),
            "run_time_limit_ms": 60_000,
            "host_silence_ms": 500,
            **{field.name: 0 for field in load().commands["configure"].fields if field.since},
        }

    def has(self, feature: Feature) -> bool:
        """Whether the board says that it has that feature."""
        return bool(self.identity["features"] >> feature & 1)

    # ------------------------------------------------------------------ steps

    @property
    def period(self) -> int:
        """Ticks from sample to sample, as the settings have it."""
        return int(self.settings["sample_period_ticks"])

    def seconds(self, samples: int) -> float:
        """So many sample periods."""
        return float(samples * self.period / self.identity["clock_hz"])

    def _decay(self) -> Decay:
        """The first decay mode that the board has."""
        return next(mode for mode in Decay if mode and self.identity["decay_modes"] >> mode & 1)

    def drive(self, samples: int, duty: float = GENTLE) -> Fields:
        """A drive_duty step of so many samples."""
        return {
            "kind": StepKind.DRIVE_DUTY,
            "decay": self._decay(),
            "level": round(duty * 1e6),
            "ticks": samples * self.period,
        }

    def hold(self, samples: int, volts: float) -> Fields:
        """A drive_volts step."""
        return self.drive(samples) | {
            "kind": StepKind.DRIVE_VOLTS,
            "level": round(volts * 1e3),
        }

    def coast(self, samples: int) -> Fields:
        """A step with the bridge open."""
        return {"kind": StepKind.COAST, "decay": 0, "level": 0, "ticks": samples * self.period}

    def brake(self, samples: int) -> Fields:
        """A step with the terminals shorted."""
        return self.coast(samples) | {"kind": StepKind.BRAKE}

    # ------------------------------------------------------------------ runs

    def configure(self, **changes: Any) -> Reply:
        """The settings with these changes."""
        self.settings = self.settings | changes
        return self.ask("configure", **self.settings)

    def load(self, steps: Sequence[Fields], **changes: Any) -> Fields:
        """Configure and load; the fields of ``start``."""
        assert self.configure(**changes).status is Status.OK
        program = [{"index": index, **step} for index, step in enumerate(steps)]
        for step in program:
            self.get("add_step", **step)
        return {
            "config_hash": config_hash(self.settings, self.identity["protocol_minor"]),
            "program_hash": program_hash(program),
        }

    def start(self, *steps: Fields, **changes: Any) -> Record:
        """Begin a run."""
        hashes = self.load(steps, **changes)
        self.told.clear()
        return Record(self.get("start", **hashes)["start_tick"])

    def follow(self, record: Record, beat: bool = True, patience_s: float = 5.0) -> Record:
        """Hear a run to its end, with heartbeats or without.

        A board that answers heartbeats and tells nothing of a run has forgotten it.
        """
        beat_at = heard_at = self.port.now()
        while not record.told or record.told[-1].name != "done":
            now = self.port.now()
            if beat and now >= beat_at:
                beat_at = now + BEAT_S
                self.send("heartbeat", sequence=0)
            self.listen()
            if self.told:
                heard_at = now
            assert now - heard_at < patience_s, "the board fell silent"
            while self.told and (not record.told or record.told[-1].name != "done"):
                record.told.append(self.told.pop(0))
        return record

    def run(self, *steps: Fields, beat: bool = True, **changes: Any) -> Record:
        """A whole run, to ``done``."""
        return self.follow(self.start(*steps, **changes), beat)

    def rest(self) -> None:
        """Wait until the encoder stands still."""
        before = None
        while before != (now := self.get("read_status")["position"]):
            before = now
            self.wait(0.2)

    @property
    def state(self) -> State:
        """As read_status has it."""
        return State(self.get("read_status")["state"])

    @property
    def fault(self) -> Fault:
        """The latched fault."""
        return Fault(self.get("read_status")["fault"])
