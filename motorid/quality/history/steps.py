"""From one version of the tables to the next, by Alembic's steps: at once, or not at all.

A file is brought up to date by itself when it is opened to be written; a copy of it stays beside
it. A server that many use is brought up to date by ``motorid history upgrade`` alone.
"""

from __future__ import annotations

import os
import sqlite3
import threading
from contextlib import closing
from pathlib import Path
from urllib.parse import quote

from sqlalchemy import Connection, Engine, column, func, inspect, select, table, text

from motorid.errors import DataError
from motorid.quality.history import schema as s

MARK = table("alembic_version", column("version_num"))
FOLDER = Path(__file__).with_name("migrations")
ONE_AT_A_TIME = threading.Lock()  # of this process: Alembic's context is one for all its threads
LOCK = 0x6D6F746F  # of PostgreSQL: one client at a time changes the tables
NONE = ""  # the step of a history that has no tables yet
FIRST = "0000"  # and of one from before there were steps


def step(connection: Connection) -> str:
    """The last step that was carried out here."""
    tables = inspect(connection)
    if tables.has_table(MARK.name):
        found = connection.scalar(select(MARK.c.version_num))
        if found is not None:
            return str(found)
    return FIRST if tables.has_table(s.meta.name) else NONE


def advance(engine: Engine, where: str, *, asked: bool) -> tuple[str, str]:
    """Carries out the steps that are missing; from which step, to which.

    Raises DataError where tables are newer than this motorid, or a server's are older and nobody
    ``asked`` for the change.
    """
    with engine.connect() as connection:
        before = step(connection.execution_options(motorid_reading=True))
    if before == s.STEP:
        return before, before
    with engine.begin() as connection:
        if engine.dialect.name == "postgresql":
            connection.execute(select(func.pg_advisory_xact_lock(LOCK)))
            connection.execute(text("SET LOCAL statement_timeout = 0"))
        before = step(connection)  # another client may have been faster
        refuse_newer(before, where)
        if before not in (NONE, s.STEP):
            if url := engine.url.database if engine.dialect.name == "sqlite" else None:
                keep_copy(Path(url))
            elif not asked:
                raise DataError(
                    f"the history {where} has tables of step {before}, this motorid writes step "
                    f"{s.STEP}: back it up, then `motorid history upgrade` once, for all stations"
                )
        if before != s.STEP:
            _run(connection)
    return before, s.STEP


def refuse_newer(found: str, where: str) -> None:
    """Raises DataError for tables that a newer motorid has made."""
    if found > s.STEP:
        raise DataError(
            f"the history {where} has tables of step {found[:40]}, this motorid knows steps up to "
            f"{s.STEP}: use the newer motorid that changed it, or the copy from before"
        )


def keep_copy(path: Path) -> Path:
    """A whole copy of a file as it stands committed, synced. Raises DataError."""
    kept = path.with_name(f"{path.name}.before-{s.STEP}")
    partial = kept.with_name(f"{kept.name}.part")
    try:
        source = f"file:{quote(str(path.resolve()))}?mode=ro"
        with (
            closing(sqlite3.connect(source, uri=True)) as old,
            closing(sqlite3.connect(partial)) as new,
        ):
            old.backup(new)
        with partial.open("rb+") as file:
            os.fsync(file.fileno())
        partial.replace(kept)
    except (OSError, sqlite3.Error) as error:
        partial.unlink(missing_ok=True)
        raise DataError(
            f"{path} needs newer tables, and no copy of it could be kept first ({error}): make "
            "room beside it"
        ) from None
    return kept


def _run(connection: Connection) -> None:
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(FOLDER).replace("%", "%%"))
    config.attributes["connection"] = connection
    with ONE_AT_A_TIME:
        command.upgrade(config, "head")
