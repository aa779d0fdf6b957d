"""Load: nothing is lost, memory stays flat, and slow disks and terminals are borne."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire import record
from motorid.acquire.journal_writer import JournalWriter
from motorid.acquire.live import Live
from motorid.acquire.port import open_port
from motorid.capture import store
from motorid.errors import LinkError, MotoridError, RigError
from motorid.rig import Rig
from tests.acquire.rigs import sim_rig
from tests.load import day

posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")


@posix
@pytest.mark.slow
@pytest.mark.long
def test_five_seconds_through_a_pseudo_terminal_lose_nothing(tmp_path: Path) -> None:
    from tests.load import pty

    found = pty.run(5.0, tmp_path, host_silence_s=10.0)  # for a busy computer
    assert found["samples"] == found["expected"] == 50_000
    assert (found["gaps"], found["bad frames"], found["end"]) == (0, 0, "completed")
    assert found["memory grew by MB"] is None or found["memory grew by MB"] < 4


@posix
@pytest.mark.slow
def test_a_slow_terminal_loses_nothing(tmp_path: Path) -> None:
    """Each line of progress takes 80 ms, ten times a second."""
    from tests.load import pty

    found = pty.run(4.0, tmp_path, pause_s=0.08, host_silence_s=5.0)
    assert found["samples"] == found["expected"]
    assert found["gaps"] == 0


@pytest.mark.slow
@pytest.mark.long
def test_a_slow_run_keeps_its_memory(tmp_path: Path) -> None:
    found = day.run(0.1, tmp_path)
    assert found["samples"] == found["expected"] == 36_000
    assert found["gaps"] == 0
    grew = found["memory grew while running by MB"]
    assert grew is None or grew < 4


@pytest.mark.slow
def test_a_slow_disk_holds_up_no_heartbeat(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each sync takes 0.3 s, more than half of what the board waits for the host."""
    fsync = os.fsync

    def slow(handle: int) -> None:
        time.sleep(0.3)
        fsync(handle)

    monkeypatch.setattr("motorid.acquire.journal_writer.os.fsync", slow)
    rig = impatient_rig()
    kept = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    assert (len(kept), kept.gaps, kept.end_reason) == (3800, (), "completed")


def impatient_rig() -> Rig:
    """In real time, on a board that waits a quarter of a second for the host."""
    rig = sim_rig(speed="realtime")
    return replace(rig, limits=replace(rig.limits, host_silence_s=0.25))


@pytest.mark.slow
def test_a_process_that_gets_no_core_is_no_silent_host(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the run the system leaves client and simulated board waiting for half a second."""
    waits: list[float] = []  # to come
    waited: list[float] = []

    def held_up(seconds: float) -> None:
        waited.extend(waits)
        time.sleep(waits.pop() if waits else seconds)

    def in_mid_run(live: Live) -> None:
        if live.done_s > 0 and not waited:
            waits.append(0.5)

    clock = SimpleNamespace(sleep=held_up, monotonic=time.monotonic)
    monkeypatch.setattr("motorid.sim.port.time", clock)
    rig = impatient_rig()
    path = record.capture(rig, rig.program, tmp_path / "run.h5", progress=in_mid_run)
    kept = store.load(path)
    assert waited
    assert (len(kept), kept.gaps, kept.end_reason) == (3800, (), "completed")


@pytest.mark.slow
def test_a_host_long_about_other_things_is_a_silent_one(tmp_path: Path) -> None:
    """And the board is not blamed for it, although nothing was heard of it meanwhile."""
    rig, calls = impatient_rig(), itertools.count()

    def busy_once(live: Live) -> None:
        if next(calls) == 1:
            time.sleep(1.5)

    with pytest.raises(RigError, match="this computer sent none for"):
        record.capture(rig, rig.program, tmp_path / "run.h5", progress=busy_once)


@pytest.mark.slow
def test_a_disk_far_behind_slows_the_reader_and_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The journal's queue is full nearly all the time."""
    monkeypatch.setattr("motorid.acquire.journal_writer.BACKLOG", 4)
    batch = JournalWriter._batch

    def slow(self: JournalWriter) -> Any:
        time.sleep(0.01)
        return batch(self)

    monkeypatch.setattr(JournalWriter, "_batch", slow)
    rig = sim_rig()
    kept = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    assert (len(kept), kept.gaps) == (3800, ())


def test_no_failure_to_open_leaves_a_descriptor(tmp_path: Path) -> None:
    rig = sim_rig()
    threads = threading.active_count()
    for port in ("/dev/no-such-port", "socket://127.0.0.1:9", "replay://nothing", "foo://x"):
        with pytest.raises(MotoridError):
            record.capture(replace(rig, port=port), rig.program, tmp_path / "run.h5")
    assert threading.active_count() == threads
    assert list(tmp_path.iterdir()) == []


@posix
@pytest.mark.slow
def test_a_second_process_is_told_who_holds_the_port(tmp_path: Path) -> None:
    from tests.load import pty

    code = "import sys\nfrom motorid.acquire.port import open_port\nport = open_port(sys.argv[1])\n"
    code += "print('held', flush=True)\nsys.stdin.read()"
    with pty.terminal() as path:
        holder = subprocess.Popen(
            [sys.executable, "-c", code, path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            assert holder.stdout is not None
            assert holder.stdout.readline() == "held\n"
            with pytest.raises(LinkError, match="another program holds this port") as caught:
                open_port(path)
            if Path("/proc").is_dir():
                assert f"process {holder.pid}," in str(caught.value)
        finally:
            holder.communicate("")


@pytest.mark.slow
def test_progress_that_fails_stops_the_motor_and_leaves_no_thread(tmp_path: Path) -> None:
    """An error of the caller's own is no fault of the rig, and passes through as it is."""
    threads = threading.active_count()
    rig = sim_rig()

    def fail(live: Live) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        record.capture(rig, rig.program, tmp_path / "run.h5", progress=fail)
    assert threading.active_count() == threads
    kept = store.load(tmp_path / "run.h5")
    assert len(kept) > 0
    assert kept.end_reason == "interrupted"
    assert list(tmp_path.iterdir()) == [tmp_path / "run.h5"]  # no journal is left
