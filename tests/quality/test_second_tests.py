"""A motor that comes again: refused, counted, or taken with a reason."""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from motorid.errors import UsageError
from motorid.json_seal import sealed
from motorid.quality.history import open_history
from motorid.quality.history.records import ResultRecord, from_stored
from motorid.quality.product import Product, parse
from motorid.report.screen import Screen
from motorid.rig import Rig
from motorid.workflow.check import CAPTURE, VERDICT, Line
from motorid.workflow.second_tests import together
from motorid.workflow.shift_history import ShiftHistory
from motorid.workflow.station import Station


def heard(station: Station, **order: Any) -> dict[str, Any]:
    """The first answer to an order."""
    answers: list[dict[str, Any]] = []
    station.take(order, answers.append)
    return answers[0]


@pytest.mark.slow
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


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_capture_that_a_killed_shift_left_counts_as_a_first_test(
    line_rig: Rig, product: Product, good: Path, tmp_path: Path
) -> None:
    """Its verdict is made before the first order is taken."""
    once = parse(
        product.text.replace('example = "D000123"', 'example = "D000123"\nrepeat = "refuse"')
    )
    left = tmp_path / "D000001_20260101T080000"
    left.mkdir()
    shutil.copy(good, left / CAPTURE)
    with Line(line_rig, once, tmp_path) as line:
        station = Station(line, lambda screen: None)
        station.settle()
        assert (left / VERDICT).exists()
        said = heard(station, order="inspect", serial="D000001")["message"]
    assert "was judged before (PASS" in said


@pytest.mark.slow
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


def into_history(book: Path, product: Product, serial: str, outcome: str, day: int) -> None:
    """A verdict of another station, whose folder is on another disk."""
    at = datetime(2026, 1, day, tzinfo=UTC)
    record = ResultRecord(
        "check", serial, (), (), product=product.name, outcome=outcome, at=at, station="line-2"
    )
    with open_history(book) as history:
        assert history.add(record)


@pytest.mark.parametrize(
    ("serial", "allowed"), [("D000001", False), ("D000002", True), ("D000003", True)]
)
def test_what_another_station_judged_is_a_test_before(
    serial: str, allowed: bool, line_rig: Rig, product: Product, tmp_path: Path
) -> None:
    """Of this product: the second motor was another product's, the third INVALID."""
    once = parse(
        product.text.replace('example = "D000123"', 'example = "D000123"\nrepeat = "refuse"')
    )
    book = tmp_path / "line.db"
    into_history(book, once, "D000001", "PASS", 1)
    into_history(book, replace(once, name="other"), "D000002", "PASS", 2)
    into_history(book, once, "D000003", "INVALID", 3)
    with Line(line_rig, once, tmp_path / "shift") as line:
        station = Station(line, lambda screen: None, ShiftHistory(str(book), once, {}))
        assert station.history is not None
        station.history.judged(serial, patience_s=60.0)  # what is loaded once
        station.history.patience_s = 60.0
        said = heard(station, order="inspect", serial=serial)
    assert (said["event"] == "accepted") == allowed, said
    if not allowed:
        assert "D000001 was judged before (PASS, 2026-01-01T00:00:00+00:00 at line-2)" in str(said)


def test_verdicts_of_folder_and_history_count_once() -> None:
    here = [{"outcome": "PASS", "time": "2026-01-02T08:00:00.250+00:00", "folder": "a"}]
    elsewhere = [
        {"outcome": "PASS", "time": "2026-01-02T08:00:00.250000+00:00", "station": "x"},
        {"outcome": "FAIL", "time": "2026-01-03T08:00:00+00:00", "station": "y"},
    ]
    assert together(here, elsewhere) == [elsewhere[1], here[0]]


def test_a_refused_scan_leaves_the_verdict_on_the_screen(
    line_rig: Rig, product: Product, tmp_path: Path
) -> None:
    shown: list[Screen] = []
    with Line(line_rig, product, tmp_path) as line:
        station = Station(line, shown.append)
        station.show(Screen("FAIL", ("D000001", "R_25"), "Put it into the red box."))
        station.scanned("nonsense")
        station.scanned("rubbish")
        station.end()
        station._serve()
    first, *refused = shown
    for screen in refused:
        assert (screen.word, screen.next_step) == (first.word, first.next_step)
        assert screen.lines[:-1] == first.lines  # one refusal, the latest
        assert "D000123" in screen.lines[-1]  # as a number looks
    assert len(refused) == 2
