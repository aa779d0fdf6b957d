"""Runs a schedule, and holds what came of it against the three laws.

1. The motor is stopped in time: the bridge is open whenever no run goes on, and at the latest
   ``host_silence_s`` after the board last heard a heartbeat.
2. Every sample in the file is one that the board sent in that run, at its tick.
3. Every block that was read more than 100 ms before the host died or its disk filled (1 s before a
   power failure) is in the file; where neither happened, every block that was read.
"""

from __future__ import annotations

import contextlib
import io
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, BinaryIO
from unittest import mock

from motorid.acquire import leftover, record
from motorid.acquire.assemble import NoSamplesError
from motorid.acquire.journal import Kind, journal_path, read_journal
from motorid.acquire.port import Port
from motorid.acquire.relay import RELAY_KINDS, RelayPort
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import MotoridError
from motorid.program import Program
from motorid.rig import Rig
from motorid.sim.faults import parse_faults
from motorid.sim.port import SimPort, open_sim
from motorid.wire.codec import BadPayload, SampleBlock, decode
from motorid.wire.framing import Decoder, Frame
from tests.acquire.rigs import SHORT, sim_rig
from tests.faults.schedule import Schedule
from tests.faults.witness import (
    SLACK_S,
    BoardWitness,
    HostDiedError,
    HostPort,
    SpiedJournal,
    columns_of,
    matching,
)

LONG = Program(SHORT.steps * 4)
CHANNELS = ("current", "terminal_voltage", "position", "supply_voltage")
LOSS_S = {"kill -9": 0.1, "power failure": 1.0, "full disk": 0.1}
DISK_BYTES = 24_000  # about half of a short run


@dataclass
class Outcome:
    """What came of a schedule."""

    error: BaseException | None
    exit_code: int
    capture: Capture | None
    sent: int  # samples, of the run proper
    read: int
    broken: list[str] = field(default_factory=list)  # laws, each with how

    @property
    def kept(self) -> int:
        """Samples in the file."""
        return len(self.capture) if self.capture is not None else 0

    @property
    def says(self) -> str:
        """The sentence that the user sees."""
        if isinstance(self.error, HostDiedError):
            return ""
        return str(self.error) if self.error is not None else ""


Lie = Callable[[bytes], list[bytes]]  # what a board says in place of a payload
HANG_UP = getattr(signal, "SIGHUP", signal.SIGTERM)  # Windows has none
SIGNALS = {
    "ctrl-c": (signal.SIGINT,),
    "ctrl-c twice": (signal.SIGINT, signal.SIGINT),
    "hang-up": (HANG_UP,),
    "hang-up twice": (HANG_UP, HANG_UP),
    "terminate": (signal.SIGTERM,),
}


class FillingDisk(io.FileIO):
    """A file on a disk that has only so much room left."""

    room = DISK_BYTES
    full_at: float | None = None  # wall time of the first refusal

    def write(self, data: Any) -> int:
        if self.tell() + len(data) > self.room:
            FillingDisk.full_at = FillingDisk.full_at or time.monotonic()
            raise OSError(28, "No space left on device")
        return super().write(data)


class Trial:
    """One schedule, from the port to the file."""

    def __init__(
        self,
        schedule: Schedule,
        folder: Path,
        *,
        change: Callable[[Rig], Rig] = lambda rig: rig,
        other: str = "",
        lie: Lie | None = None,
        act: Callable[[Path], None] = lambda path: None,
        prepare: Callable[[Path], None] = lambda path: None,
    ) -> None:
        self.schedule, self.folder = schedule, folder
        self.change, self.other, self.lie = change, other, lie
        self.act, self.prepare = act, prepare
        self.path = folder / "run.h5"
        self.boards: list[BoardWitness] = []
        self.host: HostPort | None = None
        self.died_at: float | None = None
        self.left = b""  # the journal that death leaves on the disk
        self.silence_s = schedule.host_silence_s

    def run(self) -> Outcome:
        """Captures, recovers what a dead host left, and judges."""
        error: BaseException | None = None
        SpiedJournal.latest, FillingDisk.full_at = None, None
        self.prepare(self.path)
        try:
            with (
                mock.patch.object(record, "open_port", self._open_port),
                mock.patch.object(record, "JournalWriter", self._journal),
            ):
                rig = self._rig()
                record.capture(rig, rig.program, self.path)
        except (MotoridError, KeyboardInterrupt, HostDiedError) as raised:
            error = raised
        capture = self._capture(error)
        outcome = Outcome(error, _exit_code(error), capture, 0, 0)
        self._judge(outcome)
        return outcome

    # ------------------------------------------------------------------ set-up

    def _rig(self) -> Rig:
        s = self.schedule
        rig = sim_rig(program=LONG if s.long else SHORT)
        sampling = replace(
            rig.sampling, rate_hz=s.rate_hz, channels=CHANNELS[: s.channels], mode=s.mode
        )
        limits = replace(rig.limits, host_silence_s=self.silence_s)
        return self.change(replace(rig, sampling=sampling, limits=limits))

    def _open_port(self, url: str) -> Port:
        s = self.schedule
        relay = RelayPort(
            self._open_sim("to"), parse_faults(s.link, RELAY_KINDS), s.seed, self._open_sim
        )
        dies = s.host in ("kill -9", "power failure")
        self.host = HostPort(
            relay,
            die_s=s.host_at_s if dies else None,
            stop_s=s.host_at_s if s.host in SIGNALS else None,
            signals=SIGNALS.get(s.host, ()),
            act_s=s.host_at_s if s.host == "acts" else None,
            pace_s=s.host_at_s - 2 * LOSS_S[s.host] if dies else float("inf"),
        )
        self.host.on_death = self._die
        self.host.on_act = lambda: self.act(self.path)
        return self.host

    def _open_sim(self, which: str) -> SimPort:
        s = self.schedule
        fault = self.other if which == "other" else s.board
        port = open_sim(f"sim://?{s.options}&fault={fault}")
        self.boards.append(BoardWitness(port._device))
        if self.lie is not None:
            _let_lie(port, self.lie)  # after the witness, who notes what is said
        return port

    def _journal(self, path: Path, header: Any) -> SpiedJournal:
        if self.schedule.host != "full disk":
            return SpiedJournal(path, header)

        def on_full_disk(path: Path) -> BinaryIO:
            return io.BufferedWriter(FillingDisk(str(path), "xb"))

        return SpiedJournal(path, header, open_file=on_full_disk)

    def _die(self) -> None:
        """What the journal's file holds at this moment: of it, only the synced part is safe."""
        self.died_at = time.monotonic()
        self.left = journal_path(self.path).read_bytes()
        journal = SpiedJournal.latest
        if self.schedule.host == "power failure" and journal is not None:
            self.left = self.left[: journal.synced]

    # ------------------------------------------------------------------ afterwards

    def _capture(self, error: BaseException | None) -> Capture | None:
        """The capture in the file, after recovery where the host died or its disk was full."""
        if isinstance(error, HostDiedError):
            assert SpiedJournal.latest is not None
            SpiedJournal.latest.close()  # its thread is no part of the dead host
            self.path = self.folder / "recovered.h5"
            journal_path(self.path).write_bytes(self.left)
        journal = SpiedJournal.latest
        left = journal_path(self.path)
        moved = journal is not None and journal.path != left and self.died_at is None
        if journal is not None and moved and not self.path.exists():
            left = journal.path  # where it went when its folder was removed
        if journal is not None and left.is_file():
            try:
                with mock.patch.object(leftover, "STILL_GROWING_S", 0.0):
                    self.path = record.recover(left)
            except NoSamplesError:
                return None
        return store.load(self.path) if self.path.is_file() else None

    def _judge(self, outcome: Outcome) -> None:
        for board in self.boards:
            self._judge_motor(board, outcome)
        journal = SpiedJournal.latest
        if journal is None or journal.measured_at is None:
            return
        board = max(self.boards, key=lambda b: b.runs)
        rows = board.rows()
        outcome.sent = len(rows)
        if outcome.capture is not None:
            self._judge_samples(outcome, rows)
        self._judge_kept(outcome, rows, board.period, journal.measured_at)

    def _judge_motor(self, board: BoardWitness, outcome: Outcome) -> None:
        stopped = board.stops_within(self.silence_s + 0.1)
        if board.astray:
            outcome.broken.append("1: the bridge was closed with no run")
        if board.late_s > self.silence_s + SLACK_S or not stopped:
            outcome.broken.append(
                f"1: the bridge was closed {board.late_s:.4f} s after the last heartbeat"
            )

    def _judge_samples(self, outcome: Outcome, rows: Any) -> None:
        ticks, columns = columns_of(outcome.capture)
        order = sorted(outcome.capture.channels, key=_wire_order)
        places = [list(outcome.capture.channels).index(name) for name in order]
        wrong = sum(
            rows.get(tick) != tuple(row)
            for tick, row in zip(ticks.tolist(), columns[:, places].tolist(), strict=True)
        )
        if wrong:
            outcome.broken.append(f"2: {wrong} samples of {len(ticks)} are not the board's")

    def _kept_raw(self) -> set[int]:
        """First ticks of blocks in a journal that stays, because they have no place in a run."""
        found: set[int] = set()
        for journal in self.folder.glob("*.journal.raw"):
            decoder = Decoder()
            for one in read_journal(journal).records:
                frames = decoder.feed(one.data) if one.kind is Kind.RECEIVED else []
                for frame in frames:
                    with contextlib.suppress(BadPayload):
                        message = decode(frame.payload) if isinstance(frame, Frame) else None
                        if isinstance(message, SampleBlock):
                            found.add(message.first_tick)
        return found

    def _judge_kept(self, outcome: Outcome, rows: Any, period: int, began: float) -> None:
        assert self.host is not None
        full = FillingDisk.full_at if self.schedule.host == "full disk" else None
        end = self.died_at or full
        latest = float("inf") if end is None else end - LOSS_S[self.schedule.host]
        read = [(at, b) for at, b in self.host.blocks() if at > began and matching(b, rows, period)]
        outcome.read = sum(len(block.samples) for _, block in read)
        kept = set()
        if outcome.capture is not None:
            kept = set((outcome.capture.ticks % 2**32).tolist())
        kept |= self._kept_raw()
        lost = [b for at, b in read if at < latest and b.first_tick not in kept]
        if lost:
            outcome.broken.append(f"3: {len(lost)} of {len(read)} blocks read are not in the file")


def _let_lie(port: SimPort, lie: Lie) -> None:
    """The board says other things than it did and knows."""
    board: Any = port.device.board
    say = board._send

    def lying(payload: bytes) -> None:
        for one in lie(payload):
            say(one)

    board._send = lying


def _wire_order(name: str) -> int:
    from motorid.wire.enums import Channel

    return int(Channel[name.upper()])


def _exit_code(error: BaseException | None) -> int:
    if isinstance(error, HostDiedError):
        return -9
    if isinstance(error, KeyboardInterrupt):
        return 130
    return getattr(error, "exit_code", 0)


def run(schedule: Schedule, folder: Path) -> Outcome:
    """Runs a schedule in an empty folder."""
    return Trial(schedule, folder).run()
