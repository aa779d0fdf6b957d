"""Records for the tests of the history; importable by the processes that they start."""

from __future__ import annotations

import hashlib
import sys
from datetime import UTC, datetime, timedelta

from motorid.quality.history import CaptureRecord, MeasurementRecord, ResultRecord, open_history

# what makes a history one from before its tables had steps
UNSTEPPED = (
    "DROP TABLE alembic_version",
    "DROP TABLE names",
    "DROP TABLE trail",
    "DROP TABLE tallies",
    "DELETE FROM meta WHERE name = 'names_kept_days'",
    "DROP INDEX ix_results_station_at",
    *(f"DROP INDEX ix_results_{name}_id" for name in ("outcome", "station", "product")),
)
BEGAN = datetime(2026, 1, 5, 6, 0, tzinfo=UTC)


def record(
    number: int, *, station: str = "line-1", outcome: str = "PASS", operator: str = ""
) -> ResultRecord:
    """The check of motor ``number``; equal numbers give equal records."""
    sha256 = hashlib.sha256(f"capture {number}".encode()).hexdigest()
    return ResultRecord(
        kind="check",
        serial=f"SN-{number:05d}",
        product="pump-motor",
        outcome=outcome,
        at=BEGAN + timedelta(seconds=3 * number),
        station=station,
        operator=operator,
        measurements=(
            MeasurementRecord("R", "ohm", 2.6 + 0.001 * (number % 50), 0.004, 2.4, 2.8, 0.007,
                              outcome),
            MeasurementRecord("K", "N·m/A", 0.0077, 1e-5, None, 0.008, 2e-5, outcome),
        ),
        captures=(
            CaptureRecord(
                sha256, f"shift/SN-{number:05d}.h5", f"SN-{number:05d}", BEGAN, 14_000, "completed",
                rig="[rig]\nname = 'line-1'\n", program='{"steps": []}',
            ),
        ),
        versions={"motorid": "0.1.0"},
        limits="[limits.R]\nlow = 2.4\nhigh = 2.8\n",
    )  # fmt: skip


if __name__ == "__main__":  # a station: adds the motors FIRST to LAST, says each when it is safe
    place, first, last = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    with open_history(place) as history:
        for number in range(first, last):
            history.add(record(number))
            print(number, flush=True)
