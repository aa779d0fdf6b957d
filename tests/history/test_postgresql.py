"""The same history on a real PostgreSQL, where the machine has one: not a line of code changes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import create_engine
from sqlalchemy.engine import make_url

from motorid.errors import DataError
from motorid.quality.history import Entry, Query, open_history, steps
from motorid.quality.history import schema as s
from motorid.quality.history.export import rows
from motorid.quality.history.names import FORGOTTEN
from tests.history.records import BEGAN, UNSTEPPED, record
from tests.history.test_history import run_stations
from tests.history.test_steps import differences

pytestmark = [pytest.mark.slow, pytest.mark.long]


def programs() -> Path:
    """The folder of initdb and pg_ctl; skips where there is none."""
    if sys.platform == "win32":
        pytest.skip("no PostgreSQL server on this machine that the test can start")
    pytest.importorskip("psycopg", reason="no psycopg: pip install 'motorid[postgresql]'")
    found = shutil.which("initdb")
    folders = [Path(found).parent] if found else sorted(Path("/usr/lib/postgresql").glob("*/bin"))
    if not folders:
        pytest.skip("no PostgreSQL server on this machine")
    return folders[-1]


def run(words: list[str], as_user: dict[str, Any]) -> None:
    subprocess.run(words, check=True, capture_output=True, cwd="/", **as_user)


@pytest.fixture(scope="module")
def postgresql() -> Iterator[str]:
    """The URL of a server of our own, on a socket in a temporary folder."""
    where = programs()
    as_user: dict[str, Any] = {}
    with tempfile.TemporaryDirectory(prefix="motorid-pg-") as folder:
        if os.getuid() == 0:  # the server refuses to run as root
            import pwd

            try:
                owner = pwd.getpwnam("postgres")
            except KeyError:
                pytest.skip("no PostgreSQL server on this machine that root may start")
            os.chown(folder, owner.pw_uid, owner.pw_gid)
            as_user = {"user": owner.pw_uid, "group": owner.pw_gid}
        data = f"{folder}/data"
        run([str(where / "initdb"), "-D", data, "-U", "motorid", "-A", "trust", "-N"], as_user)
        settings = f"-k {folder} -c listen_addresses='' -c fsync=off"
        control = [str(where / "pg_ctl"), "-D", data, "-w"]
        run([*control, "-l", f"{folder}/log", "-o", settings, "start"], as_user)
        try:
            yield f"postgresql+psycopg://motorid@/postgres?host={folder}"
        finally:
            run([*control, "-m", "immediate", "stop"], as_user)


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


def test_a_server_is_brought_up_to_date_only_when_asked(postgresql: str) -> None:
    """From before there were steps, and without seals; with its results, and once for all."""
    address = make_url(postgresql).set(database="older")
    engine = create_engine(postgresql, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql("CREATE DATABASE older")
    engine.dispose()
    older = address.render_as_string(hide_password=False)
    with open_history(older) as history:
        assert differences(history) == []
        history.add(record(1))
        with history.engine.begin() as connection:
            for one in ("DROP TABLE seals", "DELETE FROM meta WHERE name = 'unsealed'", *UNSTEPPED):
                connection.exec_driver_sql(one)
    with pytest.raises(DataError, match="motorid history upgrade"):
        open_history(older)
    with open_history(older, create=False) as history:
        assert history.count() == 1
    with open_history(older, create=False, upgrade=True, patience_s=20.0) as history:
        assert history.stepped == (steps.FIRST, s.STEP)
        assert differences(history) == []
        assert history.add(record(2))
        checked = history.verify()
        assert (checked.sealed, checked.unsealed, checked.problems) == (1, 1, ())
        with history.engine.begin() as connection:
            connection.exec_driver_sql("UPDATE alembic_version SET version_num = '0099'")
    with pytest.raises(DataError, match="tables of step 0099"):
        open_history(older)


def test_twenty_writers_lose_and_double_nothing(postgresql: str) -> None:
    """Each adds its motors and, as after a retry, those of its neighbour."""
    address = make_url(postgresql).set(database="twenty")
    engine = create_engine(postgresql, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql("CREATE DATABASE twenty")
    engine.dispose()
    place = address.render_as_string(hide_password=False)

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
