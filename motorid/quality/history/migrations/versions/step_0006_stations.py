"""An index by which a station's newest results, or those of a time, are found at once."""

from __future__ import annotations

from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Makes it, on PostgreSQL for each month's partition too."""
    op.create_index("ix_results_station_at", "results", ["station", "at"])
