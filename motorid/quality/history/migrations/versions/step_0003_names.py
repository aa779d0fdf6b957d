"""Names of persons beside the seals, and the trail of orders and of what befell the history."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
KEPT_DAYS = "365"

NAME, DIGEST = sa.String(200), sa.String(64)


def upgrade() -> None:
    """Makes both tables, and the rule by which names are forgotten."""
    op.create_table(
        "names",
        sa.Column("digest", DIGEST, nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("salt", DIGEST, nullable=False),
        sa.Column("at", sa.DateTime, nullable=False),
        sa.PrimaryKeyConstraint("digest", name="pk_names"),
    )
    op.create_index("ix_names_at", "names", ["at"])
    op.create_table(
        "trail",
        sa.Column("station", NAME, nullable=False),
        sa.Column("position", sa.Integer, nullable=False, autoincrement=False),
        sa.Column("key", DIGEST, nullable=False),
        sa.Column("at", sa.DateTime, nullable=False),
        sa.Column("action", NAME, nullable=False),
        sa.Column("outcome", NAME, nullable=False),
        sa.Column("who", NAME, nullable=False),
        sa.Column("subject", sa.Text, nullable=False),
        sa.Column("reason", sa.Text, nullable=False),
        sa.Column("content", DIGEST, nullable=False),
        sa.Column("chain", DIGEST, nullable=False),
        sa.PrimaryKeyConstraint("station", "position", name="pk_trail"),
        sa.UniqueConstraint("key", name="uq_trail_key"),
    )
    meta = sa.table("meta", sa.column("name"), sa.column("value"))
    rule = {"name": "names_kept_days", "value": KEPT_DAYS}
    op.get_bind().execute(sa.insert(meta).values(**rule))
