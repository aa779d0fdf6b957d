"""motorid station: orders, the operator's terminal, and a shift that is cut short."""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motorid.capture import store
from motorid.errors import UsageError
from motorid.quality.history import open_history
from motorid.quality.product import Product
from motorid.quality.verdict import Outcome, Verdict
from motorid.report.screen import Screen, big, of_verdict, render
from motorid.rig import Rig
from motorid.workflow.check import Line, Who
from motorid.workflow.station import Station
from tests.quality.controller import Controller

COMMAND = [sys.executable, "-m", "motorid.cli.main", "station", "--product", "sim-disc"]


@contextlib.contextmanager
def running(folder: Path, *more: str) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A station in its own process on a port of its own."""
    call = [*COMMAND, "--rig", "sim-line", "--speed", "max", "--listen", "0", "-o", str(folder)]
    process = subprocess.Popen(
        [*call, *more], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    assert process.stderr is not None
    try:
        said = process.stderr.readline()
        assert said.startswith("listening on 127.0.0.1:"), said
        yield process, int(said.rsplit(":", 1)[1])
    finally:
        process.kill()
        process.wait()


@pytest.mark.slow
def test_a_line_controller_gets_its_verdicts(tmp_path: Path) -> None:
    with running(tmp_path) as (_, port):
        controller = Controller(port)
        assert controller.ask(order="status")["counts"] == {"PASS": 0, "FAIL": 0, "INVALID": 0}
        first = controller.ask(order="inspect", serial="D000001", id=1)
        assert (first["event"], first["id"]) == ("accepted", 1)
        verdict = controller.hear()
        assert (verdict["event"], verdict["id"], verdict["outcome"]) == ("verdict", 1, "PASS")
        stored = json.loads((Path(verdict["folder"]) / "verdict.json").read_text())
        assert stored["outcome"] == "PASS"
        assert "scan the label" in controller.ask(order="inspect", serial="no")["message"]
        assert "no order" in controller.ask(order="explode")["message"]
        assert controller.ask(order="last", serial="D000001")["outcome"] == "PASS"
        assert "no verdict" in controller.ask(order="last", serial="D000009")["message"]
        assert controller.ask(order="status")["counts"]["PASS"] == 1
        browser = Controller(port)
        browser.say(b"POST / HTTP/1.1")
        assert browser.hear()["event"] == "error"
        assert browser.file.readline() == b""  # and the connection ends


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("kills", [2, pytest.param(8, marks=pytest.mark.study)])
def test_killed_in_mid_shift_nothing_is_lost(tmp_path: Path, kills: int) -> None:
    """Kill -9 at random moments: every verdict told is on disk, every capture gets one."""
    rng, told, number = random.Random(7), {}, 0
    for _ in range(kills):
        with running(tmp_path) as (process, port):
            controller = Controller(port)
            kill_at = None  # after the first verdict, however slow the machine
            with contextlib.suppress(TimeoutError):
                while True:
                    number += 1
                    controller.ask(order="inspect", serial=f"D{number:06d}")
                    if kill_at is not None:
                        controller.link.settimeout(max(kill_at - time.monotonic(), 0.01))
                    message = controller.hear()
                    told[message["serial"]] = message
                    kill_at = kill_at or time.monotonic() + rng.uniform(0.2, 2.5)
            process.send_signal(signal.SIGKILL)
    assert len(told) >= kills
    for message in told.values():
        stored = json.loads((Path(message["folder"]) / "verdict.json").read_text())
        assert (stored["serial"], stored["outcome"]) == (message["serial"], message["outcome"])
    for journal in tmp_path.rglob("*.journal"):  # one that still grows is another process's
        os.utime(journal, (time.time() - 60, time.time() - 60))
    with running(tmp_path) as (_, port):
        controller = Controller(port)
        assert controller.ask(order="inspect", serial="D999999")["event"] == "accepted"
        assert controller.hear()["outcome"] == "PASS"
    begun = [p for p in tmp_path.iterdir() if any(p.glob("capture.h5*"))]
    assert begun
    for folder in begun:
        stored = json.loads((folder / "verdict.json").read_text())
        if (folder / "capture.h5").exists():
            assert len(store.load(folder / "capture.h5")) > 0
        else:  # killed before the first sample: the journal stays, and the verdict says so
            assert stored["outcome"] == "INVALID"


@pytest.mark.slow
def test_killed_accepted_orders_are_named_and_not_driven(tmp_path: Path) -> None:
    """Each is judged by then, or named by the next shift until it is ordered again."""
    serials = [f"D00000{number}" for number in range(1, 5)]
    with running(tmp_path, "--queue", "9") as (process, port):
        controller = Controller(port)
        for serial in serials:
            controller.say(json.dumps({"order": "inspect", "serial": serial}).encode())
        heard = [controller.hear() for _ in serials]
        accepted = {message["serial"] for message in heard if message["event"] == "accepted"}
        process.send_signal(signal.SIGKILL)
    for journal in tmp_path.rglob("*.journal"):  # one that still grows is another process's
        os.utime(journal, (time.time() - 60, time.time() - 60))
    with running(tmp_path) as (process, port):
        assert process.stdout is not None
        assert "Ordered before and never judged: " in process.stdout.readline()
        controller = Controller(port)
        left = controller.ask(order="status")["not_judged"]
        assert left
        judged = {one.parent.name.rpartition("_")[0] for one in tmp_path.rglob("verdict.json")}
        assert accepted <= judged | set(left)
        assert controller.ask(order="inspect", serial=left[0])["event"] == "accepted"
        assert controller.hear()["event"] == "verdict"
        assert left[0] not in controller.ask(order="status")["not_judged"]


@pytest.mark.slow
def test_a_shift_goes_into_the_history_once(tmp_path: Path) -> None:
    """What a shift could not add, for want of the history or of time, the next one adds.

    Each result names who worked when it was measured, not who worked when it was added.
    """
    shift, book = tmp_path / "shift", tmp_path / "line.db"
    book.mkdir()  # no database can be made there
    names = ["--history", str(book), "--station", "line-1", "--operator"]
    with running(shift, *names, "anna") as (process, port):
        controller = Controller(port)
        controller.ask(order="inspect", serial="D000001")
        assert controller.hear()["outcome"] == "PASS"
        assert process.stdout is not None
        # READY, the same and that nobody knows of other tests, RUN, PASS, the same and why
        lines = [process.stdout.readline() for _ in range(5)]
    assert "who else tested D000001 is unknown" in lines[1]
    assert "not in the history yet" in lines[-1]
    book.rmdir()
    with running(shift, *names, "ben") as (_, port):
        controller = Controller(port)
        controller.ask(order="inspect", serial="D000002")
        assert controller.hear()["outcome"] == "PASS"
        folders = [one for one in shift.iterdir() if one.is_dir()]
        wait_for(lambda: all((one / "in-history").exists() for one in folders))
    with open_history(book) as history:
        rows = history.results()
        names = {row.serial: history.name_of(row.operator) for row in rows}
        trail = history.trail()
        assert history.verify().problems == ()
    assert names == {"D000001": "anna", "D000002": "ben"}
    assert [(one["subject"], one["outcome"], one["who"], one["station"]) for one in trail] == [
        (serial, "accepted", "controller at 127.0.0.1", "line-1") for serial in sorted(names)
    ]
    assert {row.station for row in rows} == {"line-1"}
    (folder,) = shift.glob("D000001_*")
    test = json.loads((folder / "openhtf.json").read_text(encoding="utf-8"))
    assert (test["station_id"], test["metadata"]["operator"]) == ("line-1", "anna")


@pytest.mark.parametrize("name", ["x" * 201, "a\nb", "\x1b[31m"])
def test_a_name_that_no_record_can_carry(name: str) -> None:
    with pytest.raises(UsageError, match="operator: write at most 200"):
        Who(operator=name)


def wait_for(done: Any, patience_s: float = 240.0) -> None:
    until = time.monotonic() + patience_s
    while not done():
        assert time.monotonic() < until, "it did not happen in time"
        time.sleep(0.1)


NO_TMUX = "tmux is not installed: the operator's screen is not seen in it"


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("tmux") is None, reason=NO_TMUX)
def test_the_operators_screen_in_tmux(tmp_path: Path) -> None:
    """Keyboard alone, in a terminal of 80 x 24: READY, scan, PASS, scan, INVALID serial, end."""
    server = ["tmux", "-L", f"motorid-{os.getpid()}"]
    station = " ".join([*COMMAND, "--rig", "sim-line", "--speed", "max", "--no-listen"])
    start = [*server, "-f", "/dev/null", "new-session", "-d", "-x", "80", "-y", "24"]
    command = f"{station} -o {tmp_path / 'shift'}; echo ended with $?; sleep 60"
    subprocess.run([*start, command], check=True)

    def screen() -> str:
        call = [*server, "capture-pane", "-p", "-e"]
        seen = subprocess.run(call, capture_output=True, text=True, check=True).stdout
        return " ".join(seen.split())

    def type_(*keys: str) -> None:
        subprocess.run([*server, "send-keys", *keys], check=True)

    try:
        wait_for(lambda: "scan its serial number" in screen())
        assert "Serial number:" in screen()
        type_("D000123", "Enter")
        wait_for(lambda: "Put the motor with the good ones" in screen())
        shown = screen()
        assert "D000123" in shown
        assert "\x1b[30m\x1b[42m" in shown or "\x1b[30;42m" in shown  # green, and the word
        assert "PASS" in shown
        assert "█" in shown
        type_("nonsense", "Enter")
        wait_for(lambda: "scan the label again" in screen())
        type_("C-d")
        wait_for(lambda: "ended with 0" in screen())
    finally:
        subprocess.run([*server, "kill-server"], check=False)


@pytest.mark.slow
def test_the_scanner_works_through_a_pipe(tmp_path: Path) -> None:
    call = [*COMMAND, "--rig", "sim-line", "--speed", "max", "--no-listen", "-o", str(tmp_path)]
    call += ["--queue", "9"]  # nobody waits for a verdict before the next line
    typed = "D000001\r\nwhat\nD000002"
    done = subprocess.run(call, input=typed, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    words = [line.split(" |")[0] for line in lines]
    assert words == ["READY", "RUN", "PASS", "PASS", "RUN", "PASS"]  # a refusal leaves the verdict
    assert "D000001" in lines[3]
    assert "scan the label again" in lines[3]


@pytest.mark.slow
def test_a_full_disk_is_said_and_survived(
    line_rig: Rig, product: Product, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from motorid.errors import DataError
    from motorid.workflow import check

    def full(*args: object) -> None:
        raise DataError("no space left")

    shown: list[Screen] = []
    with Line(line_rig, product, tmp_path) as line:
        station = Station(line, shown.append)
        monkeypatch.setattr(check, "write_records", full)
        station.scan(["D000001"], ends=True)
        station.run()
    assert shown[-1].word == "INVALID"
    assert "no space left" in shown[-1].lines[1]
    assert station.counts == {}  # no verdict was told that is not on disk


@pytest.mark.parametrize("outcome", list(Outcome))
@pytest.mark.parametrize("width", [20, 40, 80, 200])
def test_the_word_is_there_and_fits(outcome: Outcome, width: int) -> None:
    screen = Screen(str(outcome), ("why " * 40,), "do this " * 10, "")
    text = render(screen, width=width)
    assert str(outcome) in text
    assert max(map(len, text.splitlines())) <= max(width, 24)


def test_big_letters_and_an_empty_verdict() -> None:
    assert len(big("PASS", 80)) == 5
    assert big("PASS", 10) == ["PASS"]
    assert of_verdict(Verdict("p", "s", ())).word == "INVALID"
