"""Which results: one filter for listing, trends, export and judging again."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import ColumnElement, Select

from motorid.quality.history import months
from motorid.quality.history.schema import results


@dataclass(frozen=True)
class Query:
    """Every field that is given must hold. ``serial`` may hold ``*`` and ``?`` as file names do."""

    serial: str = ""
    product: str = ""
    outcome: str = ""
    kind: str = ""
    station: str = ""
    since: datetime | None = None
    until: datetime | None = None

    def conditions(self) -> list[ColumnElement[bool]]:
        """The filter in SQL's terms."""
        found = [
            results.c[name] == value
            for name in ("product", "outcome", "kind", "station")
            if (value := getattr(self, name))
        ]
        if self.serial:
            found.append(matches(results.c.serial, self.serial))
        if self.since:
            found.append(results.c.at >= self.since)
        if self.until:
            found.append(results.c.at < self.until)
        return [*found, *months.within(results.c.id, self.since, self.until)]

    def apply(self, select: Select[Any]) -> Select[Any]:
        """``select`` with this filter, in the order in which the results were added."""
        return select.where(*self.conditions()).order_by(results.c.id)


def matches(column: ColumnElement[str], pattern: str) -> ColumnElement[bool]:
    """Equality, or LIKE where the pattern has wildcards; what LIKE would read is escaped."""
    if not set(pattern) & {"*", "?"}:
        return column == pattern
    for special in ("\\", "%", "_"):
        pattern = pattern.replace(special, f"\\{special}")
    return column.like(pattern.replace("*", "%").replace("?", "_"), escape="\\")
