"""Which column is which quantity, by name and unit; equals are asked about."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture import quadrature
from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, TORQUE, VOLTAGE
from motorid.capture.units import AMBIENT, COMMAND, SET_POSITION, SET_SPEED, TIME
from motorid.workflow.proposal.naming import BY_UNIT, EXACT, Meaning, allowed, words
from motorid.workflow.proposal.question import Answer, Known, Question
from motorid.workflow.proposal.seen import Seen, Table
from motorid.workflow.proposal.time_base import evaluated, formula_of
from motorid.workflow.proposal.vocabulary import INDEX, OTHER, QUANTITY_OF

Floats = NDArray[np.float64]
ORDER = (
    VOLTAGE,
    CURRENT,
    SPEED,
    POSITION,
    TORQUE,
    SUPPLY,
    COMMAND,
    SET_SPEED,
    SET_POSITION,
    AMBIENT,
)
EDGES = 20  # that two lines show at least, to be an encoder's
SHOWN = {VOLTAGE: "voltage"}
NAMELESS = "its name says nothing"
MOST_NAMELESS = 4  # columns that are asked about
NEEDED = (VOLTAGE, CURRENT, SPEED, POSITION, TORQUE)  # equals are asked about; others are left out


@dataclass(frozen=True)
class Pick:
    """The column, or arithmetic, that a quantity is taken from; ``meaning`` of its name."""

    expression: str
    values: Floats
    meaning: Meaning
    column: Seen | None = None


@dataclass(frozen=True)
class Assigned:
    """``left``: column -> why it is left out."""

    picks: Mapping[str, Pick]
    left: Mapping[str, str]
    questions: tuple[Question, ...] = ()
    sense: str = ""


def shown(quantity: str) -> str:
    """The quantity's name as --map has it."""
    return SHOWN.get(quantity, quantity)


def assign(table: Table, known: Known, time: str) -> Assigned:
    """Quantities by name and unit. ``time``: the column that is it."""
    picks: dict[str, Pick] = {}
    left: dict[str, str] = {}
    taken = {time}
    for quantity, expression in known.columns.items():
        if quantity != TIME and expression:
            unit = known.units.get(quantity, "")
            picks[quantity] = _stated(table, quantity, expression, unit)
            asked = (table.named(name) for name in formula_of(table, expression).columns)
            taken |= {column.name for column in asked if column is not None}
    free = [c for c in table.columns if c.name not in taken]
    elsewhere = _own_stamps(table, time)
    for one in free:
        why = elsewhere.get(one.name) or _useless(one)
        if why:
            left[one.name] = why
    free = [c for c in free if c.name not in left]
    questions = []
    lines = _encoder(free) if not {POSITION, SPEED} & known.columns.keys() else None
    if lines is not None:
        a, b = lines
        expression = f"{quadrature.NAME}({a.name},{b.name})"
        said = Meaning(POSITION, EXACT, "counts")
        picks[POSITION] = Pick(expression, quadrature.counts(a.values, b.values), said)
        free = [c for c in free if c is not a and c is not b]
        taken |= {a.name, b.name}
    candidates = {q: _of(q, free) for q in ORDER if q not in known.columns and q not in picks}
    constant = _constant_volts(candidates)
    if constant:
        candidates[VOLTAGE] = []
        left |= {c.name: f"never changes, and {candidates[COMMAND][0].name} does" for c in constant}
    motors = _motors(candidates)
    if motors is not None:
        return Assigned(picks, left, (motors,))
    for quantity, found in candidates.items():
        if not found:
            continue
        best = [c for c in found if c.meaning.strength == found[0].meaning.strength]
        best = _of_the_same(best, picks) if len(best) > 1 else best
        if len(best) > 1 and quantity in NEEDED:
            questions.append(_which(quantity, best))
        elif len(best) > 1:
            left |= {c.name: f"one of {len(best)} that may be the {shown(quantity)}" for c in best}
            continue
        picks[quantity] = Pick(best[0].name, best[0].values, best[0].meaning, best[0])
        rest = (c for c in found if c is not best[0] and (c not in best or not questions))
        left |= {c.name: f"{best[0].name} is the {shown(quantity)}" for c in rest}
    questions += _by_unit_alone(picks)
    used = {p.column.name for p in picks.values() if p.column is not None} | left.keys() | taken
    left |= {c.name: _unknown(c, picks) for c in table.columns if c.name not in used}
    questions += _motion(picks, [c for c in free if left.get(c.name) == NAMELESS], known)
    sense = known.sense
    if not sense and VOLTAGE in picks and picks[VOLTAGE].meaning.wanted:
        sense = "command"
    return Assigned(picks, left, tuple(questions), sense)


def _stated(table: Table, quantity: str, expression: str, unit: str) -> Pick:
    column = table.named(expression)
    values = column.values if column is not None else evaluated(table, expression)
    if column is not None and not unit:
        said = column.meaning
        told = said.unit if said.unit in allowed(quantity) else ""  # its name is of another
        usual = said.usual if said.usual in allowed(quantity) else ""
        return Pick(expression, values, replace(said, unit=told, usual=usual), column)
    return Pick(expression, values, Meaning("", 9.0, unit), column)


def _useless(column: Seen) -> str:
    if column.unread:
        return column.unread
    said = column.meaning
    if said.quantity == OTHER:
        return "no quantity of a fit"
    if said.quantity == TIME:
        return "another time"
    if said.quantity == INDEX:
        return "numbers the rows"
    if said.other_unit:
        return (
            f"named as {shown(said.quantity)}, in {said.other_unit}: give --map with its gain, "
            f"such as {shown(said.quantity)}={column.name}/0.1:UNIT"
        )
    return ""


def _motion(picks: Mapping[str, Pick], nameless: Sequence[Seen], known: Known) -> list[Question]:
    """Beside a drive, and nothing that it drives: which nameless column is the motion (t, u, y)."""
    driven = {VOLTAGE, COMMAND} & picks.keys()
    found = [c for c in nameless if c.levels > 1 and not c.counts_rows]
    answered = {SPEED, POSITION, CURRENT, TORQUE} & (picks.keys() | known.columns.keys())
    if not driven or answered or not 0 < len(found) <= MOST_NAMELESS:
        return []
    answers = [
        Answer(f"{c.name}, the {q}", Known({q: c.name}), f"--map {q}={c.name}:UNIT")
        for c in found
        for q in (SPEED, POSITION, CURRENT)
    ]
    answers.append(Answer("none of them", Known({SPEED: ""}), ""))
    return [
        Question("Nothing is named as what the motor does: which column is it?", tuple(answers))
    ]


def _unknown(column: Seen, picks: Mapping[str, Pick]) -> str:
    quantity = column.meaning.quantity
    if quantity in picks:
        return f"{picks[quantity].expression} is the {shown(quantity)}"
    return f"perhaps {shown(quantity)}" if quantity else NAMELESS


def _encoder(columns: Sequence[Seen]) -> tuple[Seen, Seen] | None:
    """The two lines of an encoder; None: there are not just two such columns."""
    lines = [c for c in columns if c.levels == 2 and c.whole]
    if len(lines) != 2 or not quadrature.is_pair(lines[0].values, lines[1].values, EDGES):
        return None
    return lines[0], lines[1]


def _own_stamps(table: Table, time: str) -> dict[str, str]:
    """Columns beside a time of their own that differs: ``i.Data`` beside ``i.Time``."""
    chosen = table.named(time)
    found: dict[str, str] = {}
    if chosen is None:
        return found
    for other in table.columns:
        before, dot, _ = other.name.rpartition(".")
        if other is chosen or not dot or other.meaning.quantity != TIME or other.unread:
            continue
        if not np.array_equal(other.values, chosen.values):
            found |= {
                c.name: f"{other.name} is its time, and differs from {time}"
                for c in table.columns
                if c.name.startswith(f"{before}.") and c is not other
            }
    return found


def _of(quantity: str, columns: Iterable[Seen]) -> list[Seen]:
    """Columns that may be the quantity, the likeliest first."""
    found = [c for c in columns if c.meaning.quantity == quantity]
    moving = [c for c in found if c.levels > 1] or found
    return sorted(moving, key=lambda c: (c.meaning.wanted, -c.meaning.strength))


def _of_the_same(equals: list[Seen], picks: Mapping[str, Pick]) -> list[Seen]:
    """The one whose name shares a word with that of the motion, as left_pwm with left_rpm; else all
    of them.
    """
    motion = picks.get(SPEED) or picks.get(POSITION)
    if motion is None or motion.column is None:
        return equals
    side = {word for word in words(motion.expression) if word not in QUANTITY_OF}
    shared = [c for c in equals if side & set(words(c.name))]
    return shared if len(shared) == 1 else equals


def _constant_volts(candidates: Mapping[str, list[Seen]]) -> list[Seen]:
    """Volts that never change beside a command that does: a supply, or a target."""
    volts, commands = candidates.get(VOLTAGE, []), candidates.get(COMMAND, [])
    if any(c.levels > 1 for c in volts) or not any(c.levels > 1 for c in commands):
        return []
    return volts


def _motors(candidates: Mapping[str, list[Seen]]) -> Question | None:
    """Columns of several motors, told apart by a number in their names."""
    equal = {q: [c for c in found if c.meaning.strength == found[0].meaning.strength]
             for q, found in candidates.items() if found and q in NEEDED}  # fmt: skip
    numbers = [tuple(c.meaning.number for c in best) for best in equal.values() if len(best) > 1]
    if len(numbers) < 2 or len(set(numbers)) > 1 or len(set(numbers[0])) < len(numbers[0]):
        return None
    if not all(numbers[0]):
        return None
    answers = []
    for number in numbers[0]:
        columns = {
            q: c.name
            for q, found in candidates.items()
            for c in found
            if c.meaning.number == number
            and len([d for d in found if d.meaning.number == number]) == 1
        }
        named = ", ".join(columns.values())
        option = " ".join(f"--map {shown(q)}={name}:UNIT" for q, name in columns.items())
        answers.append(Answer(f"{number}: {named}", Known(columns), option))
    return Question(f"The columns are of {len(answers)} motors: which one?", tuple(answers))


def _which(quantity: str, equals: list[Seen]) -> Question:
    name = shown(quantity)
    answers = [
        Answer(
            c.name, Known({quantity: c.name}), f"--map {name}={c.name}:{c.meaning.unit or 'UNIT'}"
        )
        for c in equals
    ]
    if quantity != VOLTAGE:
        answers.append(Answer("none of them", Known({quantity: ""}), ""))
    return Question(f"Which column is the {name}?", tuple(answers))


def _by_unit_alone(picks: Mapping[str, Pick]) -> list[Question]:
    """Volts may be of anything: by its unit alone a channel is the motor's only beside amperes."""
    pick = picks.get(VOLTAGE)
    if pick is None or pick.meaning.strength != BY_UNIT or CURRENT in picks:
        return []
    name = pick.expression
    unit = pick.meaning.unit
    return [
        Question(
            f"Of {name} only the unit is known: what is it?",
            (
                Answer("the voltage across the motor", Known({VOLTAGE: name}, {VOLTAGE: unit}),
                       f"--map voltage={name}:{unit}"),
                Answer("something else: leave it out", Known({VOLTAGE: ""}), ""),
            ),
            "a current's sensor: volts for one ampere",
            CURRENT,
            name + "/{}",
            "A",
        )
    ]  # fmt: skip
