"""Board, bench and cable as one thing, and the faults that befall it."""

from __future__ import annotations

import math

import numpy as np

from motorid.errors import LinkError
from motorid.sim.bench import Bench
from motorid.sim.board import Board
from motorid.sim.faults import Fault
from motorid.sim.link import Cable
from motorid.sim.options import Options
from motorid.wire.enums import Channel, Input, ResetCause
from motorid.wire.enums import Fault as WireFault
from motorid.wire.framing import DELIMITER, Decoder, Frame, encode
from motorid.wire.spec import load

HELLO = load().events["hello"].code
BYTES_PER_SAMPLE = 8  # roughly, on the wire
CHATTER_S = 0.1
CHUNK = 4096
TEXT = b"ok T:21.3 /0.0 B:21.0 /0.0 @:0\r\n"
FULL_SCALE = 1e6  # counts; beyond any converter


class Device:
    """What hangs on the other end of the port. Time moves by ``advance_to``."""

    def __init__(self, options: Options) -> None:
        self.options = options
        self.cable = Cable(options.baud, options.seed)
        self._foreign = b""  # what another device says, over and over
        self._next_chatter = math.inf
        self._decoder = Decoder()
        self._rng = np.random.default_rng([options.seed, 5])
        faults = options.faults
        major = next((int(f.value) for f in faults if f.name == "major"), None)
        self._hush = any(f.name in ("text", "garbage") for f in faults)
        # from the beginning means before the board greets
        quiet = [f for f in faults if f.name in ("silence", "mute") and f.at_s is None]
        self.cable.up.dead = bool(quiet)
        self.board: Board | None = None  # the first words come while it is made
        self.board = Board(options, self._say, self._has_room, major)
        self.board.on_run = self._plan
        self._planned: list[tuple[float, Fault, bool]] = []
        self._waiting = [fault for fault in faults if fault.at_s is not None]
        for fault in faults:
            if fault.at_s is None:
                self._apply(fault)

    # ------------------------------------------------------------------ time

    @property
    def bench(self) -> Bench:
        """Motor, bridge and converters."""
        assert self.board is not None
        return self.board.bench

    @property
    def now(self) -> float:
        """True seconds since power-on."""
        return self.board.seconds if self.board else 0.0

    @property
    def step_s(self) -> float:
        """The least by which time can move: a sample period."""
        assert self.board is not None
        return self.board.bench.period_s

    def advance_to(self, seconds: float) -> None:
        """Let time pass up to ``seconds``, to within a sample period; faults strike on the way."""
        assert self.board is not None
        while True:
            due = min(seconds, self._next_event())
            samples = math.floor((due - self.now) / self.step_s + 1e-6)
            if samples > 0:
                self.board.advance(samples)
            self._deliver()
            if self._strike() or self._chatter():
                continue
            if samples <= 0 or self.now + self.step_s > seconds:
                return

    def _next_event(self) -> float:
        planned = self._planned[0][0] if self._planned else math.inf
        return min(planned, self._next_chatter, max(self.cable.down.due, self.now + self.step_s))

    def _strike(self) -> bool:
        """Apply what is due; within a sample period of its time."""
        if not self._planned or self._planned[0][0] > self.now + self.step_s:
            return False
        _, fault, on = self._planned.pop(0)
        self._apply(fault, on)
        return True

    def _plan(self) -> None:
        """The first run begins: timed faults count from here."""
        for fault in self._waiting:
            self._planned.append((self.now + (fault.at_s or 0.0), fault, True))
            if fault.until_s is not None:
                self._planned.append((self.now + fault.until_s, fault, False))
        self._waiting = []
        self._planned.sort(key=lambda item: item[0])

    # ------------------------------------------------------------------ bytes

    def hear(self, data: bytes, at: float | None = None) -> None:
        """Bytes from the host, ``at`` a time (s) within the sample period that began at ``now``,
        which the board's clock tells; None: at its beginning.
        """
        if self._foreign or self._hush:
            return
        assert self.board is not None
        self.cable.down.send(data, self.now)
        self.board.since_sample_s = 0.0 if at is None else at - self.now
        self._deliver()
        self.board.since_sample_s = 0.0

    def _deliver(self) -> None:
        """What has arrived at the board, to the board."""
        while self.board is not None and (data := self.cable.down.take(CHUNK, self.now)):
            for frame in self._decoder.feed(data):
                if isinstance(frame, Frame):
                    self.board.receive(frame.payload)

    def take(self, size: int) -> bytes:
        """Bytes for the host that have arrived by now."""
        return self.cable.take(size, self.now)

    def check(self) -> None:
        """Raise LinkError when the port is gone."""
        if self.cable.unplugged:
            raise LinkError("sim://: the simulated board was unplugged: check the cable")

    def _say(self, payload: bytes) -> None:
        if self._hush:
            return
        frame = encode(payload)
        if payload[0] == HELLO:  # which a frame that the reset cut short must not spoil
            frame = DELIMITER + frame
        self.cable.up.send(frame, self.now)

    def _has_room(self) -> bool:
        return self.cable.up.backlog(self.now) <= self.options.buffer * BYTES_PER_SAMPLE

    def _chatter(self) -> bool:
        """Another device says its piece."""
        if self.now + self.step_s < self._next_chatter:
            return False
        self._next_chatter += CHATTER_S
        self.cable.up.send(self._foreign or self._rng.bytes(40), self.now)
        return True

    # ------------------------------------------------------------------ faults

    def _apply(self, fault: Fault, on: bool = True) -> None:
        if not (self.cable.apply(fault, on) or self._be_another(fault) or self._break_board(fault)):
            self._break_bench(fault)

    def _be_another(self, fault: Fault) -> bool:
        """Another device hangs on the port, which speaks something else."""
        if fault.name not in ("text", "garbage"):
            return False
        self._hush = True
        self._foreign = TEXT if fault.name == "text" else b""
        self._next_chatter = self.now
        return True

    def _break_board(self, fault: Fault) -> bool:
        assert self.board is not None
        match fault.name:
            case "major":
                self.board.major = int(fault.value)
            case "reset":
                self.board.reset(ResetCause.EXTERNAL)
            case "watchdog":
                self.board.reset(ResetCause.WATCHDOG)
            case "driver":
                self.board.notice(WireFault.DRIVER)
            case "guard_open":
                self.board.set_inputs(self.board.inputs & ~(1 << Input.GUARD_CLOSED))
            case "part_absent":
                self.board.set_inputs(self.board.inputs & ~(1 << Input.PART_PRESENT))
            case "brownout":
                self.board.bench.set_supply(0.0)
                self.board.reset(ResetCause.BROWN_OUT)
                back = Fault("supply", self.options.supply_v, None)
                self._planned.append((self.now + fault.value, back, True))
                self._planned.sort(key=lambda item: item[0])
            case _:
                return False
        return True

    def _break_bench(self, fault: Fault) -> None:
        assert self.board is not None
        bench = self.board.bench
        match fault.name:
            case "supply":
                bench.set_supply(fault.value)
            case "stall":
                bench.stall()
            case "encoder_reversed":
                bench.break_encoder(-1)
            case "encoder_dead":
                bench.break_encoder(0)
            case "encoder_drop":
                bench.break_encoder(1, fault.value)
            case "current_dead":
                bench.break_converter(Channel.CURRENT, gain=0.0)
            case "current_reversed":
                bench.break_converter(Channel.CURRENT, gain=-1.0)
            case "current_saturated":
                bench.break_converter(Channel.CURRENT, offset=FULL_SCALE)
            case "voltage_dead":
                bench.break_converter(Channel.TERMINAL_VOLTAGE, gain=0.0)
            case "adc_stuck":
                bench.freeze_converters()
