"""Who may do what at a station: roles, and the tokens that show them, kept as salted digests.

    digest = SHA-256(salt, token)

A token has 192 random bits, so nobody can try tokens against a digest, and no slow hash is needed.
"""

from __future__ import annotations

import hashlib
import os
import secrets
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from motorid import json_text
from motorid.capture.whole import write_whole
from motorid.errors import DataError, UsageError
from motorid.limits import JSON
from motorid.reading import read_file
from motorid.workflow.check import Who

SCHEMA = "motorid-tokens-1"
INSPECT, WATCH, READ, END = "inspect", "watch", "read", "end"
ROLES: Mapping[str, frozenset[str]] = {
    "operator": frozenset({WATCH, INSPECT}),
    "engineer": frozenset({WATCH, INSPECT, READ, END}),
    "auditor": frozenset({WATCH, READ}),
}
NEEDS = {  # what a role must allow, by order
    "inspect": INSPECT,
    "status": WATCH,
    "last": WATCH,
    "history": READ,
    "end": END,
}
MOST_TOKENS = 1000
PRIVATE = 0o600


@dataclass(frozen=True)
class Caller:
    """Who gives an order: in words, and in which role. Without a role: who is at the station."""

    who: str = ""
    role: str = ""

    def may(self, action: str) -> bool:
        """Whether the role allows it."""
        return not self.role or action in ROLES[self.role]

    def at(self, place: str) -> Caller:
        """The same, with where the order came from."""
        return Caller(f"{self.who} at {place}", self.role)


def refuse_order(caller: Caller, order: str) -> None:
    """Raises DataError for what is no order, UsageError for one that the role does not allow."""
    if order not in NEEDS:
        raise DataError(f"there is no order {order!r}; they are {', '.join(NEEDS)}")
    if not caller.may(NEEDS[order]):
        raise UsageError(f"the role {caller.role} may not give the order {order}")


@dataclass(frozen=True)
class Token:
    """One line of a file of tokens."""

    name: str
    role: str
    salt: str
    digest: str
    added: str

    def is_of(self, token: str) -> bool:
        """In the same time for every token."""
        return secrets.compare_digest(_digest(self.salt, token), self.digest)


class Tokens:
    """A file of tokens. It is read for each question, so that a removed one counts no more."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def caller(self, token: str) -> Caller | None:
        """Whose token that is; None: nobody's. Raises DataError where the file cannot be read."""
        found = [one for one in self.all() if one.is_of(token)]  # all of them, whichever it is
        return Caller(f"{found[0].name} ({found[0].role})", found[0].role) if found else None

    def all(self) -> list[Token]:
        """Every token of the file. Raises DataError where it is none, or others may read it."""
        data = read_file(self.path, DataError, JSON.file, "a file of tokens")
        if os.name == "posix" and self.path.stat().st_mode & 0o077:
            raise DataError(f"{self.path}: others may read it: chmod 600 {self.path}")
        try:
            document = json_text.loads(data)
            if document["schema"] != SCHEMA:
                raise ValueError(document["schema"])
            found = [Token(**{k: str(v) for k, v in one.items()}) for one in document["tokens"]]
        except (json_text.JsonError, KeyError, TypeError, ValueError, AttributeError):
            raise DataError(
                f"{self.path} is no file of tokens: motorid token add makes one"
            ) from None
        if not all(one.role in ROLES for one in found):
            raise DataError(f"{self.path}: a role in it is none of {', '.join(ROLES)}")
        return found

    def add(self, name: str, role: str) -> str:
        """A new token, which is kept nowhere. Raises UsageError, and DataError."""
        Who(operator=name)  # raises for what no record can carry
        known = self.all() if self.path.exists() else []
        if not name or any(one.name == name for one in known):
            raise UsageError(f"{self.path} has a token of {name!r}: remove it first, or add a name")
        if len(known) >= MOST_TOKENS:
            raise UsageError(f"{self.path} holds {MOST_TOKENS} tokens already")
        token, salt = secrets.token_hex(24), secrets.token_hex(16)
        added = datetime.now(UTC).isoformat(timespec="seconds")
        self._write([*known, Token(name, role, salt, _digest(salt, token), added)])
        return token

    def remove(self, name: str) -> None:
        """Raises UsageError where there is no token of that name."""
        known = self.all()
        left = [one for one in known if one.name != name]
        if len(left) == len(known):
            raise UsageError(f"{self.path} has no token of {name!r}")
        self._write(left)

    def _write(self, tokens: list[Token]) -> None:
        said: dict[str, Any] = {"schema": SCHEMA, "tokens": [asdict(one) for one in tokens]}
        write_whole(self.path, json_text.dumps(said, indent=2).encode(), force=True, mode=PRIVATE)


def _digest(salt: str, token: str) -> str:
    return hashlib.sha256((salt + token).encode("utf-8", "surrogatepass")).hexdigest()
