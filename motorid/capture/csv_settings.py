"""What an oscilloscope writes beside its readings: start, increment and other numbers with names.

Three forms: ``t0 = -5e-3s`` in a cell of the header; a name with its number below or beside it; and
settings in the columns left of the readings, which then begin in the first line.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_STATED = re.compile(rf"(?:(\w[\w ]{{0,63}}?)\s*=\s*)?(?:\w+:)?({_NUMBER})\s*[a-zA-Zµμ]{{0,3}}")
_NAME = re.compile(r"[^\W\d][\w ./()%-]*")
_LEFT = 2  # columns of settings, at least: a name and its value

Row = Sequence[str]


def settings(header: Sequence[Row], first: Row) -> dict[str, float]:
    """Numbers with names in the lines above the readings, of which ``first`` is the first."""
    found: dict[str, float] = {}
    for above, row in zip([(), *header], header, strict=False):
        filled = [cell for cell in row if cell]
        for column, cell in enumerate(row):
            stated = _STATED.fullmatch(cell)
            if stated is None or (not stated[1] and column < len(first) and first[column]):
                continue
            over = above[column] if column < len(above) else ""
            name = stated[1] or (over if _NAME.fullmatch(over) else "")
            if name:
                found.setdefault(name, float(stated[2]))
        alike = len(filled) >= 2 and len(set(filled[1:])) == 1  # one for each column, too
        if alike and (stated := _STATED.fullmatch(filled[1])) and not stated[1]:
            name = filled[0].rstrip(": ")
            again = sum(filled[0] in other for other in header) > 1  # then it names a column too
            if _NAME.fullmatch(name) and not again:
                found.setdefault(name, float(stated[2]))
    return {name: value for name, value in found.items() if abs(value) < float("inf")}


def beside_readings(before: Sequence[Row], first: Row) -> bool:
    """Whether the lines before ``first`` hold readings too, right of columns of settings."""
    left = next((column for column, cell in enumerate(first) if cell), 0)
    if left < _LEFT or not before:
        return False
    places = [column for column in range(left, len(first)) if first[column]]
    return all(
        len(row) > places[-1] and all(re.fullmatch(_NUMBER, row[column]) for column in places)
        for row in before
    )


def settings_beside(rows: Sequence[Row]) -> dict[str, float]:
    """The same of settings that stand left of the readings: a name, then its number."""
    found: dict[str, float] = {}
    for row in rows:
        stated = _STATED.fullmatch(row[1]) if len(row) > 1 else None
        if stated and _NAME.fullmatch(row[0]):
            found.setdefault(row[0], float(stated[2]))
    return {name: value for name, value in found.items() if abs(value) < float("inf")}
