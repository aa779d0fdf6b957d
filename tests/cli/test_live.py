"""motorid scope and --live: what a person at the terminal sees, and how they end."""

from __future__ import annotations

import builtins
import io
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.acquire import port
from motorid.acquire.tap import RunFacts, Scale, Tap
from motorid.capture import store
from motorid.cli import live, main
from motorid.cli.live_screen import SPAN_S, Curves, LiveScreen
from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel

CHANNELS = (Channel.CURRENT, Channel.POSITION)
FACTS = RunFacts(
    1e6, 1000, CHANNELS, (Scale("current", "A", 0.001), Scale("position", "rad", 0.01))
)
URL = re.compile(r"^open http://127\.0\.0\.1:\d+/[0-9a-f]{48}/$", re.MULTILINE)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def feed(tap: Tap, begin: int, end: int) -> None:
    give = tap.begin(FACTS)
    for first in range(begin, end, 100):
        number = np.arange(first, first + 100)
        raw = np.column_stack([number % 1000, number]).astype(np.int16)
        give(SampleBlock(0, 1000 * first, 0, first, CHANNELS, raw))


@pytest.mark.slow
def test_a_capture_is_shown_on_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = "capture --rig sim --speed max --live --listen 0 -o"
    path = tmp_path / "run.h5"
    assert main.run([*line.split(), str(path)]) == 0
    assert URL.search(capsys.readouterr().err)
    assert store.load(path).end_reason == "completed"


@pytest.mark.slow
def test_at_a_terminal_the_run_waits_for_enter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, there = tmp_path / "run.h5", list[bool]()
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True)
    monkeypatch.setattr(live, "prompt", lambda *_, **__: there.append(any(tmp_path.iterdir())))
    line = "capture --rig sim --speed max --live --listen 0 -o"
    assert main.run([*line.split(), str(path)]) == 0
    assert there == [False]
    assert path.exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "code", "why"),
    [
        ("capture --rig sim --live=terminal -o run.h5", 2, "no terminal|is none"),
        ("capture --rig sim --live --listen 192.0.2.1:7411 -o run.h5", 2, "--allow-remote"),
        ("scope --rig sim --listen 192.0.2.1:7411 --allow-remote", 2, "TLS"),
        ("scope --rig sim --live=terminal --allow-drive", 2, "--allow-drive"),
        ("capture --rig sim -o run.h5 --allow-remote", 2, "--live"),
        ("station --product sim-disc --rig sim-line --allow-drive", 2, "--page"),
        ("station --product sim-disc --rig sim-line --page 192.0.2.1:0", 2, "--allow-remote"),
        ("scope --rig sim --port /dev/nosuch --listen 0", 3, "no such port"),
    ],
)
def test_what_cannot_be_shown_is_said_before_anything_turns(
    line: str,
    code: int,
    why: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main.run(line.split()) == code
    assert re.search(why, capsys.readouterr().err)
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_without_its_packages_the_page_names_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    real = builtins.__import__

    def missing(name: str, *args: Any, **more: Any) -> Any:
        if name == "uvicorn":
            raise ImportError(name)
        return real(name, *args, **more)

    monkeypatch.setattr(builtins, "__import__", missing)
    assert main.run(["scope", "--rig", "sim", "--listen", "0"]) == 2
    assert "pip install 'motorid[web]'" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGINT to a child alone")
def test_a_scope_ends_by_ctrl_c_with_the_bridge_open() -> None:
    command = [sys.executable, "-m", "motorid.cli.main", "scope", "--rig", "sim", "--listen", "0"]
    scope = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert scope.stderr is not None
    try:
        assert URL.match(scope.stderr.readline())
        scope.send_signal(signal.SIGINT)
        _, said = scope.communicate(timeout=60)
    finally:
        scope.kill()
    assert scope.returncode == 130
    assert "Traceback" not in said


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGINT to a child alone")
def test_ctrl_c_while_the_port_opens_ends_a_scope_as_any_other(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    opened = []

    def opening(name: str, *more: Any, **options: Any) -> Any:
        signal.raise_signal(signal.SIGINT)
        opened.append(real(name, *more, **options))
        return opened[-1]

    real = port.open_port
    monkeypatch.setattr(port, "open_port", opening)
    assert main.run(["scope", "--rig", "sim", "--listen", "0", "--seconds", "30"]) == 130
    assert len(opened) == 1  # and closed, by the one who asked for it
    assert "the bridge is open" in capsys.readouterr().err


def test_a_terminal_shows_the_latest_seconds() -> None:
    tap, curves = Tap(), Curves()
    assert curves.page(80, 24, "watching") == ["watching", "no samples yet"]
    feed(tap, 0, 7000)  # longer than the curves
    curves.take(tap)
    head, *lines = curves.page(80, 24, "watching: the bridge is open")
    assert head == "watching: the bridge is open"
    captions = [line for line in lines if re.match(r"[a-z]", line)]
    assert [line.split(",")[0] for line in captions] == ["current", "position", "speed"]
    assert captions[1].split()[2] == "+69.99"
    assert "+20 to +69.99" in captions[1]  # of the last five seconds
    assert "+10" in captions[2]
    assert all(len(line) <= 80 for line in lines)
    assert len(lines) <= 24
    assert len(set("".join(line for line in lines if line not in captions))) > 8  # it is a curve


def test_a_gap_leaves_a_blank_in_the_curve() -> None:
    tap, curves = Tap(), Curves()
    feed(tap, 0, 1000)
    curves.take(tap)
    feed(tap, 4000, 5000)
    curves.take(tap)
    values = curves._values(0)
    assert len(values) == round(SPAN_S / 1e-3)
    known = np.isfinite(values)
    assert known[:1000].all()
    assert not known[1000:4000].any()
    assert known[4000:].all()


def test_a_screen_draws_in_its_place() -> None:
    tap, stream = Tap(), Terminal()
    feed(tap, 0, 1000)
    with LiveScreen(tap, stream) as screen:
        screen.post("watching", "the bridge is open", 1)
    text = stream.getvalue()
    assert "watching: the bridge is open" in text
    assert "current, A" in text
