"""What a change of limits would change: verdicts anew from stored values and uncertainties.

No capture is read and nothing is written into the history. Ranges of results go to processes, or to
a cluster; each asks the database for itself.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from motorid import csv_text
from motorid.workflow.task import Result, Task
from motorid.workflow.tasks import Progress, Workers, answers

if TYPE_CHECKING:
    from motorid.quality.history import History, Query
    from motorid.quality.product import Product

AT_ONCE = 100_000  # results of a task
COLUMNS = ("id", "time", "serial", "station", "before", "after", "reason")


@dataclass
class Change:
    """How many results were judged; ``outcomes`` by (before, after) where these differ.

    ``reasons``: how often a quantity decided an outcome that is not as before. ``rows``: a row of
    COLUMNS for each such result.
    """

    judged: int = 0
    outcomes: Counter[tuple[str, str]] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    rows: list[list[Any]] = field(default_factory=list)


def rejudge_stored(
    history: History,
    product: Product,
    query: Query,
    *,
    jobs: Workers = 1,
    progress: Progress | None = None,
) -> Change:
    """The checks of this product that ``query`` chooses, by its limits of today."""
    from motorid.quality.history.candidates import bounds

    query = replace(query, product=product.name, kind=query.kind or "check")
    found = Change(judged=history.count(query))
    place = history.engine.url.render_as_string(hide_password=False)
    tasks = {
        ids: Task(_changed, (place, product, query, ids), {"ids": list(ids)})
        for ids in bounds(history, query, AT_ONCE)
    }
    for done, (_, answer) in enumerate(answers(tasks, jobs), 1):
        for row, names in answer["changes"]:
            found.rows.append(row)
            found.outcomes[row[4], row[5]] += 1
            found.reasons.update(names)
        if progress:
            progress(done, len(tasks))
    found.rows.sort(key=lambda row: int(row[0]))
    return found


def _changed(place: str, product: Product, query: Query, ids: tuple[int, int]) -> Result:
    from motorid.quality.history import open_history

    with open_history(place, create=False) as history:
        return {"changes": list(_changes(history, product, query, ids))}


def _changes(
    history: History, product: Product, query: Query, ids: tuple[int, int]
) -> Iterator[tuple[list[Any], list[str]]]:
    from motorid.quality.history.candidates import candidates
    from motorid.quality.stored_verdict import judge_stored

    for row, stored in candidates(history, query, product.limits, ids):
        verdict = judge_stored(stored, product)
        if verdict.outcome == row.outcome:
            continue
        decided = [m.quantity for m in verdict.measurements if m.outcome is verdict.outcome]
        names = decided if verdict.outcome != "PASS" else []
        reason = next(iter(verdict.reasons), "")
        at = row.at.isoformat()
        about = [row.id, at, row.serial, row.station, row.outcome, str(verdict.outcome), reason]
        yield about, names


def table(change: Change) -> str:
    """CSV, a row for each result whose outcome changes."""
    return csv_text.table(list(COLUMNS), change.rows)


def summary(change: Change) -> str:
    """How many change, from what to what, and by which quantities."""
    lines = [f"{change.judged} results judged from stored values, {len(change.rows)} change"]
    for (before, after), count in sorted(change.outcomes.items()):
        lines.append(f"  {before} -> {after:<8} {count}")
    for name, count in change.reasons.most_common():
        lines.append(f"  {name:<20} decides {count} of them")
    return "\n".join(lines)
