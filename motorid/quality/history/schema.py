"""The tables, in SQLAlchemy's own words: nothing here knows which database will hold them."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Column,
    DateTime,
    Double,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
)
from sqlalchemy.types import TypeDecorator

VERSION = "1"  # of the tables; another first number is refused
STEP = "0006"  # the last of the steps in migrations/; see steps.py


class UtcDateTime(TypeDecorator[datetime]):
    """Instants kept as UTC without a zone, which every database orders alike; aware outside."""

    impl = DateTime
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Any) -> datetime | None:
        """Any zone in, UTC down; an instant without a zone is a mistake of the caller."""
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError("an instant for the history needs its time zone")
        return value.astimezone(UTC).replace(tzinfo=None)

    def process_result_value(self, value: datetime | None, dialect: Any) -> datetime | None:
        """UTC up."""
        return None if value is None else value.replace(tzinfo=UTC)


def _refused(value: Any, kind: str) -> ValueError:
    return ValueError(f"it holds {str(value)[:40]!r} where a {kind} belongs: it is damaged")


class _Words:
    """What comes up is text: some databases give whatever somebody put in."""

    def process_result_value(self, value: Any, dialect: Any) -> str | None:
        """Raises ValueError for what is none."""
        if value is None or isinstance(value, str):
            return value
        raise _refused(value, "text")


class Words(_Words, TypeDecorator[str]):
    """A text of so many characters."""

    impl = String
    cache_ok = True


class LongWords(_Words, TypeDecorator[str]):
    """A text of any length."""

    impl = Text
    cache_ok = True


class Number(TypeDecorator[float]):
    """A finite number."""

    impl = Double
    cache_ok = True

    def process_result_value(self, value: Any, dialect: Any) -> float | None:
        """Raises ValueError for what is none."""
        if value is None or (isinstance(value, int | float) and math.isfinite(value)):
            return value
        raise _refused(value, "number")


class Count(TypeDecorator[int]):
    """A whole number."""

    impl: Any = Integer
    cache_ok = True

    def process_result_value(self, value: Any, dialect: Any) -> int | None:
        """Raises ValueError for what is none."""
        if value is None or isinstance(value, int):
            return value
        raise _refused(value, "whole number")


LONG = BigInteger().with_variant(Integer(), "sqlite")  # there any whole number is as long


class LongCount(Count):
    """A whole number as long as the id of a result."""

    impl = LONG
    cache_ok = True


DIGEST = Words(64)  # a SHA-256 in hexadecimal
NAME = Words(200)

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "fk": "fk_%(table_name)s_%(column_0_name)s",
        "pk": "pk_%(table_name)s",
    }
)

meta = Table(
    "meta",
    metadata,
    Column("name", NAME, primary_key=True),
    Column("value", LongWords, nullable=False),
)

# Texts that many results share: a rig file, a product's limits, a program. Kept once each.
documents = Table(
    "documents",
    metadata,
    Column("sha256", DIGEST, primary_key=True),
    Column("text", LongWords, nullable=False),
)

captures = Table(
    "captures",
    metadata,
    Column("sha256", DIGEST, primary_key=True),
    Column("path", LongWords, nullable=False),  # where it was when it was recorded
    Column("serial", NAME, nullable=False, index=True),
    Column("created", UtcDateTime),
    Column("samples", Count, nullable=False),
    Column("end_reason", NAME, nullable=False),
    Column("rig", DIGEST, ForeignKey("documents.sha256")),
    Column("program", DIGEST, ForeignKey("documents.sha256")),
    Column("calibration", DIGEST, ForeignKey("documents.sha256")),
)

results = Table(
    "results",
    metadata,
    Column("id", LONG, primary_key=True),  # see months.py
    Column("key", DIGEST, nullable=False, unique=True),  # digest of all: added once
    Column("kind", NAME, nullable=False),  # check, rejudged, fit, golden
    Column("serial", NAME, nullable=False, index=True),
    Column("product", NAME, nullable=False),
    Column("outcome", Words(16), nullable=False),  # PASS, FAIL, INVALID; "" where none was asked
    Column("marginal", Boolean, nullable=False),
    Column("at", UtcDateTime, nullable=False, index=True),
    Column("station", NAME, nullable=False),
    Column("operator", NAME, nullable=False),
    Column("note", LongWords, nullable=False),
    Column("versions", JSON, nullable=False),
    Column("limits", DIGEST, ForeignKey("documents.sha256")),
    Column("estimate", DIGEST, ForeignKey("documents.sha256")),
    *(Index(f"ix_results_{name}_id", name, "id") for name in ("outcome", "station", "product")),
    Index("ix_results_station_at", "station", "at"),
)

result_captures = Table(
    "result_captures",
    metadata,
    Column("result", LONG, ForeignKey("results.id"), primary_key=True),
    Column("position", Integer, primary_key=True),
    Column("capture", DIGEST, ForeignKey("captures.sha256"), nullable=False, index=True),
)

measurements = Table(
    "measurements",
    metadata,
    Column("result", LONG, ForeignKey("results.id"), primary_key=True),
    Column("name", NAME, primary_key=True),
    Column("unit", Words(40), nullable=False),
    Column("value", Number),
    Column("uncertainty", Number),  # standard, in unit
    Column("low", Number),  # limits; NULL where there is none
    Column("high", Number),
    Column("guard_band", Number),
    Column("outcome", Words(16), nullable=False),
    Column("marginal", Boolean, nullable=False),
    Column("reason", LongWords, nullable=False),
    Index("ix_measurements_name_result", "name", "result"),
)

# The chain of digests over each station's results; see seals.py.
seals = Table(
    "seals",
    metadata,
    Column("station", NAME, primary_key=True),
    Column("position", Count, primary_key=True, autoincrement=False),
    Column(
        "result", LongCount, nullable=False, unique=True
    ),  # no foreign key: it outlives its result
    Column("content", DIGEST, nullable=False),
    Column("chain", DIGEST, nullable=False),
)

# Names of persons, beside the digests under which results and trail cite them; see names.py.
names = Table(
    "names",
    metadata,
    Column("digest", DIGEST, primary_key=True),
    Column("name", LongWords, nullable=False),
    Column("salt", DIGEST, nullable=False),
    Column("at", UtcDateTime, nullable=False, index=True),  # of what cites it
)

# Who ordered what, and what was done to the history: a chain for each station; see trail.py.
trail = Table(
    "trail",
    metadata,
    Column("station", NAME, primary_key=True),
    Column("position", Count, primary_key=True, autoincrement=False),
    Column("key", DIGEST, nullable=False, unique=True),  # added once
    Column("at", UtcDateTime, nullable=False),
    Column("action", NAME, nullable=False),
    Column("outcome", NAME, nullable=False),
    Column("who", NAME, nullable=False),
    Column("subject", LongWords, nullable=False),
    Column("reason", LongWords, nullable=False),
    Column("content", DIGEST, nullable=False),
    Column("chain", DIGEST, nullable=False),
)

# The day's counts of what each station judged; see tallies.py.
tallies = Table(
    "tallies",
    metadata,
    Column("day", Words(10), primary_key=True),
    Column("product", NAME, primary_key=True),
    Column("station", NAME, primary_key=True),
    Column("what", Words(16), primary_key=True),
    Column("outcome", Words(16), primary_key=True),
    Column("name", NAME, primary_key=True),
    Column("side", Words(16), primary_key=True),
    Column("count", Count, nullable=False),
)
