"""The rule by which names of persons are forgotten, and doing so: both stand in the trail."""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from sqlalchemy import Connection, delete, func, select, update

from motorid.errors import DataError
from motorid.quality.history import schema as s
from motorid.quality.history import trail
from motorid.quality.history.names import CITED

RULE = "names_kept_days"  # in meta
FOR_EVER = 0  # days, as the rule says it
MOST_DAYS = 36_500


@dataclass(frozen=True)
class Forgotten:
    """How many names were; for how many ``days`` they are kept (FOR_EVER)."""

    names: int
    days: int


def forget(connection: Connection, by: str, days: int | None, now: datetime | None) -> Forgotten:
    """Forgets the names that are older than the rule says; ``days``, if any, is the rule from now.

    Raises DataError where the rule is damaged.
    """
    now = now or datetime.now(UTC)
    kept = _kept_days(connection)
    if days is not None and days != kept:
        kept = days
        connection.execute(update(s.meta).where(s.meta.c.name == RULE).values(value=str(days)))
        said = f"{days} days" if days else "for ever"
        _note(connection, trail.RULE, by, said, "", now)
    count = 0
    if kept != FOR_EVER:
        before = now - timedelta(days=kept)
        count = connection.execute(delete(s.names).where(s.names.c.at < before)).rowcount
        if count:
            _note(connection, trail.FORGET, by, before.isoformat(), f"{count} names", now)
    return Forgotten(count, kept)


def _note(
    connection: Connection, action: str, by: str, subject: str, reason: str, at: datetime
) -> None:
    key = secrets.token_hex(16)
    trail.add(connection, trail.Entry(action, trail.DONE, by, key, subject, reason, at=at))


def _kept_days(connection: Connection) -> int:
    said = str(connection.scalar(select(s.meta.c.value).where(s.meta.c.name == RULE)))
    if not said.isdecimal() or int(said) > MOST_DAYS:
        raise DataError(f"the history's rule {RULE} = {said[:40]!r} is no number of days")
    return int(said)


def sealed_in(connection: Connection) -> int:
    """How many results hold a name in their seal: from before names were kept beside it."""
    operator = s.results.c.operator
    plain = operator.not_like(f"{CITED}%") & (operator != "")
    return int(connection.scalar(select(func.count()).select_from(s.results).where(plain)) or 0)
