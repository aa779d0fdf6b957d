"""From a file to what its columns are, in words and as the options of an import."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, VOLTAGE
from motorid.capture.table_checks import speed_over_derivative
from motorid.capture.units import COMMAND, TIME
from motorid.errors import DataError
from motorid.estimate.diagnosis.facts.unit_mistakes import UNUSUAL
from motorid.workflow.proposal import laws
from motorid.workflow.proposal.assign import NEEDED, Assigned, Pick, assign, shown
from motorid.workflow.proposal.by_laws import LAWS, ask, nameless, order
from motorid.workflow.proposal.open_questions import (
    counts_open,
    elsewhere,
    figures_of,
    gear_or_unit,
    no_motor,
    swapped,
    units_open,
)
from motorid.workflow.proposal.question import Known, Question
from motorid.workflow.proposal.seen import Table
from motorid.workflow.proposal.seen import look as look
from motorid.workflow.proposal.time_base import TimeBase, of_table
from motorid.workflow.proposal.unit_choice import (
    Choice,
    Evidence,
    choose,
)

Floats = NDArray[np.float64]
FULL = (1, 100, 255, 1000, 1023, 4095, 65535)  # usual commands at full duty
SENSES = {"command": "as it was commanded"}


@dataclass(frozen=True)
class Proposal:
    """``maps``: the best guess of each quantity, settled where no question is about it.

    ``readings``: column -> what it is read as, or why it is left out. ``remarks``: sentences.
    """

    table: Table
    maps: tuple[str, ...]
    counts_per_turn: float
    sense: str
    readings: Mapping[str, str]
    remarks: tuple[str, ...]
    questions: tuple[Question, ...]


def propose(table: Table, known: Known) -> Proposal:
    """What the columns of ``table`` are; what ``known`` says is taken as it is.

    Raises DataError where no column is a quantity of a motor.
    """
    time = of_table(table, known)
    assigned = assign(table, known, time.column)
    asked: list[Question] = []
    by_name = [q for q in NEEDED if q in assigned.picks and q not in known.columns]
    if not by_name and not assigned.questions:
        free = nameless(table, time)
        by_laws = order(free, time, known)
        if by_laws is not None:
            return propose(table, known.and_(by_laws))
        asked = ask(free, known)
        if not asked and not assigned.picks:
            raise DataError(_nothing(table))
    evidence = _evidence(time, assigned)
    picks, left = _without_counts(assigned, known)
    stated = {} if time.question is not None else time.costs
    choice = choose(picks, stated, evidence)
    questions = [one for one in (time.question,) if one is not None]
    questions += [*assigned.questions, *asked]
    if not questions:
        questions += swapped(time, assigned, known) or elsewhere(evidence, assigned)
        questions += units_open(time, picks, choice)
        questions += counts_open(picks, choice, known)
        questions += no_motor(choice, known)
        questions += gear_or_unit(picks, choice, evidence, known)
    maps = _maps(time, picks, choice, evidence)
    return Proposal(
        table,
        maps,
        known.counts_per_turn if any(":counts" in one for one in maps) else 0.0,
        assigned.sense,
        _readings(table, time, picks, choice, left),
        tuple(_remarks(table, time, choice, evidence, assigned)),
        tuple(questions),
    )


def _nothing(table: Table) -> str:
    named = ", ".join(column.name for column in table.columns[:8])
    return (
        f"{table.path}: no column of numbers is a quantity of a motor ({named}): give --map "
        "QUANTITY=COLUMN:UNIT for each"
    )


def _evidence(time: TimeBase, assigned: Assigned) -> Evidence:
    values = {quantity: pick.values for quantity, pick in assigned.picks.items()}
    if not len(time.values):
        return Evidence(resistance=_resistance(values))
    found = slope = None
    if all(quantity in values for quantity in LAWS):
        found = laws.found(time.values, *(values[quantity] for quantity in LAWS))
    if SPEED in values and POSITION in values:
        rows = np.isfinite(time.values + values[SPEED] + values[POSITION])
        if rows.sum() > 1:
            slope = speed_over_derivative(
                time.values[rows], values[POSITION][rows], values[SPEED][rows]
            )
    resists = None if found is not None and found.holds else _resistance(values)
    return Evidence(found, resists, slope)


def _resistance(values: Mapping[str, Floats]) -> tuple[float, float] | None:
    if VOLTAGE not in values or CURRENT not in values:
        return None
    return laws.resistance(values[VOLTAGE], values[CURRENT])


def _without_counts(assigned: Assigned, known: Known) -> tuple[dict[str, Pick], dict[str, str]]:
    """Counts of an unknown encoder beside a speed are left out: nothing is lost by that."""
    picks, left = dict(assigned.picks), dict(assigned.left)
    pick = picks.get(POSITION)
    if pick is None or known.counts_per_turn or SPEED not in picks or POSITION in known.units:
        return picks, left
    if pick.meaning.unit == "counts":
        left[pick.expression] = "counts: give --counts-per-turn to use them"
        del picks[POSITION]
    return picks, left


def _maps(
    time: TimeBase, picks: Mapping[str, Pick], choice: Choice, evidence: Evidence
) -> tuple[str, ...]:
    maps = []
    if time.expression:
        maps.append(f"time={time.expression}:{choice.units.get(TIME, 's')}")
    for quantity, pick in picks.items():
        sign = _sign(quantity, evidence)
        maps.append(f"{shown(quantity)}={sign}{pick.expression}:{choice.units[quantity]}")
    return tuple(maps)


def _sign(quantity: str, evidence: Evidence) -> str:
    """``-`` for a column that is wired the other way round from the voltage."""
    if evidence.laws is None or not evidence.laws.holds:
        return ""
    signs = {CURRENT: evidence.laws.signs[0], SPEED: evidence.laws.signs[1]}
    return "-" if signs.get(quantity, 1.0) < 0 else ""


def _readings(
    table: Table, time: TimeBase, picks: Mapping[str, Pick], choice: Choice,
    left: Mapping[str, str],
) -> dict[str, str]:  # fmt: skip
    """Column -> what it is read as."""
    found = {name: f"left out: {why}" for name, why in left.items()}
    if time.column:
        unit = choice.units.get(TIME, "?")
        unsure = " (unsure)" if TIME in choice.open or time.question is not None else ""
        whole = time.expression == time.column
        found[time.column] = f"time in {unit}{unsure}" if whole else "numbers the rows"
    for quantity, pick in picks.items():
        unsure = " (unsure)" if quantity in choice.open else ""
        for column in table.columns:
            if pick.column is column or (pick.column is None and column.name in pick.expression):
                found[column.name] = f"{shown(quantity)} in {choice.units[quantity]}{unsure}"
    return found


def _duty(assigned: Assigned) -> list[str]:
    """A duty and a supply, whose product may be the motor's voltage, which no column is."""
    supply, command = assigned.picks.get(SUPPLY), assigned.picks.get(COMMAND)
    if VOLTAGE in assigned.picks or supply is None or command is None:
        return []
    largest = float(np.nanmax(np.abs(command.values)))
    full = next((size for size in FULL if largest <= size), largest)
    share = command.expression if full == 1 else f"{command.expression}/{full:g}"
    unit = supply.meaning.unit or "V"
    return [
        f"no column is the motor's voltage: if {command.expression} is a duty, {full:g} at full, "
        f"--map voltage={share}*{supply.expression}:{unit} makes it"
    ]


def _remarks(
    table: Table, time: TimeBase, choice: Choice, evidence: Evidence, assigned: Assigned
) -> list[str]:
    found = []
    used = {time.column} | {pick.column.name for pick in assigned.picks.values() if pick.column}
    if time.expression and time.expression != time.column:
        found.append(f"time is {time.expression}: {time.why}")
    for column in table.columns:
        gaps = table.rows - len(column.finite)
        if gaps and column.name in used:
            found.append(
                f"{column.name} holds no number in {gaps} rows: the import stops at the first, or "
                "leaves them out with --drop-bad"
            )
    if table.more:
        found.append(f"{table.more} more columns were not looked at")
    if assigned.sense:
        found.append(
            f"the voltage is taken {SENSES.get(assigned.sense, 'at the ' + assigned.sense)}"
        )
    found += _duty(assigned)
    law = evidence.laws
    if law is not None and law.holds:
        turned = [
            name for name, sign in zip(("current", "speed"), law.signs, strict=True) if sign < 0
        ]
        found += [f"the {name} runs against the voltage: it is taken with the other sign"
                  for name in turned]  # fmt: skip
    if choice.distance is not None and law is not None and law.holds:
        how = "as motors have them" if choice.distance <= UNUSUAL else "unusual for a motor"
        if choice.gear > 1.0 and choice.distance <= UNUSUAL:
            how = f"as motors behind a gear of about {choice.gear:g} have them; is there one?"
        found.append(f"{figures_of(choice)}: {how}")
    return found
