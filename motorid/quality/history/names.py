"""Names of persons: cited by a salted digest, kept beside it, and forgotten after a stated time.

    digest = SHA-256(salt, name)

Results and trail hold the digest, and their seals cover that; the table ``names`` holds name and
salt. Without the salt nobody can try names against a digest, so deleting both forgets who it was,
and every seal still holds. Each citation has a salt of its own: two of one person cannot be joined.
"""

from __future__ import annotations

import secrets
from collections.abc import Collection, Iterator
from datetime import datetime

from sqlalchemy import Connection, insert, select

from motorid.quality.history import schema as s
from motorid.quality.history.records import digest

CITED = "name:"  # begins a digest, in place of a name
FORGOTTEN = "(forgotten)"


def cite(connection: Connection, name: str, at: datetime) -> str:
    """Keeps ``name``, of something that was at ``at``; what to write in its place. "" stays ""."""
    if not name:
        return ""
    salt = secrets.token_hex(32)
    found = digest(salt + name)
    connection.execute(insert(s.names).values(digest=found, name=name, salt=salt, at=at))
    return CITED + found


def names_of(connection: Connection, cited: Collection[str]) -> dict[str, str]:
    """By citation: the name, FORGOTTEN, or the text itself where it is no citation."""
    digests = [one.removeprefix(CITED) for one in cited if one.startswith(CITED)]
    wanted = select(s.names.c.digest, s.names.c.name).where(s.names.c.digest.in_(digests))
    known = {CITED + row.digest: str(row.name) for row in connection.execute(wanted)}
    return {one: known.get(one, FORGOTTEN if one.startswith(CITED) else one) for one in cited}


def problems(connection: Connection, forgotten_before: datetime | None) -> Iterator[str]:
    """Names that are not the ones that were cited, and citations that lost theirs too early."""
    known = {row.digest: row for row in connection.execute(select(s.names))}
    for row in known.values():
        if digest(row.salt + row.name) != row.digest:
            yield f"name {row.digest[:12]}: it was edited"
    for table, column, what in (
        (s.results, s.results.c.operator, "result"),
        (s.trail, s.trail.c.who, "entry of the trail"),
    ):
        for cited, at in connection.execute(select(column, table.c.at)):
            digested = cited.removeprefix(CITED)
            early = forgotten_before is None or at >= forgotten_before
            if digested != cited and digested not in known and early:
                yield f"name {digested[:12]}, cited by a {what} of {at:%Y-%m-%d}: it was deleted"
