"""Which results a page shows, as its address says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from urllib.parse import urlencode

from motorid.errors import UsageError, nearest
from motorid.quality.history import Query

NAMES = ("product", "station", "from", "to", "serial", "quantity", "outcome", "before")
LONGEST = 200
OUTCOMES = ("", "PASS", "FAIL", "INVALID")


@dataclass(frozen=True)
class Filters:
    """``chosen``: what the address says, by NAMES. ``before``: results with a smaller number."""

    query: Query
    quantity: str = ""
    before: int | None = None
    chosen: Mapping[str, str] = field(default_factory=dict)

    def link(self, **changed: str) -> str:
        """The address of the page with some of the filters changed; "" takes one away."""
        kept = {name: value for name, value in {**self.chosen, **changed}.items() if value}
        return f"?{urlencode(kept)}" if kept else "./"


def read(said: Mapping[str, str]) -> Filters:
    """The filters of an address. Raises UsageError, which names what is wrong in it."""
    for name, value in said.items():
        if name not in NAMES:
            raise UsageError(
                f"there is no filter {name[:40]!r}{nearest(name, NAMES)}; there are "
                f"{', '.join(NAMES)}"
            )
        if len(value) > LONGEST:
            raise UsageError(f"{name} has more than {LONGEST} characters")
    chosen = {name: value.strip() for name, value in said.items() if value.strip()}
    outcome, before = chosen.get("outcome", ""), chosen.get("before", "")
    if outcome not in OUTCOMES:
        raise UsageError(f"outcome {outcome!r}: it is PASS, FAIL or INVALID")
    if before and not (before.isascii() and before.isdecimal() and len(before) < 18):
        raise UsageError(f"before {before!r}: it is the number of a result")
    query = Query(
        serial=chosen.get("serial", ""),
        product=chosen.get("product", ""),
        outcome=outcome,
        kind="check",
        station=chosen.get("station", ""),
        since=_instant("from", chosen),
        until=_instant("to", chosen),
    )
    return Filters(query, chosen.get("quantity", ""), int(before) if before else None, chosen)


def _instant(name: str, chosen: Mapping[str, str]) -> datetime | None:
    """UTC where it says no zone."""
    text = chosen.get(name)
    if not text:
        return None
    try:
        found = datetime.fromisoformat(text)
        return found.astimezone(UTC) if found.tzinfo else found.replace(tzinfo=UTC)
    except (ValueError, OverflowError):
        raise UsageError(
            f"{name} {text[:40]!r}: write a day or an instant, such as 2026-11-21 or "
            "2026-11-21T06:00"
        ) from None
