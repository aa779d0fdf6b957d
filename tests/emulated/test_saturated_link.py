"""The link test on a board's real firmware, behind a USB bridge that loses bytes when saturated.

A genuine Uno's bridge does so above 500 kbaud: the UART fills its buffer while the computer asks
seldom. A run's stream leaves it time; the link test does not.
"""

from __future__ import annotations

from collections import deque
from typing import Any

import pytest

from motorid.acquire.board import Board
from motorid.acquire.link_test import LinkTest, measure_link
from motorid.acquire.port import open_port
from tests.conformance.boards import emulator_lacks

pytestmark = pytest.mark.slow
BUFFER_BYTES = 128
URL = "emu://uno?motor=dunkermotoren-gr42&speed=max"


class Bridge:
    """A port whose board's bytes wait in a small buffer, emptied steadily; more are lost."""

    def __init__(self, inner: Any, bytes_s: float) -> None:
        self.name, self.inner, self.bytes_s = inner.name, inner, bytes_s
        self.waiting: deque[int] = deque()
        self.emptied_at, self.share, self.lost = inner.now(), 0.0, 0

    def read(self, size: int, timeout_s: float) -> bytes:
        """What the computer gets of it, a millisecond at a time, as the UART fills it."""
        until = self.now() + timeout_s
        while True:
            for byte in self.inner.read(4096, min(1e-3, max(until - self.now(), 0.0))):
                if len(self.waiting) < BUFFER_BYTES:
                    self.waiting.append(byte)
                else:
                    self.lost += 1
            self.share += (self.now() - self.emptied_at) * self.bytes_s
            self.emptied_at = self.now()
            count = min(int(self.share), len(self.waiting), size)
            self.share = self.share - count if self.waiting else 0.0
            if count or self.now() >= until:
                return bytes(self.waiting.popleft() for _ in range(count))

    def write(self, data: bytes) -> None:
        self.inner.write(data)

    def now(self) -> float:
        return float(self.inner.now())

    def close(self) -> None:
        self.inner.close()


def outcome(bytes_s: float) -> tuple[LinkTest, int]:
    """What the link test says, and how many bytes the bridge lost in it."""
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    bridge = Bridge(open_port(URL), bytes_s)
    try:
        Board(bridge).identify()  # one command at a time: it does not saturate
        assert bridge.lost == 0
        return measure_link(bridge), bridge.lost
    finally:
        bridge.close()


def test_a_bridge_that_keeps_up_is_clean() -> None:
    found, lost = outcome(bytes_s=200e3)
    assert lost == 0
    assert found.clean
    assert found.answered == found.sent == 256


def test_a_saturated_bridge_s_losses_are_measured() -> None:
    found, lost = outcome(bytes_s=30e3)
    assert lost > 0
    assert not found.clean
    assert found.answered < found.sent
    assert found.damaged > 0
    assert "loses data under load" in found.sentence()
