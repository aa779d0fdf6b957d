"""A column's name and header, read as words: which quantity, in which unit, wanted or measured."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass

from motorid.capture.columns import Described
from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, VOLTAGE
from motorid.capture.units import COMMAND, SET_POSITION, SET_SPEED, TIME, spelled, units_of
from motorid.workflow.proposal.vocabulary import (
    FILTERED,
    INDEX,
    LONG,
    MEASURED,
    OF_MOTOR,
    OTHER,
    OTHERS,
    QUANTITY_OF,
    RAW,
    SET_POINT,
    UNIT_OF,
    USUAL_UNIT,
)

_BRACKETS = re.compile(r"[(\[]([^()\[\]]*)[)\]]\s*$")
_OF_VALUES = re.compile(r"\.(?:values?|data)$", re.IGNORECASE)  # beside .time, of one signal
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[^\W\d_A-Za-z]+|\d+")
_PLAIN = str.maketrans({"ł": "l", "Ł": "L", "ß": "ss", "ø": "o", "æ": "ae", "µ": "μ"})
EXACT, PART, BY_UNIT = 3.0, 2.0, 1.0  # how well a name says what its column is
WHOLE_NAME, AS_MEASURED, AS_FILTERED = 0.5, 0.25, -0.25
_DOUBTFUL = frozenset(("m", "h", "min", "N", "1"))  # after a name they may mean something else
_WANTED = {SPEED: SET_SPEED, POSITION: SET_POSITION, VOLTAGE: VOLTAGE, COMMAND: COMMAND}
_OF_UNIT = (TIME, CURRENT, VOLTAGE, SPEED, POSITION, TORQUE)


@dataclass(frozen=True)
class Meaning:
    """``quantity``: one of ``units.QUANTITIES``, INDEX, OTHER, or "": the name says nothing.

    ``unit``: what header or name states, "" for nothing; ``usual``: what is usual with that word.
    ``number``: digits of the name, as of one motor among several.
    """

    quantity: str
    strength: float = 0.0
    unit: str = ""
    usual: str = ""
    wanted: bool = False  # a set point
    number: str = ""
    other_unit: str = ""  # stated, and none of the quantity's


def meaning(column: Described) -> Meaning:
    """What name and header say; the clearest of the header's cells counts."""
    said = [column.name, *(text for text in column.said if text != column.name)]
    found = [_meaning(text, column.unit) for text in said]
    return max(found, key=lambda one: one.strength)


def words(text: str) -> list[str]:
    """Lower-case words of a name: at blanks, signs, digits and capitals; accents are left out."""
    bare = "".join(
        c for c in unicodedata.normalize("NFKD", text.translate(_PLAIN))
        if not unicodedata.combining(c)
    )  # fmt: skip
    found = [word.casefold() for word in _WORD.findall(bare)]
    return [part for word in found for part in _cut(word)]


def _cut(word: str) -> list[str]:
    """``setvel`` -> ``set``, ``vel``: a word for a set point before that of a quantity."""
    if word in SET_POINT:
        return [word]
    for rest in range(3, len(word) - 1):
        if word[:rest] in SET_POINT and word[rest:] in QUANTITY_OF and word not in QUANTITY_OF:
            return [word[:rest], word[rest:]]
    return [word]


def _meaning(text: str, unit: str) -> Meaning:
    text = _OF_VALUES.sub("", text)
    bracket = _BRACKETS.search(text)
    bare = text[: bracket.start()] if bracket else text
    unit = unit or (spelled(bracket[1]) if bracket else None) or ""
    alone = spelled(bare) if len(bare.strip()) > 1 else None
    if alone and not (unit and unit != alone) and alone not in _DOUBTFUL:
        return Meaning(_of_unit(alone), BY_UNIT, alone)
    parts = words(bare)
    number = "".join(part for part in parts if part.isdigit())
    parts = [part for part in parts if not part.isdigit()]
    quantity, strength, word = _quantity(parts)
    by_name = ""
    if quantity in (OTHER, INDEX):
        return Meaning(quantity, strength, unit, number=number)
    if not quantity and not unit and (whole := spelled(bare)):
        unit = whole
    if not quantity:
        unit = unit or next((u for u in _suffixes(bare) if _of_unit(u)), "")
        quantity, strength = _of_unit(unit), BY_UNIT if unit else 0.0
        wanted = any(part in SET_POINT for part in parts) and quantity != TIME
        quantity = _WANTED.get(quantity, OTHER) if wanted and quantity else quantity
        return Meaning(quantity, strength, unit, wanted=wanted, number=number)
    for suffix in _suffixes(bare):
        if suffix in allowed(quantity) and suffix not in _DOUBTFUL:
            by_name = suffix
            break
    stated = unit or by_name or UNIT_OF.get(word, "")
    other = ""
    if stated and stated not in allowed(quantity):
        stated, other = "", stated
    if not stated and not other and any(part in RAW for part in parts):
        other = "raw counts"
    wanted = any(part in SET_POINT for part in parts) and quantity != TIME
    strength += (AS_MEASURED if any(part in MEASURED for part in parts) else 0.0) + (
        AS_FILTERED if any(part in FILTERED for part in parts) else 0.0
    )  # fmt: skip
    if wanted:
        quantity = _WANTED.get(quantity, OTHER)
    usual = "" if stated else USUAL_UNIT.get(word, "")
    return Meaning(quantity, strength, stated, usual, wanted, number, other)


def allowed(quantity: str) -> set[str]:
    """Units that a column of the quantity may have, counts with them."""
    more = {POSITION: {"counts"}, SET_POSITION: {"counts"}, SPEED: {"counts/s"}}
    return set(units_of(quantity)) | more.get(quantity, set())


def _quantity(parts: list[str]) -> tuple[str, float, str]:
    """Which quantity words speak of, how clearly, and by which word."""
    heard = [part for part in parts if part not in OF_MOTOR] or parts
    if parts and len(parts[-1]) >= LONG and QUANTITY_OF.get(parts[-1]) == TIME:
        return TIME, EXACT, parts[-1]  # current.Time
    found = [
        one
        for place, part in enumerate(heard)
        if (one := _word(part)) is not None and (len(part) > 1 or not place or not part.isascii())
    ]
    if any(part in OTHERS for part in parts):
        known = [one for one in found if one[0] == TIME]
        return known[0] if known else (OTHER, EXACT, "")
    if not found:
        return "", 0.0, ""
    whole = WHOLE_NAME if len(heard) == 1 else 0.0
    order = sorted(found, key=lambda one: (one[0] in (INDEX, COMMAND), len(one[2]) == 1, -one[1]))
    quantity, strength, word = order[0]
    return quantity, strength + whole, word


def _word(part: str) -> tuple[str, float, str] | None:
    if part in QUANTITY_OF:
        return QUANTITY_OF[part], EXACT, part
    within = [word for word in QUANTITY_OF if _inside(word, part)]
    if not within:
        return None
    longest = max(within, key=len)
    return QUANTITY_OF[longest], PART, longest


def _inside(word: str, part: str) -> bool:
    least = LONG if word.isascii() else 2
    return len(word) >= least and word in part and QUANTITY_OF[word] != INDEX


def _suffixes(text: str) -> Iterator[str]:
    """What may be a unit at the end of a name: current_mA, omega_rad_s, speed-rpm."""
    parts = [part for part in re.split(r"[\s_\-.]+", text.replace("_per_", "/")) if part]
    if len(parts) > 2 and (unit := spelled(f"{parts[-2]}/{parts[-1]}")):
        yield unit
    if len(parts) > 1 and (unit := spelled(parts[-1])):
        yield unit


def _of_unit(unit: str) -> str:
    return next((q for q in _OF_UNIT if unit in allowed(q) and unit not in _DOUBTFUL | {"Hz"}), "")
