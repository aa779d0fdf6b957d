"""Cells of a text table's header: which of them are units, and which begin a row of units."""

from __future__ import annotations

import re
from collections.abc import Sequence

from motorid.capture.units import spelled

COMMENTS = ("#", "%", "//")
NO_UNIT = "-"  # in a row of units: the quantity has none
# "Vertical Units,V,A" of an oscilloscope, "Y_Unit_Label" of LabVIEW; horizontal ones are the time's
_OF_EACH = re.compile(r"(?!.*horizontal)(?:.*[\W_])?units?(?:[\W_]|$)|einheit", re.IGNORECASE)
_CHANNEL = re.compile(r"\w{1,12}:(.+)")  # CH1:V
_IN_BRACKETS = re.compile(r"[(\[][^()\[\]]*[)\]]")


def without_mark(row: Sequence[str], width: int) -> list[str]:
    """A row whose first cell only marks a comment, and makes one cell too many, without it."""
    marked = len(row) == width + 1 and row[0] in COMMENTS
    return list(row[1:] if marked else row)


def are_units(filled: Sequence[str]) -> bool:
    """Whether all cells of a row are units, but for one in front that says so."""
    told = len(filled) > 1 and _OF_EACH.match(filled[0]) is not None
    cells = filled[1:] if told else filled
    return bool(cells) and all(unit_cell(cell) or cell == NO_UNIT for cell in cells)


def unit_cell(cell: str) -> str | None:
    """The unit that a cell spells, alone, in brackets, or behind its channel; or None."""
    channel = _CHANNEL.fullmatch(cell)
    return spelled(cell) or (spelled(channel[1]) if channel else None)


def only_unit(cell: str) -> bool:
    """Whether a cell is a unit, or the dash for none, and no name with one in brackets."""
    if _IN_BRACKETS.search(cell) and not _IN_BRACKETS.fullmatch(cell):
        return False
    return cell == NO_UNIT or unit_cell(cell) is not None
