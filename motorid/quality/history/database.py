"""The database: opened by a path (SQLite) or a URL, written whole, read by everybody at once."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from sqlalchemy import Connection, Engine, Row, Select, func, inspect, select
from sqlalchemy.exc import IntegrityError, OperationalError, ProgrammingError

from motorid.errors import DataError
from motorid.limits import HISTORY, refuse_large
from motorid.quality.history import (
    adding,
    chain,
    engine,
    months,
    names,
    seals,
    series,
    steps,
    tallies,
    trail,
)
from motorid.quality.history import schema as s
from motorid.quality.history.chain import Head
from motorid.quality.history.engine import READING
from motorid.quality.history.forgetting import Forgotten, forget, sealed_in
from motorid.quality.history.query import Query, matches
from motorid.quality.history.records import ResultRecord

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from motorid.quality.signed import Trusted

ATTEMPTS = 5
SIGNATURE = "product_signature"  # among a result's versions: who signed its limits
MOST_OF_A_MOTOR = 200  # results shown of one serial number
T = TypeVar("T")


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
    with engine.said(text):
        made = engine.make(text, patience_s)
        history = History(made, text)
        history._prepare(create or upgrade, upgrade)
    return history


class History:
    """Results, captures and the texts they rest on. Threads and processes may share the place."""

    def __init__(self, engine: Engine, where: str) -> None:
        self.engine = engine
        self.where = where
        self._made = False
        self._months: set[int] = set()  # that are there, as PostgreSQL divides results
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
        self._make_month(record.at)
        return self._write(lambda connection: adding.add(connection, record))

    def _make_month(self, at: datetime) -> None:
        if not months.divided(self.engine) or months.month_of(at) in self._months:
            return
        self._write(lambda connection: months.make(connection, at))
        self._months.add(months.month_of(at))

    def _write(self, write: Callable[[Connection], T]) -> T:
        """What ``write`` returns, in one transaction that is on disk when this returns."""
        with engine.said(self.where):
            if not self._made:  # opened to be read: an older one has no seals yet
                self._prepare(True)
            for attempt in range(ATTEMPTS):
                try:
                    with self.engine.begin() as connection:
                        return write(connection)
                except IntegrityError:  # another process added the same text or result meanwhile
                    if attempt == ATTEMPTS - 1:
                        raise
        raise AssertionError("unreachable")

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """A connection that sees one state of the database and holds nobody up."""
        with engine.said(self.where), self.engine.connect() as connection:
            yield connection.execution_options(**READING)

    def results(
        self, query: Query | None = None, *, last: int | None = None, before: int | None = None
    ) -> list[Row[Any]]:
        """Rows of the results table, oldest first; only the ``last`` ones if asked.

        ``before``: of smaller numbers than this one.
        """
        wanted = (query or Query()).apply(select(s.results))
        if before is not None:
            wanted = wanted.where(s.results.c.id < before)
        with self.reading() as connection:
            if last is None:
                return list(connection.execute(wanted))
            newest = wanted.order_by(None).order_by(s.results.c.id.desc()).limit(last)
            return list(connection.execute(newest))[::-1]

    def result(self, number: int) -> Row[Any] | None:
        """One result; None: there is no such."""
        with self.reading() as connection:
            return connection.execute(select(s.results).where(s.results.c.id == number)).first()

    def same_motor(self, row: Row[Any]) -> list[Row[Any]]:
        """Every result of the same serial number, oldest first, to the number of a page."""
        wanted = select(s.results).where(s.results.c.serial == row.serial)
        with self.reading() as connection:
            return list(connection.execute(wanted.order_by(s.results.c.id).limit(MOST_OF_A_MOTOR)))

    def places(self) -> tuple[list[str], list[str]]:
        """The products and the stations of all checks."""
        with self.reading() as connection:
            return tallies.places(connection)

    @property
    def name(self) -> str:
        """The place without a password, to be shown."""
        return engine.shown(self.engine.url)

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
        with self.reading() as connection:
            return list(connection.execute(series.chosen(name, query or Query(), last)))

    def arrays(
        self, name: str, query: Query, last: int | None = None
    ) -> tuple[NDArray[np.datetime64], NDArray[np.float64]]:
        """Times (UTC) and values of the rows of ``series``, in less memory."""
        with self.reading() as connection:
            return series.arrays(connection, name, query, last)

    def readings(self, query: Query, last: int, name: str = "") -> list[Row[Any]]:
        """Rows (result, name, unit, value, low, high), by time: of the ``last`` results.

        ``name``: of those that have measured this quantity, and of it alone.
        """
        m, r = s.measurements.c, s.results.c
        of_these = [*query.conditions(), m.value.is_not(None)]
        if name:
            of_these.append(m.name == name)
        there = select(m.result).where(m.result == r.id, *of_these).correlate(s.results).exists()
        newest = select(r.id).where(*query.conditions(), there).order_by(r.at.desc(), r.id.desc())
        chosen = r.id.in_(select(newest.limit(last).subquery().c.id))
        wanted = select(m.result, m.name, m.unit, m.value, m.low, m.high).join(
            s.results, r.id == m.result
        )
        with self.reading() as connection:
            found: Select[Any] = wanted.where(chosen, *of_these).order_by(r.at, r.id)
            return list(connection.execute(found))

    def head(self, station: str) -> Head:
        """The end of a station's chain of seals."""
        with self.reading() as connection:
            return chain.head(connection, s.seals, station)

    def verify(self, anchors: Sequence[Head] = ()) -> seals.Checked:
        """Whether the results are those that were added; see ``seals``."""
        with self.reading() as connection:
            if not inspect(connection).has_table(s.seals.name):
                count = connection.scalar(select(func.count()).select_from(s.results))
                return seals.Checked(0, int(count or 0), (), ())
            found = seals.verify(connection, anchors)
            if not found.problems and tallies.kept(connection):  # else they follow from those
                found = replace(found, problems=tuple(tallies.problems(connection)))
            if not inspect(connection).has_table(s.trail.name):
                return found
            return replace(found, problems=(*found.problems, *trail.problems(connection)))

    def unsigned(self, trusted: Trusted) -> Iterator[str]:
        """Results whose limits no trusted key has signed, in sentences."""
        r = s.results
        wanted = select(r.c.id, r.c.station, r.c.limits, r.c.versions).where(
            r.c.limits.is_not(None)
        )
        with self.reading() as connection:
            for row in connection.execution_options(yield_per=1000).execute(
                wanted.order_by(r.c.id)
            ):
                cited = str((row.versions or {}).get(SIGNATURE, ""))
                if problem := trusted.problem(cited, row.limits):
                    where = f"station {row.station or 'without a name'}, result {row.id}"
                    yield f"{where}, limits {row.limits[:12]}: {problem}"

    def recount(self) -> None:
        """Makes the day's counts anew from the results; see ``tallies``."""
        self._write(tallies.recount)

    def note(self, entry: trail.Entry) -> bool:
        """Adds an entry to the trail, on disk when this returns; False where it is there already.

        Raises DataError where it cannot be written.
        """
        return bool(self._write(lambda connection: trail.add(connection, entry)))

    def trail(self, *, station: str = "", serial: str = "", last: int = 50) -> list[dict[str, Any]]:
        """The ``last`` entries, oldest first: at, station, action, outcome, who, serial, reason."""
        with self.reading() as connection:
            if not inspect(connection).has_table(s.trail.name):
                return []
            wanted = select(s.trail).order_by(s.trail.c.at.desc(), s.trail.c.position.desc())
            if station:
                wanted = wanted.where(s.trail.c.station == station)
            if serial:
                wanted = wanted.where(matches(s.trail.c.subject, serial))
            rows = connection.execute(wanted.limit(last)).all()
            return trail.shown(connection, rows[::-1])

    def name_of(self, cited: str) -> str:
        """The name of an operator that a result cites, as long as it is kept."""
        with self.reading() as connection:
            return names.names_of(connection, [cited])[cited]

    def forget_names(
        self, by: str = "", days: int | None = None, now: datetime | None = None
    ) -> Forgotten:
        """Forgets the names that are older than the rule says; ``days`` becomes the rule first.

        Both stand in the trail. Names that are part of an older seal stay: see ``sealed_names``.
        """
        done = self._write(lambda connection: forget(connection, by, days, now))
        if done.names and self.engine.dialect.name == "sqlite":
            with engine.said(self.where), self.engine.connect() as connection:
                raw: Any = connection.connection.dbapi_connection
                raw.execute("PRAGMA wal_checkpoint(TRUNCATE)")  # the log holds them as well
        return done

    def sealed_names(self) -> int:
        """How many results hold the name of their operator in their seal, where it stays."""
        with self.reading() as connection:
            return sealed_in(connection)

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
