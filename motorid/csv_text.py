"""CSV out: numbers as numbers, and texts that no spreadsheet takes for a formula.

A spreadsheet runs a cell that begins with ``=``, ``+``, ``-`` or ``@``, also after a tab or a
carriage return. Such a text (a serial number, a note, a path) gets an apostrophe in front, which a
spreadsheet does not show. ``as_written`` takes it away again.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from typing import Any

from motorid.visible import visible

# also in the full width that East Asian input methods write; any apostrophes before it count, so
# that one can be added and taken away without asking whether it was there
FORMULA = re.compile("'*\\s*[=+\\-@\uff0b\uff0d\uff1d\uff20]|'*[\t\r\n]")
NUMBER = re.compile(r"[+-]?((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|inf|nan)")


def cell(value: Any) -> Any:
    """``value`` as a cell: a text that would be run gets an apostrophe, all else stays."""
    if not isinstance(value, str):
        return value
    return f"'{visible(value)}" if _would_run(value) else visible(value)


def as_written(text: str) -> str:
    """A text that ``cell`` may have marked, as it was (but for control characters)."""
    return text[1:] if text.startswith("'") and FORMULA.match(text) else text


def table(head: Sequence[str], rows: Iterable[Iterable[Any]], *, end: str = "\r\n") -> str:
    """A CSV text with a head."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator=end)
    writer.writerow([cell(name) for name in head])
    writer.writerows([cell(value) for value in row] for row in rows)
    return text.getvalue()


def _would_run(text: str) -> bool:
    return bool(FORMULA.match(text)) and not NUMBER.fullmatch(text)
