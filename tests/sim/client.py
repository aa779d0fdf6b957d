"""A small client of the wire protocol, for driving a simulated port in tests."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from motorid.sim.port import SimPort, open_sim
from motorid.wire.codec import Event, Reply, SampleBlock, decode, encode_command
from motorid.wire.enums import Decay, StepKind
from motorid.wire.framing import BadFrame, Decoder, encode
from motorid.wire.hashes import config_hash, program_hash

TICKS = 1600  # 100 us
CONFIG = {
    "sample_period_ticks": TICKS,
    "channels": 0b1111,
    "mode": 0,
    "encoder_reversed": 0,
    "current_limit_ma": 3000,
    "speed_limit_counts_s": 1_000_000,
    "supply_min_mv": 3000,
    "supply_max_mv": 9000,
    "run_time_limit_ms": 60_000,
    "host_silence_ms": 500,
}


def duty(level: float, samples: int, decay: Decay = Decay.SYNCHRONOUS_SLOW) -> dict[str, Any]:
    """A drive step of so many samples."""
    kind = StepKind.DRIVE_DUTY
    return {"kind": kind, "decay": decay, "level": round(level * 1e6), "ticks": samples * TICKS}


def volts(level: float, samples: int, decay: Decay = Decay.SYNCHRONOUS_SLOW) -> dict[str, Any]:
    """A drive step that holds a voltage."""
    kind = StepKind.DRIVE_VOLTS
    return {"kind": kind, "decay": decay, "level": round(level * 1e3), "ticks": samples * TICKS}


def coast(samples: int) -> dict[str, Any]:
    """A step with the bridge open."""
    return {"kind": StepKind.COAST, "decay": 0, "level": 0, "ticks": samples * TICKS}


def brake(samples: int) -> dict[str, Any]:
    """A step with the terminals shorted."""
    return {"kind": StepKind.BRAKE, "decay": 0, "level": 0, "ticks": samples * TICKS}


@dataclass
class Record:
    """What a run said."""

    blocks: list[SampleBlock] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    start_tick: int = 0

    @property
    def samples(self) -> np.ndarray:
        """All samples, (n, channels)."""
        return np.concatenate([block.samples for block in self.blocks])

    def event(self, name: str) -> Event:
        """The first event of that name."""
        return next(e for e in self.events if e.name == name)


class Client:
    """Sends commands, waits for replies, keeps everything else."""

    def __init__(self, options: str = "", **more: Any) -> None:
        query = "&".join([options, *(f"{k}={v}" for k, v in more.items())]).strip("&")
        self.port: SimPort = open_sim(f"sim://?speed=max&{query}" if query else "sim://?speed=max")
        self._decoder = Decoder()
        self._request = 0
        self.said: list[Event | SampleBlock] = []
        self.replies: list[Reply] = []
        self.bad = 0

    def listen(self, timeout_s: float = 0.1) -> bool:
        """Read once; False when nothing came."""
        data = self.port.read(4096, timeout_s)
        for frame in self._decoder.feed(data):
            if isinstance(frame, BadFrame):
                self.bad += 1
                continue
            message = decode(frame.payload)
            if isinstance(message, Reply):
                self.replies.append(message)
            elif isinstance(message, Event | SampleBlock):
                self.said.append(message)
        return bool(data)

    def send(self, name: str, /, request: int | None = None, **fields: Any) -> int:
        """Send without waiting; returns the request number."""
        if request is None:
            self._request += 1
            request = self._request
        self.port.write(encode(encode_command(name, request, **fields)))
        return request

    def ask(self, name: str, /, timeout_s: float = 2.0, **fields: Any) -> Reply:
        """Send and wait for the reply."""
        request = self.send(name, **fields)
        deadline = self.port.now() + timeout_s
        while self.port.now() < deadline:
            self.listen()
            for reply in self.replies:
                if reply.request == request:
                    self.replies.remove(reply)
                    return reply
        raise TimeoutError(f"no reply to {name}")

    def identify(self) -> Reply:
        """The first command."""
        return self.ask("identify", host_major=1, host_minor=0)

    def prepare(self, *steps: dict[str, Any], **config: Any) -> tuple[int, int]:
        """Configure and load; returns both hashes."""
        settings = CONFIG | config
        assert self.ask("configure", **settings).status == 0
        program = [{"index": index, **step} for index, step in enumerate(steps)]
        for step in program:
            reply = self.ask("add_step", **step)
            assert reply.status == 0, reply
        return config_hash(settings), program_hash(program)

    def run(self, *steps: dict[str, Any], beat: bool = True, **config: Any) -> Record:
        """A whole run, to ``done``."""
        hashes = self.prepare(*steps, **config)
        reply = self.ask("start", config_hash=hashes[0], program_hash=hashes[1])
        assert reply.status == 0, reply
        return self.follow(reply.fields["start_tick"], beat)

    def follow(self, start_tick: int, beat: bool = True) -> Record:
        """Read to ``done``, with heartbeats."""
        record = Record(start_tick=start_tick)
        while True:
            heard = self.listen()
            said, self.said = self.said, []
            for message in said:
                if isinstance(message, SampleBlock):
                    record.blocks.append(message)
                    if beat:
                        self.send("heartbeat", sequence=message.sequence)
                else:
                    record.events.append(message)
            if any(e.name == "done" for e in record.events):
                return record
            if not heard:
                raise TimeoutError("the board fell silent")
