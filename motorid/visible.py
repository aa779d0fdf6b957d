"""Text of others made safe to show: no character in it can steer a terminal or hide a word.

File names, serial numbers, rig files and what a board sends may hold escape sequences, bytes that
are no text, and marks that turn the reading direction. They are shown as Python writes them.
"""

from __future__ import annotations

import re

# C0 but tab and newline, DEL and C1; line and paragraph separators; marks of reading direction;
# lone surrogates, which stand for bytes that are no UTF-8
HIDDEN = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"
    "\ud800-\udfff]"
    "|\r(?!\n)"
)


def visible(text: str) -> str:
    """``text`` with each control character as an escape such as ``\\x1b``; lines stay lines."""
    return HIDDEN.sub(_escape, text)


def on_one_line(text: str) -> str:
    """The same for a name within a sentence: a tab or a newline in it is an escape too."""
    return "".join(_of_character(c) if c in "\t\n\r" else c for c in visible(text))


def _escape(found: re.Match[str]) -> str:
    return _of_character(found.group())


def _of_character(character: str) -> str:
    code = ord(character)
    if 0xDC80 <= code <= 0xDCFF:  # a byte of a file name, as Python carries it
        return f"\\x{code - 0xDC00:02x}"
    return character.encode("unicode_escape", "surrogatepass").decode("ascii")
