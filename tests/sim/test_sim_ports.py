"""The port on both clocks, and the pseudo terminal."""

from __future__ import annotations

import sys
import threading
import time

import numpy as np
import pytest

from motorid.errors import LinkError
from motorid.sim.options import CLOCK_HZ
from motorid.sim.port import open_sim
from motorid.wire.codec import Reply, decode, encode_command
from motorid.wire.framing import Decoder, Frame, encode
from tests.sim.client import Client

IDENTIFY = encode(encode_command("identify", 1, host_major=1, host_minor=0))


def test_simulated_time_moves_only_in_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """And nobody waits for it: the port does without a clock, and so without sleep."""
    port = open_sim("sim://?speed=max")
    port.read(1000, 0.0)
    before = port.now()
    time.sleep(0.02)
    assert port.now() == before
    monkeypatch.setattr("motorid.sim.port.time", None)
    assert port.read(1000, 2.0), "the board greets"
    before = port.now()
    assert port.read(1000, 2.0) == b""
    assert port.now() == pytest.approx(before + 2.0, abs=0.02)


@pytest.mark.parametrize("ppm", [0, 20_000])
def test_the_board_s_clock_goes_on_between_samples(ppm: int) -> None:
    """The host compares it with its own, in which a wait ends within a sample period."""
    client = Client(f"baud=0&clock_ppm={ppm}")
    client.port.read(1000, 0.01)
    found = []
    for wait in (0.0, 31e-6, 170e-6, 0.0113):
        client.port.read(1000, wait)
        found.append((client.port.now(), client.ask("read_status").fields["tick"]))
    times, ticks = np.array(found).T
    lags = times - client.port.device.now
    assert np.ptp(lags / client.port.device.step_s % 1.0) > 0.1, "some are within a period"
    expected = CLOCK_HZ * (1 + 1e-6 * ppm) * (times - times[0])
    assert ticks - ticks[0] == pytest.approx(expected, abs=1.0)


@pytest.mark.slow
def test_real_time_is_the_walls() -> None:
    port = open_sim("sim://")
    port.read(1000, 0.05)
    began, before = time.monotonic(), port.now()
    assert port.read(1000, 0.1) == b""
    passed = port.now() - before
    assert 0.1 <= passed <= time.monotonic() - began  # less only where this process had to wait


def test_a_closed_port_says_so() -> None:
    port = open_sim("sim://?speed=max")
    port.close()
    port.close()
    with pytest.raises(LinkError, match="closed"):
        port.read(1, 0.0)


def test_garbage_from_the_host_is_ignored() -> None:
    client = Client()
    client.port.write(bytes(range(256)) * 20 + b"\0")
    assert client.identify().status == 0


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo terminals on Windows")
def test_another_program_talks_to_it_through_a_pseudo_terminal() -> None:
    import serial

    from motorid.sim.pty import serve

    paths: list[str] = []
    over = threading.Event()
    server = threading.Thread(target=serve, args=("sim://", paths.append, over.is_set))
    server.start()
    try:
        while not paths:
            time.sleep(0.005)
        for _ in range(2):  # a client may come, go and come again
            replies: list[Reply] = []
            with serial.Serial(paths[0], 1_000_000, timeout=0.2) as line:
                line.write(b"\0" + IDENTIFY)
                decoder = Decoder()
                deadline = time.monotonic() + 60  # however busy the computer
                while not replies and time.monotonic() < deadline:
                    for frame in decoder.feed(line.read(line.in_waiting or 1)):
                        message = decode(frame.payload) if isinstance(frame, Frame) else None
                        replies += [message] if isinstance(message, Reply) else []
            assert replies[0].fields["board"] == "motorid-sim"
    finally:
        over.set()
        server.join(60)
    assert not server.is_alive()
