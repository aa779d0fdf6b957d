"""The day's counts, made once from the results that are there."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

from motorid.quality.history import tallies

revision = "0004"
down_revision = "0003"

NAME, WORD = sa.String(200), sa.String(16)


def upgrade() -> None:
    """Makes the table and fills it."""
    op.create_table(
        "tallies",
        sa.Column("day", sa.String(10), nullable=False),
        sa.Column("product", NAME, nullable=False),
        sa.Column("station", NAME, nullable=False),
        sa.Column("what", WORD, nullable=False),
        sa.Column("outcome", WORD, nullable=False),
        sa.Column("name", NAME, nullable=False),
        sa.Column("side", WORD, nullable=False),
        sa.Column("count", sa.Integer, nullable=False),
        sa.PrimaryKeyConstraint(
            "day", "product", "station", "what", "outcome", "name", "side", name="pk_tallies"
        ),
    )
    tallies.recount(op.get_bind())
