"""Whose turn it is to write what belongs together, where the database does not see to it itself.

SQLite has one writer at a time. On PostgreSQL each part of a history (a station's chain, the checks
of a motor) has a lock of its own until the transaction ends, so that twenty stations wait for one
disk together and not one after the other. Whoever takes several takes them in the order of the
functions here, so that no two wait for each other. Any other database has one lock for all.
"""

from __future__ import annotations

import hashlib

from sqlalchemy import Connection, func, select

from motorid.quality.history import schema as s

COUNTS = "counts"


def of_chain(connection: Connection, kind: str, station: str) -> None:
    """Nobody else adds to this station's chain of one kind meanwhile."""
    _wait(connection, f"{kind} of {station}")


def of_motor(connection: Connection, product: str, serial: str) -> None:
    """Nobody else adds a check of this motor, or counts everything anew, meanwhile."""
    if _has_locks(connection):
        connection.execute(select(func.pg_advisory_xact_lock_shared(_number(COUNTS))))
    _wait(connection, f"checks of {product} {serial}")


def of_counts(connection: Connection) -> None:
    """Nobody adds a check meanwhile."""
    _wait(connection, COUNTS)


def _wait(connection: Connection, name: str) -> None:
    if _has_locks(connection):
        connection.execute(select(func.pg_advisory_xact_lock(_number(name))))
    else:
        connection.execute(select(s.meta.c.value).with_for_update())


def _has_locks(connection: Connection) -> bool:
    return connection.dialect.name == "postgresql"


def _number(name: str) -> int:
    """Of a lock: 64 bits, the same in each process and version."""
    return int.from_bytes(hashlib.sha256(f"motorid {name}".encode()).digest()[:8], signed=True)
