"""The client of a board: asks one thing at a time, hears what the board says unasked."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from motorid.acquire.facts import wrong_descriptor, wrong_identity, wrong_zero
from motorid.acquire.link import Port
from motorid.acquire.resets import BoardResetError, reset_error
from motorid.errors import LinkError, MotoridError, RigError
from motorid.program import Step, StepKind
from motorid.wire.codec import (
    BadPayload,
    Event,
    Reply,
    SampleBlock,
    decode,
    encode_command,
    name_of,
)
from motorid.wire.enums import Channel, Mode, State, Status
from motorid.wire.framing import DELIMITER, BadFrame, Decoder, encode
from motorid.wire.hashes import layout_hash
from motorid.wire.spec import load

READ_BYTES = 4096
REPLY_S = 0.3
TRIES = 4
IDENTIFY_S = 5.0  # opening the port resets many boards, whose boot loaders then wait a while
ZERO_S = 5.0
REST_S = 0.15  # standing still this long is rest
GLANCE_S = 0.02  # the longest wait of a host that may be asked to stop
Fields = dict[str, Any]
News = Event | SampleBlock

AT_FAULT = "its firmware is at fault, or it is no motorid board"
RESET = "the board has lost what it was sent: check its supply and its cable"
REFUSALS: Mapping[Status, tuple[type[MotoridError], str]] = {
    Status.BAD_VALUE: (RigError, "the board cannot do a value asked for: compare rig and board"),
    Status.BAD_STATE: (LinkError, "the board is in a state that does not allow it: reset it"),
    Status.HASH_MISMATCH: (LinkError, "limits or program did not arrive as sent: try again"),
    Status.NOT_CONFIGURED: (LinkError, RESET),
    Status.PROGRAM_EMPTY: (LinkError, RESET),
    Status.FAULT_LATCHED: (RigError, "a fault is latched: see what the board trips on"),
    Status.PROGRAM_FULL: (RigError, "the program has more steps than the board holds"),
    Status.NOT_SUPPORTED: (RigError, "the board does not support it: see its identity"),
    Status.EDGE_CEILING: (
        RigError,
        "limits.speed_rad_s is faster than the board can count this encoder: lower it",
    ),
    Status.MAJOR_MISMATCH: (LinkError, "the board refuses this protocol version: update it"),
    Status.INPUT_OPEN: (RigError, "a contact of limits.inputs is open: close guard and fixture"),
    Status.NO_FRONT_END: (
        RigError,
        "it has no valid facts of its front end: `motorid board set FILE` stores them",
    ),
    Status.NOT_AT_REST: (RigError, "the motor is turning: let it come to rest first"),
}


class AskedToStopError(Exception):
    """The host was asked to stop while it waited for a reply."""


class Board:
    """One board behind a port. Methods raise LinkError where it goes silent.

    ``hasten``, where it is set, says whether to wait for replies no longer: AskedToStopError.
    """

    def __init__(self, port: Port, first_request: int = 1) -> None:
        self.port = port
        self.news: deque[News] = deque()
        self.identity: Fields = {}
        self.descriptors: dict[str, Fields] = {}
        self.bad_frames = 0
        self.good_frames = 0
        self.heard_at = port.now()
        self.reset: BoardResetError | None = None  # since it was identified
        self.hasten: Callable[[], bool] | None = None
        self.opens = True  # the bridge's driver can, as far as the front end's facts tell
        self.trip = ""  # what tripped in the latest run, where the board told more than its name
        self._received = 0
        self._request = first_request % 0xFFFF
        self._decoder = Decoder()
        self._awaited: tuple[str, int] | None = None  # command and request
        self._reply: Reply | None = None

    # -- talking
    def rest_step(self, seconds: float) -> Step:
        """A step without drive: the bridge open, or braking where its driver cannot open it."""
        return Step(StepKind.COAST if self.opens else StepKind.BRAKE, seconds)

    def ask(self, name: str, /, timeout_s: float = REPLY_S, **fields: Any) -> Fields:
        """Sends a command, as often as it takes under one id, and returns its reply's fields.

        Raises LinkError when no reply comes or the board was reset, or what REFUSALS says when the
        board refuses.
        """
        reply = self._exchange(name, timeout_s, TRIES, fields)
        if self.reset is not None:
            raise self.reset
        if reply is None:
            raise LinkError(
                f"{self.port.name}: the board does not answer {name} any more: check the cable "
                "and the board's power"
            )
        if reply.status is not Status.OK:
            self.check_same()
            kind, why = REFUSALS.get(reply.status, (LinkError, "this is a fault of the firmware"))
            status = reply.status.name.lower()
            raise kind(f"{self.port.name}: the board refused {name} ({status}): {why}")
        return reply.fields

    def ask_ticks(self, times: int) -> None:
        """Asks for its tick so often; by when the journal says that was, its clock is judged."""
        for _ in range(times):
            self.ask("read_status")

    def tell(self, name: str, /, **fields: Any) -> None:
        """Sends a command and does not wait: its reply is counted when it comes."""
        self.port.write(encode(encode_command(name, self._next_request(), **fields)))

    def hear(self, timeout_s: float) -> bool:
        """Takes what has arrived, waiting at most ``timeout_s``; False when nothing came."""
        data = self.port.read(READ_BYTES, timeout_s)
        self._received += len(data)
        for frame in self._decoder.feed(data):
            self._take(frame.payload if not isinstance(frame, BadFrame) else None)
        return bool(data)

    def wait(self, duration_s: float) -> None:
        """Lets time pass on the port's clock, hearing what comes."""
        until = self.port.now() + duration_s
        while (left := until - self.port.now()) > 0 and self.hear(left):
            pass

    def _take(self, payload: bytes | None) -> None:
        try:
            message = decode(payload) if payload is not None else None
        except BadPayload:
            message = None
        if isinstance(message, Event | SampleBlock | Reply):
            self.good_frames += 1
            self.heard_at = self.port.now()
        match message:
            case Reply() if (message.name, message.request) == self._awaited:
                self._reply = self._reply or message  # a second one is none
            case Reply():
                pass  # nobody waits for it: to a heartbeat, or late
            case Event() | SampleBlock():
                self._note_reset(message)
                self.news.append(message)
            case _:
                self.bad_frames += 1

    def _note_reset(self, message: News) -> None:
        """A board greets once after every reset, and what greeted before identify is over."""
        if isinstance(message, Event) and message.name == "hello" and self.identity:
            cause = message.fields["reset_cause"]
            self.reset = reset_error(self.port.name, cause, "while it was in use")

    def _exchange(
        self, name: str, timeout_s: float, tries: int, fields: Mapping[str, Any]
    ) -> Reply | None:
        request = self._next_request()
        frame = encode(encode_command(name, request, **fields))
        self._awaited, self._reply = (name, request), None
        try:
            for _ in range(tries):
                self.port.write(frame)
                reply = self._await_reply(timeout_s)
                if reply is not None or self.reset is not None:
                    return reply
        finally:
            self._awaited = None
        return None

    def _await_reply(self, timeout_s: float) -> Reply | None:
        until = self.port.now() + timeout_s
        while (left := until - self.port.now()) > 0:
            if self.hasten is not None and self.hasten():
                raise AskedToStopError
            heard = self.hear(left if self.hasten is None else min(left, GLANCE_S))
            if self.reset is not None:
                return None
            if self._reply is not None:
                return self._reply
            if not heard and self.hasten is None:
                break
        return None

    def _next_request(self) -> int:
        self._request = self._request % 0xFFFF + 1  # 1 to 65535: 0 means none
        return self._request

    # -- who is there
    def identify(self) -> Fields:
        """Who answers, with its channels described. Raises LinkError when no motorid board does."""
        spec = load()
        self.port.write(DELIMITER)  # ends whatever the board had half read
        reply = self._exchange("identify", IDENTIFY_S / 10, 10, _version())
        if reply is None:
            raise LinkError(self._why_nobody())
        if reply.status is Status.MAJOR_MISMATCH:
            raise LinkError(
                f"{self.port.name}: the board speaks another version of the protocol than "
                f"{spec.major}.{spec.minor}: install the firmware or the motorid that matches"
            )
        found = reply.fields
        if reply.status is not Status.OK:
            raise LinkError(f"{self.port.name}: the board refused to identify itself: reset it")
        if found["protocol_major"] != spec.major:
            raise LinkError(
                f"{self.port.name}: the board speaks protocol {found['protocol_major']}."
                f"{found['protocol_minor']}, this motorid {spec.major}.{spec.minor}: install the "
                "firmware or the motorid that matches"
            )
        if found["protocol_minor"] == spec.minor and found["layout_hash"] != layout_hash():
            raise LinkError(
                f"{self.port.name}: the board's messages differ from this motorid's though both "
                f"say protocol {spec.major}.{spec.minor}: rebuild its firmware"
            )
        if wrong := wrong_identity(found):
            raise LinkError(f"{self.port.name}: the board says {wrong}: {AT_FAULT}")
        self.identity = found
        self.describe(Mode.STREAM)
        return found

    def describe(self, mode: Mode) -> None:
        """Asks how the channels are sampled: as in a stream, or as in a fast burst."""
        for index in range(self.identity["channel_count"]):
            fact = self.ask("describe_channel", index=index, mode=mode)
            name = name_of(Channel, fact["channel"])
            if wrong := wrong_descriptor(fact):
                raise LinkError(
                    f"{self.port.name}: the board describes its channel {name} with {wrong}: "
                    f"{AT_FAULT}"
                )
            self.descriptors[name] = fact

    def check_same(self) -> None:
        """Raises LinkError when the board was reset since ``identify``, or another one answers."""
        known = self.identity.get("boot_id")
        reply = self._exchange("identify", REPLY_S, TRIES, _version())
        if self.reset is not None:
            raise self.reset
        if known is None or reply is None or reply.status is not Status.OK:
            return
        if reply.fields["boot_id"] != known:
            cause = reply.fields["reset_cause"]
            raise reset_error(self.port.name, cause, "while it was in use")

    def _why_nobody(self) -> str:
        if not self._received:
            return (
                f"{self.port.name}: nothing answers: is the board powered, its firmware loaded, "
                "and this its port? `motorid ports --probe` asks them all"
            )
        if self.good_frames:
            return (
                f"{self.port.name}: a motorid board speaks there but does not answer: check the "
                "line from this computer to it, or reset it"
            )
        return (
            f"{self.port.name}: something sends there ({self._received} bytes), but not "
            "motorid's protocol: it is another device, or set to another baud rate"
        )

    # -- state
    def make_ready(self) -> None:
        """Stops whatever still runs, waits for rest, and unlatches an earlier fault.

        Raises RigError when the motor goes on turning.
        """
        self.unlatch()
        self.wait_for_rest()

    def unlatch(self) -> None:
        """Stops whatever still runs, and unlatches an earlier fault."""
        self.ask("stop")
        if self.ask("read_status")["state"] == State.FAULTED:
            self.ask("clear_fault")

    def wait_for_rest(self, patience_s: float = 30.0) -> None:
        """Returns once the encoder has stood still a while. Raises RigError if it does not."""
        until = self.port.now() + patience_s
        before = self.position()
        while self.port.now() < until:
            self.wait(REST_S)
            after = self.position()
            if abs(after - before) <= 1:  # an edge under a line of the disc may flicker
                return
            before = after
        raise RigError(
            f"the encoder still moves {patience_s:.0f} s after the bridge opened: something else "
            "turns the motor, or the encoder's wires pick up noise"
        )

    def position(self) -> int:
        """Encoder counts, signed."""
        count = int(self.ask("read_status")["position"])
        return (count + (1 << 31)) % (1 << 32) - (1 << 31)

    def zero(self, samples: int) -> Fields:
        """Offsets at standstill, over so many readings. Raises LinkError on what is no reading."""
        found = self.ask("zero", timeout_s=ZERO_S, samples=samples)
        if wrong := wrong_zero(found):
            raise LinkError(f"{self.port.name}: the board says {wrong} at rest: {AT_FAULT}")
        return found

    def supply_v(self) -> float | None:
        """The supply's voltage now, or None where the board does not measure it."""
        fact = self.descriptors.get("supply_voltage")
        if fact is None:
            return None
        raw = self.ask("read_status")["supply_voltage_raw"]
        return float(fact["scale"] * (raw - fact["offset"]))


def _version() -> Fields:
    spec = load()
    return {"host_major": spec.major, "host_minor": spec.minor}
