"""Frames on their way to the pages: nobody waits for a slow one, and it learns what it lost."""

from __future__ import annotations

import asyncio
import json
import struct

import numpy as np
import pytest

from motorid.acquire.tap import Tap
from motorid.web import hub as hubs
from motorid.web.hub import Hub, Viewer
from tests.acquire.test_strips import FACTS, block


def frames(hub: Hub, tap: Tap, count: int, begin: int = 0) -> None:
    give = tap.begin(FACTS)
    for number in range(begin, begin + count):
        give(block(250 * number, [512 + number], [number]))
        hub.turn()


def sent(viewer: Viewer) -> list[str | bytes]:
    async def drained() -> list[str | bytes]:
        return [await viewer.next() for _ in iter(lambda: viewer.waits, False)]

    return asyncio.run(drained())


def binary(viewer: Viewer) -> list[bytes]:
    return [one for one in sent(viewer) if isinstance(one, bytes)]


def lost(frame: bytes) -> int:
    (count,) = struct.unpack_from("<I", frame)
    return int(count)


def test_a_frame_holds_the_samples() -> None:
    tap = Tap()
    hub, viewer = Hub(tap, {"rig": "bench"}), Viewer()
    assert hub.join(viewer)
    give = tap.begin(FACTS)
    give(block(0, [512, 612], [0, 1]))
    give(block(500, [412, 512], [2, 3]))
    hub.turn()
    text, frame = sent(viewer)
    assert isinstance(text, str)
    assert json.loads(text)["channels"][2] == {"name": "speed", "unit": "rad/s"}
    assert isinstance(frame, bytes)
    assert struct.unpack_from("<IIIIdd", frame) == (0, 3, 4, 1, 0.0, 250e-6)
    values = np.frombuffer(frame, "<f8", offset=32).reshape(3, 4)
    np.testing.assert_allclose(values[:2], [[0, 1, -1, 0], [0, 0.5, 1, 1.5]])


def test_a_page_that_does_not_read_loses_old_frames_and_no_other_page_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(hubs, "MOST_WAITING", 4)
    tap = Tap()
    hub, slow, good = Hub(tap, {}), Viewer(), Viewer()
    hub.join(slow)
    hub.join(good)
    seen = []
    for number in range(10):
        frames(hub, tap, 1, number)
        seen += binary(good)
    late = binary(slow)
    assert len(seen) == 10
    assert [lost(one) for one in seen] == [0] * 10
    assert [lost(one) for one in late] == [6, 0, 0, 0]
    assert late[1:] == seen[-3:]
    assert not hub.settled or not slow.waits


def test_a_page_that_opens_late_sees_what_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hubs, "BACKLOG_BYTES", 200)
    tap = Tap()
    hub, viewer = Hub(tap, {}), Viewer()
    frames(hub, tap, 10)
    hub.join(viewer)
    kept = binary(viewer)
    assert 0 < sum(map(len, kept)) <= 200
    starts = [struct.unpack_from("<d", one, 16)[0] for one in kept]
    assert starts[-1] == pytest.approx(9 * 250e-6)


def test_what_is_said_reaches_each_page_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hubs, "MOST_VIEWERS", 2)
    hub = Hub(Tap(), {"rig": "bench"})
    one, other, third = Viewer(), Viewer(), Viewer()
    assert [hub.join(viewer) for viewer in (one, other, third)] == [True, True, False]
    for viewer in (one, other):
        assert json.loads(str(sent(viewer)[0]))["rig"] == "bench"
    hub.post(state="measuring", text="a")
    hub.post(text="b")
    assert not hub.settled
    hub.turn()
    for viewer in (one, other):
        (text,) = sent(viewer)
        assert {"rig": "bench", "state": "measuring", "text": "b"}.items() <= json.loads(
            text
        ).items()
    assert hub.settled
