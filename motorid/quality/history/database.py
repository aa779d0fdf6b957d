"""The database: opened by a path (SQLite) or a URL, written whole, read by everybody at once."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import (
    URL,
    Connection,
    Engine,
    Row,
    create_engine,
    event,
    func,
    insert,
    inspect,
    select,
)
from sqlalchemy.engine import make_url
from sqlalchemy.exc import (
    ArgumentError,
    IntegrityError,
    NoSuchModuleError,
    OperationalError,
    ProgrammingError,
    SQLAlchemyError,
)

from motorid import json_text
from motorid.errors import DataError, UsageError
from motorid.limits import HISTORY, refuse_large
from motorid.quality.history import schema as s
from motorid.quality.history import seals, steps
from motorid.quality.history.query import Query, matches
from motorid.quality.history.records import CaptureRecord, ResultRecord, digest

PATIENCE_S = 60.0  # how long a writer waits for the others
ATTEMPTS = 5
UNREADABLE = (ValueError, TypeError, OverflowError, LookupError, AttributeError, ArithmeticError)
READING = {"motorid_reading": True}


def open_history(
    where: str | Path,
    *,
    create: bool = True,
    patience_s: float | None = None,
    upgrade: bool = False,
) -> History:
    """The history in a file (SQLite) or at an SQLAlchemy URL; its tables are made if need be.

    A file with older tables is brought up to date if ``create``, a server only if ``upgrade``.
    ``patience_s`` bounds what each statement may take; None leaves it to the database, and a
    writer waits a minute for others in a file. Raises DataError where it cannot be opened, is no
    history, or is of another major version.
    """
    text = str(where)
    if "://" not in text and not create and not Path(text).exists():
        raise DataError(f"there is no history {text}: check the path")
    if "://" not in text and Path(text).exists():
        refuse_large(Path(text), HISTORY)
    with _said(text):
        engine = _engine(text, patience_s)
        history = History(engine, text)
        history._prepare(create or upgrade, upgrade)
    return history


def _engine(text: str, patience_s: float | None) -> Engine:
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

    @event.listens_for(engine, "begin")
    def begun(connection: Connection) -> None:
        reading = connection.get_execution_options().get("motorid_reading")
        # a transaction that turns from reader to writer could not wait for its turn
        connection.exec_driver_sql("BEGIN" if reading else "BEGIN IMMEDIATE")


@contextmanager
def _said(where: str) -> Iterator[None]:
    """A database's complaint as one sentence of ours.

    A damaged one gives texts where numbers or dates were, and what reads them raises its own.
    """
    try:
        yield
    except (SQLAlchemyError, *UNREADABLE) as error:
        cause = getattr(error, "orig", None) or error
        raise DataError(f"the history {where} cannot be used: {cause}") from None


class History:
    """Results, captures and the texts they rest on. Threads and processes may share the place."""

    def __init__(self, engine: Engine, where: str) -> None:
        self.engine = engine
        self.where = where
        self._made = False
        self.stepped = ("", "")  # from which step of the tables to which, when it was opened

    def close(self) -> None:
        """Gives back the connections."""
        self.engine.dispose()

    def __enter__(self) -> History:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def add(self, record: ResultRecord) -> bool:
        """Adds ``record``, whole or not at all, on disk when this returns.

        False where the history has it already. Raises DataError where it cannot be written.
        """
        with _said(self.where):
            if not self._made:  # opened to be read: an older one has no seals yet
                self._prepare(True)
            for attempt in range(ATTEMPTS):
                try:
                    with self.engine.begin() as connection:
                        return _add(connection, record)
                except IntegrityError:  # another process added the same text or result meanwhile
                    if attempt == ATTEMPTS - 1:
                        raise
        raise AssertionError("unreachable")

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """A connection that sees one state of the database and holds nobody up."""
        with _said(self.where), self.engine.connect() as connection:
            yield connection.execution_options(**READING)

    def results(self, query: Query | None = None, *, last: int | None = None) -> list[Row[Any]]:
        """Rows of the results table, oldest first; only the ``last`` ones if asked."""
        wanted = (query or Query()).apply(select(s.results))
        with self.reading() as connection:
            if last is None:
                return list(connection.execute(wanted))
            newest = wanted.order_by(None).order_by(s.results.c.id.desc()).limit(last)
            return list(connection.execute(newest))[::-1]

    def count(self, query: Query | None = None) -> int:
        """How many results."""
        wanted = select(func.count()).select_from(s.results)
        with self.reading() as connection:
            return int(connection.scalar(wanted.where(*(query or Query()).conditions())) or 0)

    def measurements(self, result: int) -> list[Row[Any]]:
        """The measurements of one result."""
        wanted = select(s.measurements).where(s.measurements.c.result == result)
        with self.reading() as connection:
            return list(connection.execute(wanted))

    def captures_of(self, result: int) -> list[Row[Any]]:
        """The captures that one result rests on, in their order."""
        link = s.result_captures
        wanted = (
            select(s.captures)
            .join(link, link.c.capture == s.captures.c.sha256)
            .where(link.c.result == result)
            .order_by(link.c.position)
        )
        with self.reading() as connection:
            return list(connection.execute(wanted))

    def captures(self, serial: str = "", sha256: str = "") -> list[Row[Any]]:
        """Captures by serial number (wildcards allowed) and by the beginning of their SHA-256."""
        wanted = select(s.captures).order_by(s.captures.c.created, s.captures.c.sha256)
        if serial:
            wanted = wanted.where(matches(s.captures.c.serial, serial))
        if sha256:
            wanted = wanted.where(s.captures.c.sha256.startswith(sha256, autoescape=True))
        with self.reading() as connection:
            return list(connection.execute(wanted))

    def results_of(self, sha256: str) -> list[Row[Any]]:
        """Every result that rests on the capture of that SHA-256."""
        link = s.result_captures
        wanted = select(s.results).join(link, link.c.result == s.results.c.id)
        wanted = wanted.where(link.c.capture == sha256).order_by(s.results.c.id)
        with self.reading() as connection:
            return list(connection.execute(wanted))

    def document(self, sha256: str | None) -> str:
        """The text that a result or a capture cites; "" for none."""
        if sha256 is None:
            return ""
        wanted = select(s.documents.c.text).where(s.documents.c.sha256 == sha256)
        with self.reading() as connection:
            return str(connection.scalar(wanted) or "")

    def series(
        self, name: str, query: Query | None = None, *, last: int | None = None
    ) -> list[Row[Any]]:
        """Rows (at, serial, value, uncertainty, low, high, unit) of one quantity, by time.

        Only the ``last`` ones if asked, without reading the others.
        """
        m, r = s.measurements, s.results
        of_these = (*(query or Query()).conditions(), m.c.name == name, m.c.value.is_not(None))
        wanted = (
            select(r.c.at, r.c.serial, m.c.value, m.c.uncertainty, m.c.low, m.c.high, m.c.unit)
            .join(r, r.c.id == m.c.result)
            .where(*of_these)
            .order_by(r.c.at, r.c.id)
        )
        if last is not None:  # walks back in time, instead of sorting every result
            there = select(m.c.result).where(m.c.result == r.c.id, *of_these).correlate(r).exists()
            newest = select(r.c.id).where(there).order_by(r.c.at.desc(), r.c.id.desc()).limit(last)
            wanted = wanted.where(r.c.id.in_(select(newest.subquery().c.id)))
        with self.reading() as connection:
            return list(connection.execute(wanted))

    def head(self, station: str) -> seals.Head:
        """The end of a station's chain of seals."""
        with self.reading() as connection:
            return seals.head(connection, station)

    def verify(self, anchors: Sequence[seals.Head] = ()) -> seals.Checked:
        """Whether the results are those that were added; see ``seals``."""
        with self.reading() as connection:
            if not inspect(connection).has_table(s.seals.name):
                count = connection.scalar(select(func.count()).select_from(s.results))
                return seals.Checked(0, int(count or 0), (), ())
            return seals.verify(connection, anchors)

    def names(self) -> list[str]:
        """The quantities that any result has measured."""
        wanted = select(s.measurements.c.name).distinct().order_by(s.measurements.c.name)
        with self.reading() as connection:
            return list(connection.scalars(wanted))

    def _prepare(self, create: bool, upgrade: bool = False) -> None:
        """Tables and journal; several processes may do this at the same moment."""
        for attempt in range(ATTEMPTS):
            try:
                if create:
                    self._make(upgrade)
                break
            except (IntegrityError, OperationalError, ProgrammingError):
                if attempt == ATTEMPTS - 1:
                    raise
                time.sleep(0.2 * (attempt + 1))
        with self.reading() as connection:
            steps.refuse_newer(steps.step(connection), self.where)
            found = connection.scalar(select(s.meta.c.value).where(s.meta.c.name == "schema"))
        if str(found).partition(".")[0] != s.VERSION:
            raise DataError(
                f"the history {self.where} has tables of version {found}, this motorid knows "
                f"{s.VERSION}: use the motorid that wrote it"
            )

    def _make(self, upgrade: bool) -> None:
        if self.engine.dialect.name == "sqlite":
            with self.engine.connect() as connection:
                raw: Any = connection.connection.dbapi_connection
                if raw.execute("PRAGMA journal_mode").fetchone()[0] != "wal":
                    raw.execute("PRAGMA journal_mode = WAL")
        self.stepped = steps.advance(self.engine, self.where, asked=upgrade)
        self._made = True


def _add(connection: Connection, record: ResultRecord) -> bool:
    key = record.key
    if connection.scalar(select(s.results.c.id).where(s.results.c.key == key)) is not None:
        return False
    row = {
        name: getattr(record, name)
        for name in ("kind", "serial", "product", "outcome", "marginal", "at", "station")
    }
    row |= {"operator": record.operator, "note": record.note, "versions": dict(record.versions)}
    row |= {"limits": _keep(connection, record.limits)}
    row |= {"estimate": _keep(connection, record.estimate)}
    done = connection.execute(insert(s.results).values(key=key, **row))
    assert done.inserted_primary_key is not None
    result = done.inserted_primary_key[0]
    for position, capture in enumerate(record.captures):
        _add_capture(connection, capture)
        link = {"result": result, "position": position, "capture": capture.sha256}
        connection.execute(insert(s.result_captures).values(**link))
    if record.measurements:
        rows: Sequence[dict[str, Any]] = [
            {"result": result, **vars(m)} for m in record.measurements
        ]
        connection.execute(insert(s.measurements), rows)
    seals.seal(connection, result, record.station)
    return True


def _add_capture(connection: Connection, capture: CaptureRecord) -> None:
    known = select(s.captures.c.sha256).where(s.captures.c.sha256 == capture.sha256)
    if connection.scalar(known) is not None:
        return
    texts = {name: _keep(connection, getattr(capture, name)) for name in TEXTS_OF_CAPTURE}
    connection.execute(insert(s.captures).values(**{**vars(capture), **texts}))


TEXTS_OF_CAPTURE = ("rig", "program", "calibration")


def _keep(connection: Connection, text: str) -> str | None:
    """The digest under which ``text`` is kept; None for no text."""
    if not text:
        return None
    sha256 = digest(text)
    known = connection.scalar(select(s.documents.c.sha256).where(s.documents.c.sha256 == sha256))
    if known is None:
        connection.execute(insert(s.documents).values(sha256=sha256, text=text))
    return sha256
