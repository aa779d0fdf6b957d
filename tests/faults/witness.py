"""Witnesses of a capture: what the board did and sent, and what the host read and when."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from motorid.acquire.journal_writer import JournalWriter
from motorid.acquire.port import Port
from motorid.sim.device import Device
from motorid.wire.codec import BadPayload, Event, Reply, SampleBlock, decode
from motorid.wire.enums import State
from motorid.wire.framing import Decoder, Frame

STOP_STEP_S = 1e-3
SLACK_S = 5e-3  # the board's time is seen in stretches of samples
Rows = dict[int, tuple[int, ...]]  # tick modulo 2^32 -> raw readings


class BoardWitness:
    """Stands behind every fault, at the simulated board itself."""

    def __init__(self, device: Device) -> None:
        assert device.board is not None
        self.device, self.board = device, device.board
        self.blocks: list[SampleBlock] = []  # of the run that began last
        self.period = 0  # ticks between its samples
        self.runs = 0
        self.ended: Event | None = None  # done, of the run that began last
        self.unheard_s = 0.0  # by then, since the last heartbeat
        self.late_s = 0.0  # the longest that the bridge was closed after the host was last heard
        self.astray = False  # bridge closed and no run
        self._heard_s = 0.0
        self._wrap("_send", self._send)
        self._wrap("on_run", self._run)
        self._wrap("_do_heartbeat", self._heartbeat)
        self._wrap("_advance_run", self._advanced)
        self._wrap("_advance_idle", self._advanced)

    def _wrap(self, name: str, also: Callable[..., None]) -> None:
        inner = getattr(self.board, name)

        def both(*args: Any) -> Any:
            result = inner(*args)
            also(*args)
            return result

        setattr(self.board, name, both)

    def _send(self, payload: bytes) -> None:
        try:
            message = decode(payload)
        except BadPayload:  # of a board that lies
            return
        if isinstance(message, SampleBlock):
            self.blocks.append(message)
        elif isinstance(message, Event) and message.name == "done":
            self.ended = message
            self.unheard_s = self.board.seconds - self._heard_s

    def _run(self) -> None:
        self.runs += 1
        self.blocks = []
        self.ended = None
        self.period = self.board._period
        self._heard_s = self.board.seconds

    def _heartbeat(self, _: Any) -> None:
        self._heard_s = self.board.seconds

    def _advanced(self, *_: Any) -> None:
        if not self.board.bench.is_open:
            self.late_s = max(self.late_s, self.board.seconds - self._heard_s)
            self.astray |= self.board.state != State.RUNNING

    def rows(self) -> Rows:
        """Every sample that the board sent of its last run."""
        found: Rows = {}
        for block in self.blocks:
            for number, row in enumerate(block.samples.tolist()):
                found[(block.first_tick + number * self.period) % 2**32] = tuple(row)
        return found

    def stops_within(self, patience_s: float) -> bool:
        """Leaves the board alone until no run goes on; whether its bridge is open then."""
        at = self.device.now
        until = at + patience_s
        while self.board.state == State.RUNNING and at < until:
            at += STOP_STEP_S  # the device stands still until a whole sample fits
            self.device.advance_to(at)
        return self.board.state != State.RUNNING and self.board.bench.is_open


class HostDiedError(BaseException):
    """The computer or the process is gone; nothing below may catch this."""


class HostPort:
    """The host's end of the link: notes what is read and when, and dies, or stops, when told to.

    ``die_s``, ``stop_s`` and ``act_s`` are times of the port's clock. From ``pace_s`` on the
    port goes no faster than the wall clock, by which the journal's promises count.
    """

    def __init__(
        self,
        inner: Port,
        *,
        die_s: float | None = None,
        stop_s: float | None = None,
        signals: tuple[int, ...] = (signal.SIGINT,),
        act_s: float | None = None,
        pace_s: float = float("inf"),
        patience_s: float = 300.0,
    ) -> None:
        self.name = inner.name
        self.reads: list[tuple[float, bytes]] = []  # wall time
        self.on_death: Callable[[], None] = lambda: None
        self.on_act: Callable[[], None] = lambda: None  # at ``act_s``, with the host as it was
        self._inner = inner
        self._die_s, self._stop_s, self._pace_s = die_s, stop_s, pace_s
        self._signals = signals
        self._act_s = act_s
        self._dead = False
        self._patience_s = patience_s
        self._pace: tuple[float, float] | None = None

    def read(self, size: int, timeout_s: float) -> bytes:
        now = self._inner.now()
        if self._die_s is not None and now >= self._die_s:
            self._dead = True  # no courtesy of a finally reaches the board
            self.on_death()
            raise HostDiedError
        if self._stop_s is not None and now >= self._stop_s:
            self._stop_s = None
            for number in self._signals:
                signal.raise_signal(number)
        if self._act_s is not None and now >= self._act_s:
            self._act_s = None
            self.on_act()
        assert now < self._patience_s, "the capture does not end"
        data = self._inner.read(size, timeout_s)
        if data:
            self.reads.append((time.monotonic(), data))
        self._keep_pace()
        return data

    def _keep_pace(self) -> None:
        now = self._inner.now()
        if now < self._pace_s:
            return
        if self._pace is None:
            self._pace = now, time.monotonic()
        ahead = (now - self._pace[0]) - (time.monotonic() - self._pace[1])
        if ahead > 0:
            time.sleep(ahead)

    def write(self, data: bytes) -> None:
        if self._dead:
            raise HostDiedError
        self._inner.write(data)

    def now(self) -> float:
        return self._inner.now()

    def close(self) -> None:
        self._inner.close()

    def blocks(self) -> list[tuple[float, SampleBlock]]:
        """Blocks since the last reply to start, each with the wall time at which it was read."""
        decoder, found = Decoder(), []
        for at, data in self.reads:
            for frame in decoder.feed(data):
                try:
                    message = decode(frame.payload) if isinstance(frame, Frame) else None
                except BadPayload:
                    continue
                if isinstance(message, Reply) and message.name == "start":
                    found = []
                if isinstance(message, SampleBlock):
                    found.append((at, message))
        return found


class SpiedJournal(JournalWriter):
    """A journal that knows how much of it is synced, and when the run proper began."""

    latest: SpiedJournal | None = None
    synced = 0
    measured_at: float | None = None  # wall time

    def __init__(self, path: Path, header: Any, **more: Any) -> None:
        SpiedJournal.latest = self
        super().__init__(path, header, **more)

    def mark(self, time_s: float, **what: Any) -> None:
        if "measure" in what:
            self.measured_at = time.monotonic()
        super().mark(time_s, **what)

    def _sync(self) -> None:
        self._file.flush()
        size = os.fstat(self._file.fileno()).st_size
        super()._sync()
        self.synced = size


def matching(block: SampleBlock, rows: Rows, period: int) -> bool:
    """Whether the board sent this very block."""
    ticks = [(block.first_tick + n * period) % 2**32 for n in range(len(block.samples))]
    return all(rows.get(t) == tuple(r) for t, r in zip(ticks, block.samples.tolist(), strict=True))


def columns_of(capture: Any) -> tuple[Any, Any]:
    """A capture's ticks (n,) modulo 2^32 and raw columns (n, k), positions as the wire has them."""
    columns = [np.asarray(channel.raw).astype(np.int64) for channel in capture.channels.values()]
    low = (np.stack(columns, axis=1) + (1 << 15)) % (1 << 16) - (1 << 15)
    return capture.ticks % 2**32, low
