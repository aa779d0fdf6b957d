"""A record into the tables: whole, once, sealed and counted, in one transaction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sqlalchemy import Connection, insert, select

from motorid.quality.history import months, names, seals, tallies
from motorid.quality.history import schema as s
from motorid.quality.history.records import CaptureRecord, ResultRecord, digest

TEXTS_OF_CAPTURE = ("rig", "program", "calibration")


def add(connection: Connection, record: ResultRecord) -> bool:
    """False where it is there already. Raises IntegrityError where another adds it meanwhile."""
    key = record.key
    if months.known(connection, key):
        return False
    row = {
        name: getattr(record, name)
        for name in ("kind", "serial", "product", "outcome", "marginal", "at", "station")
    }
    row |= {"operator": names.cite(connection, record.operator, record.at)}
    row |= {"note": record.note, "versions": dict(record.versions)}
    row |= {"limits": _keep(connection, record.limits)}
    row |= {"estimate": _keep(connection, record.estimate)}
    result = months.add(connection, {"key": key, **row})
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
    tallies.add(connection, result, record)
    return True


def _add_capture(connection: Connection, capture: CaptureRecord) -> None:
    known = select(s.captures.c.sha256).where(s.captures.c.sha256 == capture.sha256)
    if connection.scalar(known) is not None:
        return
    texts = {name: _keep(connection, getattr(capture, name)) for name in TEXTS_OF_CAPTURE}
    connection.execute(insert(s.captures).values(**{**vars(capture), **texts}))


def _keep(connection: Connection, text: str) -> str | None:
    """The digest under which ``text`` is kept; None for no text."""
    if not text:
        return None
    sha256 = digest(text)
    known = connection.scalar(select(s.documents.c.sha256).where(s.documents.c.sha256 == sha256))
    if known is None:
        connection.execute(insert(s.documents).values(sha256=sha256, text=text))
    return sha256
