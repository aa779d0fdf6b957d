"""The device end of the wire: state machine, commands and replies of the simulated board."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np

from motorid.sim import identity
from motorid.sim.bench import Bench, Raw
from motorid.sim.chain import draw_chain, idle_period
from motorid.sim.front_end import FrontEnd
from motorid.sim.options import CLOCK_HZ, Options
from motorid.sim.run import Run
from motorid.sim.stream import U32, Stream
from motorid.wire.codec import (
    BadPayload,
    Command,
    decode,
    encode_event,
    encode_refusal,
    encode_reply,
)
from motorid.wire.enums import Fault, FrontEndSource, ResetCause, State, Status, StepKind
from motorid.wire.hashes import program_hash
from motorid.wire.spec import COMMAND_HEADER, REPLY_HEADER, Field, fields_size, load

IDENTIFY = load().commands["identify"].code
NEW_COMMANDS = {"describe_input": 3, "read_front_end": 3, "write_front_end": 3}
IDLE_STRETCH = 512  # samples taken at once while nothing runs
MAX_ZERO = 4096
AGE_TICKS = load().limits.block_age_ms * CLOCK_HZ // 1000
Fields = dict[str, Any]
Answer = tuple[Status, Fields]
OK = Status.OK


class Board:
    """A board and the bench it is wired to. Knows no bytes below payloads and no wall clock.

    ``send`` takes the payloads it says, ``has_room`` tells whether the link takes more samples.
    ``seconds`` is true time since power-on; it moves only by ``advance``.
    """

    def __init__(
        self,
        options: Options,
        send: Callable[[bytes], None],
        has_room: Callable[[], bool] = lambda: True,
        major: int | None = None,
    ) -> None:
        self.options = options
        self.chain = draw_chain(options)
        self.front_end = FrontEnd(self.chain, options.front_end == "compiled")
        self.bench = Bench(options, self.chain)
        self.major = load().major if major is None else major
        self._send, self._has_room = send, has_room
        self.seconds = 0.0
        self.tick = options.first_tick  # of the last sample; grows without wrapping
        self.since_sample_s = 0.0  # true time since then, at which a command came
        self.boots = 0
        self.runs = 0
        self.on_run: Callable[[], None] = lambda: None
        self._boot(ResetCause.POWER_ON)

    # ------------------------------------------------------------------ resets and time

    def _boot(self, cause: ResetCause) -> None:
        self.boots += 1
        seed = f"{self.options.seed}/{self.options.motor}/{self.boots}"
        self.boot_id = zlib.crc32(seed.encode())
        self.reset_cause = cause
        hung = cause == ResetCause.WATCHDOG
        self.state = State.FAULTED if hung else State.IDLE
        self.fault = Fault.WATCHDOG if hung else Fault.NONE
        self.config: Fields | None = None
        self.steps: list[Fields] = []
        self.run: Run | None = None
        self.dropped = 0  # in the last run
        self.inputs = identity.INPUTS  # bit n: input n is closed
        self._host_major = self.major
        self._kept: tuple[int, bytes] | None = None  # last request and its reply
        self._zeroing: _Zeroing | None = None
        self._period = idle_period(self.options, self.chain)
        self._send(encode_event("hello", boot_id=self.boot_id, reset_cause=cause))

    @property
    def clock(self) -> int:
        """Ticks of the board's clock, which goes on between samples; no sample is due yet."""
        since = math.floor(self.since_sample_s * self.chain.clock_hz)
        return self.tick + min(max(since, 0), self._period - 1)

    def reset(self, cause: ResetCause) -> None:
        """Restart the processor: bridge open, everything forgotten, ticks from 0."""
        self.bench.arm(None)
        self.bench.set_period(idle_period(self.options, self.chain))
        self.bench.command(StepKind.COAST)
        self.tick = 0
        self._boot(cause)

    def advance(self, samples: int) -> None:
        """Let so many sample periods pass."""
        while samples > 0:
            if self.run is not None:
                taken = self._advance_run(self.run, samples)
            else:
                taken = self._advance_idle(samples)
            samples -= taken
            self.seconds += taken * self.bench.period_s

    def notice(self, fault: Fault, value: int = 0) -> None:
        """The board sees a fault of its own: the bridge opens, and a run ends."""
        self.bench.command(StepKind.COAST)
        if self.run is not None:
            self.run.trip(fault, value)
            self._end_run(self.run)

    def set_inputs(self, closed: int) -> None:
        """Contacts change: bit n, input n is closed. A run that requires another one ends."""
        self.inputs = closed
        if self.run is not None and (missing := self._missing_inputs()):
            self.run.trip(Fault.INPUT_OPENED, missing)
            self._end_run(self.run)

    def _missing_inputs(self) -> int:
        return self.config["inputs_required"] & ~self.inputs if self.config else 0

    def _advance_run(self, run: Run, samples: int) -> int:
        taken = run.advance(samples)
        self.tick = run.tick - self._period
        if run.over:
            self._end_run(run)
        return taken

    def _end_run(self, run: Run) -> None:
        self.run = None
        self.dropped = run.stream.dropped
        self.fault = run.fault
        self.state = State.FAULTED if run.fault else State.LOADED

    def _advance_idle(self, samples: int) -> int:
        zeroing = self._zeroing
        raw, counts = self.bench.run(min(samples, zeroing.left if zeroing else IDLE_STRETCH))
        self.tick += len(counts) * self._period
        if zeroing:
            zeroing.add(raw, bool(np.ptp(np.append(counts, zeroing.count))))
            if zeroing.moved or not zeroing.left:
                self._end_zero(zeroing.answer())
        return len(counts)

    def _end_zero(self, answer: Answer) -> None:
        zeroing, self._zeroing = self._zeroing, None
        if zeroing is not None:
            self.state = zeroing.before
            self._answer("zero", zeroing.request, answer)

    # ------------------------------------------------------------------ commands

    def receive(self, payload: bytes) -> None:
        """Execute a command and send its reply; ``docs/protocol.md`` gives the order of checks."""
        try:
            command = decode(self._understood(payload))
        except BadPayload as error:
            self._refuse(error, payload)
            return
        if not isinstance(command, Command):
            return
        name, request = command.name, command.request
        self._fields = self._understood(payload)[COMMAND_HEADER:]
        if self._repeated(payload[0], request):
            return
        refusal = self._refusal(name)
        answer = (refusal, {}) if refusal else self._execute(command)
        if answer is not None:
            self._answer(name, request, answer)

    def _understood(self, payload: bytes) -> bytes:
        """A command without the fields that a later minor appended."""
        name = next((n for n, m in load().commands.items() if payload[:1] == bytes([m.code])), None)
        if name is None:
            return payload
        return payload[: COMMAND_HEADER + self._known(load().commands[name].fields)]

    def _known(self, fields: tuple[Field, ...]) -> int:
        """Bytes of those that this board's minor has."""
        return fields_size(field for field in fields if field.since <= self.options.minor)

    def _refuse(self, error: BadPayload, payload: bytes) -> None:
        """A payload without a command in it: answered only when it has a request number."""
        if error.code is None or error.request is None or payload[0] & 0xC0:
            return
        code, request = error.code, error.request
        if self._repeated(code, request):
            return
        if self._foreign() and code != IDENTIFY:
            error.status = Status.MAJOR_MISMATCH
        self._keep(request, encode_refusal(code, request, error.status))

    def _repeated(self, code: int, request: int) -> bool:
        """True when this request was answered already: its reply, if there is one, goes again."""
        if code == IDENTIFY:
            return False
        if self._zeroing and self._zeroing.request == request:
            return True
        if self._kept is None or self._kept[0] != request:
            return False
        self._send(self._kept[1])
        return True

    def _foreign(self) -> bool:
        return self._host_major != self.major

    def _refusal(self, name: str) -> Status:
        """Why this command is not accepted now, or OK."""
        if self._foreign() and name not in ("identify", "stop"):
            return Status.MAJOR_MISMATCH
        if self.options.minor < NEW_COMMANDS.get(name, 0):
            return Status.UNKNOWN_COMMAND
        states = load().commands[name].states
        if not states or self.state.name.lower() in states:
            return OK
        if self.state == State.FAULTED:
            return Status.FAULT_LATCHED
        if self.state == State.IDLE:
            return Status.NOT_CONFIGURED if name != "clear_fault" else Status.BAD_STATE
        if name == "start" and self.state == State.CONFIGURED:
            return Status.PROGRAM_EMPTY
        return Status.BAD_STATE

    def _execute(self, command: Command) -> Answer | None:
        """Do it. None: the reply comes later."""
        handler: Callable[[Command], Answer | None] = getattr(self, f"_do_{command.name}")
        return handler(command)

    def _answer(self, name: str, request: int, answer: Answer) -> None:
        status, fields = answer
        size = REPLY_HEADER + self._known(load().commands[name].reply)
        self._keep(request, encode_reply(name, request, status, **fields)[:size])

    def _keep(self, request: int, reply: bytes) -> None:
        self._kept = (request, reply)
        self._send(reply)

    def _do_identify(self, command: Command) -> Answer:
        self._host_major = command.fields["host_major"]
        return OK, identity.identify(self)

    def _do_describe_channel(self, command: Command) -> Answer:
        index = command.fields["index"]
        if index >= identity.CHANNELS:
            return Status.BAD_VALUE, {}
        if not identity.has_mode(self, command.fields["mode"]):
            return Status.NOT_SUPPORTED, {}
        return OK, identity.describe(self, index, command.fields["mode"])

    def _do_configure(self, command: Command) -> Answer:
        config = command.fields
        if problem := identity.check_config(self, config):
            return problem, {}
        self.config, self.steps = dict(config), []
        self.config_hash = zlib.crc32(self._fields)
        self._period, fast = identity.pace(self, config)
        self.bench.set_period(self._period, fast)
        self.bench.set_driver(self.front_end.opens)
        self.state = State.CONFIGURED
        return OK, {"config_hash": self.config_hash}

    def _do_read_config(self, command: Command) -> Answer:
        if self.config is None:
            return Status.NOT_CONFIGURED, {}
        return OK, self.config | {"config_hash": self.config_hash}

    def _do_clear_program(self, command: Command) -> Answer:
        self.steps.clear()
        self.state = State.CONFIGURED
        return OK, {}

    def _do_add_step(self, command: Command) -> Answer:
        if problem := identity.check_step(self, command.fields):
            return problem, {}
        self.steps.append(command.fields)
        self.state = State.LOADED
        return OK, {"steps": len(self.steps), "program_hash": program_hash(self.steps)}

    def _do_start(self, command: Command) -> Answer:
        config = self.config
        assert config is not None  # loaded implies configured
        ours = self.config_hash, program_hash(self.steps)
        if ours != (command.fields["config_hash"], command.fields["program_hash"]):
            return Status.HASH_MISMATCH, {}
        if self._missing_inputs():
            return Status.INPUT_OPEN, {}
        if self.front_end.source is FrontEndSource.NONE:
            return Status.NO_FRONT_END, {}
        if self.front_end.magnitude:  # whose sign is no drive's
            config = config | {"sign_check_ma": U32}
        self.runs += 1
        self.bench.seed_run(self.runs)
        start = self.tick + self._period
        options = self.options
        stream = Stream(config, AGE_TICKS, self._send, self._has_room, options.buffer)
        self.run = Run(self.bench, config, list(self.steps), stream, self._send, start, CLOCK_HZ)
        self.state = State.RUNNING
        self.on_run()
        return OK, {"start_tick": start & U32}

    def _do_stop(self, command: Command) -> Answer:
        if self._zeroing:
            self._end_zero((Status.BAD_STATE, {}))
        if self.run is not None:
            self.run.stop()
            self._end_run(self.run)
        return OK, {"state": self.state}

    def _do_heartbeat(self, command: Command) -> Answer:
        if self.run is not None:
            self.run.heard(self.tick)
        return OK, {}

    def _do_zero(self, command: Command) -> Answer | None:
        samples = command.fields["samples"]
        if not 1 <= samples <= MAX_ZERO:
            return Status.BAD_VALUE, {}
        self._zeroing = _Zeroing(command.request, samples, self.state, self.bench.count)
        self.state = State.ZEROING
        return None

    def _do_read_status(self, command: Command) -> Answer:
        return OK, identity.status(self)

    def _do_describe_input(self, command: Command) -> Answer:
        pin = identity.PINS.get(command.fields["input"])
        if pin is None:
            return Status.NOT_SUPPORTED, {}
        closed = self.inputs >> command.fields["input"] & 1
        return OK, {"pin": pin, "closed": closed}

    def _do_read_front_end(self, command: Command) -> Answer:
        return OK, self.front_end.reply()

    def _do_write_front_end(self, command: Command) -> Answer:
        if not self.front_end.store(command.fields):
            return Status.BAD_VALUE, {}
        self.chain = self.front_end.chain()
        self.bench.redeclare(self.chain)
        return OK, {"front_end_hash": self.front_end.hash}

    def _do_clear_fault(self, command: Command) -> Answer:
        self.fault = Fault.NONE
        self.steps.clear()
        self.state = State.CONFIGURED if self.config is not None else State.IDLE
        return OK, {"state": self.state}


class _Zeroing:
    """Readings of one ``zero`` command."""

    def __init__(self, request: int, samples: int, before: State, count: int) -> None:
        self.request, self.before = request, before
        self.left = samples
        self.count = count
        self.moved = False
        self._readings: list[Raw] = []

    def add(self, raw: Raw, moved: bool) -> None:
        """Readings (n, 3), and whether the encoder moved meanwhile."""
        self._readings.append(raw)
        self.left -= len(raw)
        self.moved |= moved

    def answer(self) -> Answer:
        """Means and standard deviations in counts."""
        if self.moved:
            return Status.NOT_AT_REST, {}
        raw = np.concatenate(self._readings).astype(np.float64)
        mean, spread = raw.mean(axis=0), raw.std(axis=0)
        return OK, {
            "current_offset": mean[0],
            "current_noise": spread[0],
            "voltage_offset": mean[1],
            "voltage_noise": spread[1],
        }
