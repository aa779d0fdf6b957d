"""A closed terminal, a dropped ssh, a request to terminate: stopped at once, and kept."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from motorid.acquire import interrupt, record
from motorid.acquire.port import Port
from motorid.acquire.session import Session
from motorid.capture import store
from motorid.sim.port import SimPort, open_sim
from motorid.wire.codec import decode
from motorid.wire.enums import EndReason
from motorid.wire.framing import Decoder, Frame
from tests.acquire.rigs import sim_rig
from tests.conformance.boards import emulator_lacks

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no hang-ups")
STOPPED_S = 0.05
HANG_UP = getattr(signal, "SIGHUP", signal.SIGTERM)
ASKING = [HANG_UP, signal.SIGTERM, signal.SIGINT]


class SignalledPort:
    """A simulated board whose host gets signals ``at_s`` seconds after the start of a run.

    Runs count from 1, the check pulse. ``mute``: the host hears nothing from that start on.
    """

    def __init__(self, inner: SimPort, at_s: float, numbers: list[int], run: int = 2) -> None:
        self.name = inner.name
        self._inner, self._at_s, self._numbers, self._run = inner, at_s, numbers, run
        self._device: Any = inner._device
        self.signalled_s: float | None = None
        self.stopped_s: float | None = None
        self.mute = False
        self._sent = Decoder()
        self._runs = 0
        self._began = 0.0

    def read(self, size: int, timeout_s: float) -> bytes:
        due = self._runs >= self._run and self.now() - self._began >= self._at_s
        if due and self.signalled_s is None:
            self.signalled_s = self.now()
            for number in self._numbers:
                signal.raise_signal(number)
        data = self._inner.read(size, timeout_s)
        return b"" if self.mute and self._runs >= self._run else data

    def write(self, data: bytes) -> None:
        self._inner.write(data)
        for frame in self._sent.feed(data):
            assert isinstance(frame, Frame)
            command = decode(frame.payload)
            if command.name == "start" and self._runs < self._run:
                self._runs += 1
                self._began = self.now()
            if command.name == "stop" and self.signalled_s is not None and not self.stopped_s:
                self.stopped_s = self.now()

    def now(self) -> float:
        return self._inner.now()

    def close(self) -> None:
        self._inner.close()

    @property
    def after_s(self) -> float:
        """From the signal to the stop."""
        assert self.signalled_s is not None
        assert self.stopped_s is not None
        return self.stopped_s - self.signalled_s


def signalled(
    monkeypatch: pytest.MonkeyPatch, at_s: float, numbers: list[int], run: int = 2
) -> Callable[[], SignalledPort]:
    """Captures from now on get a signalled port; returns the last of them."""
    made: list[SignalledPort] = []

    def opened(url: str) -> Port:
        made.append(SignalledPort(open_sim(url), at_s, numbers, run))
        return made[-1]

    monkeypatch.setattr(record, "open_port", opened)
    return lambda: made[-1]


@pytest.mark.slow
@pytest.mark.parametrize(
    "numbers",
    [*([one] for one in ASKING), [HANG_UP] * 2, [HANG_UP, signal.SIGTERM]],
    ids=lambda numbers: "+".join(signal.Signals(n).name for n in numbers),
)
def test_the_stop_is_sent_at_once_and_the_run_is_kept(
    numbers: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A shell and its terminal both send a hang-up: the second does not cut the first short."""
    last = signalled(monkeypatch, 0.1, numbers)
    path = tmp_path / "run.h5"
    with pytest.raises(KeyboardInterrupt, match=r"\d+ samples are kept in"):
        record.capture(rig := sim_rig(), rig.program, path)
    assert last().after_s <= STOPPED_S
    capture = store.load(path)
    assert capture.end_reason == "interrupted"
    assert capture.provenance["link"]["done"]["reason"] == EndReason.STOPPED
    assert capture.gaps == ()
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("run", [1, 2], ids=["check pulse", "run"])
def test_the_stop_does_not_wait_for_the_reply_to_start(
    run: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    last = signalled(monkeypatch, 0.03, [HANG_UP], run)
    opened = record.open_port

    def mute(url: str) -> Port:
        port = opened(url)
        port.mute = True  # type: ignore[attr-defined]
        return port

    monkeypatch.setattr(record, "open_port", mute)
    with pytest.raises(KeyboardInterrupt, match="nothing was measured"):
        record.capture(rig := sim_rig(), rig.program, tmp_path / "run.h5")
    assert last().after_s <= STOPPED_S
    assert last()._device.bench.is_open
    assert list(tmp_path.iterdir()) == []


def test_nothing_moves_that_was_to_start_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hang-up while offsets are read: no pulse follows."""
    last = signalled(monkeypatch, 0.2, [HANG_UP], run=0)
    with pytest.raises(KeyboardInterrupt, match="nothing was measured"):
        record.capture(rig := sim_rig(), rig.program, tmp_path / "run.h5")
    assert last()._device.board.runs == 0


@pytest.mark.parametrize("number", ASKING)
def test_a_level_of_a_calibration_stops_too(number: int) -> None:
    rig = sim_rig()
    port = SignalledPort(open_sim(rig.port), 0.1, [number])
    session = Session(port, rig)
    pulse = session.pulse()
    session.board.wait_for_rest()
    with pytest.raises(KeyboardInterrupt, match="the bridge is open"):
        session.hold(1.0, 1.0, pulse)
    assert port.after_s <= STOPPED_S
    assert port._device.bench.is_open


@pytest.mark.slow
def test_a_caller_s_own_error_stops_the_motor_and_keeps_the_run(tmp_path: Path) -> None:
    """Such as a line of progress to a terminal that is gone."""

    def gone(live: Any) -> None:
        raise OSError(5, "Input/output error")

    rig = sim_rig()
    with pytest.raises(OSError, match="Input/output"):
        record.capture(rig, rig.program, tmp_path / "run.h5", progress=gone)
    capture = store.load(tmp_path / "run.h5")
    assert len(capture) > 0
    assert capture.end_reason == "interrupted"
    assert list(tmp_path.iterdir()) == [tmp_path / "run.h5"]


@contextlib.contextmanager
def handlers_kept() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in interrupt.ASKING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@pytest.mark.parametrize("number", ASKING)
def test_the_program_ends_as_interrupted_wherever_it_waits(number: int) -> None:
    with handlers_kept():
        interrupt.heed()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)


def test_a_hang_up_that_is_ignored_stays_so() -> None:
    """As nohup asks for."""
    with handlers_kept():
        signal.signal(HANG_UP, signal.SIG_IGN)
        interrupt.heed()
        with interrupt.interruptible() as stop:
            signal.raise_signal(HANG_UP)
            assert not stop.requested
        signal.raise_signal(HANG_UP)
        assert signal.getsignal(HANG_UP) == signal.SIG_IGN


def test_a_hang_up_after_the_outcome_changes_no_exit_code() -> None:
    with handlers_kept():
        signal.signal(HANG_UP, signal.SIG_DFL)
        interrupt.heed()
        interrupt.heed_no_more()
        signal.raise_signal(HANG_UP)
        assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL  # an exit that hangs can end


# ---------------------------------------------------------------- terminals that close


def on_terminal(words: list[str], cwd: Path) -> tuple[subprocess.Popen[bytes], int]:
    """A command with a terminal of its own, as its controlling one; and the terminal's far end."""
    import fcntl
    import termios

    far, near = os.openpty()
    process = subprocess.Popen(
        words,
        stdin=near,
        stdout=near,
        stderr=near,
        cwd=cwd,
        start_new_session=True,
        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
    )
    os.close(near)
    return process, far


def seen(far: int, text: bytes) -> None:
    """Reads the terminal until ``text`` has come."""
    found = b""
    while text not in found:
        found += os.read(far, 4096)


def close_in_mid_run(words: list[str]) -> int:
    """Closes the terminal of a capture once it shows a part of the run; its exit code."""
    root = Path(__file__).resolve().parents[2]
    process, far = on_terminal(words, root)
    try:
        seen(far, b"rad/s")
        os.close(far)
        return process.wait(60)
    finally:
        process.kill()
        process.wait()


@pytest.mark.slow
def test_a_closed_terminal_ends_a_capture_gently(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    words = [sys.executable, "-m", "motorid.cli.main", "capture", "--rig", "sim"]
    close_in_mid_run(
        [*words, "--port", "sim://?motor=faulhaber-2338s006s&speed=realtime", "-o", str(path)],
    )
    capture = store.load(path)
    assert capture.end_reason == "interrupted"
    assert capture.provenance["link"]["done"]["reason"] == EndReason.STOPPED
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
def test_a_closed_terminal_stops_an_emulated_board(repo_root: Path, tmp_path: Path) -> None:
    """By the board's own word, and by its pins, long before it would miss the heartbeats."""
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    path = tmp_path / "run.h5"
    server = repo_root / "firmware" / "emulator" / "serve.py"
    motor = "emu://uno?motor=dunkermotoren-gr42"
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, str(server), motor], cwd=repo_root, **pipes) as board:
        try:
            device = next(line.strip() for line in board.stdout if line.startswith("/dev/"))
            words = [sys.executable, "-m", "motorid.cli.main", "capture", "-o", str(path)]
            rig = str(repo_root / "rigs" / "emulated-uno.toml")
            close_in_mid_run([*words, "--rig", rig, "--port", device])
            board.stdin.write("\n")
            board.stdin.flush()
            assert not json.loads(board.stdout.readline())["enabled"]
        finally:
            board.kill()
    capture = store.load(path)
    assert capture.end_reason == "interrupted"
    assert capture.provenance["link"]["done"]["reason"] == EndReason.STOPPED
    assert list(tmp_path.iterdir()) == [path]
