"""What a proposal leaves open: units, counts, exchanged columns, a voltage from elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations

from motorid.capture.model import SPEED, VOLTAGE
from motorid.capture.units import TIME
from motorid.estimate.diagnosis.facts.unit_mistakes import NO_MOTOR
from motorid.workflow.proposal import laws
from motorid.workflow.proposal.assign import Assigned, Pick, shown
from motorid.workflow.proposal.by_laws import LAWS
from motorid.workflow.proposal.question import Answer, Known, Question
from motorid.workflow.proposal.time_base import TimeBase
from motorid.workflow.proposal.unit_choice import Choice, Evidence, ungeared

GEAR = 10.0  # from which on a gear is asked about
BETTER = 5.0  # times less that another arrangement of columns leaves


def swapped(time: TimeBase, assigned: Assigned, known: Known) -> list[Question]:
    """Columns that follow a motor's laws under other names only."""
    picks = assigned.picks
    if not len(time.values) or any(q not in picks or q in known.columns for q in LAWS):
        return []
    tried = {}
    for arranged in permutations(LAWS):
        found = laws.found(time.values, *(picks[quantity].values for quantity in arranged))
        if found is None:
            return []
        tried[arranged] = sum(found.left)
    best = min(tried, key=lambda arranged: tried[arranged])
    if tried[best] > min(laws.HOLDS, tried[LAWS] / BETTER):
        return []
    truly = {q: picks[of].expression for q, of in zip(LAWS, best, strict=True)}
    named = {q: picks[q].expression for q in LAWS}

    def answer(text: str, columns: Mapping[str, str]) -> Answer:
        option = " ".join(f"--map {shown(q)}={name}:UNIT" for q, name in columns.items())
        said = ", ".join(f"{name} is the {shown(q)}" for q, name in columns.items())
        return Answer(f"{text}: {said}", Known(columns), option)

    return [
        Question(
            "As named, the columns do not follow a motor's laws; in another order they do. Which "
            "order is right?",
            (answer("as named", named), answer("exchanged", truly)),
        )
    ]


def units_open(time: TimeBase, picks: Mapping[str, Pick], choice: Choice) -> list[Question]:
    questions = []
    for quantity, units in choice.open.items():
        name = time.expression if quantity == TIME else picks[quantity].expression
        answers = tuple(
            Answer(
                f"{unit}",
                Known({quantity: name}, {quantity: unit}),
                f"--map {shown(quantity)}={name}:{unit}",
            )
            for unit in units
        )
        questions.append(
            Question(f"Unit of {name}, read as the {shown(quantity)}: which?", answers)
        )
    return questions


def counts_open(picks: Mapping[str, Pick], choice: Choice, known: Known) -> list[Question]:
    counted = [q for q, unit in choice.units.items() if unit.startswith("count") and q in picks]
    if not counted or known.counts_per_turn:
        return []
    name = picks[counted[0]].expression
    return [
        Question(
            f"{name} holds counts: how many make a turn of the shaft?",
            (Answer(f"leave {name} out", Known({counted[0]: ""}), ""),),
            "counts a turn: four times an encoder's lines",
            "counts",
        )
    ]


def no_motor(choice: Choice, known: Known) -> list[Question]:
    if known.as_it_stands or choice.distance is None or choice.distance <= NO_MOTOR:
        return []
    return [
        Question(
            f"{figures_of(choice)} go together in no motor of the catalogues: a unit or a column "
            "is wrong.",
            (Answer("import it as it stands", Known(as_it_stands=True), ""),),
        )
    ]


def elsewhere(evidence: Evidence, assigned: Assigned) -> list[Question]:
    """A voltage that is not the motor's own, as far as current and speed show it."""
    law = evidence.laws
    if law is None or law.holds or assigned.sense:
        return []
    places = {
        "terminals": "across the motor, all the same",
        "supply": "at the supply",
        "command": "nowhere: it is what was commanded",
    }
    return [
        Question(
            f"{assigned.picks[VOLTAGE].expression} does not follow R i + K w. Where was the "
            "voltage measured?",
            tuple(Answer(text, Known(sense=s), f"--sense {s}") for s, text in places.items()),
        )
    ]


def gear_or_unit(
    picks: Mapping[str, Pick], choice: Choice, evidence: Evidence, known: Known
) -> list[Question]:
    """A speed that is a gear's, or in another unit than its header says: both look alike."""
    if SPEED in choice.open or SPEED in known.units or known.geared or choice.gear < GEAR:
        return []
    units = ungeared(choice, evidence)
    if not units:
        return []
    name, stated = picks[SPEED].expression, choice.units[SPEED]

    def answer(unit: str, text: str) -> Answer:
        option = f"--map speed={name}:{unit}"
        return Answer(text, Known({SPEED: name}, {SPEED: unit}), option)

    return [
        Question(
            f"{name} is slow for such a motor. Is it the speed behind a gear of about "
            f"{choice.gear:g} (--gear-ratio), or in another unit?",
            (
                answer(stated, f"a gear's: in {stated}, as it says"),
                *(answer(unit, f"the motor's: in {unit}") for unit in units if unit != stated),
            ),
        )
    ]


def figures_of(choice: Choice) -> str:
    units = {"R": "ohm", "K": "N·m/A", "J": "kg·m²"}
    known = [f"{n} about {choice.figures[n]:.2g} {units[n]}" for n in units if n in choice.figures]
    return ", ".join([*known, f"at up to {choice.figures['V']:.3g} V"])
