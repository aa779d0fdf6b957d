"""Indices by which the newest results of an outcome, a station or a product are found at once."""

from __future__ import annotations

from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Makes them."""
    for column in ("outcome", "station", "product"):
        op.create_index(f"ix_results_{column}_id", "results", [column, "id"])
