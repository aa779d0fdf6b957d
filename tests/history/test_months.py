"""Results by month on a real PostgreSQL: made by who comes first, one key over all months."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from alembic.autogenerate import compare_metadata
from alembic.command import upgrade
from alembic.config import Config
from alembic.migration import MigrationContext
from sqlalchemy import Connection, create_engine, event, insert, inspect, select
from sqlalchemy.exc import IntegrityError

from motorid.errors import DataError
from motorid.quality.history import History, Query, months, open_history, steps
from motorid.quality.history import schema as s
from tests.history.records import record
from tests.history.servers import Server, running

pytestmark = [pytest.mark.slow, pytest.mark.long]
DIVIDED = ("results", "measurements", "result_captures")
LAST_DAY, NEXT_DAY = datetime(2026, 3, 31, 23, 59, tzinfo=UTC), datetime(2026, 4, 1, tzinfo=UTC)


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with running() as found:
        yield found


def partitions(history: History, table: str = "results") -> list[str]:
    asked = (
        "SELECT inhrelid::regclass::text FROM pg_inherits "
        f"WHERE inhparent = '{table}'::regclass ORDER BY 1"
    )
    with history.reading() as connection:
        return list(connection.exec_driver_sql(asked).scalars())


def differences(history: History) -> list[Any]:
    """Between the tables of the server and those that the code means, months aside."""
    months_ = {one for table in DIVIDED for one in partitions(history, table)}
    with history.reading() as connection:
        found = compare_metadata(MigrationContext.configure(connection), s.metadata)
        unique = inspect(connection).get_pk_constraint(months.keys.name)["constrained_columns"]
    assert unique == ["key"]  # in place of the one constraint that partitions cannot have
    return [one for one in found if not _of_months(one, {*months_, months.keys.name})]


def _of_months(one: Any, tables: set[str]) -> bool:
    """Whether a difference is a partition, what PostgreSQL gives it, or the key's own table."""
    what, thing = one
    if what == "add_constraint":
        return bool(thing.name == "uq_results_key")
    if what == "remove_fk":  # a reference to a table is one to each of its partitions
        return str(thing.elements[0].target_fullname).partition(".")[0] in tables
    return (thing if what == "remove_table" else thing.table).name in tables


def at(when: datetime, number: int, **changed: Any) -> Any:
    return replace(record(number, station=f"line-{number % 5}"), at=when, **changed)


def test_a_month_is_made_with_the_next_one_and_found_by_the_id(server: Server) -> None:
    with open_history(server.database("made")) as history:
        assert partitions(history) == []
        for number, when in enumerate((LAST_DAY, NEXT_DAY, datetime(2026, 12, 2, tzinfo=UTC))):
            assert history.add(at(when, number))
        for table in DIVIDED:
            ends = [one.rpartition("_")[2] for one in partitions(history, table)]
            assert ends == ["202603", "202604", "202605", "202612", "202701"]
        assert [row.id // months.FIRST for row in history.results()] == [202603, 202604, 202612]
        assert history.verify().problems == ()
        assert differences(history) == []
        for row in history.results():
            assert len(history.measurements(row.id)) == 2
            assert len(history.captures_of(row.id)) == 1


@pytest.mark.parametrize("when", [datetime.min, datetime.max, datetime(2026, 1, 31)])
def test_any_time_that_a_clock_may_show_has_its_month(server: Server, when: datetime) -> None:
    with open_history(server.database(f"clock_{when.year}")) as history:
        assert history.add(at(when.replace(tzinfo=UTC), 1))
        assert [row.at for row in history.results()] == [when.replace(tzinfo=UTC)]
        assert len(history.series("R", Query(since=when.replace(tzinfo=UTC)))) == 1


def test_what_is_no_month_is_refused(server: Server) -> None:
    with (
        open_history(server.database("no_month")) as history,
        pytest.raises(DataError, match="202613 is no month"),
    ):
        history._write(lambda c: c.exec_driver_sql("SELECT motorid_month(202613)"))


def test_a_result_is_not_added_in_another_month_again(server: Server) -> None:
    """Its key holds no time where a capture tells; twenty writers try it at once."""
    with open_history(server.database("again")) as history:
        first = at(LAST_DAY, 1)
        with ThreadPoolExecutor(20) as writers:
            records = [replace(first, at=one) for one in (LAST_DAY, NEXT_DAY) * 10]
            assert sum(writers.map(history.add, records)) == 1
        assert history.count() == 1
        assert history.verify().sealed == 1
        (row,) = history.results()
        same = {name: value for name, value in row._mapping.items() if name != "id"}
        with pytest.raises(IntegrityError, match="pk_result_keys"), history.engine.begin() as c:
            months.add(c, same | {"at": NEXT_DAY})
        assert history.count() == 1


def test_rows_need_their_result(server: Server) -> None:
    with open_history(server.database("orphans")) as history:
        history.add(at(LAST_DAY, 1))
        (row,) = history.results()
        cited = history.captures_of(row.id)[0].sha256
        for table, values in (
            (s.result_captures, {"result": row.id + 1, "position": 0, "capture": cited}),
            (months.keys, {"key": "0" * 64, "result": row.id + 1}),
        ):
            with pytest.raises(IntegrityError, match="fk_result"), history.engine.begin() as c:
                c.execute(insert(table).values(**values))


def test_a_new_month_waits_for_no_reader(server: Server) -> None:
    """Who reads all for an hour holds nobody up; nor does a backup, which locks no more."""
    with open_history(server.database("read")) as history:
        history.add(at(LAST_DAY, 1))
        with history.reading() as reader:
            for table in DIVIDED:
                reader.exec_driver_sql(f"SELECT * FROM {table}")  # holds its locks to the end
            with open_history(history.where, patience_s=60.0) as other:
                assert other.add(at(datetime(2027, 1, 5, tzinfo=UTC), 2))
        assert history.count() == 2


def test_twenty_writers_at_the_turn_of_a_month(server: Server) -> None:
    """Of months that nobody has made: none lost, none doubled, each in its month."""
    place = server.database("turn")
    turn = [datetime(2026 + n // 12, n % 12 + 1, 1, tzinfo=UTC) for n in range(10)]

    def write(writer: int) -> int:
        with open_history(place) as history:
            return sum(history.add(at(turn[n % 10], n)) for n in range(writer, writer + 10))

    with ThreadPoolExecutor(20) as writers:
        added = sum(writers.map(write, range(20)))
    with open_history(place) as history:
        assert added == history.count() == 29
        assert {row.serial for row in history.results()} == {f"SN-{n:05d}" for n in range(29)}
        assert all(row.id // months.FIRST == months.month_of(row.at) for row in history.results())
        assert (history.verify().sealed, history.verify().problems) == (29, ())


def test_a_question_on_a_month_reads_that_month(server: Server) -> None:
    """By PostgreSQL's own plan, for the results and for their measurements."""
    plans: list[str] = []

    def explain(_: Any, cursor: Any, statement: str, given: Any, *__: Any) -> None:
        with create_engine(history.where).connect() as other:
            found = other.exec_driver_sql(f"EXPLAIN {statement}", given)
            plans.append("\n".join(row[0] for row in found))

    with open_history(server.database("asked")) as history:
        for month in range(1, 7):
            history.add(at(datetime(2026, month, 5, tzinfo=UTC), month))
        event.listen(history.engine, "before_cursor_execute", explain)
        march = Query(since=datetime(2026, 3, 1, tzinfo=UTC), until=LAST_DAY)
        assert [row.serial for row in history.results(march)] == ["SN-00003"]
        assert [row.serial for row in history.series("R", march)] == ["SN-00003"]
        for plan in plans:
            assert "_202603" in plan
            assert not any(f"_20260{n}" in plan for n in (1, 2, 4, 5, 6)), plan


# ---- histories from before there were months


def made(place: str, step: str, source: History) -> None:
    """The tables of a step, with the rows of ``source``, whose tables have the same columns."""
    config = Config()
    config.set_main_option("script_location", str(steps.FOLDER))
    engine = create_engine(place)
    with engine.begin() as connection, source.reading() as read:
        config.attributes["connection"] = connection
        upgrade(config, "0001" if step == steps.FIRST else step)
        there = inspect(connection).get_table_names()
        for table in s.metadata.sorted_tables:
            rows = [dict(row._mapping) for row in read.execute(select(table))]
            if table.name in there and rows and table.name != "meta":
                connection.execute(insert(table), rows)
        connection.exec_driver_sql("SELECT setval('results_id_seq', max(id)) FROM results")
        if step == steps.FIRST:
            _unsealed(connection)
    engine.dispose()


def _unsealed(connection: Connection) -> None:
    for table in ("seals", "alembic_version"):
        connection.exec_driver_sql(f"DROP TABLE {table}")
    connection.exec_driver_sql("DELETE FROM meta WHERE name = 'unsealed'")


@pytest.mark.parametrize("step", [steps.FIRST, "0001", "0002", "0003", "0004"])
def test_older_tables_are_divided_and_keep_each_row(
    server: Server, tmp_path: Path, step: str
) -> None:
    """Their ids, seals, counts and names; what comes next goes into its month, once."""
    place = server.database(f"step_{step}")
    later = steps.FIRST < "0003" <= step
    with open_history(tmp_path / "line.db") as source:
        for number in range(30):
            when = LAST_DAY if number % 2 else NEXT_DAY
            source.add(at(when, number, operator="anna" if later else ""))
        made(place, step, source)
        was = [tuple(row) for row in source.results()]
        with pytest.raises(DataError, match="motorid history upgrade"):
            open_history(place)
        with open_history(place, create=False) as history:  # who reads needs no step
            assert [tuple(row) for row in history.results()] == was
            assert len(history.series("R", Query(since=NEXT_DAY))) == 15
        with open_history(place, create=False, upgrade=True) as history:
            assert history.stepped == (step, s.STEP)
            assert partitions(history) == ["results_before"]
            assert [tuple(row) for row in history.results()] == was
            assert [tuple(r) for r in history.series("R")] == [tuple(r) for r in source.series("R")]
            sealed = 0 if step == steps.FIRST else 30
            checked = history.verify()
            assert (checked.sealed, checked.unsealed, checked.problems) == (sealed, 30 - sealed, ())
            assert differences(history) == []
            again = at(LAST_DAY, 1, operator="anna" if later else "")
            assert not history.add(replace(again, at=NEXT_DAY))
            assert history.add(at(NEXT_DAY, 31))
            assert history.results()[-1].id == months.FIRST * 202604 + 31
            assert len(history.series("R", Query(since=NEXT_DAY))) == 16
            assert history.verify().problems == ()
            if later:
                assert history.name_of(history.results()[0].operator) == "anna"


def test_a_step_that_fails_on_a_server_changes_nothing(server: Server, tmp_path: Path) -> None:
    place = server.database("failing")
    with open_history(tmp_path / "line.db") as source:
        source.add(record(1))
        made(place, "0003", source)
    engine = create_engine(place)
    with engine.begin() as connection:
        connection.exec_driver_sql("CREATE TABLE result_keys (key integer)")
        before = sorted(inspect(connection).get_table_names())
    with pytest.raises(DataError, match='"result_keys" already exists'):
        open_history(place, create=False, upgrade=True)
    with engine.begin() as connection:
        assert sorted(inspect(connection).get_table_names()) == before
    with open_history(place, create=False) as history:
        assert history.count() == 1
    engine.dispose()
