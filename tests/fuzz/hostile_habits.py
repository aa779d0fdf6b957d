"""What a hostile board does to its own words, drawn by a seed."""

from __future__ import annotations

import math
import random
import signal
from dataclasses import dataclass
from typing import Any

from motorid.acquire import interrupt
from motorid.wire.codec import (
    BadPayload,
    Event,
    Reply,
    SampleBlock,
    channel_mask,
    decode,
    encode_event,
    encode_reply,
)
from motorid.wire.enums import Status
from motorid.wire.framing import encode
from motorid.wire.spec import FORMATS, load
from tests.fuzz.hostile_board import HostilePort

FLOATS = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1e38, 1e-38, -3e38)
HABITS = (
    *("field", "start_tick", "grid", "tick", "dropped", "channels", "drop", "double", "swap"),
    *("truncate", "cut", "corrupt", "unknown", "garbage", "spurious", "refuse", "flood", "reset"),
    *("mute", "unplug", "endless", "deaf", "ends early", "end lost", "request"),
)
NAMES = (
    *("identify", "describe_channel", "configure", "read_config", "add_step", "start", "stop"),
    *("zero", "read_status", "sample_block", "phase", "done", "heartbeat"),
)

OF_ONE = {
    **dict.fromkeys(("grid", "tick", "dropped", "channels", "ends early"), "sample_block"),
    "start_tick": "start",
    "end lost": "done",
}


@dataclass
class Habit:
    """What it does, to which messages, how often, and from which run on (1: the check pulse)."""

    what: str
    name: str
    odds: float
    run: int
    amount: int


class Hostility:
    """The habits of one case. ``mangle`` is the port's; ``signal_at_s`` interrupts the host."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        rng = self.rng
        self.habits = [self._draw() for _ in range(rng.choice((1, 1, 2, 2, 3)))]
        self.signal_at_s = rng.uniform(0.2, 1.5) if rng.random() < 0.1 else math.inf
        self.signal = rng.choice(interrupt.ASKING)
        self.port = HostilePort(self.mangle)
        self.port.before_read = self._on_time
        self._held: bytes | None = None
        self._acts_at_s = {n: rng.uniform(0.0, 1.5) for n in range(len(self.habits))}

    def __str__(self) -> str:
        return "; ".join(map(str, self.habits))

    def _draw(self) -> Habit:
        rng = self.rng
        what = rng.choice(HABITS)
        return Habit(
            what,
            OF_ONE.get(what) or rng.choice((*NAMES, "sample_block", "sample_block", "any")),
            rng.choice((0.05, 0.3, 1.0)),
            rng.choice((0, 1, 2, 2, 2, 2)),
            rng.choice((1, -1, 7, 1600, -1600, 16_000, rng.randrange(2**32), 2**31)),
        )

    # ------------------------------------------------------------------ by time

    def _on_time(self) -> None:
        port = self.port
        if port.now() >= self.signal_at_s:
            self.signal_at_s = math.inf
            signal.raise_signal(self.signal)
        for number, habit in enumerate(self.habits):
            if habit.run > port.board.runs or port.now() < self._acts_at_s[number]:
                continue
            self._act(habit)

    def _act(self, habit: Habit) -> None:
        port = self.port
        match habit.what:
            case "mute":
                port.hush = True
            case "deaf":
                port.deaf = True
            case "unplug":
                port.gone = True
            case "endless":
                port.board.ends = port.board.heeds_stop = False
            case "reset":
                habit.run = 1000
                port.board.reset()
            case "flood":
                for _ in range(1 + habit.amount % 20):
                    port.put(encode(self._invented()))

    # ------------------------------------------------------------------ by message

    def mangle(self, payload: bytes) -> list[bytes]:
        """What goes on the wire in place of a payload."""
        pieces = [payload]
        for habit in self.habits:
            if habit.run <= self.port.board.runs and self.rng.random() < habit.odds:
                pieces = [new for one in pieces for new in self._changed(habit, one)]
        frames = [one if one.startswith(b"\0") else encode(one) for one in pieces if one]
        held, self._held = self._held, None
        return [*frames, held] if held is not None and frames else frames

    def _changed(self, habit: Habit, payload: bytes) -> list[bytes]:
        """Payloads; one that begins with a zero byte goes out as it is."""
        rng = self.rng
        if payload.startswith(b"\0") or habit.name not in ("any", name_of(payload)):
            return [payload]
        match habit.what:
            case "drop":
                return []
            case "double":
                return [payload, payload]
            case "swap":
                self._held = encode(payload)
                return []
            case "truncate":
                return [payload[: rng.randrange(1, len(payload) + 1)]]
            case "cut":
                frame = encode(payload)
                return [b"\0" + frame[: rng.randrange(1, len(frame))]]
            case "corrupt":
                frame = bytearray(encode(payload))
                frame[rng.randrange(len(frame))] ^= 1 << rng.randrange(8)
                return [b"\0" + bytes(frame)]
            case "unknown":
                return [bytes([rng.randrange(256)]) + payload[1:]]
            case "garbage":
                return [b"\0" + rng.randbytes(rng.randrange(1, 400)), payload]
            case "spurious":
                return [self._invented(), payload]
            case _:
                return self._reworded(habit, payload)

    def _reworded(self, habit: Habit, payload: bytes) -> list[bytes]:
        """The same message, with other words in it."""
        if not name_of(payload):
            return [payload]
        message = decode(payload)
        match habit.what, message:
            case "field", Reply() | Event() if message.fields:
                key = self.rng.choice(sorted(message.fields))
                return [again(message, {key: self._wild(message, key)})]
            case "start_tick", Reply(name="start"):
                tick = (message.fields["start_tick"] + habit.amount) % 2**32
                return [again(message, {"start_tick": tick})]
            case "request", Reply():
                return [encode_reply(message.name, 0xFFFF, message.status, **message.fields)]
            case "refuse", Reply():
                status = self.rng.choice([s for s in Status if s])
                return [encode_reply(message.name, message.request, status)]
            case "ends early", SampleBlock():
                counts = {"blocks": 1, "samples": self.rng.randrange(2**32), "dropped": 2**32 - 1}
                return [encode_event("done", reason=self.rng.randrange(256), tick=0, **counts)]
            case "end lost", Event(name="done"):
                return []
            case "grid" | "tick" | "dropped" | "channels", SampleBlock():
                return [self._reblocked(habit, message)]
        return [payload]

    def _reblocked(self, habit: Habit, block: SampleBlock) -> bytes:
        rng, fields = self.rng, {}
        match habit.what:
            case "grid":
                fields["first_tick"] = (block.first_tick + habit.amount) % 2**32
            case "tick":
                fields["first_tick"] = rng.choice((0, block.first_tick // 2, rng.randrange(2**32)))
            case "dropped":
                fields["dropped"] = 65535
            case "channels":
                mask = rng.randrange(256)
                return again(block, {}, mask)
        return again(block, fields)

    def _wild(self, message: Reply | Event, key: str) -> Any:
        """A value that the field's type takes and its meaning does not."""
        spec = load().commands if isinstance(message, Reply) else load().events
        fields = (
            spec[message.name].reply if isinstance(message, Reply) else spec[message.name].fields
        )
        kind = next(field.type for field in fields if field.name == key)
        if kind == "f32":
            return self.rng.choice(FLOATS)
        if kind == "text16":
            return "\x1b[31m" + "x" * self.rng.randrange(8)
        bits = 8 * {"b": 1, "h": 2, "i": 4}[FORMATS[kind].lower()]
        low = -(1 << bits - 1) if kind.startswith("i") else 0
        high = low + (1 << bits) - 1
        return self.rng.choice((low, high, 0, 1, self.rng.randint(low, high)))

    def _invented(self) -> bytes:
        """A message that nobody asked for, with any values."""
        rng = self.rng
        name = rng.choice(("hello", "done", "fault", "phase", "start", "zero", "identify"))
        spec = load()
        if name in spec.events:
            empty = Event(name, {field.name: 0 for field in spec.events[name].fields})
            fields = {key: self._wild(empty, key) for key in empty.fields}
            return encode_event(name, **fields)
        last = self.port.sent[-1].request if self.port.sent else 1
        blank = Reply(name, last, Status.OK, {f.name: 0 for f in spec.commands[name].reply})
        return again(blank, {key: self._wild(blank, key) for key in blank.fields})


def name_of(payload: bytes) -> str:
    """The message's name; "" where it is none any more."""
    try:
        return decode(payload).name
    except BadPayload:
        return ""


def again(message: Any, fields: dict[str, Any], mask: int | None = None) -> bytes:
    """A message's payload with other fields."""
    if isinstance(message, Reply):
        return encode_reply(
            message.name, message.request, message.status, **(message.fields | fields)
        )
    if isinstance(message, Event):
        return encode_event(message.name, **(message.fields | fields))
    old = {
        "sequence": message.sequence,
        "first_tick": message.first_tick,
        "dropped": message.dropped,
        "position": message.position,
        "channels": channel_mask(message.channels),
    }
    payload = bytearray(encode_event(message.name, **(old | fields), samples=message.samples))
    if mask is not None:
        payload[13] = mask  # after code, sequence, tick, dropped and position
    return bytes(payload)
