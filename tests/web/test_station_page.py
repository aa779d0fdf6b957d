"""The operator's page: what it shows and says, who may scan there, and nothing old as new."""

from __future__ import annotations

import contextlib
import json
import re
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from motorid.cli.live import Listen
from motorid.cli.operator_page import OperatorPage
from motorid.quality.judge import not_measured
from motorid.quality.product import Product, SelfTest, load_product
from motorid.quality.verdict import Outcome
from motorid.report import screen as screens
from motorid.report.screen import Screen
from motorid.rig import load_rig
from motorid.workflow import station_words
from motorid.workflow.check import Inspection, Line, write_records
from motorid.workflow.shift_board import LAST, ShiftBoard
from motorid.workflow.station import Station
from tests.chromium import Page
from tests.web.test_live_page import browser, page

__all__ = ["browser", "page"]  # fixtures
PAGES = Path(__file__).resolve().parents[2] / "motorid" / "web" / "page"
PATIENCE_S = 60.0


class Shift:
    """A station with its page, on a simulated rig as fast as it computes."""

    def __init__(self, line: Line) -> None:
        self.shown: list[Screen] = []
        self.page = OperatorPage(line, "Line 3", self.shown.append)
        self.station = Station(line, self.page.show, witnesses=[self.page])

    @property
    def origin(self) -> str:
        return "/".join(self.page.url.split("/")[:3])

    def socket(self) -> Any:
        url = self.page.url.replace("http", "ws") + "live"
        return connect(url, origin=self.origin, close_timeout=1)  # type: ignore[arg-type]


@contextlib.contextmanager
def shift(folder: Path, *, scans: bool = True, works: bool = True) -> Iterator[Shift]:
    """``works``: its own thread inspects; else a test says what is shown."""
    rig = load_rig("sim-line")
    rig = replace(rig, port=f"{rig.port}&speed=max")
    with Line(rig, load_product("sim-disc"), folder) as line:
        one = Shift(line)
        with one.page.served(one.station, Listen("0", False, None, None), scans=scans):
            thread = threading.Thread(target=one.station.run)
            if works:
                thread.start()
            try:
                yield one
            finally:
                one.station.end()
                if works:
                    thread.join()


def text(page: Page, name: str) -> str:
    return str(page.run(f'document.getElementById("{name}").innerText'))


def word(page: Page, wanted: str) -> None:
    page.wait(f'document.body?.dataset.word === "{wanted}"')


@pytest.mark.slow
def test_a_shift_on_the_page(page: Page, tmp_path: Path) -> None:
    """One motor, scanned by typing, with twenty others watching; then the station is gone."""
    with shift(tmp_path) as here, contextlib.ExitStack() as stack:
        others = [stack.enter_context(here.socket()) for _ in range(20)]
        page.open(here.page.url)
        word(page, "READY")
        assert "due now" in text(page, "shift")
        page.run("document.activeElement.blur()")
        for letter in "nonsense":
            page.ask("Input.dispatchKeyEvent", type="keyDown", key=letter, text=letter)
        page.ask("Input.dispatchKeyEvent", type="keyDown", key="Enter", text="\r")
        page.wait('document.getElementById("reasons").innerText.includes("no serial number")')
        for letter in "D000007":  # wherever the page is
            page.ask("Input.dispatchKeyEvent", type="keyDown", key=letter, text=letter)
        page.run('document.getElementById("send").click()')
        word(page, "PASS")
        assert text(page, "serial") == "D000007"
        assert text(page, "word") == "PASS"
        assert text(page, "next") == screens.NEXT[Outcome.PASS]
        assert "100.0 % of 1" in text(page, "shift")
        assert "D000007" in text(page, "last")
        assert page.run("motorid.figures.received") > 1000  # the run was seen
        assert page.run("motorid.figures.played") == ["PASS"]
        for one in others:
            words = (json.loads(said).get("word") for said in one if isinstance(said, str))
            assert next(said for said in words if said == "PASS")
        page.run('document.getElementById("language").click()')
        assert text(page, "word") == "GUT"
        assert "Motor zu den guten legen" in text(page, "next")
        page.run('document.getElementById("language").click()')
        assert page.complaints == []
    word(page, "gone")
    assert text(page, "word") == "NO CONNECTION"
    assert text(page, "reasons") == ""
    assert page.run('getComputedStyle(document.getElementById("serial")).display') == "none"
    assert page.run('document.getElementById("scan").hidden')


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1920, 1080), (1024, 768), (768, 1024)], ids=str)
def test_each_word_is_seen_by_colour_and_text(
    size: tuple[int, int], scheme: str, page: Page, tmp_path: Path
) -> None:
    reasons = tuple(f"R_25 is 3.{k} Ω, above 2.9 Ω by more than the guard band" for k in range(4))
    with shift(tmp_path, works=False) as here:
        page.size(*size)
        page.scheme(scheme)
        page.open(here.page.url)
        colours = set()
        for name in ("READY", "RUN", "PASS", "FAIL", "INVALID"):
            here.page.show(Screen(name, ("D000123", *reasons), "Call maintenance."))
            word(page, name)
            assert text(page, "word") == name
            colours.add(page.run(
                'getComputedStyle(document.getElementById("verdict")).backgroundColor'
            ))  # fmt: skip
            high = page.run('document.getElementById("word").getBoundingClientRect().height')
            assert high > 0.08 * min(size)
            low = page.run('document.getElementById("next").getBoundingClientRect().bottom')
            assert low < size[1]  # what to do is there without scrolling
            assert page.run("document.documentElement.scrollWidth") <= size[0]
        assert len(colours) == 5
        page.run('document.getElementById("language").click()')
        assert page.run("document.documentElement.scrollWidth") <= size[0]


@pytest.mark.slow
def test_a_connection_that_falls_silent_is_a_lost_one(page: Page, tmp_path: Path) -> None:
    """Nobody closes it: a cable is out, or the program hangs. It is there again later."""
    with shift(tmp_path, works=False) as here:
        here.page.show(Screen("PASS", ("D000001",), ""))
        page.open(here.page.url)
        word(page, "PASS")
        turn = here.page.hub.turn
        here.page.hub.turn = lambda: None  # type: ignore[method-assign]
        word(page, "gone")
        here.page.hub.turn = turn  # type: ignore[method-assign]
        word(page, "PASS")
        assert page.run("motorid.figures.played") == []  # it was heard before


@pytest.mark.slow
def test_touch_keys_type_a_serial_number(page: Page, tmp_path: Path) -> None:
    with shift(tmp_path, works=False) as here:
        here.page.show(Screen("READY", (), ""))
        page.open(here.page.url)
        page.wait('document.getElementById("scan") && !document.getElementById("scan").hidden')
        page.run('document.getElementById("pad").click()')
        keys = '[...document.querySelectorAll("#keypad button")]'
        for key in ("D", "1", "2", "⌫"):
            page.run(f'{keys}.find((one) => one.textContent === "{key}").click()')
        assert page.run('document.getElementById("number").value') == "D1"


@pytest.mark.slow
def test_without_leave_a_page_only_watches(tmp_path: Path) -> None:
    with shift(tmp_path, scans=False, works=False) as here, here.socket() as socket:
        socket.send('{"ask": "scan", "serial": "D000001"}')
        said = []
        with pytest.raises(ConnectionClosed):
            said.extend(json.loads(one) for one in socket)
        assert not any(one.get("scans") for one in said)
        assert here.station._in_work == []


@pytest.mark.slow
def test_the_terminal_names_the_page(tmp_path: Path) -> None:
    with shift(tmp_path, works=False) as here:
        here.page.show(Screen("READY", (), "Scan."))
        here.page.show(Screen("PASS", ("D000001",), "Scan.", "PASS 1"))
        assert [one.footer for one in here.shown] == [f"page: {here.page.url}", "PASS 1"]


@pytest.mark.slow
@pytest.mark.parametrize("serial", ["", " ", 7, None, "x" * 300])
def test_what_is_no_serial_number_moves_nothing(serial: object, tmp_path: Path) -> None:
    with shift(tmp_path, works=False) as here, here.socket() as socket:
        socket.send(json.dumps({"ask": "scan", "serial": serial}))
        said = (json.loads(one) for one in iter(lambda: socket.recv(timeout=PATIENCE_S), None))
        assert "scan a serial number" in next(one["refused"] for one in said if "refused" in one)
        assert here.station._in_work == []


def test_every_sentence_of_the_station_is_there_in_german() -> None:
    page = (PAGES / "words.js").read_text(encoding="utf-8")
    shown = [
        station_words.ready(product()),
        station_words.running("17"),
        station_words.not_kept("17", OSError()),
    ]
    steps = [*screens.NEXT.values(), *(screen.next_step for screen in shown)]
    assert len(steps) >= 6
    assert [one for one in steps if f'"{one}":' not in page] == []
    english, german = (
        set(re.findall(r"(\w+|\"\"): ", part))
        for part in re.findall(r"  (?:en|de): \{\n(.*?)\n  \},", page, re.DOTALL)
    )
    assert english == german


# ---- what stands beside the word


def board(folder: Path, **test: Any) -> ShiftBoard:
    return ShiftBoard(folder, product(**test))


def product(**test: Any) -> Product:
    return replace(load_product("sim-disc"), self_test=SelfTest(**test))


def inspected(folder: Path, serial: str, outcome: Outcome, begin: float) -> Inspection:
    """A motor's verdict as its folder holds it; ``begin`` in seconds."""
    verdict = not_measured(product(), serial, "a reason")
    rows = tuple(replace(row, outcome=outcome) for row in verdict.measurements)
    verdict = replace(verdict, measurements=rows)
    inside = folder / f"{serial}_{begin:.0f}"
    write_records(verdict, inside, datetime.fromtimestamp(1.8e9 + begin, UTC))
    return Inspection(verdict, inside, verdict.exit_code)


def test_a_motor_that_proves_the_rig_falls_due(tmp_path: Path) -> None:
    one = board(tmp_path, golden=("GOLD",), inspections=3)
    station = Station(Line(load_rig("sim-line"), product(), tmp_path), lambda screen: None)
    ready = Screen("READY", (), "")
    due = lambda: one.facts(ready, station)["golden_due"]  # noqa: E731
    assert due() == 0  # it has never passed
    one.judged(inspected(tmp_path, "D000001", Outcome.PASS, 1))
    assert due() == 0
    one.judged(inspected(tmp_path, "GOLD", Outcome.PASS, 2))
    assert due() == 3
    for number in range(4):
        one.judged(inspected(tmp_path, f"D00001{number}", Outcome.FAIL, 3 + number))
    assert due() == 0
    assert board(tmp_path, inspections=6).since_sound == 4  # any motor's pass, from disk


def test_the_last_motors_are_there_after_a_restart(tmp_path: Path) -> None:
    for number in range(LAST + 2):
        inspected(tmp_path, f"D0000{number:02}", Outcome.PASS, number)
        time.sleep(0.002)  # so that their files have an order
    (tmp_path / "D000099_0").mkdir()
    (tmp_path / "D000099_0" / "verdict.json").write_text("{")  # damaged: it proves nothing
    kept = [one["serial"] for one in board(tmp_path).last]
    assert kept == [f"D0000{number:02}" for number in range(LAST + 1, 1, -1)]


def test_the_yield_counts_first_tests_that_were_judged(tmp_path: Path) -> None:
    station = Station(Line(load_rig("sim-line"), product(), tmp_path), lambda screen: None)
    one = board(tmp_path)
    ready = Screen("READY", (), "")
    assert one.facts(ready, station)["first_pass_yield"] is None
    station.counts.update(PASS=4, FAIL=1, INVALID=2)
    station.first.update(PASS=3, FAIL=1, INVALID=1)
    facts = one.facts(ready, station)
    assert (facts["first_pass_yield"], facts["first_tests"], facts["again"]) == (0.75, 4, 2)
