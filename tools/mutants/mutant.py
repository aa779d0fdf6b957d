"""One mutant, the sample of a room, and the list of those that change no behaviour."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
EQUIVALENT = Path(__file__).with_name("equivalent.toml")


@dataclass(frozen=True)
class Mutant:
    """A stretch of a file, and what stands there instead. Offsets count bytes."""

    path: str  # of the repository, with "/"
    line: int
    operator: str  # which kind of fault
    begin: int
    end: int
    text: str
    before: str  # the line as it was, stripped
    after: str  # and as it becomes
    at_import: bool = False  # run when the module is loaded, and not by a call

    @property
    def change(self) -> str:
        """What a reader, and equivalent.toml, calls it."""
        return f"{self.before} -> {self.after}"

    def applied(self, source: bytes) -> bytes:
        """The file with the fault in it."""
        return source[: self.begin] + self.text.encode() + source[self.end :]


def digest(*parts: str | bytes) -> str:
    """One number for several texts."""
    whole = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        whole.update(len(data).to_bytes(8, "big") + data)
    return whole.hexdigest()


def sample(mutants: Iterable[Mutant], seed: int) -> list[Mutant]:
    """All of them in an order by chance, which an edit elsewhere leaves nearly as it was."""
    seen: dict[tuple[str, str], int] = {}
    keyed = []
    for one in mutants:
        again = seen[one.path, one.change] = seen.get((one.path, one.change), -1) + 1
        keyed.append((digest(str(seed), one.path, one.operator, one.change, str(again)), one))
    return [one for _, one in sorted(keyed, key=lambda pair: pair[0])]


def line_of(source: bytes, begin: int, end: int, text: str) -> tuple[int, str, str]:
    """The number of a line, and the line before and after a change in it."""
    first = source.rfind(b"\n", 0, begin) + 1
    last = source.find(b"\n", end)
    last = len(source) if last < 0 else last
    before = source[first:last].decode()
    after = source[first:begin].decode() + text + source[end:last].decode()
    return source.count(b"\n", 0, begin) + 1, _in_one_line(before), _in_one_line(after)


def _in_one_line(text: str) -> str:
    return " ".join(text.split())


def equivalent() -> dict[tuple[str, str], str]:
    """Why a mutant changes no behaviour, by file and change."""
    entries = tomllib.loads(EQUIVALENT.read_text(encoding="utf-8")).get("mutant", [])
    return {(one["file"], one["change"]): one["why"] for one in entries}
