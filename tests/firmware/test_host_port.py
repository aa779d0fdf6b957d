"""The core as a program of this computer: its command line, its links, and a host that dies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from motorid.acquire.board import Board
from motorid.acquire.port import open_port
from motorid.wire.enums import Fault, State
from tests.conformance.boards import HOST_PORT, HostBoard, build_firmware, module_of, query
from tests.conformance.client import Client
from tests.conformance.lock_step import stop

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def binary() -> Path:
    return build_firmware() / "host" / "board"


@contextmanager
def running(*flags: str) -> Iterator[str]:
    """A board in a process of its own; where it can be reached."""
    build_firmware()
    command = [sys.executable, str(HOST_PORT / "board.py"), *flags, "sim://?seed=2"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
    finally:
        stop(process)


def complaint(binary: Path, *arguments: str) -> str:
    done = subprocess.run([binary, *arguments], capture_output=True, text=True, timeout=10)
    assert done.returncode == 2
    return done.stderr


@pytest.mark.slow
def test_mistakes_on_the_command_line_are_told(binary: Path) -> None:
    good = module_of(HOST_PORT / "board.py").arguments(query({}))
    assert "clock_hz is missing" in complaint(binary, "--pty")
    assert "give --socket PORT or --pty" in complaint(binary, *good)
    assert "give --socket PORT or --pty" in complaint(binary, *good, "--pty", "--socket", "0")
    assert "no such value" in complaint(binary, "--pty", *good, "plant.colour=3")
    assert "not a number" in complaint(binary, "--pty", *good, "seed=x")
    assert "not a number" in complaint(binary, "--pty", *good, "seed=nan")
    assert "NAME=VALUE" in complaint(binary, "--pty", *good, "seed")
    assert "--speed: not understood" in complaint(binary, "--pty", "--speed", "slow", *good)
    assert "--socket: not understood" in complaint(binary, "--socket", "70000", *good)
    assert "window does not fit" in complaint(binary, "--pty", *good, "current.true_delay=1")


def test_the_wrapper_refuses_what_the_port_does_not_have() -> None:
    arguments = module_of(HOST_PORT / "board.py").arguments
    with pytest.raises(ValueError, match="no option fault"):
        arguments("sim://?fault=stall")


@pytest.mark.slow
@pytest.mark.parametrize("flags", [("--pty",), ("--socket", "0")], ids=["pty", "socket"])
def test_motorid_finds_a_board_there(flags: tuple[str, ...]) -> None:
    with running(*flags) as url:
        port = open_port(url)
        board = Board(port)
        assert board.identify()["board"] == "motorid-host"
        assert sorted(board.descriptors) == [
            "current",
            "position",
            "supply_voltage",
            "terminal_voltage",
        ]
        board.make_ready()
        assert board.supply_v() == pytest.approx(7.0, rel=0.02)
        port.close()


@pytest.mark.slow
def test_full_speed_is_faster_than_the_wall_clock() -> None:
    """Once at least, where other programs hold the cores most of the time."""
    with running("--socket", "0", "--speed", "max") as url:
        client = Client(open_port(url), deadline_s=30.0)
        client.bring_up()

        def gained() -> float:
            ticks = [client.get("read_status")["tick"]]
            began = time.monotonic()
            client.wait(0.3)
            ticks.append(client.get("read_status")["tick"])
            simulated = ((ticks[1] - ticks[0]) & 0xFFFF_FFFF) / client.identity["clock_hz"]
            return float(simulated / (time.monotonic() - began))

        assert any(gained() > 1.5 for _ in range(50))


DRIVER = """
import sys, time
from motorid.acquire.port import open_port
from tests.conformance.client import Client
client = Client(open_port(sys.argv[1]), deadline_s=30.0)
client.bring_up()
client.start(client.drive(200_000), host_silence_ms=200)
print("running", flush=True)
while True:
    client.send("heartbeat", sequence=0)
    client.wait(0.02)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no make and gcc: nor SIGKILL")
def test_a_host_that_is_killed_stops_the_motor() -> None:
    with running("--socket", "0") as url:
        command = [sys.executable, "-c", DRIVER, url]
        host = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT)
        assert host.stdout is not None
        assert host.stdout.readline() == "running\n"
        time.sleep(0.3)
        host.send_signal(signal.SIGKILL)
        stop(host)
        time.sleep(2.0)  # ten times the silence that it bears
        client = Client(open_port(url), deadline_s=30.0)
        client.wait(0.05)
        status = client.get("read_status")
        assert (status["state"], status["fault"]) == (State.FAULTED, Fault.HOST_SILENCE)


def test_lock_step_is_deterministic() -> None:
    heard = []
    for _ in range(2):
        board = HostBoard(seed=9)
        client = Client(board.port)
        client.bring_up()
        record = client.run(client.drive(500), client.coast(100))
        heard.append((record.start_tick, record.samples.tobytes(), board.port.now()))
        board.close()
    assert heard[0] == heard[1]
