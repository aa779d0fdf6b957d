"""Frames from the run to each viewer; one that is slow loses frames, and nobody waits for it."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any

from motorid import json_text
from motorid.acquire.strips import Strip, Strips, joined
from motorid.acquire.tap import Tap
from motorid.web.frames import after_loss, encoded

ALIVE_S = 1.0  # at least so often each page hears something, or takes the connection for lost
FRAME_S = 0.025  # between frames: forty a second
MOST_WAITING = 64  # frames that a viewer may be behind, 1.6 s; then the oldest go
BACKLOG_BYTES = 8_000_000  # of the latest frames, for a page that opens late
MOST_VIEWERS = 32
MOST_ANSWERS = 8  # that a page may leave unread


class Viewer:
    """What one page has not been sent yet: bounded, and the newest stays."""

    def __init__(self) -> None:
        self._past: deque[bytes] = deque()
        self._frames: deque[bytes] = deque()
        self._texts: deque[str] = deque(maxlen=MOST_ANSWERS)
        self._status = ""
        self._lost = 0
        self._more = asyncio.Event()

    def remember(self, past: Iterable[bytes]) -> None:
        """Queues what was kept before this page was opened, at its beginning."""
        self._past.extend(past)

    def show(self, frame: bytes) -> None:
        """Queues a frame, in place of the oldest where there are too many."""
        if len(self._frames) >= MOST_WAITING:
            self._frames.popleft()
            self._lost += 1
        self._frames.append(frame)
        self._more.set()

    def tell(self, status: str) -> None:
        """Queues the status, in place of one that waits."""
        self._status = status
        self._more.set()

    def answer(self, text: str) -> None:
        """Queues what this page alone is told."""
        self._texts.append(text)
        self._more.set()

    @property
    def waits(self) -> bool:
        """Whether anything is to be sent."""
        return bool(self._status or self._texts or self._past or self._frames)

    async def next(self) -> str | bytes:
        """What to send next; texts first."""
        while not self.waits:
            self._more.clear()
            await self._more.wait()
        if self._status:
            status, self._status = self._status, ""
            return status
        if self._texts:
            return self._texts.popleft()
        if self._past:
            return self._past.popleft()
        frame, lost, self._lost = self._frames.popleft(), self._lost, 0
        return after_loss(frame, lost) if lost else frame


class Hub:
    """All viewers of one tap. Everything but ``post`` belongs to the server's thread."""

    def __init__(self, tap: Tap, facts: Mapping[str, Any]) -> None:
        self.tap = tap
        self.viewers: set[Viewer] = set()
        self._strips = Strips()
        self._channels: tuple[tuple[str, str], ...] = ()
        self._backlog: deque[bytes] = deque()
        self._bytes = 0
        self._told_at = time.monotonic()
        self._status: dict[str, Any] = dict(facts)
        self._posted: deque[dict[str, Any]] = deque(maxlen=16)  # from the other thread

    def post(self, **changed: Any) -> None:
        """Changes what the pages are told besides samples; from any thread."""
        self._posted.append(changed)

    @property
    def settled(self) -> bool:
        """Whether nothing waits for any page; from any thread."""
        waits = self.tap.waiting or self._posted or any(one.waits for one in tuple(self.viewers))
        return not waits

    def join(self, viewer: Viewer) -> bool:
        """A new viewer gets the status, and what is kept; False where there are too many."""
        if len(self.viewers) >= MOST_VIEWERS:
            return False
        self.viewers.add(viewer)
        viewer.tell(self._text())
        viewer.remember(self._backlog)
        return True

    async def pump(self) -> None:
        """Hands on what came, forty times a second, for as long as the server runs."""
        while True:
            self.turn()
            await asyncio.sleep(FRAME_S)

    def turn(self) -> None:
        """Hands on what came since the last turn."""
        strips = [s for f, b in self.tap.taken() if (s := self._strips.take(f, b)) is not None]
        for strip in joined(strips):
            self._name(strip)
            frame = encoded(strip)
            self._keep(frame)
            for viewer in self.viewers:
                viewer.show(frame)
        due = time.monotonic() - self._told_at >= ALIVE_S
        while self._posted:
            self._status |= self._posted.popleft()
            due = True
        if due:
            self._tell()

    def _name(self, strip: Strip) -> None:
        channels = tuple(zip(strip.names, strip.units, strict=True))
        if channels != self._channels:
            self._channels = channels
            self._status["channels"] = [{"name": name, "unit": unit} for name, unit in channels]
            self._tell()

    def _keep(self, frame: bytes) -> None:
        self._backlog.append(frame)
        self._bytes += len(frame)
        while self._bytes > BACKLOG_BYTES and len(self._backlog) > 1:
            self._bytes -= len(self._backlog.popleft())

    def _tell(self) -> None:
        self._told_at = time.monotonic()
        for viewer in self.viewers:
            viewer.tell(self._text())

    def _text(self) -> str:
        return json_text.dumps({**self._status, "lost_blocks": self.tap.lost})
