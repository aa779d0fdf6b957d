"""Decimal marks and marks that group thousands: which cells are numbers, and which could be two.

``1.009`` is a thousand and nine to one writer and one and a bit to another. A column shows which
only where its cells differ; where they leave it open, a person has to say.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from motorid.capture.columns import BadCell

Floats = NDArray[np.float64]

SPACES, APOSTROPHES = " \N{NO-BREAK SPACE}\N{THIN SPACE}\N{NARROW NO-BREAK SPACE}", "'’"
GROUPERS = ".,_" + SPACES + APOSTROPHES
_EXPONENT = r"(?:[eE][+-]?\d+)?"
_ANY = rf"[{re.escape(GROUPERS)}]"
# 1.234.567,8 and 12,34,567.8: groups by one mark, and at most one other mark behind them
_GROUPED = re.compile(
    rf"[+-]?(?:\d{{1,3}}({_ANY})\d{{3}}(?:\1\d{{3}})*|\d{{1,2}}(?:,\d\d)+,\d{{3}})(?:(?!\1)[.,]\d+)?"
)
_OTHER_DECIMAL = re.compile(rf"[+-]?\d*[.,]\d+{_EXPONENT}")
_WHOLE = re.compile(r"[+-]?\d{1,3}")
ALIKE = 2.0  # cells with and without a mark, all within this factor, are of one size
CHANGES = 4  # from one kind to the other, or more, that show it


def alike(mark: str) -> str:
    """All that a person may mean by a mark: any kind of blank, any kind of apostrophe."""
    return next((kinds for kinds in (SPACES, APOSTROPHES) if mark in kinds), mark)


def looks_marked(cell: str) -> bool:
    """Whether a cell that is no plain number is one with other marks."""
    return bool(_GROUPED.fullmatch(cell) or _OTHER_DECIMAL.fullmatch(cell))


@dataclass(frozen=True)
class Marks:
    """How numbers are written: a decimal mark, and a mark that groups thousands, or none."""

    decimal: str
    thousands: str = ""

    def numbers(self, cells: Sequence[str]) -> Floats:
        """Cells as floats, (n,); NaN where a cell is not a finite number written so."""
        import pandas as pd

        plain = np.array([self._plain(cell) for cell in cells], dtype=object)
        numbers = pd.to_numeric(plain, errors="coerce").astype(np.float64)
        return np.where(np.isfinite(numbers), numbers, np.nan)

    def _plain(self, cell: str) -> str:
        """The cell with a point for a decimal mark and no groups; empty where it is no number."""
        if self.thousands:
            marks = alike(self.thousands)
            if any(mark in cell for mark in marks):
                whole, _, _ = cell.strip().partition(self.decimal)
                if not _GROUPED.fullmatch(whole):
                    return ""
                cell = cell.translate({ord(mark): None for mark in marks})
        if self.decimal == ",":
            return "" if "." in cell else cell.replace(",", ".")
        return cell

    def question(self, cell: str) -> str:
        """What to ask about a cell that looks like a number with other marks."""
        grouped = _GROUPED.fullmatch(cell)
        if grouped is None:
            other = "," if self.decimal == "." else "."
            return (
                f"has {other!r} for a decimal mark, where others have {self.decimal!r}: write one "
                "mark throughout, or give --decimal"
            )
        mark = grouped[1] or ","
        shown = "' '" if mark in SPACES else f'"{mark}"' if mark in APOSTROPHES else mark
        if self.thousands:
            return f"is no number in groups of three by {self.thousands!r}: repair it"
        return f"seems to group thousands by {mark!r}: if so, give --thousands {shown}"


def may_be_groups(values: Floats) -> bool:
    """Whether numbers could be thousands in groups, as far as their values show it.

    Then all of them are whole thousandths, none lies between 0 and 1, and some are whole.
    """
    known = np.abs(values[np.isfinite(values)])
    if not len(known):
        return False
    whole = known == np.rint(known)
    if whole.all() or not whole.any() or known.max() >= 1e3:
        return False
    parts = known[~whole]
    return bool(parts.min() > 1.0 and np.allclose(1e3 * parts, np.rint(1e3 * parts), atol=1e-6))


@dataclass
class Ambiguous:
    """Looks through a column's cells whether its decimal mark may group thousands."""

    column: str
    decimal: str
    first: BadCell | None = None  # with the mark
    beside: str = ""  # the first cell without
    clear: bool = False  # some cell can only be decimal
    changes: int = 0  # from a cell with it to one without, or back
    sizes: dict[bool, list[float]] = field(default_factory=dict)  # with it, without: extremes

    def look(self, cells: Sequence[str], row: int) -> None:
        """Takes more cells, the first of them of ``row``."""
        import pandas as pd

        if self.clear:
            return
        which, different = pd.factorize(np.array(cells, dtype=object))  # few, where many repeat
        texts = [str(cell).strip() for cell in different]
        if not all(self._open(text) for text in texts if text):
            self.clear = True  # 1.5 beside 1.009, or 1009
            return
        has = np.array([self.decimal in text for text in texts], dtype=bool)
        marked, empty = has[which], np.array([not text for text in texts], dtype=bool)[which]
        if marked.any() and self.first is None:
            index = int(np.argmax(marked))
            self.first = BadCell(row + index, self.column, texts[which[index]])
        if not self.beside and (~marked & ~empty).any():
            self.beside = texts[which[int(np.argmax(~marked & ~empty))]]
        self.changes += int(np.sum(marked[1:] != marked[:-1]))
        numbers = np.abs(Marks(self.decimal).numbers(texts))
        for kind in (False, True):
            known = numbers[(has == kind) & np.isfinite(numbers)]
            if len(known):
                seen = [*self.sizes.get(kind, ()), float(known.min()), float(known.max())]
                self.sizes[kind] = [min(seen), max(seen)]

    def _open(self, text: str) -> bool:
        """Whether a cell could be in groups, or is too short for them."""
        if self.decimal in text:
            return bool(_GROUPED.fullmatch(text)) and not text.lstrip("+-").startswith("0")
        return bool(_WHOLE.fullmatch(text))

    @property
    def question(self) -> str:
        """What to ask; empty where the column leaves nothing open."""
        if self.clear or self.first is None or not self.beside:
            return ""
        least, most = (f(e for ends in self.sizes.values() for e in ends) for f in (min, max))
        if self.changes >= CHANGES and most < ALIKE * least:
            return ""  # 12 and 12.003
        mark = self.decimal
        return (
            f"holds {self.first.text!r} and {self.beside!r}: say whether {mark!r} groups thousands "
            f"(--thousands {mark}) or is the decimal mark (--decimal {mark})"
        )
