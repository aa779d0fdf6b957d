"""Columns without telling names: the three that follow a motor's laws, or a question for each."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

from motorid.capture.model import CURRENT, SPEED, VOLTAGE
from motorid.workflow.proposal import laws
from motorid.workflow.proposal.assign import NEEDED, shown
from motorid.workflow.proposal.question import Answer, Known, Question
from motorid.workflow.proposal.seen import Seen, Table
from motorid.workflow.proposal.time_base import TimeBase

LAWS = (VOLTAGE, CURRENT, SPEED)
MOST = 5  # columns that are tried in every order
BETTER = 5.0  # times less that the best order leaves than any of other columns or another order


def nameless(table: Table, time: TimeBase) -> list[Seen]:
    """Columns of changing numbers whose names say nothing."""
    return [
        column
        for column in table.columns
        if not column.unread
        and column.name != time.column
        and not column.meaning.quantity
        and column.levels > 1
    ]


def order(columns: Sequence[Seen], time: TimeBase, known: Known) -> Known | None:
    """Voltage, current and speed among columns by a motor's laws, where ``known`` leaves any open.

    None: the laws leave it open too, or contradict what is known.
    """
    if all(quantity in known.columns for quantity in LAWS):
        return None
    if not len(time.values) or not 3 <= len(columns) <= MOST:
        return None
    tried = []
    for chosen in permutations(columns, 3):
        found = laws.found(time.values, *(column.values for column in chosen))
        if found is not None and found.signs == (1.0, 1.0):
            tried.append((sum(found.left), chosen))
    tried.sort(key=lambda one: one[0])
    if not tried or tried[0][0] > laws.HOLDS:
        return None
    if len(tried) > 1 and tried[1][0] < BETTER * tried[0][0]:
        return None
    named = {q: column.name for q, column in zip(LAWS, tried[0][1], strict=True)}
    contradicted = any(known.columns.get(q, name) != name for q, name in named.items())
    return None if contradicted else Known(named)


def ask(columns: Sequence[Seen], known: Known) -> list[Question]:
    """Which of the columns is the next quantity that nobody has spoken of."""
    taken = set(known.columns.values())
    free = [column for column in columns if column.name not in taken]
    for quantity in NEEDED:
        if quantity in known.columns or not free:
            continue
        answers = [
            Answer(c.name, Known({quantity: c.name}), f"--map {shown(quantity)}={c.name}:UNIT")
            for c in free
        ]
        answers.append(Answer("none of them", Known({quantity: ""}), ""))
        return [Question(f"Which column is the {shown(quantity)}?", tuple(answers))]
    return []
