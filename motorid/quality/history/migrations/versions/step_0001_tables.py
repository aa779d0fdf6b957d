"""The tables of schema 1. Histories from before Alembic may have all of them, or all but seals."""

from __future__ import annotations

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None

NAME, DIGEST = sa.String(200), sa.String(64)


def upgrade() -> None:
    """Makes each table that is not there, and counts the results from before there were seals."""
    connection = op.get_bind()
    there = set(sa.inspect(connection).get_table_names())
    for name, columns, indices in TABLES:
        if name not in there:
            op.create_table(name, *columns())
            for index, indexed in indices:
                op.create_index(index, name, indexed)
    meta = sa.table("meta", sa.column("name"), sa.column("value"))
    results = sa.table("results", sa.column("id"))
    known = set(connection.scalars(sa.select(meta.c.name)))
    last = sa.func.coalesce(sa.func.max(results.c.id), 0)
    before = connection.execute(sa.select(sa.func.count(results.c.id), last)).one()
    for name, value in (("schema", "1"), ("unsealed", f"{before[0]} {before[1]}")):
        if name not in known:
            connection.execute(sa.insert(meta).values(name=name, value=value))


def _text(name: str, kind: Any, **rest: Any) -> sa.Column[Any]:
    return sa.Column(name, kind, nullable=False, **rest)


def _cited(table: str, name: str, key: str, kind: Any, **rest: Any) -> sa.Column[Any]:
    target = sa.ForeignKey(key, name=f"fk_{table}_{name}")
    return sa.Column(name, kind, target, **rest)


def _meta() -> list[Any]:
    return [_text("name", NAME), _text("value", sa.Text), _primary("meta", "name")]


def _primary(table: str, *names: str) -> sa.PrimaryKeyConstraint:
    return sa.PrimaryKeyConstraint(*names, name=f"pk_{table}")


def _documents() -> list[Any]:
    return [_text("sha256", DIGEST), _text("text", sa.Text), _primary("documents", "sha256")]


def _captures() -> list[Any]:
    return [
        _text("sha256", DIGEST),
        _text("path", sa.Text),
        _text("serial", NAME),
        sa.Column("created", sa.DateTime),
        _text("samples", sa.Integer),
        _text("end_reason", NAME),
        *(
            _cited("captures", name, "documents.sha256", DIGEST)
            for name in ("rig", "program", "calibration")
        ),
        _primary("captures", "sha256"),
    ]


def _results() -> list[Any]:
    return [
        sa.Column("id", sa.Integer, nullable=False),
        _text("key", DIGEST),
        _text("kind", NAME),
        _text("serial", NAME),
        _text("product", NAME),
        _text("outcome", sa.String(16)),
        _text("marginal", sa.Boolean),
        _text("at", sa.DateTime),
        _text("station", NAME),
        _text("operator", NAME),
        _text("note", sa.Text),
        _text("versions", sa.JSON),
        _cited("results", "limits", "documents.sha256", DIGEST),
        _cited("results", "estimate", "documents.sha256", DIGEST),
        _primary("results", "id"),
        sa.UniqueConstraint("key", name="uq_results_key"),
    ]


def _result_captures() -> list[Any]:
    table = "result_captures"
    return [
        _cited(table, "result", "results.id", sa.Integer, nullable=False),
        _text("position", sa.Integer),
        _cited(table, "capture", "captures.sha256", DIGEST, nullable=False),
        _primary(table, "result", "position"),
    ]


def _measurements() -> list[Any]:
    return [
        _cited("measurements", "result", "results.id", sa.Integer, nullable=False),
        _text("name", NAME),
        _text("unit", sa.String(40)),
        *(
            sa.Column(name, sa.Double)
            for name in ("value", "uncertainty", "low", "high", "guard_band")
        ),
        _text("outcome", sa.String(16)),
        _text("marginal", sa.Boolean),
        _text("reason", sa.Text),
        _primary("measurements", "result", "name"),
    ]


def _seals() -> list[Any]:
    return [
        _text("station", NAME),
        _text("position", sa.Integer, autoincrement=False),
        _text("result", sa.Integer),
        _text("content", DIGEST),
        _text("chain", DIGEST),
        _primary("seals", "station", "position"),
        sa.UniqueConstraint("result", name="uq_seals_result"),
    ]


TABLES: tuple[tuple[str, Any, tuple[tuple[str, list[str]], ...]], ...] = (
    ("meta", _meta, ()),
    ("documents", _documents, ()),
    ("captures", _captures, (("ix_captures_serial", ["serial"]),)),
    ("results", _results, (("ix_results_serial", ["serial"]), ("ix_results_at", ["at"]))),
    ("result_captures", _result_captures, (("ix_result_captures_capture", ["capture"]),)),
    ("measurements", _measurements, (("ix_measurements_name_result", ["name", "result"]),)),
    ("seals", _seals, ()),
)
