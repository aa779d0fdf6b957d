"""The same history on a real PostgreSQL, where the machine has one: not a line of code changes."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.exc import ProgrammingError

from motorid.errors import DataError
from motorid.quality.history import Entry, Query, adding, open_history
from motorid.quality.history.export import rows
from motorid.quality.history.names import FORGOTTEN
from tests.history.records import BEGAN, record
from tests.history.servers import Server, running
from tests.history.test_history import run_stations

pytestmark = [pytest.mark.slow, pytest.mark.long]


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with running() as found:
        yield found


@pytest.fixture
def postgresql(server: Server) -> str:
    return server.url


def test_stations_share_a_server(postgresql: str) -> None:
    """Four processes make the tables at once and write overlapping ranges: none lost or doubled."""
    run_stations(postgresql, [(0, 40), (30, 70), (60, 100), (0, 40)])
    with open_history(postgresql) as history:
        assert history.count() == 100
        assert {row.serial for row in history.results()} == {f"SN-{n:05d}" for n in range(100)}
        assert not history.add(record(7))


def test_both_databases_answer_alike(postgresql: str, tmp_path: Path) -> None:
    with open_history(postgresql) as server, open_history(tmp_path / "line.db") as file:
        for number in range(100):
            file.add(record(number))
            server.add(record(number))

        def table(history: Any) -> list[tuple[Any, ...]]:
            found = [row[1:] for piece in rows(history, Query()) for row in piece]
            return sorted(found, key=lambda row: (row[2], row[6:8], str(row)))

        assert table(server) == table(file)
        assert [tuple(r) for r in server.series("R")] == [tuple(r) for r in file.series("R")]
        query = Query(serial="SN-0001?")
        assert server.count(query) == file.count(query) == 10


def test_names_are_forgotten_on_a_server_too(postgresql: str) -> None:
    with open_history(postgresql) as history:
        history.add(record(500, operator="anna"))
        history.note(Entry("order", "refused", "Zoë", "1", "SN-00501", "no\tpart", at=BEGAN))
        assert history.trail()[0]["who"] == "Zoë"
        assert not history.note(Entry("order", "refused", "Zoë", "1", "SN-00501", at=BEGAN))
        assert history.verify().problems == ()
        assert history.forget_names("quality", now=BEGAN + timedelta(days=400)).names == 2
        assert history.verify().problems == ()
        (row,) = history.results(Query(serial="SN-00500"))
        assert history.name_of(row.operator) == FORGOTTEN


def test_newer_tables_of_a_server_are_refused(server: Server) -> None:
    newer = server.database("newer")
    with open_history(newer) as history, history.engine.begin() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '0099'")
    with pytest.raises(DataError, match="tables of step 0099"):
        open_history(newer)


def test_a_station_needs_no_more_than_the_page_grants(server: Server) -> None:
    """And can neither change nor delete a result with it; a reader adds none."""
    place = server.database("granted")
    page = (Path(__file__).parents[2] / "docs" / "plant-operation.md").read_text(encoding="utf-8")
    grants = page.partition("```sql\n")[2].partition("```")[0]
    reading = "CREATE ROLE reader LOGIN; GRANT SELECT ON ALL TABLES IN SCHEMA public TO reader"
    with open_history(place) as history, history.engine.begin() as connection:
        for one in f"CREATE ROLE line LOGIN; {grants}; {reading}".split(";"):
            if words := one.partition("--")[0].strip() or one.partition("\n")[2].strip():
                connection.exec_driver_sql(words)
    with open_history(place.replace("motorid@", "line@")) as history:
        assert history.add(record(1, operator="anna"))
        assert history.note(Entry("order", "accepted", "anna", "1", "SN-00001", at=BEGAN))
        assert history.forget_names("quality", now=BEGAN + timedelta(days=400)).names == 2
        for forbidden in (
            "UPDATE results SET outcome = 'PASS'",
            "DELETE FROM results",
            "DROP TABLE results_202601",
            "DELETE FROM results_202601",
            "CREATE TABLE results_202701 PARTITION OF results DEFAULT",
        ):
            with (
                pytest.raises(ProgrammingError, match=r"permission denied|must be owner"),
                history.engine.begin() as c,
            ):
                c.exec_driver_sql(forbidden)
    with open_history(place.replace("motorid@", "reader@"), create=False) as history:
        assert history.verify().problems == ()
        with pytest.raises(DataError, match="permission denied"):
            history.add(record(2))


def test_a_backup_is_restored_with_every_seal(server: Server) -> None:
    """What came after it is missed by the head that was kept elsewhere, and can be added again."""
    place = server.database("kept")
    with open_history(place) as history:
        for number in range(20):
            history.add(record(number, operator="anna"))
        head = history.head("line-1")
        server.copy("kept", "restored")
        history.add(record(20))
        later = history.head("line-1")
    with open_history(place.replace("/kept?", "/restored?")) as history:
        assert history.count() == 20
        assert history.verify([head]).problems == ()
        assert "the end was cut off" in history.verify([later]).problems[0]
        assert not history.add(record(19))
        assert history.add(record(20))
        assert history.verify([head]).problems == ()


def test_twenty_writers_lose_and_double_nothing(server: Server) -> None:
    """Each adds its motors and, as after a retry, those of its neighbour."""
    place = server.database("twenty")

    def write(writer: int) -> int:
        numbers = [*range(5 * writer, 5 * writer + 10)]
        with open_history(place) as history:
            return sum(history.add(record(n, station=f"line-{n % 5}")) for n in numbers)

    with ThreadPoolExecutor(20) as writers:
        added = sum(writers.map(write, range(20)))
    with open_history(place) as history:
        assert added == history.count() == 105
        assert {row.serial for row in history.results()} == {f"SN-{n:05d}" for n in range(105)}
        checked = history.verify()
        assert (checked.sealed, checked.problems, len(checked.heads)) == (105, (), 5)


def test_a_station_waits_for_its_own_chain_and_motor_alone(server: Server) -> None:
    """While a transaction is open that has sealed a result of line-1, of one motor."""
    place = server.database("turns")
    with open_history(place) as first, open_history(place, patience_s=2.0) as other:
        first.add(record(1, station="line-1"))
        with first.engine.begin() as connection:
            assert adding.add(connection, record(2, station="line-1"))
            assert other.add(record(3, station="line-2"))
            assert other.note(Entry("order", "accepted", "anna", "1", station="line-1", at=BEGAN))
            with pytest.raises(DataError, match="timeout"):
                other.add(record(4, station="line-1"))
            with pytest.raises(DataError, match="timeout"):
                other.add(replace(record(5, station="line-2"), serial="SN-00002"))
        assert other.add(record(4, station="line-1"))
        assert first.verify().problems == ()


def test_stations_that_check_the_same_motors_at_once_count_each_once(server: Server) -> None:
    """A result changes which check of its motor was the first or the last, at another station."""
    place = server.database("same")

    def write(writer: int) -> None:
        with open_history(place) as history:
            for n in range(24):
                later = BEGAN + timedelta(hours=(7 * n + 5 * writer) % 24, seconds=writer)
                serial, outcome = f"SN-{(n + 3 * writer) % 12}", ("PASS", "FAIL")[(n + writer) % 2]
                one = record(24 * writer + n, station=f"line-{writer}", outcome=outcome)
                assert history.add(replace(one, serial=serial, at=later))

    with ThreadPoolExecutor(8) as writers:
        list(writers.map(write, range(8)))
    with open_history(place) as history:
        assert history.count() == 8 * 24
        assert history.verify().problems == ()
