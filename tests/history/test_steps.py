"""The steps of the history's tables: from an old file, on both databases, never by surprise."""

from __future__ import annotations

import shutil
import sqlite3
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import event

from motorid.cli.main import run
from motorid.errors import DataError
from motorid.quality.history import History, Query, open_history, steps
from motorid.quality.history import schema as s
from tests.history.records import BEGAN, record

OLD = Path(__file__).parents[1] / "corpus" / "format_1_0"


def sql(place: Path, *statements: str) -> list[Any]:
    with closing(sqlite3.connect(place)) as connection, connection:
        return [row for one in statements for row in connection.execute(one)]


def differences(history: History) -> list[Any]:
    """Between the tables that the steps made and those that the code means."""
    with history.reading() as connection:
        return list(compare_metadata(MigrationContext.configure(connection), s.metadata))


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """A history from before there were steps, without seals."""
    for path in OLD.glob("line.db*"):
        shutil.copy(path, tmp_path)
    return tmp_path / "line.db"


def test_the_last_step_is_the_one_that_the_code_writes() -> None:
    config = Config()
    config.set_main_option("script_location", str(steps.FOLDER))
    assert ScriptDirectory.from_config(config).get_heads() == [s.STEP]


def test_the_steps_make_the_tables_that_the_code_means(tmp_path: Path) -> None:
    with open_history(tmp_path / "new 100%.db") as history:
        assert differences(history) == []
        assert history.stepped == (steps.NONE, s.STEP)
    with open_history(tmp_path / "new 100%.db") as history:
        assert history.stepped == (s.STEP, s.STEP)


def test_an_old_file_is_brought_up_to_date_and_a_copy_stays(old: Path) -> None:
    was = sql(old, "SELECT * FROM results", "SELECT * FROM measurements")
    with open_history(old) as history:
        assert history.stepped == (steps.FIRST, s.STEP)
        assert differences(history) == []
        assert history.add(record(1))
        checked = history.verify()
        assert (checked.sealed, checked.unsealed, checked.problems) == (1, 1, ())
    copy = old.with_name(f"line.db.before-{s.STEP}")
    assert sql(copy, "SELECT * FROM results", "SELECT * FROM measurements") == was
    with open_history(copy, create=False) as history:  # as old as it was, and readable
        assert [row.serial for row in history.results()] == ["D000017"]


def test_who_only_reads_changes_nothing(old: Path) -> None:
    with open_history(old, create=False) as history:
        assert history.count() == 1
    assert list(old.parent.glob("*.before-*")) == []
    assert sql(old, "SELECT name FROM sqlite_master WHERE name = 'alembic_version'") == []


def test_without_room_for_a_copy_nothing_changes(
    old: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any) -> None:
        raise OSError(28, "no space left on device")

    monkeypatch.setattr("motorid.quality.history.steps.os.fsync", full)
    with pytest.raises(DataError, match="no copy of it could be kept first"):
        open_history(old)
    assert sql(old, "SELECT name FROM sqlite_master WHERE name = 'alembic_version'") == []
    assert list(old.parent.glob("*.before-*")) == []


@pytest.mark.slow
def test_a_step_that_fails_leaves_the_file_as_it_was(old: Path) -> None:
    sql(old, "CREATE INDEX ix_results_product_id ON results (id)")  # the last one of a step
    before = sql(old, "SELECT name FROM sqlite_master ORDER BY name")
    with pytest.raises(DataError, match="ix_results_product_id already exists"):
        open_history(old)
    assert sql(old, "SELECT name FROM sqlite_master ORDER BY name") == before


@pytest.mark.slow
@pytest.mark.parametrize("create", [True, False])
def test_a_newer_history_is_refused_in_a_sentence(tmp_path: Path, create: bool) -> None:
    path = tmp_path / "line.db"
    with open_history(path) as history:
        history.add(record(1))
    sql(path, "UPDATE alembic_version SET version_num = '0099'")
    with pytest.raises(DataError, match=r"tables of step 0099, this motorid knows steps up to"):
        open_history(path, create=create)
    assert list(tmp_path.glob("*.before-*")) == []


def test_init_and_upgrade_say_what_they_did(old: Path, capfd: pytest.CaptureFixture[str]) -> None:
    new = old.with_name("new.db")
    for words, said in (
        (["init", str(new)], "now (before: none)"),
        (["init", str(new)], "already"),
        (["upgrade", str(old)], f"now (before: {steps.FIRST})"),
        (["upgrade", str(old)], "already"),
    ):
        assert run(["history", *words]) == 0
        assert said in capfd.readouterr().out


def test_the_newest_readings_are_those_of_the_whole_series(tmp_path: Path) -> None:
    with open_history(tmp_path / "line.db") as history:
        for number in (5, 3, 9, 1, 7):
            history.add(record(number))
        every = history.series("R")
        assert history.series("R", last=2) == every[-2:]
        assert [row.serial for row in every[-2:]] == ["SN-00007", "SN-00009"]


@pytest.mark.slow
def test_the_queries_of_a_line_need_no_walk_through_all_results(tmp_path: Path) -> None:
    """SQLite's own plan of each statement that is sent: by an index that also gives the order."""
    plans: list[str] = []

    def explain(_: Any, cursor: Any, statement: str, given: Any, *__: Any) -> None:
        found = cursor.connection.execute(f"EXPLAIN QUERY PLAN {statement}", given).fetchall()
        plans.append(str([row[-1] for row in found]))

    with open_history(tmp_path / "line.db") as history:
        history.add(record(1))
        event.listen(history.engine, "before_cursor_execute", explain)
        for query, index in (
            (Query(serial="SN-00001"), "ix_results_serial"),
            (Query(outcome="FAIL"), "ix_results_outcome_id"),
            (Query(station="line-1"), "ix_results_station_id"),
            (Query(product="pump-motor"), "ix_results_product_id"),
        ):
            history.results(query, last=50)
            assert index in plans[-1], plans[-1]
            assert "B-TREE" not in plans[-1]
        history.series("R", last=100)
        assert "ix_results_at" in plans[-1], plans[-1]
        assert "SCAN measurements" not in plans[-1]
        assert "(name=?)" not in plans[-1]  # nor every reading of the quantity
        for since in (None, BEGAN):
            history.readings(Query(station="line-1", since=since), 100, "R")
            newest = plans[-1].partition("CO-ROUTINE")[2]
            assert "ix_results_station_at" in newest, plans[-1]
            assert "B-TREE" not in newest.partition("SCAN anon")[0]


@pytest.mark.slow
def test_threads_make_several_histories_at_once(tmp_path: Path) -> None:
    """Alembic has one context for a whole process."""
    places = [tmp_path / f"{n}.db" for n in range(8)]

    def make(place: Path) -> tuple[str, str]:
        with open_history(place) as history:
            assert differences(history) == []
            return history.stepped

    with ThreadPoolExecutor(8) as threads:
        assert set(threads.map(make, places)) == {(steps.NONE, s.STEP)}


def test_a_series_as_arrays_is_the_series(tmp_path: Path) -> None:
    """In pieces, in the order of time; a damaged reading is refused."""
    with open_history(tmp_path / "line.db") as history:
        for number in (5, 3, 9, 1, 7):
            history.add(record(number))
        for last in (None, 2):
            rows = history.series("R", last=last)
            times, values = history.arrays("R", Query(), last)
            assert values.tolist() == [row.value for row in rows]
            assert times.tolist() == [row.at.replace(tzinfo=None) for row in rows]
        assert len(history.arrays("none", Query())[0]) == 0
        sql(tmp_path / "line.db", "UPDATE measurements SET value = 9e999 WHERE name = 'R'")
        with pytest.raises(DataError, match="it is damaged"):
            history.arrays("R", Query())
