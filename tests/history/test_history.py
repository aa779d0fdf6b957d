"""The history: once and whole, whoever writes; found again from either end."""

from __future__ import annotations

import csv
import signal
import subprocess
import sys
from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from sqlalchemy import select, text
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.schema import CreateIndex, CreateTable

from motorid.errors import DataError, UsageError
from motorid.quality.history import History, Query, open_history
from motorid.quality.history import schema as s
from motorid.quality.history.export import columns, export, rows
from tests.history.records import BEGAN, record

ROOT = Path(__file__).resolve().parents[2]
STATION = [sys.executable, "-m", "tests.history.records"]


@pytest.fixture
def history(tmp_path: Path) -> History:
    with open_history(tmp_path / "line.db") as found:
        yield found


def test_a_result_goes_in_whole_and_once(history: History) -> None:
    assert history.add(record(1))
    assert not history.add(record(1))
    assert history.add(record(2))
    assert history.count() == 2
    row = history.results()[0]
    assert (row.serial, row.outcome, row.at) == ("SN-00001", "PASS", BEGAN + timedelta(seconds=3))
    found = {m.name: m for m in history.measurements(row.id)}
    assert found["R"].value == 2.601
    assert (found["K"].low, found["K"].high) == (None, 0.008)


def test_what_makes_two_results_different(history: History) -> None:
    """Other limits, another version, another outcome: another result. Another clock: the same."""
    first = record(1)
    others = [
        replace(first, limits="[limits]\n"),
        replace(first, versions={"motorid": "9"}),
        replace(first, outcome="FAIL"),
        replace(first, kind="rejudged"),
    ]
    assert [history.add(r) for r in [first, *others]] == [True] * 5
    assert not history.add(replace(first, at=first.at + timedelta(hours=1)))


@pytest.mark.slow
def test_shared_texts_are_kept_once(history: History) -> None:
    for number in range(5):
        history.add(record(number))
    with history.reading() as connection:
        assert len(list(connection.execute(select(s.documents)))) == 3  # rig, program, limits
    capture = history.captures(serial="SN-00003")[0]
    assert history.document(capture.rig) == record(3).captures[0].rig
    assert history.document(history.results()[0].limits) == record(0).limits


def test_from_serial_to_capture_and_back(history: History) -> None:
    for number in range(3):
        history.add(record(number))
    history.add(replace(record(1), kind="rejudged"))
    (capture,) = history.captures(serial="SN-00001")
    assert capture.path == "shift/SN-00001.h5"
    back = history.results_of(capture.sha256)
    assert [(r.serial, r.kind) for r in back] == [("SN-00001", "check"), ("SN-00001", "rejudged")]
    assert history.captures_of(back[0].id)[0].sha256 == capture.sha256
    assert history.captures(sha256=capture.sha256[:12]) == [capture]
    assert history.captures(sha256="%") == []  # no wildcard of SQL's gets through


@pytest.mark.slow
def test_queries(history: History) -> None:
    for number in range(10):
        history.add(record(number, outcome="FAIL" if number == 4 else "PASS"))

    def serials(**fields: object) -> list[str]:
        return [row.serial for row in history.results(Query(**fields))]

    assert serials(outcome="FAIL") == ["SN-00004"]
    assert len(serials(serial="SN-*")) == 10
    assert serials(serial="SN-0000?", since=BEGAN + timedelta(seconds=27)) == ["SN-00009"]
    assert serials(serial="SN_00001") == []
    assert serials(until=BEGAN + timedelta(seconds=3)) == ["SN-00000"]
    east = (BEGAN + timedelta(seconds=27)).astimezone(timezone(timedelta(hours=8)))
    assert serials(since=east) == ["SN-00009"]
    assert [r.serial for r in history.results(last=2)] == ["SN-00008", "SN-00009"]
    series = history.series("R")
    assert [row.value for row in series][:3] == [2.6, 2.601, 2.602]
    assert history.names() == ["K", "R"]


def run_stations(place: str, ranges: list[tuple[int, int]]) -> None:
    running = [
        subprocess.Popen(
            [*STATION, place, str(a), str(b)], cwd=ROOT, stdout=subprocess.PIPE, text=True
        )
        for a, b in ranges
    ]
    for process in running:
        process.communicate(timeout=240)
        assert process.returncode == 0


@pytest.mark.slow
def test_many_processes_lose_and_double_nothing(tmp_path: Path) -> None:
    """Four stations begin on an absent file at once; their ranges overlap, as after a retry."""
    place = tmp_path / "line.db"
    run_stations(str(place), [(0, 60), (40, 100), (80, 140), (0, 60)])
    with open_history(place) as history:
        assert [row.serial for row in sorted(history.results(), key=lambda r: r.serial)] == [
            f"SN-{n:05d}" for n in range(140)
        ]
        found = [r for piece in rows(history, Query()) for r in piece]
        assert len(found) == 280


@pytest.mark.slow
def test_a_killed_station_loses_nothing_it_acknowledged(tmp_path: Path) -> None:
    """SIGKILL in mid-shift: what was said to be safe is there, and nothing is there by half."""
    place = tmp_path / "line.db"
    process = subprocess.Popen(
        [*STATION, str(place), "0", "100000"], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    said = [int(process.stdout.readline()) for _ in range(25)]
    process.send_signal(signal.SIGKILL)
    rest, _ = process.communicate(timeout=60)
    said += [int(line) for line in rest.split()]
    with open_history(place) as history:
        kept = {row.serial for row in history.results()}
        assert {f"SN-{n:05d}" for n in said} <= kept
        assert len(kept) <= len(said) + 1  # one may be safe and not yet said
        assert all(len(history.measurements(r.id)) == 2 for r in history.results())
        assert all(len(history.captures_of(r.id)) == 1 for r in history.results())
        with history.reading() as connection:
            assert connection.scalar(text("PRAGMA integrity_check")) == "ok"


@pytest.mark.slow
def test_sqlite_is_in_wal_and_readers_do_not_wait(tmp_path: Path) -> None:
    with open_history(tmp_path / "line.db") as writer, open_history(tmp_path / "line.db") as other:
        writer.add(record(1))
        with writer.engine.begin() as connection:
            assert connection.scalar(text("PRAGMA journal_mode")) == "wal"
            assert connection.scalar(text("PRAGMA synchronous")) == 2  # FULL
            assert other.count() == 1  # while the writer holds its lock


@pytest.mark.slow
def test_export(history: History, tmp_path: Path) -> None:
    for number in range(30):
        history.add(record(number))
    assert export(history, tmp_path / "line.csv", Query(serial="SN-0000*")) == 20
    with open(tmp_path / "line.csv", encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    assert list(table[0]) == columns()
    assert [float(row["value"]) for row in table[:2]] == [0.0077, 2.6]  # K, then R
    assert (table[0]["low"], table[0]["high"]) == ("", "0.008")
    assert datetime.fromisoformat(table[0]["at"]) == BEGAN
    with pytest.raises(UsageError, match="exists already"):
        export(history, tmp_path / "line.csv")
    with pytest.raises(UsageError, match="format"):
        export(history, tmp_path / "line.xlsx")


@pytest.mark.slow
def test_export_to_parquet_is_the_same_table(history: History, tmp_path: Path) -> None:
    import pandas as pd

    for number in range(30):
        history.add(record(number))
    assert export(history, tmp_path / "line.parquet") == 60
    table = pd.read_parquet(tmp_path / "line.parquet")
    assert list(table.columns) == columns()
    expected = [r for piece in rows(history, Query()) for r in piece]
    assert table["value"].tolist() == [r[columns().index("value")] for r in expected]
    assert table["at"].iloc[0].to_pydatetime() == BEGAN
    assert table["low"].isna().tolist() == [r[columns().index("low")] is None for r in expected]


def test_the_schema_compiles_for_postgresql() -> None:
    """Every table, index and query of this room in PostgreSQL's words, none in SQLite's alone."""
    dialect = postgresql.dialect()
    for table in s.metadata.sorted_tables:
        words = str(CreateTable(table).compile(dialect=dialect))
        assert "CREATE TABLE" in words
        for index in table.indexes:
            assert "CREATE" in str(CreateIndex(index).compile(dialect=dialect))
    everything = Query("SN-*", "p", "PASS", "check", "s", BEGAN, BEGAN)
    words = str(everything.apply(select(s.results)).compile(dialect=dialect))
    assert "LIKE" in words
    assert "ESCAPE" in words
    assert "TIMESTAMP WITHOUT TIME ZONE" in str(CreateTable(s.results).compile(dialect=dialect))


def test_refusals(tmp_path: Path, history: History) -> None:
    with pytest.raises(DataError, match="there is no history"):
        open_history(tmp_path / "none.db", create=False)
    stranger = tmp_path / "text.db"
    stranger.write_text("not a database, but long enough to be taken for a damaged one" * 20)
    with pytest.raises(DataError, match="cannot be used"):
        open_history(stranger)
    with pytest.raises(UsageError, match="no database"):
        open_history("nonsense://somewhere")
    with history.engine.begin() as connection:
        connection.execute(s.meta.update().values(value="2.1"))
    with pytest.raises(DataError, match=r"version 2\.1"):
        open_history(history.where)


def test_an_instant_needs_its_zone(history: History) -> None:
    with pytest.raises(DataError, match="time zone"):
        history.add(replace(record(1), at=datetime(2026, 1, 1)))
    assert history.add(replace(record(1), at=datetime(2026, 1, 1, tzinfo=UTC)))


@pytest.mark.parametrize("value", [float("inf"), float("nan"), "2.6", b"2.6"])
def test_a_number_that_is_none_is_damage(value: object) -> None:
    with pytest.raises(ValueError, match="where a number belongs: it is damaged"):
        s.Number().process_result_value(value, sqlite.dialect())


@pytest.mark.parametrize("value", [None, 2, 2.6])
def test_a_finite_number_or_none_is_read_as_it_is(value: float | None) -> None:
    assert s.Number().process_result_value(value, sqlite.dialect()) == value
