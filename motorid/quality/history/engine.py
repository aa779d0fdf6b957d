"""SQLAlchemy's engine for a history: what a path or a URL means, and how it is spoken to."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import URL, Connection, Engine, create_engine, event
from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError, NoSuchModuleError, SQLAlchemyError

from motorid import json_text
from motorid.errors import DataError, UsageError

PATIENCE_S = 60.0  # how long a writer waits for the others
UNREADABLE = (ValueError, TypeError, OverflowError, LookupError, AttributeError, ArithmeticError)
READING = {"motorid_reading": True}


def make(text: str, patience_s: float | None) -> Engine:
    """Raises UsageError for what is no database that SQLAlchemy knows, or lacks its package."""
    try:
        url = make_url(text if "://" in text else f"sqlite:///{Path(text)}")
        engine = create_engine(
            url,
            json_serializer=json_text.dumps,
            json_deserializer=json_text.loads,
            connect_args=_bounds(url, patience_s) if patience_s else {},
        )
    except (ArgumentError, NoSuchModuleError, *UNREADABLE) as error:
        raise UsageError(f"{text} is no database that SQLAlchemy knows: {error}") from None
    except ModuleNotFoundError as error:
        raise UsageError(
            f"{url.drivername} needs the package {error.name}: pip install it"
        ) from None
    if engine.dialect.name == "sqlite":
        _tune_sqlite(engine, patience_s or PATIENCE_S)
    return engine


def shown(url: URL) -> str:
    """A database's name for a page: no host, no user, no password."""
    return url.database or url.drivername


def _bounds(url: URL, patience_s: float) -> dict[str, Any]:
    """What makes PostgreSQL's client give up: no connection, no answer, a host that is gone."""
    if url.get_backend_name() != "postgresql" or "options" in url.query:
        return {}
    most_ms = int(1e3 * patience_s)
    return {
        "connect_timeout": max(2, round(patience_s)),
        "tcp_user_timeout": most_ms,
        "options": f"-c statement_timeout={most_ms} -c lock_timeout={most_ms}",
    }


def _tune_sqlite(engine: Engine, patience_s: float) -> None:
    """WAL, synced at every commit, and writers that queue instead of failing."""

    @event.listens_for(engine, "connect")
    def connected(connection: Any, _: Any) -> None:
        connection.isolation_level = None  # the driver must not begin transactions of its own
        connection.execute(f"PRAGMA busy_timeout = {int(patience_s * 1000)}")
        connection.execute("PRAGMA foreign_keys = ON")
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA secure_delete = ON")  # a name that is forgotten leaves no bytes

    @event.listens_for(engine, "begin")
    def begun(connection: Connection) -> None:
        reading = connection.get_execution_options().get("motorid_reading")
        # a transaction that turns from reader to writer could not wait for its turn
        connection.exec_driver_sql("BEGIN" if reading else "BEGIN IMMEDIATE")


@contextmanager
def said(where: str) -> Iterator[None]:
    """A database's complaint as one sentence of ours.

    A damaged one gives texts where numbers or dates were, and what reads them raises its own.
    """
    try:
        yield
    except (SQLAlchemyError, *UNREADABLE) as error:
        cause = getattr(error, "orig", None) or error
        raise DataError(f"the history {where} cannot be used: {cause}") from None
