"""motorid station: orders, the operator's terminal, and a shift that is cut short."""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.capture import store
from motorid.errors import UsageError
from motorid.json_seal import sealed
from motorid.quality.history import open_history
from motorid.quality.history.records import from_stored
from motorid.quality.product import Product, parse
from motorid.quality.verdict import Outcome, Verdict
from motorid.report.screen import Screen, big, of_verdict, render
from motorid.rig import Rig
from motorid.workflow.check import Line, Who
from motorid.workflow.orders import (
    MOST_CLIENTS,
    Answer,
    Message,
    Orders,
    read_order,
)
from motorid.workflow.station import Station

COMMAND = [sys.executable, "-m", "motorid.cli.main", "station", "--product", "sim-disc"]


class Controller:
    """A line controller: one connection, JSON lines."""

    def __init__(self, port: int) -> None:
        self.link = socket.create_connection(("127.0.0.1", port), timeout=240)
        self.file = self.link.makefile("rwb")

    def say(self, line: bytes) -> None:
        self.file.write(line + b"\n")
        self.file.flush()

    def hear(self) -> dict[str, Any]:
        return dict(json.loads(self.file.readline()))

    def ask(self, **order: Any) -> dict[str, Any]:
        self.say(json.dumps(order).encode())
        return self.hear()


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
def test_killed_in_mid_shift_nothing_is_lost(tmp_path: Path, product: Product) -> None:
    """Kill -9 at random moments: every verdict told is on disk, every capture gets one."""
    rng, told, number = random.Random(7), {}, 0
    for _ in range(4):
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
    assert len(told) >= 4
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
        lines = [process.stdout.readline() for _ in range(4)]  # READY, RUN, PASS, PASS and why
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
    assert {row.serial: row.operator for row in rows} == {"D000001": "anna", "D000002": "ben"}
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
    words = [line.split(" |")[0] for line in done.stdout.splitlines()]
    assert words == ["READY", "RUN", "PASS", "READY", "RUN", "PASS"]


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


@given(st.binary(max_size=200))
def test_any_line_is_an_order_or_a_sentence(line: bytes) -> None:
    with contextlib.suppress(ValueError):
        assert isinstance(read_order(line + b"\n")["order"], str)


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


@pytest.mark.parametrize(
    "value", ["1e999", "NaN", "-Infinity", '"\\ud800"', "9" * 400, '1, "id": 2', "[" * 60_000]
)
def test_an_order_is_strict_json(value: str) -> None:
    """What is read would be answered, and an answer that is no JSON stops the controller."""
    line = f'{{"order": "status", "id": {value}}}\n'.encode()
    with pytest.raises(ValueError, match="an order is a JSON object on one line: "):
        read_order(line)


class Deaf:
    """What a socket server shows of a client that never reads."""

    def __init__(self, port: int) -> None:
        self.link = socket.socket()
        self.link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
        self.link.connect(("127.0.0.1", port))

    def shout(self, lines: int) -> None:
        line = b'{"order": "status", "id": "' + b"x" * 150 + b'"}\n'
        with contextlib.suppress(OSError):  # the station ends it when enough is unread
            for _ in range(lines):
                self.link.sendall(line)


@pytest.fixture
def server() -> Iterator[Orders]:
    def take(order: Message, answer: Answer) -> None:
        if order["order"] == "inspect":
            answer({"event": "accepted"})
        else:
            answer({"event": "status", "id": order.get("id"), "much": "y" * 20_000})

    orders = Orders(("127.0.0.1", 0), take)
    yield orders
    orders.stop()


def test_a_client_that_never_reads_stops_nobody(server: Orders) -> None:
    deaf = Deaf(server.port)
    deaf.shout(2_000)  # 40 MB of answers: no socket holds them
    assert Controller(server.port).ask(order="status", id=3)["id"] == 3
    deaf.link.close()


def test_idle_connections_make_way_and_waiting_ones_stay(server: Orders) -> None:
    waiting = [Controller(server.port) for _ in range(3)]
    assert [one.ask(order="inspect")["event"] for one in waiting] == ["accepted"] * 3
    idle = [Controller(server.port) for _ in range(MOST_CLIENTS - 3)]
    assert {one.ask(order="status")["event"] for one in idle} == {"status"}
    late = Controller(server.port)
    assert late.ask(order="status")["event"] == "status"
    assert idle[0].file.readline() == b""  # it had said nothing for longest
    assert waiting[0].ask(order="status")["event"] == "status"
    for one in (*idle[1:], late):
        assert one.ask(order="inspect")["event"] == "accepted"
    refused = Controller(server.port)
    assert "wait already" in refused.hear()["message"]


def test_what_is_too_long_is_refused_before_it_is_kept() -> None:
    with pytest.raises(ValueError, match="'id' of an order is longer than 200 characters"):
        read_order(json.dumps({"order": "status", "id": "x" * 300}).encode() + b"\n")


def heard(station: Station, **order: Any) -> dict[str, Any]:
    """The first answer to an order."""
    answers: list[dict[str, Any]] = []
    station.take(order, answers.append)
    return answers[0]


def test_one_order_is_in_work_and_a_bounced_scan_is_none(
    line_rig: Rig, product: Product, tmp_path: Path
) -> None:
    shown: list[Screen] = []
    with Line(line_rig, product, tmp_path) as line:
        station = Station(line, shown.append)
        station.scan(["D000001", "D000001", "D000002"], ends=False)
        assert (
            "D000001 is in work already"
            in heard(station, order="inspect", serial="D000001")["message"]
        )
        assert "after its verdict" in heard(station, order="inspect", serial="D000002")["message"]
        station.end()
        station.run()
        assert [s.word for s in shown] == ["READY", "RUN", "PASS"]
        assert "2 scans ignored" in str(shown[-1])
        assert heard(station, order="inspect", serial="D000001")["event"] == "accepted"
        station.end()
        station.run()
    status = station.status()
    assert status["counts"]["PASS"] == 2
    assert status["first_tests"]["PASS"] == 1  # the second test of a motor is no first pass


def test_a_product_may_refuse_a_second_test(
    line_rig: Rig, product: Product, tmp_path: Path
) -> None:
    once = parse(
        product.text.replace('example = "D000123"', 'example = "D000123"\nrepeat = "refuse"')
    )
    with Line(line_rig, once, tmp_path) as line:
        station = Station(line, lambda screen: None)
        for _ in range(2):
            station.scan(["D000001"], ends=True)
            station.run()
        assert station.counts["PASS"] == 1
        said = heard(station, order="inspect", serial="D000001")["message"]
    assert "was judged before (PASS" in said
    with pytest.raises(UsageError, match=r"serial\.repeat must be one of count, refuse"):
        parse(product.text.replace('example = "D000123"', 'repeat = "twice"'))


@pytest.mark.parametrize("rule", ["reason", "release"])
def test_a_second_test_with_a_reason(
    rule: str, line_rig: Rig, product: Product, tmp_path: Path
) -> None:
    """Any second test, or only that of a rejected motor; the reason stays with the verdict."""
    example = 'example = "D000123"'
    asking = parse(product.text.replace(example, f'{example}\nrepeat = "{rule}"'))
    shown: list[Screen] = []
    with Line(line_rig, asking, tmp_path) as line:
        station = Station(line, shown.append)
        station.scan(["D000001"], ends=True)
        station.run()
        rejected(tmp_path, "D000001")
        refused = heard(station, order="inspect", serial="D000001")
        assert "(FAIL" in refused["message"]
        assert "needs a reason" in refused["message"]
        station.scan(["D000001"], ends=True)
        station.run()
        assert "`D000001 new connector`" in str(shown[-1])
        assert (
            "at most 200"
            in heard(station, order="inspect", serial="D000001", reason="x" * 201)["message"]
        )
        station.scan(["D000001 loose plug"], ends=True)
        station.run()
        assert (station.counts["PASS"], station.first["PASS"]) == (2, 1)
        stored = json.loads((newest(tmp_path) / "verdict.json").read_text(encoding="utf-8"))
        assert stored["retest"] == "loose plug"
        assert from_stored(stored, []).note == "tested again: loose plug"
        after_a_pass = heard(station, order="inspect", serial="D000001")
        assert (after_a_pass["event"] == "accepted") == (rule == "release")


def newest(folder: Path) -> Path:
    return max((one for one in folder.glob("D*_*")), key=lambda one: one.stat().st_mtime_ns)


def rejected(folder: Path, serial: str) -> None:
    """Makes the verdict on a motor a FAIL, and older than what comes."""
    path = newest(folder) / "verdict.json"
    said = json.loads(path.read_text(encoding="utf-8"))
    said.pop("sha256", None)
    assert said["serial"] == serial
    path.write_text(json.dumps(sealed(said | {"outcome": "FAIL"})), encoding="utf-8")
    for one in (path, path.parent):
        os.utime(one, (1.7e9, 1.7e9))


def verdict_on_disk(folder: Path, serial: str, outcome: str, hour: int) -> None:
    inspection = folder / f"{serial}_20260101T{hour:02d}0000"
    inspection.mkdir()
    said = {
        "serial": serial,
        "outcome": outcome,
        "marginal": False,
        "reasons": [],
        "time": f"2026-01-01T{hour:02d}:00:00+00:00",
    }
    path = inspection / "verdict.json"
    path.write_text(json.dumps(sealed(said)), encoding="utf-8")
    os.utime(path, (1.7e9 + hour, 1.7e9 + hour))


@pytest.mark.parametrize(
    ("rule", "outcomes", "allowed"),
    [
        ("refuse", ["INVALID"], True),
        ("reason", ["INVALID", "INVALID"], True),
        ("release", ["FAIL", "INVALID"], False),
        ("release", ["FAIL", "PASS", "INVALID"], True),
        ("refuse", ["PASS", "INVALID"], False),
    ],
)
def test_invalid_is_no_judgement(
    rule: str,
    outcomes: list[str],
    allowed: bool,
    line_rig: Rig,
    product: Product,
    tmp_path: Path,
) -> None:
    """It uses up no test of a motor, and releases none that was rejected."""
    example = 'example = "D000123"'
    asking = parse(product.text.replace(example, f'{example}\nrepeat = "{rule}"'))
    for hour, outcome in enumerate(outcomes):
        verdict_on_disk(tmp_path, "D000001", outcome, hour)
    with Line(line_rig, asking, tmp_path) as line:
        station = Station(line, lambda screen: None)
        answer = heard(station, order="inspect", serial="D000001")
        assert (answer["event"] == "accepted") == allowed, answer
        if not allowed:  # and it is not in work: the next motor is taken
            assert heard(station, order="inspect", serial="D000002")["event"] == "accepted"


def test_an_order_that_comes_with_the_verdict_is_a_second_test(
    line_rig: Rig, product: Product, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rule looks at the disk once the motor is in work: no verdict falls between the two."""
    once = parse(
        product.text.replace('example = "D000123"', 'example = "D000123"\nrepeat = "refuse"')
    )
    with Line(line_rig, once, tmp_path) as line:
        station = Station(line, lambda screen: None)
        enter = station._enter

        def judged_meanwhile(serial: str) -> str:
            verdict_on_disk(tmp_path, serial, "PASS", 1)
            return enter(serial)

        monkeypatch.setattr(station, "_enter", judged_meanwhile)
        said = heard(station, order="inspect", serial="D000001")["message"]
    assert "was judged before (PASS" in said
