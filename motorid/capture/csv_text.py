"""The text of a table that may be large: its encoding, its size and its end, in one pass.

It is read in blocks and never held whole. Lines end with ``\\n`` whatever the file has.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from motorid.errors import DataError
from motorid.limits import CSV, refuse_large, size
from motorid.reading import open_file

BLOCK = CSV.line or 0  # characters; a line within one block is no longer than a line may be


@dataclass(frozen=True)
class Extent:
    """``characters`` and ``lines`` up to the last one that is no blank."""

    encoding: str
    characters: int
    lines: int


def measure(path: Path) -> Extent:
    """Reads the file once. Raises DataError for one that is empty, binary or beyond the limits."""
    refuse_large(path, CSV)
    try:
        with open_file(path, DataError) as file:
            head = file.read(2)
        if head in (b"\xff\xfe", b"\xfe\xff"):
            return _measure(path, "utf-16")
        try:
            return _measure(path, "utf-8-sig")
        except UnicodeDecodeError:
            return _measure(path, "latin-1")
    except UnicodeDecodeError:
        raise DataError(f"{path} begins as UTF-16 and is not: is it damaged?") from None
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror or error}") from None


def opened(path: Path, encoding: str) -> TextIO:
    """The file as text, every line end a newline."""
    return io.TextIOWrapper(open_file(path, DataError), encoding=encoding, newline=None)


def _measure(path: Path, encoding: str) -> Extent:
    characters = lines = 0  # up to the last character that is no blank
    blank = newlines = 0  # after it
    since = 0  # the last newline
    with opened(path, encoding) as text:
        for block in _blocks(text):
            if encoding != "utf-16" and "\0" in block:
                raise DataError(
                    f"{path} is a binary file, not a text table: import reads CSV, MAT, Parquet, "
                    "NPZ, XLSX and JSON lines"
                )
            since = _longest(path, block, since)
            filled = len(block.rstrip())
            if filled:
                lines += newlines + block.count("\n", 0, filled)
                characters += blank + filled
                blank = newlines = 0
            blank += len(block) - filled
            newlines += block.count("\n", filled)
            if CSV.rows is not None and lines > CSV.rows + CSV_HEADER:
                raise DataError(
                    f"{path} has more than {CSV.rows:,} lines, the most that a table may have: "
                    "import a part of it, or every second line"
                )
    if not characters:
        raise DataError(f"{path} is empty")
    return Extent(encoding, characters, lines + 1)


CSV_HEADER = 100  # lines before the first of numbers, at most


def _blocks(text: TextIO) -> Iterator[str]:
    while block := text.read(BLOCK):
        yield block


def _longest(path: Path, block: str, since: int) -> int:
    """Characters after the last newline. Raises DataError for a line that is too long."""
    first = block.find("\n")
    if since + (first if first >= 0 else len(block)) > BLOCK:
        raise DataError(
            f"{path} has a line of more than {size(BLOCK)}, the most that a table's may have: "
            "is it a table?"
        )
    return since + len(block) if first < 0 else len(block) - block.rfind("\n") - 1


class Body:
    """The lines of a table from one line on, without blanks at its end, for a parser to read."""

    def __init__(self, text: TextIO, skip: int, characters: int) -> None:
        self._text, self._left = text, characters
        for _ in range(skip):
            self._left -= len(text.readline())

    def read(self, count: int = -1) -> str:
        """At most ``count`` characters; nothing at the end."""
        wanted = self._left if count < 0 else min(count, self._left)
        found = self._text.read(max(0, wanted))
        self._left -= len(found)
        return found

    def __iter__(self) -> Iterator[str]:
        while line := self._text.readline(max(0, self._left)):
            self._left -= len(line)
            yield line


def head(path: Path, encoding: str, lines: int, characters: int) -> list[str]:
    """The first lines, and no more than so many characters of them beside the first."""
    found: list[str] = []
    with opened(path, encoding) as text:
        while len(found) < lines and characters > 0 and (line := text.readline(BLOCK + 1)):
            found.append(line.rstrip("\n"))
            characters -= len(line)
    return found
